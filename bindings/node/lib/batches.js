// SPDX-License-Identifier: MIT
'use strict';

const { types } = require('node:util');

/** prim of a miss. */
const NONE = 0xffffffff;

const RAY_FLOATS = 8;
const HIT_WORDS = 4;

/** Answers to a batch of rays, over one buffer: t, u, v and prim of each. */
class Hits {
    #floats;

    #words;

    /** @param {number | ArrayBuffer | SharedArrayBuffer} source how many, or 16 bytes for each */
    constructor(source) {
        const isCount = typeof source === 'number';
        const buffer = isCount ? new ArrayBuffer(4 * HIT_WORDS * source) : source;
        if (!types.isAnyArrayBuffer(buffer) || buffer.byteLength % (4 * HIT_WORDS) !== 0) {
            throw new TypeError('hits need a count, or a buffer of 16 bytes for each');
        }
        this.#floats = new Float32Array(buffer);
        this.#words = new Uint32Array(buffer);
    }

    get buffer() { return this.#words.buffer; }

    get floats() { return this.#floats; }

    get words() { return this.#words; }

    get count() { return this.#words.length / HIT_WORDS; }

    t(index) { return this.#floats[HIT_WORDS * index]; }

    u(index) { return this.#floats[HIT_WORDS * index + 1]; }

    v(index) { return this.#floats[HIT_WORDS * index + 2]; }

    prim(index) { return this.#words[HIT_WORDS * index + 3]; }

    isHit(index) { return this.prim(index) < NONE; }

    get(index) {
        return { t: this.t(index), u: this.u(index), v: this.v(index), prim: this.prim(index) };
    }

    * [Symbol.iterator]() {
        for (let i = 0; i < this.count; ++i) yield this.get(i);
    }
}

/** What each ray of a batch cost, in the paper's terms. */
class Counters {
    #words;

    /** @param {number} count of rays */
    constructor(count) {
        this.#words = new Uint32Array(4 * count);
    }

    get words() { return this.#words; }

    get count() { return this.#words.length / 4; }

    traversalSteps(index) { return this.#words[4 * index]; }

    leafSteps(index) { return this.#words[4 * index + 1]; }

    intersections(index) { return this.#words[4 * index + 2]; }
}

/** The rays' floats: the array itself, or a copy of a plain one. */
function raysOf(rays) {
    const floats = types.isFloat32Array(rays) ? rays : floatsOf(rays, 'rays');
    if (floats.length % RAY_FLOATS !== 0) {
        throw new RangeError(`rays hold ${floats.length} floats: a ray has ${RAY_FLOATS}`);
    }
    return floats;
}

function floatsOf(values, what) {
    if (!Array.isArray(values)) throw new TypeError(`${what} must be a Float32Array or an array`);
    return Float32Array.from(values);
}

/** An array that stays as it is while JavaScript runs beside C: memory that can be moved away or
 * shrunk, as all but shared memory can, is copied. */
function steady(array) {
    return array && !types.isSharedArrayBuffer(array.buffer) ? array.slice() : array;
}

module.exports = { Hits, Counters, NONE, RAY_FLOATS, HIT_WORDS, raysOf, floatsOf, steady };
