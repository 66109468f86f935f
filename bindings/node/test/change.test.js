// SPDX-License-Identifier: MIT
'use strict';

/* Trees that rays build, compact and collapsed ones, and trees that are brought to another mesh. */

const test = require('node:test');
const assert = require('node:assert/strict');
const { HTree, KINDS } = require('htree');
const callbacks = require('../lib/callbacks');
const { TETRAHEDRON, terrain, above, shared } = require('./common');

const CELLS = 60;
const RAYS = above(60);
const LAZY = { kind: 'wide', lazy: true };
const BOX = [-1, -1, -1, 1, 1, 1];
const BAD = { ...TETRAHEDRON, indices: [0, 1, 4] };

/** The same triangles, one side of them higher. */
function lifted({ positions, indices }, by = 0.1) {
    const made = Float32Array.from(positions, (value, i) => {
        return i % 3 === 2 ? value + by * positions[i - 2] : value;
    });
    return { positions: made, indices };
}

function hitsOf(mesh) {
    const tree = HTree.build(mesh, { kind: 'bvh-sah' });
    const { words } = tree.intersect(RAYS);
    tree.close();
    return words;
}

function assertAnswersAs(tree, mesh) {
    tree.check();
    assert.deepEqual(tree.intersect(RAYS).words, hitsOf(mesh));
}

// ---- Compact, collapsed ------------------------------------------------------------------------

test('compact trees answer alike in less than half of the memory', () => {
    const mesh = terrain(CELLS);
    const whole = HTree.build(mesh, { kind: 'wide' });
    const tree = HTree.build(mesh, { kind: 'wide', compact: true });
    assert.ok(2 * tree.stats().bytes < whole.stats().bytes);
    assert.throws(() => tree.view(), { code: 'UNSUPPORTED' });
    assertAnswersAs(tree, mesh);
    const back = HTree.load(tree.save());
    assertAnswersAs(back, mesh);
    assert.equal(tree.update(lifted(mesh), 'refit'), 1);
    assertAnswersAs(tree, lifted(mesh));
    assert.throws(() => HTree.build(mesh, { ...LAZY, compact: true }), { code: 'ARGUMENT' });
    for (const each of [whole, tree, back]) each.close();
});

test('collapsed trees are wide', () => {
    const mesh = terrain(CELLS);
    for (const kind of ['bvh-median', 'ah', 'best']) {
        const tree = HTree.build(mesh, { kind, collapse: true });
        assert.equal(tree.stats().kind, 'wide');
        assertAnswersAs(tree, mesh);
        const plain = HTree.build(mesh, { kind, collapse: false });
        assert.equal(plain.stats().kind, HTree.defaults({ kind }).kind);
        tree.close();
        plain.close();
    }
});

// ---- Lazy --------------------------------------------------------------------------------------

test('rays build a lazy tree, and complete builds the rest', async () => {
    const mesh = terrain(CELLS);
    const eager = HTree.build(mesh, { kind: 'wide', morton: true });
    for (const finish of [(tree) => tree.complete(), (tree) => tree.completeAsync()]) {
        const lazy = HTree.build(mesh, LAZY);
        const { subtrees, subtreesBuilt } = lazy.stats();
        assert.ok(subtrees > 10);
        assert.equal(subtreesBuilt, 0);
        assert.equal(eager.stats().subtrees, 0);
        assert.ok(lazy.occludedRay([0.3, 0.4, 2], [0, 0, -1]));
        const built = lazy.stats().subtreesBuilt;
        assert.ok(built > 0 && built < subtrees, `${built} of ${subtrees}`);
        assert.throws(() => lazy.view(), { code: 'UNSUPPORTED' });
        assertAnswersAs(lazy, mesh);
        await finish(lazy);
        await finish(lazy);
        assert.equal(lazy.stats().subtrees, 0);
        assert.deepEqual(lazy.view(), eager.view());
        assertAnswersAs(lazy, mesh);
        lazy.close();
    }
    eager.close();
});

test('a lazy tree reads no array that JavaScript may take away', async () => {
    const expected = hitsOf(terrain(CELLS));
    const take = ({ positions, indices }) => {
        structuredClone(positions.buffer, { transfer: [positions.buffer, indices.buffer] });
        global.gc();
        return Array.from({ length: 50 }, () => new Float32Array(3 * (CELLS + 1) ** 2).fill(NaN));
    };
    for (const build of [HTree.build, HTree.buildAsync]) {
        const mesh = terrain(CELLS);
        const tree = await build(mesh, LAZY);
        take(mesh);
        assert.deepEqual(tree.intersect(RAYS).words, expected);
        for (const update of [tree.update, tree.updateAsync]) {
            const next = lifted(terrain(CELLS));
            const want = hitsOf(next);
            await update.call(tree, next, 'refit');
            assert.ok(tree.stats().subtrees > 10);
            take(next);
            assert.deepEqual(tree.intersect(RAYS).words, want);
        }
        tree.close();
    }
});

test('shared arrays are kept by a lazy tree', async () => {
    const { positions, indices } = terrain(CELLS);
    const build = (...arrays) => HTree.build({ positions: arrays[0], indices: arrays[1] }, LAZY);
    const tree = build(shared(positions), shared(indices));
    for (let i = 0; i < 20; ++i) {
        global.gc();
        new Uint8Array(new SharedArrayBuffer(positions.byteLength)).fill(255);
        await new Promise((resolve) => { setTimeout(resolve, 1); });
    }
    assertAnswersAs(tree, { positions, indices });
    tree.close();
});

