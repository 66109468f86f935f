// SPDX-License-Identifier: MIT
'use strict';

/* Progress and objects: JavaScript called from C, and what it throws on the way back. */

const test = require('node:test');
const assert = require('node:assert/strict');
const { HTree, Hits } = require('htree');
const { terrain, above } = require('./common');

const SPHERES = 40;
const RADIUS = 0.02;
const centre = (object) => (object + 0.5) / SPHERES;

/** Spheres stand along the diagonal of the unit square, at height 1. */
function intersectSphere(object, { org, dir }) {
    const offset = [org[0] - centre(object), org[1] - centre(object), org[2] - 1];
    const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const a = dot(dir, dir);
    const b = dot(offset, dir);
    const discriminant = b * b - a * (dot(offset, offset) - RADIUS * RADIUS);
    if (discriminant < 0) return null;
    return { t: (-b - Math.sqrt(discriminant)) / a, u: 0.25, v: 0.75 };
}

/** One large triangle below the spheres. */
function spheres(intersect) {
    const boxes = [];
    for (let i = 0; i < SPHERES; ++i) {
        const [low, high] = [centre(i) - 1.01 * RADIUS, centre(i) + 1.01 * RADIUS];
        boxes.push(low, low, 1 - 1.01 * RADIUS, high, high, 1 + 1.01 * RADIUS);
    }
    return { positions: [-5, -5, 0, 9, -5, 0, -5, 9, 0], objects: { boxes, intersect } };
}

function down(count = 10 * SPHERES) {
    const rays = new Float32Array(8 * count);
    for (let i = 0; i < count; ++i) {
        rays.set([centre(i % SPHERES), centre(i % SPHERES), 3, 0, 0, 0, -1, Infinity], 8 * i);
    }
    return rays;
}

test('objects are hit', async () => {
    for (const tree of [
        HTree.build(spheres(intersectSphere)), await HTree.buildAsync(spheres(intersectSphere))]) {
        const hits = tree.intersect(down());
        for (let i = 0; i < hits.count; ++i) {
            assert.equal(hits.prim(i), 1 + i % SPHERES);
            assert.ok(Math.abs(hits.t(i) - 2 + RADIUS) < 1e-6);
            assert.deepEqual([hits.u(i), hits.v(i)], [0.25, 0.75]);
        }
        assert.ok(tree.occluded(down()).every((byte) => byte === 1));
        assert.equal(tree.stats().objects, SPHERES);
        assert.equal(tree.intersectRay([0, 0.5, 3], [0, 0, -1]).prim, 0);
        tree.close();
    }
});

test('u and v may be left out, and objects missed', () => {
    const plain = HTree.build(spheres((object, ray) => ({ t: intersectSphere(object, ray).t })));
    assert.deepEqual([plain.intersect(down()).u(0), plain.intersect(down()).prim(0)], [0, 1]);
    plain.close();
    const missed = HTree.build(spheres(() => undefined));
    assert.equal(missed.intersect(down()).prim(0), 0);
    missed.close();
});

test('objects are refused where JavaScript cannot run', async () => {
    const tree = HTree.build(spheres(intersectSphere));
    assert.throws(() => tree.intersect(down(), { threads: 2 }), RangeError);
    assert.throws(() => tree.intersect(down(), { threads: 0 }), RangeError);
    await assert.rejects(tree.intersectAsync(down()), TypeError);
    await assert.rejects(tree.occludedAsync(down()), TypeError);
    assert.equal(tree.intersect(down(), { threads: 1 }).prim(0), 1);
    tree.close();
});

