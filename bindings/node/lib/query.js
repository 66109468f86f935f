// SPDX-License-Identifier: MIT
'use strict';

/* One batch: the caller's arrays checked, and those that C gets. */

const koffi = require('koffi');
const { types } = require('node:util');
const raw = require('./raw');
const { check } = require('./errors');
const { Hits, HIT_WORDS, RAY_FLOATS, raysOf, steady } = require('./batches');
const { requireNames, requireUint32 } = require('./options');

const COUNTER_WORDS = 4;
const QUERY_BYTES = koffi.sizeof(raw.types.htree_query);
const NAMES = ['threads', 'counters', 'progress'];

/** An array that C writes. What the caller has and JavaScript may move while C runs is written
 * elsewhere first, and copied when C is done. */
class Output {
    #callers;

    #used;

    constructor(callers, used, moves) {
        this.#callers = callers;
        this.#used = used;
        this.array = moves ? steady(callers) : callers;
    }

    finish() {
        if (this.array !== this.#callers) this.#callers.set(this.array.subarray(0, this.#used));
    }
}

function requireRoom(words, used, isType, what) {
    if (!isType(words) || words.length < used) {
        throw new RangeError(`${what} have no room for an answer to every ray`);
    }
    return words;
}

/** A batch of htree_intersect ('hits') or htree_occluded ('occluded'). */
class Batch {
    constructor(answer, rays, options, handle, treeThreads, isAsync) {
        requireNames(options, [...NAMES, answer], 'options');
        const { threads, counters, progress } = options;
        refuseJavaScriptElsewhere(handle, threads, progress, isAsync);
        const moves = isAsync || handle.hasObjects || progress != null;
        const floats = raysOf(rays);
        this.count = floats.length / RAY_FLOATS;
        this.rays = moves ? steady(floats) : floats;
        this.progress = progress;
        this.threads = handle.hasObjects ? 1 : requireUint32(threads ?? treeThreads, 'threads');
        this.isPlain = threads === undefined && counters == null && progress == null
            && !handle.hasObjects;
        this.outputs = [];
        this.counters = counters == null ? null : this.#output(requireRoom(
            counters.words, COUNTER_WORDS * this.count, types.isUint32Array, 'counters'),
        COUNTER_WORDS * this.count, moves);
        this.#answer(answer, options[answer], moves);
    }

    #output(array, used, moves) {
        const output = new Output(array, used, moves);
        this.outputs.push(output);
        return output.array;
    }

    /** An array that is made here is nobody else's until the call is over. */
    #answer(answer, given, moves) {
        const own = given == null;
        if (answer === 'hits') {
            const used = HIT_WORDS * this.count;
            this.result = own ? new Hits(this.count) : given;
            this.answers = this.#output(
                requireRoom(this.result.words, used, types.isUint32Array, 'hits'),
                used, moves && !own);
        } else {
            this.result = own ? new Uint8Array(this.count) : given;
            this.answers = this.#output(
                requireRoom(this.result, this.count, types.isUint8Array, 'occluded'),
                this.count, moves && !own);
        }
    }

    /** The struct; NULL, which means the same, where nothing was asked for. */
    struct(progress) {
        if (this.isPlain) return null;
        const query = {
            size: 0, flags: 0, threads: 0, reserved: 0, counters: null,
            progress: { report: null, user: 0 },
        };
        check(raw.htree_query_init(query, QUERY_BYTES));
        query.threads = this.threads;
        query.counters = this.counters;
        query.progress = progress;
        return query;
    }

    finish() {
        for (const output of this.outputs) output.finish();
        return this.result;
    }
}

/** JavaScript runs on one thread, and C must not wait for it on another. */
function refuseJavaScriptElsewhere(handle, threads, progress, isAsync) {
    if (isAsync && progress != null) {
        throw new TypeError('progress cannot be heard from a worker: use the call that waits');
    }
    if (isAsync && handle.hasObjects) {
        throw new TypeError('objects cannot be tested on a worker: use the call that waits');
    }
    if (handle.hasObjects && threads !== undefined && threads !== 1) {
        throw new RangeError(`threads is ${threads}: objects are tested on the caller's thread, 1`);
    }
}

module.exports = { Batch };
