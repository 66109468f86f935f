// SPDX-License-Identifier: MIT
'use strict';

/* Every mistake of the conformance file gives its status and a sentence; those that JavaScript can
 * make besides give an error and no crash. */

const test = require('node:test');
const assert = require('node:assert/strict');
const koffi = require('koffi');
const { HTree, HTreeError, Hits, Counters } = require('htree');
const raw = require('htree/raw');
const { TETRAHEDRON, terrain, above, readConformance } = require('./common');

const file = readConformance();
const stop = () => true;
const build = (options) => HTree.build(TETRAHEDRON, { kind: 'ah', ...options });

function check(status) {
    if (status !== 0) throw new HTreeError(status, raw.htree_error_text());
}

const isOfJavaScript = (error) => error instanceof TypeError || error instanceof RangeError;

function rawMesh(fields) {
    return {
        positions: null, position_stride: 0, vertex_count: 0, indices: null, triangle_count: 0,
        objects: null, reserved: [0, 0], ...fields,
    };
}

function rawOptions(fields) {
    const options = {
        size: 0, kind: 0, flags: 0, threads: 0, buckets: 0, axes: 0, cost_skd: 0, cost_bv2: 0,
        cost_bv6: 0, cost_intersect: 0, cells_per_prim: 0, few_prims: 0,
        allocator: { allocate: null, release: null, user: null }, tasks: { run: null, user: null },
        progress: { report: null, user: 0 },
    };
    check(raw.htree_options_init(options, koffi.sizeof(raw.types.htree_options), 6));
    return { ...options, ...fields };
}

function withRawTree(use) {
    const out = [null];
    check(raw.htree_build(out, rawMesh(), null));
    try {
        check(use(out[0]));
    } finally {
        raw.htree_free(out[0]);
    }
}

const zeros = (type) => Object.fromEntries(Object.entries(type.members).map(([name, member]) => {
    if (member.type.primitive === 'Record') return [name, zeros(member.type)];
    if (member.type.primitive === 'Array') return [name, new Array(member.type.length).fill(0)];
    return [name, member.type.primitive === 'Pointer' ? null : 0];
}));

const ray = new Float32Array(8);
const hit = new Float32Array(4);

const CASES = {
    'build-index-out-of-range': () => HTree.build({ ...TETRAHEDRON, indices: [0, 1, 4] }),
    'build-strict-nan': () => HTree.build({ positions: [NaN, 0, 0, 1, 0, 0, 0, 1, 0] },
        { strict: true }),
    'build-kind-unknown': () => build({ kind: 99 }),
    'build-buckets-1': () => build({ buckets: 1 }),
    'build-axes-2': () => build({ axes: 2 }),
    'build-flags-unknown': () => check(
        raw.htree_build([null], rawMesh(), rawOptions({ flags: 0x80000000 }))),
    'build-cost-nan': () => build({ costSkd: NaN }),
    'build-cost-zero': () => build({ costIntersect: 0 }),
    'build-cells-huge': () => build({ cellsPerPrim: 1e9 }),
    'build-few-prims-0': () => build({ fewPrims: 0 }),
    'build-stride-8': () => HTree.build({ ...TETRAHEDRON, positionStride: 8 }),
    'build-too-few-vertices': () => HTree.build({
        positions: new Float32Array(9), triangleCount: 2,
    }),
    'build-positions-null': () => check(
        raw.htree_build([null], rawMesh({ triangle_count: 1 }), null)),
    'build-cancelled': () => HTree.build(terrain(50), { progress: stop }),
    'query-cancelled': () => HTree.build(TETRAHEDRON).intersect(
        new Float32Array(8 * 100000), { progress: stop, threads: 1 }),
    'query-flags-unknown': () => withRawTree((tree) => {
        const query = zeros(raw.types.htree_query);
        check(raw.htree_query_init(query, koffi.sizeof(raw.types.htree_query)));
        return raw.htree_intersect(tree, ray, 1, hit, { ...query, flags: 1 });
    }),
    'options-size-0': () => check(
        raw.htree_options_init(zeros(raw.types.htree_options), 0, 6)),
    'query-size-0': () => check(raw.htree_query_init(zeros(raw.types.htree_query), 0)),
    'stats-size-0': () => withRawTree(
        (tree) => raw.htree_get_stats(tree, zeros(raw.types.htree_stats))),
    'view-size-0': () => withRawTree(
        (tree) => raw.htree_get_view(tree, zeros(raw.types.htree_view))),
    'view-lazy': () => HTree.build(terrain(60), { kind: 'wide', lazy: true }).view(),
    'update-how-3': () => withRawTree((tree) => raw.htree_update(tree, rawMesh(), 3, null)),
    'update-index-out-of-range': () => HTree.build(TETRAHEDRON).update(
        { ...TETRAHEDRON, indices: [0, 1, 4] }, 'rebuild'),
    'update-mesh-null': () => withRawTree((tree) => raw.htree_update(tree, null, 2, null)),
    'complete-null': () => check(raw.htree_complete(null)),
    'rays-null': () => withRawTree((tree) => raw.htree_intersect(tree, null, 1, hit, null)),
    'hits-null': () => withRawTree((tree) => raw.htree_intersect(tree, ray, 1, null, null)),
    'tree-null': () => check(raw.htree_intersect(null, ray, 1, hit, null)),
    'out-null': () => check(raw.htree_build(null, rawMesh(), null)),
    'mesh-null': () => check(raw.htree_build([null], null, null)),
};

