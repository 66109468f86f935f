// SPDX-License-Identifier: MIT
'use strict';

/* What a tree answers, and what is written where. */

const test = require('node:test');
const assert = require('node:assert/strict');
const { HTree, Hits, Counters, NONE, KINDS } = require('htree');
const raw = require('htree/raw');
const { TETRAHEDRON, terrain, above, shared } = require('./common');

const INTO_FACE_3 = [2, 2, 2, 0, -1, -1, -1, Infinity];

test('a ray hits the tetrahedron', () => {
    const tree = HTree.build(TETRAHEDRON);
    const hits = tree.intersect(INTO_FACE_3);
    assert.equal(hits.count, 1);
    assert.ok(hits.isHit(0));
    assert.equal(hits.prim(0), 3);
    assert.ok(Math.abs(hits.t(0) - 5 / 3) < 1e-6);
    assert.deepEqual([...hits], [hits.get(0)]);
    assert.deepEqual(tree.intersectRay([2, 2, 2], [-1, -1, -1]), hits.get(0));
    assert.equal(tree.occludedRay([2, 2, 2], [-1, -1, -1]), true);
    assert.equal(tree.occludedRay([2, 2, 2], [-1, -1, -1], 0, 1), false);
    assert.deepEqual(tree.bounds(), { lo: [0, 0, 0], hi: [1, 1, 1] });
    tree.close();
});

test('a miss keeps tmax', () => {
    const tree = HTree.build(TETRAHEDRON);
    const hits = tree.intersect([2, 2, 2, 0, 1, 1, 1, 7]);
    assert.deepEqual(hits.get(0), { t: 7, u: 0, v: 0, prim: NONE });
    assert.equal(hits.isHit(0), false);
    assert.equal(tree.intersectRay([2, 2, 2], [1, 1, 1]), null);
    tree.close();
});

test('an empty mesh is missed', () => {
    const tree = HTree.build({});
    assert.equal(tree.intersect(INTO_FACE_3).isHit(0), false);
    assert.deepEqual(tree.bounds(), { lo: [Infinity, Infinity, Infinity],
        hi: [-Infinity, -Infinity, -Infinity] });
    assert.equal(tree.intersect(new Float32Array(0)).count, 0);
    tree.close();
});

test('vertices may lie among other data, and numbers in any array', () => {
    const interleaved = new Float32Array(20);
    const { positions, indices } = TETRAHEDRON;
    const vertex = (i) => [...positions.subarray(3 * i, 3 * i + 3)];
    for (let i = 0; i < 4; ++i) interleaved.set(vertex(i), 5 * i);
    for (const mesh of [
        { positions: interleaved, positionStride: 20, indices },
        { positions: Array.from(positions), indices: Array.from(indices) },
        { positions, indices: Uint16Array.from(indices) },
        { positions: shared(positions), indices: shared(indices) },
        { positions: Array.from(indices).flatMap(vertex) },
        { positions, indices, triangleCount: 4 },
    ]) {
        const tree = HTree.build(mesh);
        assert.equal(tree.intersect(INTO_FACE_3).prim(0), 3);
        tree.close();
    }
});

test('answers go where the caller wants them, and nowhere else', () => {
    const tree = HTree.build(terrain(20));
    const rays = above(16);
    const expected = tree.intersect(rays);
    const hits = new Hits(300);
    hits.words.fill(0x5a5a5a5a);
    const framed = new Float32Array(8 * 258);
    framed.set(rays, 8);
    assert.equal(tree.intersect(framed.subarray(8, 8 * 257), { hits }), hits);
    assert.deepEqual(hits.words.subarray(0, 1024), expected.words);
    assert.ok(hits.words.subarray(1024).every((word) => word === 0x5a5a5a5a));

    const bytes = new Uint8Array(260).fill(9);
    tree.occluded(rays, { occluded: bytes.subarray(2, 258) });
    assert.deepEqual([bytes[0], bytes[1], bytes[258], bytes[259]], [9, 9, 9, 9]);
    for (let i = 0; i < 256; ++i) assert.equal(bytes[2 + i], Number(expected.isHit(i)));

    const memory = new SharedArrayBuffer(16 * 256);
    tree.intersect(shared(rays), { hits: new Hits(memory) });
    assert.deepEqual(new Uint32Array(memory), new Uint32Array(shared(expected.words).buffer));
    tree.close();
});

