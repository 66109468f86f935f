// SPDX-License-Identifier: MIT
'use strict';

/* JavaScript called from C. Two trampolines serve all trees and calls, which C tells apart by the
 * number that it hands back as `user`. What JavaScript throws must not cross C: it is kept, and
 * thrown when the call is over. */

const koffi = require('koffi');
const { types } = require('./raw');

const clients = new Map();
let lastKey = 0;

function add(callback) {
    clients.set(++lastKey, { callback, failures: [] });
    return lastKey;
}

const remove = (key) => clients.delete(key);

/** Callbacks that C may still call, for tests. */
const live = () => clients.size;

function guarded(key, otherwise, call) {
    const client = clients.get(key);
    try {
        return call(client.callback);
    } catch (thrown) {
        client.failures.push(thrown);
        return otherwise;
    }
}

const report = koffi.register(
    (key, fraction) => guarded(key, 1, (progress) => (progress(fraction) ? 1 : 0)),
    types.htree_report);

const intersect = koffi.register((key, object, rayPointer, hitPointer) => {
    return guarded(key, 0, (intersectObject) => {
        const hit = intersectObject(object, koffi.decode(rayPointer, types.htree_ray));
        if (!hit) return 0;
        const { t, u = 0, v = 0 } = hit;
        if (![t, u, v].every((value) => typeof value === 'number')) {
            throw new TypeError('an object is hit at {t, u, v}, or not at all');
        }
        koffi.encode(hitPointer, types.htree_hit, { t, u, v, prim: 0 });
        return 1;
    });
}, types.htree_object_intersect);

/** Calls `use`, and throws what the client with this key threw meanwhile, if there is one. */
function rethrowing(key, use) {
    const client = clients.get(key);
    if (!client) return use();
    const outer = client.failures;
    client.failures = [];
    try {
        const result = use();
        if (client.failures.length > 0) throw client.failures[0];
        return result;
    } finally {
        client.failures = outer;
    }
}

/** Calls `use` with the struct of a progress hook, and throws what the hook threw. */
function withProgress(progress, use) {
    if (progress == null) return use({ report: null, user: 0 });
    if (typeof progress !== 'function') throw new TypeError('progress must be a function');
    const user = add(progress);
    try {
        return rethrowing(user, () => use({ report, user }));
    } finally {
        remove(user);
    }
}

module.exports = { intersect, add, remove, live, rethrowing, withProgress };
