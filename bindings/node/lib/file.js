// SPDX-License-Identifier: MIT
'use strict';

/* A tree as bytes, and bytes as a tree. */

const koffi = require('koffi');
const raw = require('./raw');
const callbacks = require('./callbacks');
const { check } = require('./errors');
const { requireNames, requireUint32 } = require('./options');

const OPTIONS_BYTES = koffi.sizeof(raw.types.htree_load_options);

function save(tree) {
    const size = [0];
    check(raw.htree_save(tree, null, 0, size));
    const file = new Uint8Array(Number(size[0]));
    check(raw.htree_save(tree, file, file.length, size));
    return file;
}

/** The struct; `key` names the objects' callback, if there is one. */
function toStruct(threads, key) {
    const struct = {
        size: 0, flags: 0, threads: 0, reserved: 0, intersect: null, user: 0,
        allocator: { allocate: null, release: null, user: null },
        tasks: { run: null, user: null },
    };
    check(raw.htree_load_options_init(struct, OPTIONS_BYTES));
    struct.threads = threads;
    if (key) {
        struct.intersect = callbacks.intersect;
        struct.user = key;
    }
    return struct;
}

function bytesOf(file) {
    const isView = ArrayBuffer.isView(file);
    if (!isView && !(file instanceof ArrayBuffer) && !(file instanceof SharedArrayBuffer)) {
        throw new TypeError('a file must be a Uint8Array or a buffer');
    }
    return isView ? new Uint8Array(file.buffer, file.byteOffset, file.byteLength)
        : new Uint8Array(file);
}

/** The tree's pointer, the key of its objects' callback, and its threads. */
function load(file, given) {
    requireNames(given, ['threads', 'intersect'], 'load options');
    const { threads = 0, intersect = null } = given;
    if (intersect !== null && typeof intersect !== 'function') {
        throw new TypeError('intersect must be a function');
    }
    const bytes = bytesOf(file);
    const key = intersect ? callbacks.add(intersect) : 0;
    const out = [null];
    try {
        const struct = toStruct(requireUint32(threads, 'threads'), key);
        // Of no bytes there is no address, and they are no tree.
        const memory = bytes.length > 0 ? bytes : new Uint8Array(1);
        check(raw.htree_load(out, memory, bytes.length, struct));
    } catch (thrown) {
        callbacks.remove(key);
        throw thrown;
    }
    return { pointer: out[0], key, threads };
}

module.exports = { save, load };
