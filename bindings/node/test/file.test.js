// SPDX-License-Identifier: MIT
'use strict';

/* A tree that is saved and loaded is the same tree, and what is no tree is not loaded. */

const test = require('node:test');
const assert = require('node:assert/strict');
const { HTree } = require('htree');
const callbacks = require('../lib/callbacks');
const { TETRAHEDRON, terrain, above } = require('./common');

test('a saved tree comes back, of every kind', () => {
    const rays = above(40);
    for (const kind of ['ug', 'kd', 'bvh-median', 'bvh-sah', 'skd', 'h', 'ah', 'wide']) {
        const tree = HTree.build(terrain(20), { kind });
        const file = tree.save();
        const moved = new Uint8Array(file.length + 3);
        moved.set(file, 3);
        for (const bytes of [file, file.buffer, Buffer.from(file), moved.subarray(3)]) {
            const back = HTree.load(bytes, { threads: 1 });
            assert.equal(back.stats().kind, kind);
            assert.deepEqual(back.intersect(rays).words, tree.intersect(rays).words);
            assert.deepEqual(back.save(), file);
            back.check();
            back.close();
        }
        tree.close();
        assert.throws(() => tree.save(), /closed/);
    }
});

test('objects need their function again', () => {
    const boxes = [0, 0, 0, 1, 1, 1, 2, 0, 0, 3, 1, 1];
    const intersect = (object, { org, dir }) => ({ t: (1 - org[2]) / dir[2], v: object });
    const tree = HTree.build({ objects: { boxes, intersect } });
    const file = tree.save();
    tree.close();
    const before = callbacks.live();
    assert.throws(() => HTree.load(file), { code: 'ARGUMENT' });
    assert.throws(() => HTree.load(file.subarray(1), { intersect }), { code: 'CORRUPT' });
    assert.equal(callbacks.live(), before);
    const back = HTree.load(file, { intersect });
    assert.deepEqual(back.intersectRay([2.5, 0.5, 5], [0, 0, -1]), { t: 4, u: 0, v: 1, prim: 1 });
    back.close();
    assert.equal(callbacks.live(), before);
});

test('what is no tree is not loaded', () => {
    const tree = HTree.build(TETRAHEDRON);
    const file = tree.save();
    tree.close();
    const changed = file.slice();
    changed[file.length >> 1] ^= 1;
    for (const bad of [new Uint8Array(0), file.subarray(0, 100), file.subarray(1), changed]) {
        assert.throws(() => HTree.load(bad), { name: 'HTreeError', code: 'CORRUPT' });
    }
    for (const bad of [null, 'text', 5, [1, 2]]) assert.throws(() => HTree.load(bad), TypeError);
    assert.throws(() => HTree.load(file, { thread: 1 }), TypeError);
    assert.throws(() => HTree.load(file, { intersect: 1 }), TypeError);
    assert.throws(() => HTree.load(file, { threads: -1 }), RangeError);
});
