// SPDX-License-Identifier: MIT
'use strict';

/* htree.h, one to one, with its names: what each means and may fail with is written there. Nothing
 * here is checked, and a wrong pointer ends the process. Types are anonymous, so that a program may
 * load two versions of this package. */

const koffi = require('koffi');
const { library } = require('./library');

const { struct, array, pointer } = koffi;
const out = (type) => koffi.out(pointer(type));
const inout = (type) => koffi.inout(pointer(type));

// ---- Callbacks ---------------------------------------------------------------------------------

const htree_object_intersect = pointer(
    koffi.proto('int32_t', ['uintptr_t', 'uint32_t', 'void *', 'void *']));
const htree_report = pointer(koffi.proto('int32_t', ['uintptr_t', 'double']));

// ---- Structs -----------------------------------------------------------------------------------

const htree_ray = struct({
    org: array('float', 3), tmin: 'float', dir: array('float', 3), tmax: 'float',
});
const htree_hit = struct({ t: 'float', u: 'float', v: 'float', prim: 'uint32_t' });
const htree_box = struct({ lo: array('float', 3), hi: array('float', 3) });
const htree_objects = struct({
    boxes: 'void *', count: 'uint64_t', intersect: htree_object_intersect, user: 'uintptr_t',
});
const htree_mesh = struct({
    positions: 'void *',
    position_stride: 'uint64_t',
    vertex_count: 'uint64_t',
    indices: 'void *',
    triangle_count: 'uint64_t',
    objects: pointer(htree_objects),
    reserved: array('uint64_t', 2),
});
const htree_progress = struct({ report: htree_report, user: 'uintptr_t' });
// Hooks for memory and threads are called from threads where no JavaScript can run.
const htree_allocator = struct({ allocate: 'void *', release: 'void *', user: 'void *' });
const htree_tasks = struct({ run: 'void *', user: 'void *' });
const htree_options = struct({
    size: 'uint32_t',
    kind: 'int32_t',
    flags: 'uint32_t',
    threads: 'uint32_t',
    buckets: 'uint32_t',
    axes: 'uint32_t',
    cost_skd: 'float',
    cost_bv2: 'float',
    cost_bv6: 'float',
    cost_intersect: 'float',
    cells_per_prim: 'float',
    few_prims: 'uint32_t',
    allocator: htree_allocator,
    tasks: htree_tasks,
    progress: htree_progress,
});
const htree_load_options = struct({
    size: 'uint32_t',
    flags: 'uint32_t',
    threads: 'uint32_t',
    reserved: 'uint32_t',
    intersect: htree_object_intersect,
    user: 'uintptr_t',
    allocator: htree_allocator,
    tasks: htree_tasks,
});
const htree_query = struct({
    size: 'uint32_t',
    flags: 'uint32_t',
    threads: 'uint32_t',
    reserved: 'uint32_t',
    counters: 'void *',
    progress: htree_progress,
});
const htree_stats = struct({
    size: 'uint32_t',
    kind: 'int32_t',
    triangles: 'uint64_t',
    objects: 'uint64_t',
    invalid: 'uint64_t',
    degenerate: 'uint64_t',
    nodes: 'uint64_t',
    leaves: 'uint64_t',
    references: 'uint64_t',
    skd_nodes: 'uint64_t',
    bv2_nodes: 'uint64_t',
    bv6_nodes: 'uint64_t',
    link_nodes: 'uint64_t',
    bvo_nodes: 'uint64_t',
    ternary_nodes: 'uint64_t',
    depth: 'uint32_t',
    stack: 'uint32_t',
    bytes: 'uint64_t',
    peak_bytes: 'uint64_t',
    build_seconds: 'double',
    sah_cost: 'double',
    subtrees: 'uint64_t',
    subtrees_built: 'uint64_t',
});
const htree_view = struct({
    size: 'uint32_t',
    kind: 'int32_t',
    bounds: htree_box,
    prims: 'uint32_t',
    triangle_count: 'uint32_t',
    object_count: 'uint32_t',
    stack: 'uint32_t',
    triangles: 'void *',
    nodes: 'void *',
    node_bytes: 'uint64_t',
    leaves: 'void *',
    leaf_bytes: 'uint64_t',
    grid: 'void *',
    grid_bytes: 'uint64_t',
});

const types = {
    htree_object_intersect, htree_report, htree_ray, htree_hit, htree_box, htree_objects,
    htree_mesh, htree_progress, htree_allocator, htree_tasks, htree_options,
    htree_load_options, htree_query, htree_stats, htree_view,
};

// ---- Functions ---------------------------------------------------------------------------------

const status = 'int32_t';
const tree = 'void *';
const f = (name, result, parameters) => library.func(name, result, parameters);

module.exports = {
    types,
    htree_version: f('htree_version', 'uint32_t', []),
    htree_status_name: f('htree_status_name', 'str', [status]),
    htree_error_text: f('htree_error_text', 'str', []),
    htree_kind_name: f('htree_kind_name', 'str', ['int32_t']),
    htree_kind_from_name: f('htree_kind_from_name', 'int32_t', ['str']),
    htree_options_init: f('htree_options_init', status,
        [inout(htree_options), 'uint64_t', 'int32_t']),
    htree_calibrate: f('htree_calibrate', status, [inout(htree_options)]),
    htree_build: f('htree_build', status,
        [out(tree), pointer(htree_mesh), pointer(htree_options)]),
    htree_complete: f('htree_complete', status, [tree]),
    htree_update: f('htree_update', status,
        [tree, pointer(htree_mesh), 'int32_t', out('double')]),
    htree_free: f('htree_free', 'void', [tree]),
    htree_query_init: f('htree_query_init', status, [inout(htree_query), 'uint64_t']),
    htree_intersect: f('htree_intersect', status,
        [tree, 'void *', 'uint64_t', 'void *', pointer(htree_query)]),
    htree_occluded: f('htree_occluded', status,
        [tree, 'void *', 'uint64_t', 'void *', pointer(htree_query)]),
    htree_save: f('htree_save', status, [tree, 'void *', 'uint64_t', out('uint64_t')]),
    htree_load_options_init: f('htree_load_options_init', status,
        [inout(htree_load_options), 'uint64_t']),
    htree_load: f('htree_load', status,
        [out(tree), 'void *', 'uint64_t', pointer(htree_load_options)]),
    htree_get_bounds: f('htree_get_bounds', status, [tree, out(htree_box)]),
    htree_get_stats: f('htree_get_stats', status, [tree, inout(htree_stats)]),
    htree_get_view: f('htree_get_view', status, [tree, inout(htree_view)]),
    htree_check: f('htree_check', status, [tree]),
};
