// SPDX-License-Identifier: MIT
//! `include/htree.h` of libhtree, name for name; the contract of every call stands there.
//!
//! The crate [`htree`](https://docs.rs/htree) is the safe way to it. The layout is held against
//! `tests/abi.txt`, which the C compiler wrote, by `tests/abi.rs`.
#![allow(non_camel_case_types)]

use std::os::raw::{c_char, c_void};

/// Version of the header that this crate mirrors.
pub const HTREE_VERSION_MAJOR: u32 = 0;
/// Version of the header that this crate mirrors.
pub const HTREE_VERSION_MINOR: u32 = 1;
/// Version of the header that this crate mirrors.
pub const HTREE_VERSION_PATCH: u32 = 0;

// ---- Status --------------------------------------------------------------------------------------

pub type htree_status = i32;

pub const HTREE_OK: htree_status = 0;
/// A NULL, a size, a flag or a number that the call does not take.
pub const HTREE_ERROR_ARGUMENT: htree_status = 1;
/// The allocator returned NULL.
pub const HTREE_ERROR_MEMORY: htree_status = 2;
/// More objects than the structure can address.
pub const HTREE_ERROR_LIMIT: htree_status = 3;
/// An index beyond the vertices; with `HTREE_STRICT` bad numbers too.
pub const HTREE_ERROR_GEOMETRY: htree_status = 4;
/// The progress hook asked to stop.
pub const HTREE_ERROR_CANCELLED: htree_status = 5;
/// This build of the library lacks the kind that was asked for.
pub const HTREE_ERROR_UNSUPPORTED: htree_status = 6;
/// `htree_check` found a broken tree.
pub const HTREE_ERROR_CORRUPT: htree_status = 7;
/// No OpenCL here, or no device of that name.
pub const HTREE_ERROR_NO_DEVICE: htree_status = 8;
/// A call to the device failed.
pub const HTREE_ERROR_DEVICE: htree_status = 9;
/// The device is gone, with all that was on it.
pub const HTREE_ERROR_DEVICE_LOST: htree_status = 10;
/// The device's compiler refused a kernel, or it is wrong.
pub const HTREE_ERROR_KERNEL: htree_status = 11;

// ---- Rays and hits -------------------------------------------------------------------------------

/// A ray: points `org + t * dir` with `tmin <= t <= tmax`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct htree_ray {
    pub org: [f32; 3],
    pub tmin: f32,
    pub dir: [f32; 3],
    pub tmax: f32,
}

/// The closest hit, or `prim == HTREE_NONE`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct htree_hit {
    pub t: f32,
    pub u: f32,
    pub v: f32,
    pub prim: u32,
}

/// `prim` of a miss.
pub const HTREE_NONE: u32 = u32::MAX;
/// 2^60: larger coordinates are skipped.
pub const HTREE_COORDINATE_MAX: f32 = 1_152_921_504_606_846_976.0;

#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct htree_box {
    pub lo: [f32; 3],
    pub hi: [f32; 3],
}

// ---- Geometry ------------------------------------------------------------------------------------

pub type htree_object_intersect = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        object: u32,
        ray: *const htree_ray,
        hit: *mut htree_hit,
    ) -> i32,
>;

/// Objects of the caller's own, known by box and callback.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct htree_objects {
    pub boxes: *const htree_box,
    pub count: u64,
    pub intersect: htree_object_intersect,
    pub user: *mut c_void,
}

/// Triangles, and objects if any. Start from zero.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct htree_mesh {
    pub positions: *const f32,
    pub position_stride: u64,
    pub vertex_count: u64,
    pub indices: *const u32,
    pub triangle_count: u64,
    pub objects: *const htree_objects,
    pub reserved: [u64; 2],
}

// ---- Hooks ---------------------------------------------------------------------------------------

/// Memory.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct htree_allocator {
    pub allocate:
        Option<unsafe extern "C" fn(user: *mut c_void, bytes: u64, alignment: u64) -> *mut c_void>,
    pub release: Option<unsafe extern "C" fn(user: *mut c_void, memory: *mut c_void, bytes: u64)>,
    pub user: *mut c_void,
}

/// What `htree_tasks::run` calls once for every index.
pub type htree_task = Option<unsafe extern "C" fn(data: *mut c_void, index: u32)>;

/// Parallel for.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct htree_tasks {
    pub run: Option<
        unsafe extern "C" fn(user: *mut c_void, count: u32, task: htree_task, data: *mut c_void),
    >,
    pub user: *mut c_void,
}

/// Progress and cancelling.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct htree_progress {
    pub report: Option<unsafe extern "C" fn(user: *mut c_void, fraction: f64) -> i32>,
    pub user: *mut c_void,
}

// ---- Options -------------------------------------------------------------------------------------

pub type htree_kind = i32;

pub const HTREE_UG: htree_kind = 1;
pub const HTREE_KD: htree_kind = 2;
pub const HTREE_BVH_MEDIAN: htree_kind = 3;
pub const HTREE_BVH_SAH: htree_kind = 4;
pub const HTREE_SKD: htree_kind = 5;
pub const HTREE_H: htree_kind = 6;
pub const HTREE_AH: htree_kind = 7;
pub const HTREE_WIDE: htree_kind = 8;
pub const HTREE_FAST: htree_kind = 101;
pub const HTREE_BALANCED: htree_kind = 102;
pub const HTREE_BEST: htree_kind = 103;

