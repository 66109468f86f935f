// SPDX-License-Identifier: MIT
'use strict';

/* Every kind gives the C library's bits, on one thread and on all, waiting or not. */

const test = require('node:test');
const assert = require('node:assert/strict');
const { HTree, HTreeError, STATUSES, NONE, libraryVersion, bindingVersion } = require('htree');
const raw = require('htree/raw');
const { floatsOfBits, readConformance } = require('./common');

const file = readConformance();
assert.equal(file.format, 1);
assert.ok(file.scenes.length > 0 && file.kinds.length > 0);

const meshOf = (scene) => ({
    positions: floatsOfBits(scene.positions),
    indices: scene.indices && Uint32Array.from(scene.indices),
});
const bits = (floats) => Array.from(new Uint32Array(Float32Array.from(floats).buffer));

for (const scene of file.scenes) {
    for (const kind of file.kinds) {
        test(`${scene.name} ${kind} gives the bits of C`, async () => {
            const rays = floatsOfBits(scene.rays);
            const hits = Uint32Array.from(scene.hits);
            const occluded = Uint8Array.from(scene.occluded);
            for (const threads of [1, 0]) {
                const tree = HTree.build(meshOf(scene), { kind, threads });
                tree.check();
                assert.deepEqual(tree.intersect(rays).words, hits);
                assert.deepEqual(tree.occluded(rays), occluded);
                assert.deepEqual((await tree.intersectAsync(rays)).words, hits);
                assert.deepEqual(await tree.occludedAsync(rays), occluded);
                const { lo, hi } = tree.bounds();
                assert.deepEqual(bits([...lo, ...hi]), scene.bounds);
                const { triangles, objects, invalid, degenerate, kind: built } = tree.stats();
                assert.deepEqual({ triangles, objects, invalid, degenerate }, scene.stats);
                assert.equal(built, kind);
                tree.close();
            }
            const tree = await HTree.buildAsync(meshOf(scene), { kind });
            assert.deepEqual(tree.intersect(rays).words, hits);
            tree.close();
        });
    }
}

function assertAnswers(scene, tree) {
    const rays = floatsOfBits(scene.rays);
    tree.check();
    assert.deepEqual(tree.intersect(rays).words, Uint32Array.from(scene.hits));
    assert.deepEqual(tree.occluded(rays), Uint8Array.from(scene.occluded));
}

test('lazy trees and complete ones give the bits of C', () => {
    for (const scene of file.scenes) {
        const tree = HTree.build(meshOf(scene), { kind: 'wide', lazy: true });
        assertAnswers(scene, tree);
        tree.complete();
        assertAnswers(scene, tree);
        tree.close();
    }
});

test('a tree that goes from scene to scene gives the bits of C', () => {
    for (const kind of file.kinds) {
        const tree = HTree.build({}, { kind });
        for (const scene of file.scenes) {
            for (const how of ['rebuild', 'refit']) {
                tree.update(meshOf(scene), how);
                assertAnswers(scene, tree);
            }
        }
        tree.close();
    }
});

test('one ray gives the bits of its batch', () => {
    for (const scene of file.scenes) {
        const rays = floatsOfBits(scene.rays);
        const tree = HTree.build(meshOf(scene));
        for (let i = 0; i < rays.length / 8; ++i) {
            const ray = rays.subarray(8 * i, 8 * i + 8);
            const one = [ray.subarray(0, 3), ray.subarray(4, 7), ray[3], ray[7]];
            const [t, u, v, prim] = scene.hits.slice(4 * i, 4 * i + 4);
            const hit = tree.intersectRay(...one);
            if (prim === NONE) {
                assert.equal(hit, null);
            } else {
                assert.equal(hit.prim, prim);
                assert.deepEqual(bits([hit.t, hit.u, hit.v]), [t, u, v]);
            }
            assert.equal(tree.occludedRay(...one), scene.occluded[i] === 1);
        }
        tree.close();
    }
});

test('statuses are the library\'s', () => {
    assert.deepEqual({ ...STATUSES }, file.statuses);
    for (const [name, number] of Object.entries(STATUSES)) {
        const error = new HTreeError(number, 'sentence');
        assert.equal(error.code, name);
        assert.equal(error.words, file.status_names[number]);
        assert.equal(raw.htree_status_name(number), file.status_names[number]);
    }
    assert.equal(new HTreeError(12345, '').code, 'UNKNOWN');
});

test('the library is the one that wrote the file', () => {
    assert.equal(libraryVersion(), file.library);
    assert.equal(bindingVersion(), '0.1.0');
});
