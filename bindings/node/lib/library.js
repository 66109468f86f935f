// SPDX-License-Identifier: MIT
'use strict';

/* Finds libhtree, and refuses one whose structs may differ from ours. */

const fs = require('node:fs');
const path = require('node:path');
const koffi = require('koffi');

/** The version of htree.h that raw.js declares. */
const VERSION = { major: 0, minor: 1, patch: 0 };

const FILES = { linux: 'libhtree.so', darwin: 'libhtree.dylib', win32: 'htree.dll' };
const SYSTEM_FILES = { linux: 'libhtree.so.0', darwin: 'libhtree.0.dylib', win32: 'htree.dll' };

function numbers(version) {
    return {
        major: Math.floor(version / 10000),
        minor: Math.floor(version / 100) % 100,
        patch: version % 100,
    };
}

function dotted({ major, minor, patch }) {
    return `${major}.${minor}.${patch}`;
}

/** HTREE_LIBRARY, else the package's own, else the system's. */
function find() {
    if (process.env.HTREE_LIBRARY) return process.env.HTREE_LIBRARY;
    const folder = `${process.platform}-${process.arch}`;
    const file = path.join(__dirname, '..', 'prebuilt', folder, FILES[process.platform] ?? '');
    return fs.existsSync(file) && fs.statSync(file).isFile()
        ? file
        : SYSTEM_FILES[process.platform] ?? 'libhtree.so';
}

function open() {
    const file = find();
    try {
        return [koffi.load(file), file];
    } catch (cause) {
        throw new Error(
            `htree: cannot load ${file}: ${cause.message}; HTREE_LIBRARY may name the library`,
            { cause });
    }
}

function requireCompatible(version, file) {
    const { major, minor } = numbers(version);
    if (major === VERSION.major && (major !== 0 || minor === VERSION.minor)) return;
    throw new Error(`htree: ${file} has version ${dotted(numbers(version))}; ` +
        `this binding needs ${VERSION.major}.${VERSION.minor}`);
}

const [library, file] = open();
requireCompatible(library.func('htree_version', 'uint32_t', [])(), file);

module.exports = { library, VERSION, numbers, dotted, requireCompatible };
