// SPDX-License-Identifier: MIT
'use strict';

const koffi = require('koffi');
const raw = require('./raw');
const meshes = require('./mesh');
const options = require('./options');
const callbacks = require('./callbacks');
const { check, HTreeError, STATUSES } = require('./errors');
const { Batch } = require('./query');
const { Hits } = require('./batches');
const { Handle } = require('./handle');
const inspect = require('./inspect');
const files = require('./file');

if (!Symbol.dispose) {
    Object.defineProperty(Symbol, 'dispose', { value: Symbol('Symbol.dispose') });
}

/** How update brings a tree to a mesh. */
const HOW = { rebuild: 1, refit: 2 };

/** Only build and load know it, so only they construct. */
const BUILT = Symbol('built');
const forgotten = new FinalizationRegistry((handle) => handle.close());

/** Runs a function of the library on a worker. */
function onWorker(f, ...parameters) {
    return new Promise((resolve, reject) => {
        f.async(...parameters, (error, result) => (error ? reject(error) : resolve(result)));
    });
}

/** A mesh as C reads it; a lazy tree goes on reading, so it gets copies that stay. */
function prepareMesh(mesh, copy, lazy) {
    const parts = meshes.read(mesh, copy || lazy);
    const key = parts.objects ? callbacks.add(parts.objects.intersect) : 0;
    return { mesh: meshes.toStruct(parts, key), key, arrays: lazy ? parts : null };
}

/** What htree_build gets and fills. */
function prepare(mesh, given, copy) {
    const struct = options.toStruct(given);
    return { struct, out: [null], ...prepareMesh(mesh, copy, options.isLazy(struct)) };
}

/** What htree_update gets and fills. */
function prepareUpdate(mesh, how, copy, lazy) {
    if (!Object.hasOwn(HOW, how)) throw new RangeError(`no update is named ${String(how)}`);
    return { how: HOW[how], quality: [0], ...prepareMesh(mesh, copy, lazy) };
}

function abandon({ out, key }) {
    raw.htree_free(out[0]);
    callbacks.remove(key);
}

/** The sentence stayed with the worker's thread. A mistake that the library finds before it builds
 * says it again when it is made here. */
function explain(status, { out, mesh, struct }) {
    const early = [STATUSES.ARGUMENT, STATUSES.GEOMETRY, STATUSES.LIMIT, STATUSES.UNSUPPORTED];
    if (early.includes(status) && raw.htree_build(out, mesh, struct) === status) check(status);
    throw new HTreeError(status, raw.htree_status_name(status));
}

/** The tree has been brought to the mesh; an update that fails keeps its key, to be removed. */
function adopt(handle, update) {
    handle.refer(update.key, update.arrays);
    update.key = 0;
    return update.quality[0];
}

/** What a worker's call came to. Its sentence stayed with the worker's thread. */
function requireOk(status) {
    if (status !== 0) throw new HTreeError(status, raw.htree_status_name(status));
}

/** A hierarchy over a mesh, which only update and complete change. */
class HTree {
    #handle;

    #threads;

    #lazy;

    constructor(built, handle, threads, lazy) {
        if (built !== BUILT) throw new TypeError('HTree.build and HTree.load make trees');
        this.#handle = handle;
        this.#threads = threads;
        this.#lazy = lazy;
        forgotten.register(this, handle, this);
    }

