// SPDX-License-Identifier: MIT

/* Renders a wavy floor with a bowl on it, lit from everywhere, to a PGM: one batch of rays finds
 * what each pixel sees, one more finds how much of the sky each point sees. */

import { writeFile } from 'node:fs/promises';
import { HTree } from 'htree';

const SIDE = 256;
const SAMPLES = 32;
const CELLS = 96;

/** A grid of cells over [-2, 2] x [-2, 2]: waves, and in the middle half a sphere. */
function scene() {
    const positions = [];
    for (let v = 0; v < (CELLS + 1) ** 2; ++v) {
        const x = 4 * (v % (CELLS + 1)) / CELLS - 2;
        const y = 4 * Math.floor(v / (CELLS + 1)) / CELLS - 2;
        const waves = 0.12 * Math.sin(5 * x) * Math.cos(4 * y);
        positions.push(x, y, Math.max(waves, Math.sqrt(Math.max(0, 1 - x * x - y * y))));
    }
    const indices = [];
    for (let c = 0; c < CELLS * CELLS; ++c) {
        const a = Math.floor(c / CELLS) * (CELLS + 1) + c % CELLS;
        const b = a + CELLS + 1;
        indices.push(a, a + 1, b, a + 1, b + 1, b);
    }
    return { positions: Float32Array.from(positions), indices: Uint32Array.from(indices) };
}

/** Memory that a worker may use without a copy. */
const sharedRays = (count) => new Float32Array(new SharedArrayBuffer(32 * count));

/** Parallel rays from above, slanted. */
function eyeRays() {
    const rays = sharedRays(SIDE * SIDE);
    for (let i = 0; i < SIDE * SIDE; ++i) {
        const x = 3.6 * (i % SIDE) / SIDE - 1.8;
        const y = 1.8 - 3.6 * Math.floor(i / SIDE) / SIDE;
        rays.set([x, y - 3, 4, 0, 0, 0.6, -0.8, 100], 8 * i);
    }
    return rays;
}

/** Numbers from 0 to 1, the same in every run. */
function randomNumbers() {
    let state = 1;
    return () => {
        state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
        return state / 2 ** 32;
    };
}

/** SAMPLES rays up from every point that was hit; those of misses point nowhere. */
function skyRays(eye, hits) {
    const rays = sharedRays(hits.count * SAMPLES);
    const random = randomNumbers();
    for (let i = 0; i < hits.count * SAMPLES; ++i) {
        const pixel = Math.floor(i / SAMPLES);
        const [x, y, z, , dx, dy, dz] = eye.subarray(8 * pixel, 8 * pixel + 8);
        const t = hits.isHit(pixel) ? hits.t(pixel) : NaN;
        const up = random();
        const angle = 2 * Math.PI * random();
        const radius = Math.sqrt(1 - up * up);
        rays.set([x + t * dx, y + t * dy, z + t * dz, 1e-3,
            radius * Math.cos(angle), radius * Math.sin(angle), up, 100], 8 * i);
    }
    return rays;
}

function picture(hits, occluded) {
    const pixels = new Uint8Array(hits.count);
    for (let i = 0; i < hits.count; ++i) {
        const closed = occluded.subarray(i * SAMPLES, (i + 1) * SAMPLES).reduce((a, b) => a + b);
        pixels[i] = hits.isHit(i) ? 255 * (SAMPLES - closed) / SAMPLES : 24;
    }
    return Buffer.concat([Buffer.from(`P5\n${SIDE} ${SIDE}\n255\n`), pixels]);
}

const out = process.argv[2] ?? 'occlusion.pgm';
const tree = await HTree.buildAsync(scene());
const eye = eyeRays();
const hits = await tree.intersectAsync(eye);
const occluded = await tree.occludedAsync(skyRays(eye, hits));
await writeFile(out, picture(hits, occluded));
console.log(`${out}: ${tree.stats().triangles} triangles, ${hits.count * (1 + SAMPLES)} rays`);
tree.close();
