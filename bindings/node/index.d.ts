// SPDX-License-Identifier: MIT

/** Name of a kind of tree, or of a preset: 'fast', 'balanced' (the default), 'best'. */
export type KindName =
    | 'ug' | 'kd' | 'bvh-median' | 'bvh-sah' | 'skd' | 'h' | 'ah' | 'wide'
    | 'fast' | 'balanced' | 'best';

/** Name of a status of the library. */
export type StatusName =
    | 'OK' | 'ARGUMENT' | 'MEMORY' | 'LIMIT' | 'GEOMETRY' | 'CANCELLED' | 'UNSUPPORTED'
    | 'CORRUPT' | 'NO_DEVICE' | 'DEVICE' | 'DEVICE_LOST' | 'KERNEL';

/** Kinds and their numbers. */
export const KINDS: Readonly<Record<KindName, number>>;

/** Statuses and their numbers. */
export const STATUSES: Readonly<Record<StatusName, number>>;

/** `prim` of a miss: 2^32 - 1. */
export const NONE: 0xffffffff;

/** Version of the library that was loaded, for example "0.1.0". */
export function libraryVersion(): string;

/** Version of the library that this package was written for. */
export function bindingVersion(): string;

/** Hears how far a call is, from 0 to 1. Returns true to cancel it, which throws CANCELLED; what it
 * throws cancels too and is thrown out of the call. */
export type Progress = (fraction: number) => boolean | void;

/** A ray as an object's test sees it. */
export interface ObjectRay {
    org: Float32Array;
    tmin: number;
    dir: Float32Array;
    tmax: number;
}

/** Objects of your own, known by box and callback. A tree with objects is queried by the calls that
 * wait, on one thread. */
export interface UserObjects {
    /** Six floats an object: least x y z, greatest x y z. */
    boxes: Float32Array | readonly number[];

    /** Where the ray hits the object, at the smallest t from tmin to tmax; nothing for a miss. A
     * pure function. What it throws is thrown out of the query. It must not refer to the tree it
     * serves, or that tree is freed by close only. */
    intersect(
        object: number, ray: ObjectRay): { t: number; u?: number; v?: number } | null | undefined;
}

/** Triangles, and objects if any. */
export interface Mesh {
    /** x y z of every vertex. */
    positions?: Float32Array | readonly number[];
    /** Bytes from a vertex to the next, a multiple of 4, at least 12; 0, the default, means 12. */
    positionStride?: number;
    /** Three a triangle; without them triangle i has vertices 3i, 3i + 1 and 3i + 2. */
    indices?: Uint32Array | Uint16Array | Int32Array | readonly number[] | null;
    /** The first triangles only; without it all there are. */
    triangleCount?: number;
    objects?: UserObjects | null;
}

/** How to build. What is left out is the library's default. */
export interface Options {
    kind?: KindName | number;
    /** Refuse NaN, infinite and oversize coordinates instead of skipping them. */
    strict?: boolean;
    /** h, ah: bounding nodes of any of 63 plane sets. */
    anyPlanes?: boolean;
    /** ah: planes as the grid gives them, half a cell wide. */
    loosePlanes?: boolean;
    /** wide: Morton order below the grid: faster to build, slower to trace. */
    morton?: boolean;
    /** wide: only the top is built, the rest by the first ray that gets there. The tree reads a
     * copy of the mesh, or its shared arrays, which must not change until complete or close. */
    lazy?: boolean;
    /** wide: less than half of the memory, slower to build and to trace; not with lazy. */
    compact?: boolean;
    /** bvh-median, bvh-sah, skd, h, ah: collapses the finished tree into one of kind wide. */
    collapse?: boolean;
    /** Of queries: 0 all cores, 1 the caller's, n at most n. */
    threads?: number;
    /** 2 to 64: cost is evaluated at one plane fewer. */
    buckets?: number;
    /** 1: split along the widest extent only; 3: try all axes. */
    axes?: number;
    costSkd?: number;
    costBv2?: number;
    costBv6?: number;
    costIntersect?: number;
    /** ah: cells of the grid for each object, 1/64 to 64. */
    cellsPerPrim?: number;
    /** ah: ranges of no more objects are built as an H-tree, 1 to 2^20. */
    fewPrims?: number;
    progress?: Progress | null;
}