test('workers meet in a lazy tree', async () => {
    const mesh = terrain(CELLS);
    const expected = hitsOf(mesh);
    for (let i = 0; i < 10; ++i) {
        const tree = HTree.build(mesh, LAZY);
        const running = Array.from({ length: 4 }, () => tree.intersectAsync(RAYS));
        for (const hits of await Promise.all(running)) assert.deepEqual(hits.words, expected);
        tree.close();
    }
});

test('presets keep their flags, and flags can be taken back', () => {
    assert.equal(HTree.defaults({ kind: 'fast' }).morton, true);
    assert.equal(HTree.defaults({ kind: 'fast', morton: false }).morton, false);
    assert.equal(HTree.defaults({ kind: 'best' }).collapse, true);
    assert.equal(HTree.defaults(LAZY).lazy, true);
});

// ---- Update ------------------------------------------------------------------------------------

test('every kind answers as a new tree after updates', async () => {
    for (const kind of Object.keys(KINDS)) {
        let mesh = terrain(CELLS);
        const tree = HTree.build({}, { kind });
        for (const how of ['rebuild', 'refit', 'refit', 'rebuild']) {
            for (const update of [tree.update, tree.updateAsync]) {
                mesh = lifted(mesh, 0.02);
                const quality = await update.call(tree, mesh, how);
                assert.ok(quality > 0.2 && quality < 20, `${kind}: ${quality}`);
                assert.ok(how === 'refit' || quality === 1);
                assertAnswersAs(tree, mesh);
            }
        }
        tree.close();
    }
});

test('refitting is no rebuild', () => {
    const mesh = terrain(CELLS);
    const tree = HTree.build(mesh);
    assert.ok(Math.abs(tree.update(mesh, 'refit') - 1) < 1e-9);
    assert.notEqual(tree.update(lifted(mesh, 0.5), 'refit'), 1);
    const fresh = HTree.build(lifted(mesh, 0.5));
    assert.notDeepEqual(tree.view().nodes, fresh.view().nodes);
    assert.equal(tree.update(lifted(mesh, 0.5), 'rebuild'), 1);
    assert.deepEqual(tree.view().nodes, fresh.view().nodes);
    tree.close();
    fresh.close();
});

test('what is refused leaves the tree as it was', async () => {
    const mesh = terrain(CELLS);
    for (const options of [{}, LAZY]) {
        const tree = HTree.build(mesh, options);
        for (const how of ['rebuild', 'refit']) {
            assert.throws(() => tree.update(BAD, how), { code: 'GEOMETRY', message: /vertex 4/ });
            await assert.rejects(tree.updateAsync(BAD, how), { code: 'GEOMETRY' });
        }
        for (const how of [undefined, 'rest', 1, 'toString']) {
            assert.throws(() => tree.update(mesh, how), RangeError);
        }
        assert.throws(() => tree.update(null, 'refit'), TypeError);
        assertAnswersAs(tree, mesh);
        tree.close();
    }
});

test('objects are those of the last update', async () => {
    const at = (t) => ({ objects: { boxes: BOX, intersect: () => ({ t }) } });
    const before = callbacks.live();
    const tree = HTree.build(at(2));
    let t = 2;
    for (const how of ['rebuild', 'refit']) {
        for (const update of [tree.update, tree.updateAsync]) {
            t += 0.25;
            await update.call(tree, at(t), how);
            assert.equal(callbacks.live(), before + 1);
            assert.equal(tree.intersectRay([0, 0, 3], [0, 0, -1]).t, t);
            const bad = { ...BAD, ...at(9) };
            assert.throws(() => tree.update(bad, how), { code: 'GEOMETRY' });
            await assert.rejects(tree.updateAsync(bad, how), { code: 'GEOMETRY' });
            assert.equal(callbacks.live(), before + 1);
            assert.equal(tree.intersectRay([0, 0, 3], [0, 0, -1]).t, t);
        }
    }
    tree.update({}, 'rebuild');
    assert.equal(callbacks.live(), before);
    assert.equal(tree.intersectRay([0, 0, 3], [0, 0, -1]), null);
    tree.close();
});

// ---- One at a time -----------------------------------------------------------------------------

test('a tree is not changed while it is used, nor used while it is changed', async () => {
    const mesh = terrain(CELLS);
    const next = lifted(mesh);
    const tree = HTree.build(mesh);
    const tracing = tree.intersectAsync(RAYS);
    for (const change of [() => tree.complete(), () => tree.update(mesh, 'refit')]) {
        assert.throws(change, /in use/);
        const progress = () => { change(); };
        assert.throws(() => tree.intersect(RAYS, { progress }), /in use/);
    }
    await assert.rejects(tree.updateAsync(mesh, 'refit'), /in use/);
    await assert.rejects(tree.completeAsync(), /in use/);
    assert.deepEqual((await tracing).words, hitsOf(mesh));
    const updating = tree.updateAsync(next, 'rebuild');
    assert.throws(() => tree.intersect(RAYS), /being changed/);
    assert.throws(() => tree.stats(), /being changed/);
    assert.throws(() => tree.update(mesh, 'refit'), /being changed/);
    await assert.rejects(tree.intersectAsync(RAYS), /being changed/);
    assert.equal(await updating, 1);
    assertAnswersAs(tree, next);
    const last = tree.updateAsync(mesh, 'rebuild');
    tree.close();
    assert.equal(await last, 1);
    assert.throws(() => tree.stats(), /closed/);
});
