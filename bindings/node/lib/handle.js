// SPDX-License-Identifier: MIT
'use strict';

const raw = require('./raw');
const callbacks = require('./callbacks');

let live = 0;

/** A tree of the library and how many use it: its owner, and every call that runs on it. The last
 * to let go frees it, so closing while workers or callbacks use it waits for nothing and breaks
 * nothing. A call that changes the tree is the only one, or it throws: JavaScript's thread, which
 * others need to end, cannot wait for them. */
class Handle {
    #pointer;

    #objectsKey;

    #arrays = null;

    #users = 1;

    #changing = false;

    #closed = false;

    /** @param {object | null} arrays what a lazy tree reads until it is complete */
    constructor(pointer, objectsKey, arrays) {
        this.#pointer = pointer;
        this.#objectsKey = objectsKey;
        this.#arrays = arrays;
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
        if (this.#changing) throw new Error('the tree is being changed by a worker');
        ++this.#users;
        return this.#pointer;
    }

    /** The same for a call that changes it. */
    acquireAlone() {
        const tree = this.acquire();
        if (this.#users > 2) {
            this.release();
            throw new Error('the tree is in use: by a worker, or by the query that calls back');
        }
        this.#changing = true;
        return tree;
    }

    release() {
        this.#changing = false;
        if (--this.#users > 0) return;
        raw.htree_free(this.#pointer);
        callbacks.remove(this.#objectsKey);
        this.#arrays = null;
        --live;
    }

    /** The tree refers to other objects and arrays now. */
    refer(objectsKey, arrays) {
        callbacks.remove(this.#objectsKey);
        this.#objectsKey = objectsKey;
        this.#arrays = arrays;
    }

    /** The tree reads no arrays any more. */
    dropArrays() { this.#arrays = null; }

    close() {
        if (this.#closed) return;
        this.#closed = true;
        this.release();
    }

    /** What `use` makes of the tree, which is acquireAlone() where it changes it. */
    with(use, tree = this.acquire()) {
        try {
            return use(tree);
        } finally {
            this.release();
        }
    }

    /** The same where `use` gives a promise. */
    async withAsync(use, tree = this.acquire()) {
        try {
            return await use(tree);
        } finally {
            this.release();
        }
    }
}

module.exports = { Handle };