test('counters count and change nothing', async () => {
    const tree = HTree.build(terrain(30));
    const rays = above(30);
    const counters = new Counters(900);
    const hits = tree.intersect(rays, { counters, threads: 2 });
    assert.deepEqual(hits.words, tree.intersect(rays).words);
    let tests = 0;
    for (let i = 0; i < counters.count; ++i) {
        assert.ok(counters.leafSteps(i) <= counters.traversalSteps(i));
        assert.ok(!hits.isHit(i) || counters.intersections(i) > 0);
        tests += counters.intersections(i);
    }
    assert.ok(tests > 450);
    const later = new Counters(900);
    await tree.intersectAsync(rays, { counters: later });
    assert.deepEqual(later.words, counters.words);
    tree.close();
});

test('every kind has its name and number', () => {
    for (const [name, number] of Object.entries(KINDS)) {
        assert.ok(number > 0);
        assert.equal(raw.htree_kind_name(number), name);
    }
    assert.equal(raw.htree_kind_from_name('octree'), 0);
    assert.equal(raw.htree_kind_from_name(null), 0);
});

test('defaults are the library\'s', () => {
    const best = HTree.defaults({ kind: 'best' });
    assert.equal(best.kind, 'bvh-sah');
    assert.equal(best.collapse, true);
    assert.equal(best.buckets, 32);
    assert.deepEqual(HTree.defaults(), HTree.defaults({ kind: 'balanced' }));
});

test('every option reaches the library', () => {
    const odd = {
        kind: 'ah', strict: true, anyPlanes: true, loosePlanes: true, morton: true, lazy: true,
        compact: false, collapse: true,
        threads: 1, buckets: 5, axes: 3, fewPrims: 1, costSkd: 1, costBv2: 2, costBv6: 3,
        costIntersect: 4, cellsPerPrim: 2,
    };
    assert.deepEqual(HTree.defaults(odd), odd);
    const mesh = terrain(40);
    const tree = HTree.build(mesh, odd);
    const plain = HTree.build(mesh);
    tree.check();
    assert.equal(tree.stats().kind, 'wide');
    assert.notEqual(tree.stats().sahCost, plain.stats().sahCost);
    assert.deepEqual(tree.intersect(above(20)).words, plain.intersect(above(20)).words);
    tree.close();
    plain.close();
});

test('calibration measures costs', () => {
    const measured = HTree.calibrate({ kind: 'h', threads: 1 });
    assert.equal(measured.costSkd, 1);
    assert.ok(measured.costBv6 > 0 && measured.costIntersect > 0);
    assert.equal(measured.threads, 1);
    HTree.build(TETRAHEDRON, measured).close();
});

test('a view is a copy that outlives the tree', () => {
    const tree = HTree.build(TETRAHEDRON, { kind: 'h' });
    const view = tree.view();
    const again = tree.view();
    tree.close();
    const { kind, prims, triangleCount, objectCount, bounds } = view;
    assert.deepEqual({ kind, prims, triangleCount, objectCount, bounds }, {
        kind: 'h',
        prims: 4,
        triangleCount: 4,
        objectCount: 0,
        bounds: { lo: [0, 0, 0], hi: [1, 1, 1] },
    });
    const corners = Array.from(TETRAHEDRON.indices)
        .flatMap((i) => [...TETRAHEDRON.positions.subarray(3 * i, 3 * i + 3)]);
    assert.deepEqual(Array.from(view.triangles), corners);
    assert.ok(view.nodes.byteLength > 0);
    assert.deepEqual(view, again);
    const grid = HTree.build(terrain(8), { kind: 'ug' });
    assert.ok(grid.view().grid.byteLength > 0 && grid.view().leaves.byteLength > 0);
    grid.close();
    const wide = HTree.build(TETRAHEDRON);
    assert.equal(wide.view().kind, 'wide');
    assert.equal(wide.view().triangles.length, 0);
    assert.ok(wide.view().leaves.byteLength > 0);
    wide.close();
});

test('import and require give the same package', async () => {
    const module = await import('htree');
    for (const [name, value] of Object.entries(require('htree'))) assert.equal(module[name], value);
    assert.equal(module.default, require('htree'));
});
