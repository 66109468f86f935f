// SPDX-License-Identifier: MIT
'use strict';

/* Trees are freed once, at the right moment, in whatever order they are let go. */

const test = require('node:test');
const assert = require('node:assert/strict');
const { HTree, Hits } = require('htree');
const { Handle } = require('../lib/handle');
const callbacks = require('../lib/callbacks');
const { TETRAHEDRON, terrain, above, shared, resident, collectUntil } = require('./common');

const MANY = 100000;
const GROWTH_BYTES = 64 << 20;
const BOX = [-1, -1, 0, 1, 1, 1];

const settle = () => collectUntil(() => Handle.live === 0);

test('closing twice does nothing', async () => {
    await settle();
    const tree = HTree.build(TETRAHEDRON);
    assert.equal(Handle.live, 1);
    assert.equal(tree.closed, false);
    tree.close();
    tree.close();
    tree[Symbol.dispose]();
    assert.equal(tree.closed, true);
    assert.equal(Handle.live, 0);
});

test('every use after close throws', async () => {
    const tree = HTree.build(TETRAHEDRON);
    tree.close();
    for (const use of [
        () => tree.intersect(above(2)), () => tree.occluded(above(2)), () => tree.bounds(),
        () => tree.intersectRay([0, 0, 0], [0, 0, 1]), () => tree.occludedRay([0, 0, 0], [0, 0, 1]),
        () => tree.stats(), () => tree.view(), () => tree.check(), () => tree.complete(),
        () => tree.update(TETRAHEDRON, 'refit'),
    ]) assert.throws(use, /the tree is closed/);
    await assert.rejects(tree.intersectAsync(above(2)), /the tree is closed/);
    await assert.rejects(tree.occludedAsync(above(2)), /the tree is closed/);
    await assert.rejects(tree.completeAsync(), /the tree is closed/);
    await assert.rejects(tree.updateAsync(TETRAHEDRON, 'refit'), /the tree is closed/);
});

test('trees close in any order', () => {
    for (let step = 1; step < 19; ++step) {
        const trees = Array.from({ length: 19 }, () => HTree.build(TETRAHEDRON));
        for (let i = 0; i < 19; ++i) trees[(i * step) % 19].close();
    }
    assert.equal(Handle.live, 0);
});

test('a tree closed while workers trace is freed by the last of them', async () => {
    const rays = above(200);
    const tree = HTree.build(terrain(30));
    const expected = tree.intersect(rays).words;
    const running = [];
    for (let i = 0; i < 12; ++i) running.push(tree.intersectAsync(i % 2 ? rays : shared(rays)));
    tree.close();
    assert.equal(tree.closed, true);
    assert.equal(Handle.live, 1);
    for (const hits of await Promise.all(running)) assert.deepEqual(hits.words, expected);
    assert.equal(Handle.live, 0);
});

test('the event loop turns while workers work', async () => {
    let turns = 0;
    const timer = setInterval(() => { ++turns; }, 1);
    const tree = await HTree.buildAsync(terrain(300), { threads: 1 });
    const rays = above(700);
    const hits = await tree.intersectAsync(rays);
    clearInterval(timer);
    assert.ok(turns > 5, `${turns} turns`);
    assert.deepEqual(hits.words, tree.intersect(rays).words);
    tree.close();
});

test('arrays may be moved away or dropped while workers use them', async () => {
    const tree = HTree.build(terrain(30));
    const expected = tree.intersect(above(300)).words;
    for (let i = 0; i < 20; ++i) {
        const rays = above(300);
        const running = tree.intersectAsync(rays);
        structuredClone(rays.buffer, { transfer: [rays.buffer] });
        global.gc();
        assert.deepEqual((await running).words, expected);
    }
    const hits = new Hits(90000);
    const running = tree.intersectAsync(above(300), { hits });
    structuredClone(hits.buffer, { transfer: [hits.buffer] });
    await assert.rejects(running);
    const kept = new Hits(90000);
    assert.equal(await tree.intersectAsync(above(300), { hits: kept }), kept);
    assert.deepEqual(kept.words, expected);
    tree.close();
});

test('the stack of a worker is deep enough for deep trees', async () => {
    const positions = [];
    for (let i = 0; i < 3000; ++i) {
        const x = 1e-30 * 1.04 ** i;
        positions.push(x, 0, 0, 1.01 * x, 0, 1e-3 * x, x, x, 0);
    }
    for (const kind of ['ug', 'kd', 'bvh-median', 'bvh-sah', 'skd', 'h', 'ah']) {
        const tree = await HTree.buildAsync({ positions }, { kind });
        const hits = await tree.intersectAsync(above(20), { threads: 1 });
        assert.deepEqual(hits.words, tree.intersect(above(20)).words);
        tree.close();
    }
});

test('small batches on workers survive the garbage collector', async () => {
    const tree = HTree.build(TETRAHEDRON);
    const running = [];
    for (let i = 0; i < 200; ++i) {
        running.push(tree.intersectAsync([2, 2, 2, 0, -1, -1, -1, Infinity]));
        if (i % 20 === 0) global.gc();
    }
    for (const hits of await Promise.all(running)) assert.equal(hits.prim(0), 3);
    tree.close();
});

test('failed builds leave nothing', async () => {
    const mesh = { ...TETRAHEDRON, indices: [0, 1, 4], objects: { boxes: BOX, intersect() {} } };
    for (let i = 0; i < 1000; ++i) assert.throws(() => HTree.build(mesh));
    for (let i = 0; i < 100; ++i) await assert.rejects(HTree.buildAsync(mesh));
    assert.equal(Handle.live, 0);
    assert.equal(callbacks.live(), 0);
});

test('forgotten trees are freed, with their objects', async () => {
    const drop = () => {
        for (let i = 0; i < 1000; ++i) {
            HTree.build({ objects: { boxes: BOX, intersect: () => ({ t: 0.5 }) } });
        }
    };
    drop();
    await settle();
    assert.equal(Handle.live, 0);
    assert.equal(callbacks.live(), 0);
});

test('a mesh may go before its tree', async () => {
    const build = () => HTree.build({ objects: { boxes: BOX, intersect: () => ({ t: 0.5 }) } });
    const tree = build();
    global.gc();
    await new Promise((resolve) => { setTimeout(resolve, 5); });
    global.gc();
    assert.equal(tree.intersectRay([0, 0, 0], [0, 0, 1]).t, 0.5);
    tree.close();
});

test('many forgotten trees do not grow the process', async () => {
    const forget = async (count) => {
        for (let i = 0; i < count; ++i) {
            HTree.build(TETRAHEDRON, { kind: 'h' });
            if (i % 2000 === 0) await collectUntil(() => Handle.live < 100);
        }
        await settle();
    };
    await forget(MANY / 2);
    const before = resident();
    await forget(MANY);
    assert.equal(Handle.live, 0);
    const growth = resident() - before;
    assert.ok(growth < GROWTH_BYTES, `grew by ${growth} bytes`);
});