/** How to load. */
export interface LoadOptions {
    /** Of queries: 0 all cores, 1 the caller's, n at most n. */
    threads?: number;
    /** Of a tree with objects: as in UserObjects. */
    intersect?: UserObjects['intersect'] | null;
}

/** Options with every default filled in. */
export type FullOptions = Required<Omit<Options, 'kind' | 'progress'>> & { kind: KindName };

export interface Hit {
    t: number;
    u: number;
    v: number;
    /** Triangle i of the mesh is i, object j is triangleCount + j; NONE for a miss. */
    prim: number;
}

/** Answers to a batch of rays, over one buffer of 16 bytes each. */
export class Hits implements Iterable<Hit> {
    /** How many, or a buffer to write to. */
    constructor(source: number | ArrayBuffer | SharedArrayBuffer);
    readonly buffer: ArrayBuffer | SharedArrayBuffer;
    /** t, u, v of hit i at 4i, 4i + 1, 4i + 2. */
    readonly floats: Float32Array;
    /** prim of hit i at 4i + 3. */
    readonly words: Uint32Array;
    readonly count: number;
    t(index: number): number;
    u(index: number): number;
    v(index: number): number;
    prim(index: number): number;
    isHit(index: number): boolean;
    get(index: number): Hit;
    [Symbol.iterator](): Iterator<Hit>;
}

/** What each ray of a batch cost, in the paper's terms. */
export class Counters {
    constructor(count: number);
    /** Four a ray, the last of them reserved. */
    readonly words: Uint32Array;
    readonly count: number;
    /** N_TS: nodes visited, leaves included. */
    traversalSteps(index: number): number;
    /** N_ETS: leaves visited. */
    leafSteps(index: number): number;
    /** N_IT: objects tested. */
    intersections(index: number): number;
}

/** How to query on a worker. */
export interface AsyncQuery {
    /** 0 all cores, 1 the worker's, n at most n; without it as the tree's options say. */
    threads?: number;
    counters?: Counters | null;
}

/** How to query. */
export interface Query extends AsyncQuery {
    progress?: Progress | null;
}

export interface Box {
    lo: [number, number, number];
    hi: [number, number, number];
}

/** What a tree is made of, in the paper's terms. */
export interface Stats {
    kind: KindName;
    triangles: number;
    objects: number;
    invalid: number;
    degenerate: number;
    nodes: number;
    leaves: number;
    references: number;
    skdNodes: number;
    bv2Nodes: number;
    bv6Nodes: number;
    linkNodes: number;
    bvoNodes: number;
    ternaryNodes: number;
    depth: number;
    stack: number;
    bytes: number;
    peakBytes: number;
    buildSeconds: number;
    sahCost: number;
    /** Of a lazy tree: left to rays; else 0. */
    subtrees: number;
    /** Of these, built by now. */
    subtreesBuilt: number;
}

/** How update brings a tree to a mesh: 'rebuild' as build would, in the memory of the builds
 * before; 'refit', wide: the same nodes around the new positions. */
export type How = 'rebuild' | 'refit';

/** Copies of a tree's arrays. Nodes, leaves and grid are laid out as lib/tree/layout.h says, which
 * holds for one minor version. */
export interface View {
    kind: KindName;
    bounds: Box;
    prims: number;
    triangleCount: number;
    objectCount: number;
    stack: number;
    /** Nine floats a triangle; a skipped one is all 0. wide: none, its leaves hold the corners. */
    triangles: Float32Array;
    nodes: ArrayBuffer;
    leaves: ArrayBuffer;
    grid: ArrayBuffer;
}

/** Eight floats a ray: org x y z, tmin, dir x y z, tmax. An array is copied. */
export type Rays = Float32Array | readonly number[];

type Vector = readonly [number, number, number] | Float32Array;