pub const HTREE_STRICT: u32 = 1;
pub const HTREE_ANY_PLANES: u32 = 2;
pub const HTREE_LOOSE_PLANES: u32 = 4;
pub const HTREE_MORTON: u32 = 8;
pub const HTREE_LAZY: u32 = 16;
pub const HTREE_COMPACT: u32 = 32;
pub const HTREE_COLLAPSE: u32 = 64;

/// How to build; `htree_options_init` writes every default.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct htree_options {
    pub size: u32,
    pub kind: htree_kind,
    pub flags: u32,
    pub threads: u32,
    pub buckets: u32,
    pub axes: u32,
    pub cost_skd: f32,
    pub cost_bv2: f32,
    pub cost_bv6: f32,
    pub cost_intersect: f32,
    pub cells_per_prim: f32,
    pub few_prims: u32,
    pub allocator: htree_allocator,
    pub tasks: htree_tasks,
    pub progress: htree_progress,
}

pub const HTREE_BORROW: u32 = 1;

/// How to load; `htree_load_options_init` writes every default.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct htree_load_options {
    pub size: u32,
    pub flags: u32,
    pub threads: u32,
    pub reserved: u32,
    pub intersect: htree_object_intersect,
    pub user: *mut c_void,
    pub allocator: htree_allocator,
    pub tasks: htree_tasks,
}

// ---- Trees ---------------------------------------------------------------------------------------

/// How `htree_update` brings a tree to a mesh: as `htree_build` would.
pub const HTREE_REBUILD: i32 = 1;
/// The same nodes around the new positions.
pub const HTREE_REFIT: i32 = 2;

/// A tree, seen by its address only.
#[repr(C)]
pub struct htree {
    _private: [u8; 0],
}

/// What one ray cost.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct htree_counters {
    pub traversal_steps: u32,
    pub leaf_steps: u32,
    pub intersections: u32,
    pub reserved: u32,
}

/// How to query; `htree_query_init` writes every default.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct htree_query {
    pub size: u32,
    pub flags: u32,
    pub threads: u32,
    pub reserved: u32,
    pub counters: *mut htree_counters,
    pub progress: htree_progress,
}

/// What a tree is made of, in the paper's columns.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct htree_stats {
    pub size: u32,
    pub kind: htree_kind,
    pub triangles: u64,
    pub objects: u64,
    pub invalid: u64,
    pub degenerate: u64,
    pub nodes: u64,
    pub leaves: u64,
    pub references: u64,
    pub skd_nodes: u64,
    pub bv2_nodes: u64,
    pub bv6_nodes: u64,
    pub link_nodes: u64,
    pub bvo_nodes: u64,
    pub ternary_nodes: u64,
    pub depth: u32,
    pub stack: u32,
    pub bytes: u64,
    pub peak_bytes: u64,
    pub build_seconds: f64,
    pub sah_cost: f64,
    pub subtrees: u64,
    pub subtrees_built: u64,
}

/// The arrays of a finished tree; they belong to it.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct htree_view {
    pub size: u32,
    pub kind: htree_kind,
    pub bounds: htree_box,
    pub prims: u32,
    pub triangle_count: u32,
    pub object_count: u32,
    pub stack: u32,
    pub triangles: *const f32,
    pub nodes: *const c_void,
    pub node_bytes: u64,
    pub leaves: *const c_void,
    pub leaf_bytes: u64,
    pub grid: *const c_void,
    pub grid_bytes: u64,
}

// ---- Functions -----------------------------------------------------------------------------------

extern "C" {
    pub fn htree_version() -> u32;
    pub fn htree_status_name(status: htree_status) -> *const c_char;
    pub fn htree_error_text() -> *const c_char;

    pub fn htree_kind_name(kind: htree_kind) -> *const c_char;
    pub fn htree_kind_from_name(name: *const c_char) -> htree_kind;
    pub fn htree_options_init(
        options: *mut htree_options,
        size: u64,
        kind: htree_kind,
    ) -> htree_status;
    pub fn htree_calibrate(options: *mut htree_options) -> htree_status;

    pub fn htree_build(
        out: *mut *mut htree,
        mesh: *const htree_mesh,
        options: *const htree_options,
    ) -> htree_status;
    pub fn htree_complete(tree: *mut htree) -> htree_status;
    pub fn htree_update(
        tree: *mut htree,
        mesh: *const htree_mesh,
        how: i32,
        quality: *mut f64,
    ) -> htree_status;
    pub fn htree_free(tree: *mut htree);

    pub fn htree_query_init(query: *mut htree_query, size: u64) -> htree_status;
    pub fn htree_intersect(
        tree: *const htree,
        rays: *const htree_ray,
        count: u64,
        hits: *mut htree_hit,
        query: *const htree_query,
    ) -> htree_status;
    pub fn htree_occluded(
        tree: *const htree,
        rays: *const htree_ray,
        count: u64,
        occluded: *mut u8,
        query: *const htree_query,
    ) -> htree_status;

    pub fn htree_save(
        tree: *const htree,
        file: *mut c_void,
        size: u64,
        bytes: *mut u64,
    ) -> htree_status;
    pub fn htree_load_options_init(options: *mut htree_load_options, size: u64) -> htree_status;
    pub fn htree_load(
        out: *mut *mut htree,
        file: *const c_void,
        size: u64,
        options: *const htree_load_options,
    ) -> htree_status;

    pub fn htree_get_bounds(tree: *const htree, bounds: *mut htree_box) -> htree_status;
    pub fn htree_get_stats(tree: *const htree, stats: *mut htree_stats) -> htree_status;
    pub fn htree_get_view(tree: *const htree, view: *mut htree_view) -> htree_status;
    pub fn htree_check(tree: *const htree) -> htree_status;
}
