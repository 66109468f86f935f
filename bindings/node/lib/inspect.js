// SPDX-License-Identifier: MIT
'use strict';

/* What a tree tells about itself, in JavaScript's names. */

const koffi = require('koffi');
const raw = require('./raw');
const { check } = require('./errors');

const STATS_BYTES = koffi.sizeof(raw.types.htree_stats);
const VIEW_BYTES = koffi.sizeof(raw.types.htree_view);

const STATS = {
    triangles: 'triangles',
    objects: 'objects',
    invalid: 'invalid',
    degenerate: 'degenerate',
    nodes: 'nodes',
    leaves: 'leaves',
    references: 'references',
    skdNodes: 'skd_nodes',
    bv2Nodes: 'bv2_nodes',
    bv6Nodes: 'bv6_nodes',
    linkNodes: 'link_nodes',
    bvoNodes: 'bvo_nodes',
    ternaryNodes: 'ternary_nodes',
    depth: 'depth',
    stack: 'stack',
    bytes: 'bytes',
    peakBytes: 'peak_bytes',
    buildSeconds: 'build_seconds',
    sahCost: 'sah_cost',
    subtrees: 'subtrees',
    subtreesBuilt: 'subtrees_built',
};

const boxOf = ({ lo, hi }) => ({ lo: Array.from(lo), hi: Array.from(hi) });

function bounds(tree) {
    const box = {};
    check(raw.htree_get_bounds(tree, box));
    return boxOf(box);
}

function stats(tree) {
    const struct = { size: STATS_BYTES, kind: 0 };
    for (const field of Object.values(STATS)) struct[field] = 0;
    check(raw.htree_get_stats(tree, struct));
    const result = { kind: raw.htree_kind_name(struct.kind) };
    for (const [name, field] of Object.entries(STATS)) result[name] = Number(struct[field]);
    return result;
}

/** A copy, for nothing keeps a view of C's memory from outliving the tree. */
function copyOf(pointer, bytes) {
    return pointer && bytes ? koffi.view(pointer, bytes).slice(0) : new ArrayBuffer(0);
}

function view(tree) {
    const struct = {
        size: VIEW_BYTES, kind: 0, bounds: { lo: [0, 0, 0], hi: [0, 0, 0] }, prims: 0,
        triangle_count: 0, object_count: 0, stack: 0, triangles: null, nodes: null, node_bytes: 0,
        leaves: null, leaf_bytes: 0, grid: null, grid_bytes: 0,
    };
    check(raw.htree_get_view(tree, struct));
    return {
        kind: raw.htree_kind_name(struct.kind),
        bounds: boxOf(struct.bounds),
        prims: struct.prims,
        triangleCount: struct.triangle_count,
        objectCount: struct.object_count,
        stack: struct.stack,
        triangles: new Float32Array(copyOf(struct.triangles, 36 * struct.triangle_count)),
        nodes: copyOf(struct.nodes, struct.node_bytes),
        leaves: copyOf(struct.leaves, struct.leaf_bytes),
        grid: copyOf(struct.grid, struct.grid_bytes),
    };
}

module.exports = { bounds, stats, view };
