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

/** Only build and load know it, so only they construct. */
const BUILT = Symbol('built');
const forgotten = new FinalizationRegistry((handle) => handle.close());

/** Runs a function of the library on a worker. */
function onWorker(f, ...parameters) {
    return new Promise((resolve, reject) => {
        f.async(...parameters, (error, result) => (error ? reject(error) : resolve(result)));
    });
}

/** What htree_build gets and fills. */
function prepare(mesh, given, copy) {
    const struct = options.toStruct(given);
    const parts = meshes.read(mesh, copy);
    const key = parts.objects ? callbacks.add(parts.objects.intersect) : 0;
    return { struct, mesh: meshes.toStruct(parts, key), key, out: [null] };
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

/** A hierarchy over a mesh, built once and never changed. */
class HTree {
    #handle;

    #threads;

    constructor(built, handle, threads) {
        if (built !== BUILT) throw new TypeError('HTree.build and HTree.load make trees');
        this.#handle = handle;
        this.#threads = threads;
        forgotten.register(this, handle, this);
    }

    static #of({ out, key, struct }) {
        return new HTree(BUILT, new Handle(out[0], key), struct.threads);
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
        return new HTree(BUILT, new Handle(pointer, key), threads);
    }

    static defaults(given = {}) { return options.defaults(given); }

    static calibrate(given = {}) { return options.calibrated(given); }

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
            if (status !== 0) throw new HTreeError(status, raw.htree_status_name(status));
            return batch.finish();
        });
    }
}

module.exports = { HTree };
