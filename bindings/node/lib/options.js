// SPDX-License-Identifier: MIT
'use strict';

/* Options between JavaScript's names and the struct's. The defaults are the library's. */

const koffi = require('koffi');
const raw = require('./raw');
const { check } = require('./errors');

/** Kinds by name, and their numbers; the last three are presets. */
const KINDS = Object.freeze(Object.fromEntries(
    ['ug', 'kd', 'bvh-median', 'bvh-sah', 'skd', 'h', 'ah', 'wide', 'fast', 'balanced', 'best']
        .map((name) => [name, raw.htree_kind_from_name(name)])));

const FLAGS = {
    strict: 1, anyPlanes: 2, loosePlanes: 4, morton: 8, lazy: 16, compact: 32, collapse: 64,
};
const INTEGERS = { threads: 'threads', buckets: 'buckets', axes: 'axes', fewPrims: 'few_prims' };
const FLOATS = {
    costSkd: 'cost_skd',
    costBv2: 'cost_bv2',
    costBv6: 'cost_bv6',
    costIntersect: 'cost_intersect',
    cellsPerPrim: 'cells_per_prim',
};
const NAMES = ['kind', 'progress', ...Object.keys({ ...FLAGS, ...INTEGERS, ...FLOATS })];

const BLANK_OPTIONS = () => ({
    size: 0, kind: 0, flags: 0, threads: 0, buckets: 0, axes: 0, cost_skd: 0, cost_bv2: 0,
    cost_bv6: 0, cost_intersect: 0, cells_per_prim: 0, few_prims: 0,
    allocator: { allocate: null, release: null, user: null },
    tasks: { run: null, user: null },
    progress: { report: null, user: 0 },
});

/** A misspelt name would be an option that does nothing. */
function requireNames(given, names, what) {
    if (given === null || typeof given !== 'object') {
        throw new TypeError(`${what} must be an object`);
    }
    for (const name of Object.keys(given)) {
        if (!names.includes(name)) throw new TypeError(`${what} have no ${name}`);
    }
}

/** C would take another number for one that it is not. */
function requireUint32(value, what) {
    if (!Number.isInteger(value) || value < 0 || value > 0xffffffff) {
        throw new RangeError(`${what} is ${value}: must be an integer from 0 to 2^32 - 1`);
    }
    return value;
}

function requireNumber(value, what) {
    if (typeof value !== 'number') throw new TypeError(`${what} must be a number`);
    return value;
}

/** A number is handed on, so that the library judges it. */
function kindNumber(kind) {
    if (Number.isInteger(kind) && Math.abs(kind) < 2 ** 31) return kind;
    if (!Object.hasOwn(KINDS, kind)) throw new RangeError(`no kind is named ${String(kind)}`);
    return KINDS[kind];
}

/** The struct of options as the caller gave them; its progress is left empty. */
function toStruct(given) {
    requireNames(given, NAMES, 'options');
    const struct = BLANK_OPTIONS();
    const kind = kindNumber(given.kind ?? 'balanced');
    check(raw.htree_options_init(struct, koffi.sizeof(raw.types.htree_options), kind));
    for (const [name, bit] of Object.entries(FLAGS)) {
        if (given[name] === undefined) continue;
        struct.flags = given[name] ? struct.flags | bit : struct.flags & ~bit;
    }
    for (const [name, field] of Object.entries(INTEGERS)) {
        if (given[name] !== undefined) struct[field] = requireUint32(given[name], name);
    }
    for (const [name, field] of Object.entries(FLOATS)) {
        if (given[name] !== undefined) struct[field] = requireNumber(given[name], name);
    }
    return struct;
}

/** Whether a tree with these options reads its mesh after the build. */
const isLazy = ({ kind, flags }) => kind === KINDS.wide && (flags & FLAGS.lazy) !== 0;

function fromStruct(struct) {
    const options = { kind: raw.htree_kind_name(struct.kind) };
    for (const [name, bit] of Object.entries(FLAGS)) options[name] = (struct.flags & bit) !== 0;
    for (const [name, field] of Object.entries({ ...INTEGERS, ...FLOATS })) {
        options[name] = struct[field];
    }
    return options;
}

/** These options with every default filled in. */
const defaults = (given) => fromStruct(toStruct(given));

/** The same with the four costs as measured on this machine. */
function calibrated(given) {
    const struct = toStruct(given);
    check(raw.htree_calibrate(struct));
    return fromStruct(struct);
}

module.exports = { KINDS, toStruct, isLazy, defaults, calibrated, requireNames, requireUint32 };
