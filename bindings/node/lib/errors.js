// SPDX-License-Identifier: MIT
'use strict';

const raw = require('./raw');

/** The one table of statuses: the names of htree.h and their numbers. */
const STATUSES = Object.freeze({
    OK: 0,
    ARGUMENT: 1,
    MEMORY: 2,
    LIMIT: 3,
    GEOMETRY: 4,
    CANCELLED: 5,
    UNSUPPORTED: 6,
    CORRUPT: 7,
    NO_DEVICE: 8,
    DEVICE: 9,
    DEVICE_LOST: 10,
    KERNEL: 11,
});
const NAMES = new Map(Object.entries(STATUSES).map(([name, number]) => [number, name]));

/** A call of the library failed; the message is the library's own sentence. */
class HTreeError extends Error {
    constructor(status, sentence) {
        super(sentence);
        /** 'GEOMETRY', ...: a name of STATUSES, or UNKNOWN for a number that is not there. */
        this.code = NAMES.get(status) ?? 'UNKNOWN';
        /** The library's number. */
        this.status = status;
        /** The library's words for the number, for example "bad geometry". */
        this.words = raw.htree_status_name(status);
    }
}
Object.defineProperty(HTreeError.prototype, 'name', { value: 'HTreeError', configurable: true });

/** Right after the call, on its thread: the library keeps its sentences by thread. */
function check(status) {
    if (status !== 0) throw new HTreeError(status, raw.htree_error_text());
}

module.exports = { HTreeError, STATUSES, check };
