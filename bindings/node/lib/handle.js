// SPDX-License-Identifier: MIT
'use strict';

const raw = require('./raw');
const callbacks = require('./callbacks');

let live = 0;

/** A tree of the library and how many use it: its owner, and every call that runs on it. The last
 * to let go frees it, so closing while workers or callbacks use it waits for nothing and breaks
 * nothing. */
class Handle {
    #pointer;

    #objectsKey;

    #users = 1;

    #closed = false;

    constructor(pointer, objectsKey) {
        this.#pointer = pointer;
        this.#objectsKey = objectsKey;
        ++live;
    }

    /** Trees that are not freed yet, for tests. */
    static get live() { return live; }

    get closed() { return this.#closed; }

    get objectsKey() { return this.#objectsKey; }

    get hasObjects() { return this.#objectsKey !== 0; }

    /** The tree, until release. */
    acquire() {
        if (this.#closed) throw new Error('the tree is closed');
        ++this.#users;
        return this.#pointer;
    }

    release() {
        if (--this.#users > 0) return;
        raw.htree_free(this.#pointer);
        callbacks.remove(this.#objectsKey);
        --live;
    }

    close() {
        if (this.#closed) return;
        this.#closed = true;
        this.release();
    }

    /** What `use` makes of the tree. */
    with(use) {
        const tree = this.acquire();
        try {
            return use(tree);
        } finally {
            this.release();
        }
    }

    /** The same where `use` gives a promise. */
    async withAsync(use) {
        const tree = this.acquire();
        try {
            return await use(tree);
        } finally {
            this.release();
        }
    }
}

module.exports = { Handle };
