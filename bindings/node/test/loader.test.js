// SPDX-License-Identifier: MIT
'use strict';

/* Which library is loaded, and which is refused. Each in a process of its own. */

const test = require('node:test');
const assert = require('node:assert/strict');
const fs = require('node:fs');
const path = require('node:path');
const { spawnSync } = require('node:child_process');
const { requireCompatible, VERSION } = require('../lib/library');

const PACKAGE = path.join(__dirname, '..');

function load(library, script = 'console.log(require("htree").libraryVersion())') {
    const env = { ...process.env, HTREE_LIBRARY: library };
    if (library === undefined) delete env.HTREE_LIBRARY;
    return spawnSync(process.execPath, ['-e', script], { cwd: PACKAGE, env, encoding: 'utf8' });
}

test('versions of this ABI are taken, others refused', () => {
    const ours = 10000 * VERSION.major + 100 * VERSION.minor;
    requireCompatible(ours, 'libhtree');
    requireCompatible(ours + 99, 'libhtree');
    assert.throws(() => requireCompatible(ours + 100, 'libhtree'), /needs 0\.1/);
    assert.throws(() => requireCompatible(ours + 10000, 'libhtree'), /needs 0\.1/);
});

test('HTREE_LIBRARY comes first', () => {
    const run = load(process.env.HTREE_LIBRARY);
    assert.equal(run.stdout.trim(), '0.1.0');
    assert.match(load('/nowhere/libhtree.so').stderr, /htree: cannot load \/nowhere\/libhtree\.so/);
});

test('a library of another ABI is refused', { skip: !process.env.HTREE_SKEWED }, () => {
    const run = load(process.env.HTREE_SKEWED);
    assert.notEqual(run.status, 0);
    assert.match(run.stderr, /has version 0\.2\.0; this binding needs 0\.1/);
});

test('the package\'s own library comes next', { skip: process.platform !== 'linux' }, () => {
    const folder = path.join(PACKAGE, 'prebuilt', `${process.platform}-${process.arch}`);
    assert.equal(fs.existsSync(folder), false);
    try {
        fs.mkdirSync(folder, { recursive: true });
        fs.copyFileSync(process.env.HTREE_LIBRARY, path.join(folder, 'libhtree.so'));
        assert.equal(load(undefined).stdout.trim(), '0.1.0');
    } finally {
        fs.rmSync(path.join(PACKAGE, 'prebuilt'), { recursive: true });
    }
});

test('threads of JavaScript load it too', () => {
    const run = load(process.env.HTREE_LIBRARY, `
        const { Worker } = require('node:worker_threads');
        new Worker(\`
            const { HTree } = require('htree');
            const tree = HTree.build({ positions: [0, 0, 0, 1, 0, 0, 0, 1, 0] });
            console.log(tree.intersectRay([0.2, 0.2, 1], [0, 0, -1]).t);
        \`, { eval: true });
        require('htree');`);
    assert.equal(run.stdout.trim(), '1', run.stderr);
});

test('a process may exit while workers trace', () => {
    const run = load(process.env.HTREE_LIBRARY, `
        const { HTree } = require('htree');
        const tree = HTree.build({ positions: [0, 0, 0, 1, 0, 0, 0, 1, 0] });
        tree.intersectAsync(new Float32Array(8000000));
        setTimeout(() => process.exit(3), 5);`);
    assert.equal(run.status, 3, run.stderr);
});