test('what an intersector throws or returns amiss leaves the query', () => {
    const broken = new Error('broken sphere');
    let thrower = true;
    // Without the triangle below, which is an any-hit as good as a sphere.
    const { objects } = spheres((object, ray) => {
        if (thrower && object === 7) throw broken;
        return intersectSphere(object, ray);
    });
    const tree = HTree.build({ objects });
    assert.throws(() => tree.intersect(down()), (thrown) => thrown === broken);
    assert.throws(() => tree.occluded(down()), (thrown) => thrown === broken);
    thrower = false;
    assert.equal(tree.intersect(down()).prim(7), 7);
    tree.close();
    for (const answer of [{}, { t: 'near' }, { t: 1, u: {} }, 1, 'hit']) {
        const amiss = HTree.build(spheres(() => answer));
        assert.throws(() => amiss.intersect(down()), TypeError);
        amiss.close();
    }
});

test('a tree may be closed or queried by its own intersector', () => {
    let tree = null;
    let inner = null;
    let calls = 0;
    tree = HTree.build(spheres((object, ray) => {
        if (++calls === 1) {
            inner = tree.intersect(down(1));
            tree.close();
        }
        return intersectSphere(object, ray);
    }));
    assert.equal(tree.intersect(down()).prim(0), 1);
    assert.equal(inner.prim(0), 1);
    assert.ok(tree.closed);
    assert.throws(() => tree.intersect(down()), /closed/);
});

test('what an inner query throws stays with it', () => {
    const broken = new Error('inner');
    let depth = 0;
    let caught = null;
    const tree = HTree.build(spheres((object, ray) => {
        if (depth > 0) throw broken;
        ++depth;
        try {
            tree.intersect(down(1));
        } catch (thrown) {
            caught = thrown;
        }
        --depth;
        return intersectSphere(object, ray);
    }));
    assert.equal(tree.intersect(down(SPHERES)).prim(3), 4);
    assert.equal(caught, broken);
    tree.close();
});

function assertRising(reports) {
    assert.ok(reports.length > 3, `only ${reports}`);
    let before = 0;
    for (const fraction of reports) {
        assert.ok(before <= fraction && fraction <= 1, String(reports));
        before = fraction;
    }
}

test('progress rises', () => {
    const reports = [];
    const progress = (fraction) => { reports.push(fraction); };
    const tree = HTree.build(terrain(60), { progress });
    assertRising(reports);
    reports.length = 0;
    const hits = tree.intersect(above(150), { progress, threads: 1 });
    assertRising(reports);
    assert.deepEqual(hits.words, tree.intersect(above(150)).words);
    tree.close();
});

test('what progress throws leaves the call', () => {
    const broken = new Error('broken bar');
    const progress = () => { throw broken; };
    assert.throws(() => HTree.build(terrain(60), { progress }), (thrown) => thrown === broken);
    const tree = HTree.build(terrain(60));
    for (const call of ['intersect', 'occluded']) {
        assert.throws(() => tree[call](above(150), { progress, threads: 1 }),
            (thrown) => thrown === broken);
    }
    tree.close();
});

test('progress is refused where JavaScript cannot run', async () => {
    const progress = () => false;
    await assert.rejects(HTree.buildAsync(terrain(4), { progress }), TypeError);
    const tree = HTree.build(terrain(4));
    await assert.rejects(tree.intersectAsync(above(4), { progress }), TypeError);
    tree.close();
});

test('arrays may be moved away while C runs', () => {
    const mesh = terrain(60);
    const expected = HTree.build(mesh).intersect(above(150));
    const move = (...arrays) => {
        for (const { buffer } of arrays) {
            if (buffer.byteLength > 0) structuredClone(buffer, { transfer: [buffer] });
        }
        return false;
    };
    const tree = HTree.build(mesh, { progress: () => move(mesh.positions, mesh.indices) });
    assert.equal(mesh.positions.length, 0);
    const rays = above(150);
    const hits = tree.intersect(rays, { progress: () => move(rays), threads: 1 });
    assert.equal(rays.length, 0);
    assert.deepEqual(hits.words, expected.words);
    const given = new Hits(150 * 150);
    assert.throws(() => tree.intersect(
        above(150), { hits: given, progress: () => move(given), threads: 1 }));
    tree.close();
});