assert.ok(file.misuse.length > 0);
for (const { case: name, status } of file.misuse) {
    test(`${name} is ${status}`, () => {
        assert.ok(Object.hasOwn(CASES, name), 'a case that this test does not know');
        assert.throws(CASES[name], (error) => {
            assert.ok(error instanceof HTreeError, String(error));
            assert.equal(error.name, 'HTreeError');
            assert.equal(error.code, status);
            assert.equal(error.status, file.statuses[status]);
            assert.equal(error.words, file.status_names[error.status]);
            assert.ok(error.message.length > 0);
            return true;
        });
    });
}

test('a worker\'s failure has its sentence too', async () => {
    await assert.rejects(HTree.buildAsync({ ...TETRAHEDRON, indices: [0, 1, 4] }), {
        code: 'GEOMETRY', message: 'triangle 0 refers to vertex 4 of 4',
    });
    await assert.rejects(HTree.buildAsync(TETRAHEDRON, { buckets: 1 }), { code: 'ARGUMENT' });
    await assert.rejects(HTree.buildAsync({ positions: [NaN, 0, 0, 1, 0, 0, 0, 1, 0] },
        { strict: true }), { code: 'GEOMETRY' });
});

const REFUSED = {
    'a mesh that is none': () => HTree.build(7),
    'no mesh': () => HTree.build(),
    'a misspelt mesh': () => HTree.build({ vertices: [] }),
    'doubles': () => HTree.build({ positions: new Float64Array(9) }),
    'part of a vertex': () => HTree.build({ positions: [1, 2] }),
    'part of a triangle': () => HTree.build({ ...TETRAHEDRON, indices: [0, 1] }),
    'a negative index': () => HTree.build({ ...TETRAHEDRON, indices: [0, 1, -1] }),
    'triangles beyond the indices': () => HTree.build({ ...TETRAHEDRON, triangleCount: 5 }),
    'a negative stride': () => HTree.build({ ...TETRAHEDRON, positionStride: -4 }),
    'objects without a test': () => HTree.build({ objects: { boxes: [0, 0, 0, 1, 1, 1] } }),
    'part of a box': () => HTree.build({ objects: { boxes: [0], intersect: stop } }),
    'a misspelt option': () => build({ thread: 1 }),
    'options that are none': () => HTree.build(TETRAHEDRON, null),
    'an unknown name of a kind': () => build({ kind: 'octree' }),
    'a name that objects have anyway': () => build({ kind: 'constructor' }),
    'a fraction of a thread': () => build({ threads: 1.5 }),
    'a negative number of threads': () => build({ threads: -1 }),
    'a cost in words': () => build({ costSkd: '1' }),
    'progress that is no function': () => build({ progress: 3 }),
    'new HTree': () => new HTree(),
    'new HTree around a number': () => new HTree(Symbol('built'), 1234),
    'hits of part of a hit': () => new Hits(new ArrayBuffer(15)),
    'hits of nothing': () => new Hits(null),
};
for (const [name, mistake] of Object.entries(REFUSED)) {
    test(`${name}: refused`, () => {
        assert.throws(mistake, isOfJavaScript);
    });
}

test('queries that would read or write past an array are refused', () => {
    const tree = HTree.build(TETRAHEDRON);
    const rays = above(4);
    class Liar extends Hits {
        get words() { return new Float64Array(1); }

        get count() { return 1000; }
    }
    for (const mistake of [
        () => tree.intersect(),
        () => tree.intersect('rays'),
        () => tree.intersect(1234),
        () => tree.intersect(new Float64Array(8)),
        () => tree.intersect(new Float32Array(9)),
        () => tree.intersect(rays, { hits: new Hits(15) }),
        () => tree.intersect(rays, { hits: new Float32Array(64) }),
        () => tree.intersect(rays, { hits: new Liar(16) }),
        () => tree.intersect(rays, { counters: new Counters(15) }),
        () => tree.intersect(rays, { counters: {} }),
        () => tree.intersect(rays, { threads: -1 }),
        () => tree.intersect(rays, { occluded: new Uint8Array(16) }),
        () => tree.intersect(rays, null),
        () => tree.occluded(rays, { occluded: new Uint8Array(15) }),
        () => tree.occluded(rays, { occluded: new Uint16Array(16) }),
        () => tree.intersectRay([0, 0], [0, 0, 1]),
    ]) {
        assert.throws(mistake, isOfJavaScript);
    }
    assert.throws(() => HTree.prototype.intersect.call({}, rays), TypeError);
    tree.close();
});

test('arrays that were moved away are empty, not dangling', () => {
    const tree = HTree.build(TETRAHEDRON);
    const rays = above(4);
    const hits = new Hits(16);
    structuredClone(rays.buffer, { transfer: [rays.buffer] });
    assert.equal(tree.intersect(rays).count, 0);
    structuredClone(hits.buffer, { transfer: [hits.buffer] });
    assert.throws(() => tree.intersect(above(4), { hits }), RangeError);
    tree.close();
});
