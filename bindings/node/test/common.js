// SPDX-License-Identifier: MIT
'use strict';

/* Meshes and rays that the tests share, and the file that the C library's own tests write. */

const fs = require('node:fs');

const TETRAHEDRON = {
    positions: new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]),
    indices: new Uint32Array([0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]),
};

/** Heights over n x n cells of the unit square. */
function terrain(n) {
    const positions = [];
    const indices = [];
    for (let j = 0; j <= n; ++j) {
        for (let i = 0; i <= n; ++i) {
            positions.push(i / n, j / n, 0.1 * Math.sin(9 * i / n) * Math.cos(7 * j / n));
        }
    }
    for (let j = 0; j < n; ++j) {
        for (let i = 0; i < n; ++i) {
            const a = j * (n + 1) + i;
            const b = a + n + 1;
            indices.push(a, a + 1, b, a + 1, b + 1, b);
        }
    }
    return { positions: Float32Array.from(positions), indices: Uint32Array.from(indices) };
}

/** side x side rays from above, some of them past a terrain's border. */
function above(side) {
    const rays = new Float32Array(8 * side * side);
    for (let i = 0; i < side * side; ++i) {
        const x = 1.2 * (i % side) / side - 0.1;
        const y = 1.2 * Math.floor(i / side) / side - 0.1;
        rays.set([x, y, 2, 0, 0.01, 0.02, -1, Infinity], 8 * i);
    }
    return rays;
}

/** Floats in memory that workers may share. */
function shared(floats) {
    const copy = new floats.constructor(new SharedArrayBuffer(floats.byteLength));
    copy.set(floats);
    return copy;
}

const floatsOfBits = (bits) => new Float32Array(Uint32Array.from(bits).buffer);

const readConformance = () => JSON.parse(fs.readFileSync(process.env.HTREE_CONFORMANCE, 'utf8'));

const resident = () => process.memoryUsage().rss;

/** Collects garbage until a condition holds, and lets finalisers run. */
async function collectUntil(holds) {
    for (let i = 0; i < 200 && !holds(); ++i) {
        global.gc();
        await new Promise((resolve) => { setTimeout(resolve, 5); });
    }
}

module.exports = {
    TETRAHEDRON, terrain, above, shared, floatsOfBits, readConformance, resident, collectUntil,
};