/** A hierarchy over a mesh, which only update and complete change. Its memory is the library's:
 * close it. */
export class HTree {
    private constructor();

    /** Builds a tree. Throws HTreeError. */
    static build(mesh: Mesh, options?: Options): HTree;

    /** Builds a tree on a worker, from copies of the mesh's arrays where they are not shared. */
    static buildAsync(mesh: Mesh, options?: Omit<Options, 'progress'>): Promise<HTree>;

    /** The tree that save wrote: the same hits. It copies the bytes. Whatever they are, what is
     * returned has been proved. Throws HTreeError: CORRUPT, ARGUMENT, MEMORY, UNSUPPORTED. */
    static load(
        file: ArrayBufferView | ArrayBuffer | SharedArrayBuffer, options?: LoadOptions): HTree;

    /** These options with every default filled in; a preset becomes what it stands for. */
    static defaults(options?: Options): FullOptions;

    /** The same with the four costs as measured on this machine, which takes some milliseconds. */
    static calibrate(options?: Options): FullOptions;

    /** Builds what rays have not reached yet of a lazy tree, on all cores, and lets its mesh go.
     * Does nothing to any other tree. Throws while a worker uses the tree, and in a callback of a
     * query on it. */
    complete(): void;

    /** The same on a worker; until then every use of the tree throws. */
    completeAsync(): Promise<void>;

    /** Brings the tree to new positions, or with 'rebuild' to any mesh at all, with the options
     * that it was built with. Refitting is for a mesh of as many triangles and objects; the tree is
     * rebuilt where it cannot do. Returns the expected cost of a ray over that when the tree was
     * built: 1 after a rebuild; from about 1.5 on rebuilding pays. Throws HTreeError, and as
     * complete does; then the tree is as it was. */
    update(mesh: Mesh, how: How): number;

    /** The same on a worker, from copies of the mesh's arrays where they are not shared; until then
     * every use of the tree throws. */
    updateAsync(mesh: Mesh, how: How): Promise<number>;

    /** The closest hit of every ray. */
    intersect(rays: Rays, query?: Query & { hits?: Hits | null }): Hits;

    /** The same on a worker. */
    intersectAsync(rays: Rays, query?: AsyncQuery & { hits?: Hits | null }): Promise<Hits>;

    /** 1 for every ray that hits anything, else 0; faster than intersect. */
    occluded(rays: Rays, query?: Query & { occluded?: Uint8Array | null }): Uint8Array;

    /** The same on a worker. */
    occludedAsync(
        rays: Rays, query?: AsyncQuery & { occluded?: Uint8Array | null }): Promise<Uint8Array>;

    /** The closest hit of one ray, or null. */
    intersectRay(org: Vector, dir: Vector, tmin?: number, tmax?: number): Hit | null;

    /** Whether one ray hits anything. */
    occludedRay(org: Vector, dir: Vector, tmin?: number, tmax?: number): boolean;

    /** The tree as bytes, for load; objects are saved as their boxes. */
    save(): Uint8Array;

    /** Bounds of everything that can be hit; lo is Infinity, hi -Infinity if there is nothing. */
    bounds(): Box;

    /** Walks the tree and counts what it is made of. */
    stats(): Stats;

    /** Copies the tree's arrays. Throws UNSUPPORTED for a compact tree, and for a lazy one
     * that is not complete. */
    view(): View;

    /** Proves the structure. Throws HTreeError: CORRUPT, MEMORY. */
    check(): void;

    readonly closed: boolean;

    /** Frees the tree, after the last call that runs on it. Closing twice does nothing. */
    close(): void;

    [Symbol.dispose](): void;
}

/** A call of the library failed; the message is the library's own sentence. */
export class HTreeError extends Error {
    private constructor();
    readonly name: 'HTreeError';
    readonly code: Exclude<StatusName, 'OK'> | 'UNKNOWN';
    /** The library's number. */
    readonly status: number;
    /** The library's words for the number, for example "bad geometry". */
    readonly words: string;
}