    static #of({ out, key, struct, arrays }) {
        const lazy = options.isLazy(struct);
        return new HTree(BUILT, new Handle(out[0], key, arrays), struct.threads, lazy);
    }

    static build(mesh, given = {}) {
        const { progress } = given;
        const build = prepare(mesh, given, progress != null);
        try {
            check(callbacks.withProgress(progress, (hook) => {
                return raw.htree_build(build.out, build.mesh, { ...build.struct, progress: hook });
            }));
        } catch (thrown) {
            abandon(build);
            throw thrown;
        }
        return HTree.#of(build);
    }

    static async buildAsync(mesh, given = {}) {
        if (given.progress != null) {
            throw new TypeError('progress cannot be heard from a worker: use build');
        }
        const build = prepare(mesh, given, true);
        try {
            const status = await onWorker(raw.htree_build, build.out, build.mesh, build.struct);
            if (status !== 0) explain(status, build);
        } catch (thrown) {
            abandon(build);
            throw thrown;
        }
        return HTree.#of(build);
    }

    static load(file, given = {}) {
        const { pointer, key, threads } = files.load(file, given);
        return new HTree(BUILT, new Handle(pointer, key, null), threads, false);
    }

    static defaults(given = {}) { return options.defaults(given); }

    static calibrate(given = {}) { return options.calibrated(given); }

    complete() {
        const handle = this.#handle;
        handle.with((tree) => check(raw.htree_complete(tree)), handle.acquireAlone());
        handle.dropArrays();
    }

    async completeAsync() {
        const handle = this.#handle;
        await handle.withAsync(async (tree) => {
            requireOk(await onWorker(raw.htree_complete, tree));
            handle.dropArrays();
        }, handle.acquireAlone());
    }

    update(mesh, how) {
        const handle = this.#handle;
        const update = prepareUpdate(mesh, how, false, this.#lazy);
        try {
            return handle.with((tree) => {
                check(raw.htree_update(tree, update.mesh, update.how, update.quality));
                return adopt(handle, update);
            }, handle.acquireAlone());
        } finally {
            callbacks.remove(update.key);
        }
    }

    async updateAsync(mesh, how) {
        const handle = this.#handle;
        const update = prepareUpdate(mesh, how, true, this.#lazy);
        try {
            return await handle.withAsync(async (tree) => {
                requireOk(await onWorker(
                    raw.htree_update, tree, update.mesh, update.how, update.quality));
                return adopt(handle, update);
            }, handle.acquireAlone());
        } finally {
            callbacks.remove(update.key);
        }
    }

    intersect(rays, given = {}) { return this.#trace(raw.htree_intersect, 'hits', rays, given); }

    occluded(rays, given = {}) { return this.#trace(raw.htree_occluded, 'occluded', rays, given); }

    async intersectAsync(rays, given = {}) {
        return this.#traceAsync(raw.htree_intersect, 'hits', rays, given);
    }

    async occludedAsync(rays, given = {}) {
        return this.#traceAsync(raw.htree_occluded, 'occluded', rays, given);
    }

    intersectRay(org, dir, tmin = 0, tmax = Infinity) {
        const hits = new Hits(1);
        this.intersect(Float32Array.of(...org, tmin, ...dir, tmax), { hits });
        return hits.isHit(0) ? hits.get(0) : null;
    }

    occludedRay(org, dir, tmin = 0, tmax = Infinity) {
        return this.occluded(Float32Array.of(...org, tmin, ...dir, tmax))[0] !== 0;
    }

    save() { return this.#handle.with(files.save); }

    bounds() { return this.#handle.with(inspect.bounds); }

    stats() { return this.#handle.with(inspect.stats); }

    view() { return this.#handle.with(inspect.view); }

    check() { this.#handle.with((tree) => check(raw.htree_check(tree))); }

    get closed() { return this.#handle.closed; }

    close() {
        forgotten.unregister(this);
        this.#handle.close();
    }

    [Symbol.dispose]() { this.close(); }

    #trace(f, answer, rays, given) {
        const handle = this.#handle;
        return handle.with((tree) => {
            const batch = new Batch(answer, rays, given, handle, this.#threads, false);
            check(callbacks.rethrowing(handle.objectsKey, () => {
                return callbacks.withProgress(batch.progress, (hook) => {
                    return f(tree, batch.rays, batch.count, batch.answers, batch.struct(hook));
                });
            }));
            return batch.finish();
        });
    }

    #traceAsync(f, answer, rays, given) {
        const handle = this.#handle;
        return handle.withAsync(async (tree) => {
            const batch = new Batch(answer, rays, given, handle, this.#threads, true);
            const hook = { report: null, user: 0 };
            const status = await onWorker(
                f, tree, batch.rays, batch.count, batch.answers, batch.struct(hook));
            requireOk(status);
            return batch.finish();
        });
    }
}

module.exports = { HTree };
