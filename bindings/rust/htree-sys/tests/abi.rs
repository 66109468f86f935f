// SPDX-License-Identifier: MIT
//! The whole of tests/abi.txt, which the C compiler wrote, equals what rustc makes of src/lib.rs.
#![cfg(target_pointer_width = "64")]

use htree_sys::*;
use std::collections::BTreeSet;
use std::mem::{size_of, size_of_val, MaybeUninit};
use std::path::Path;

/// The lines `size` and `field` of a struct; the pattern names every field, or this does not compile.
macro_rules! layout {
    ($lines:ident, $type:ident { $($field:ident),+ }) => {{
        let place = MaybeUninit::<$type>::zeroed();
        let start = place.as_ptr();
        // SAFETY: zero bytes are a value of each of these types: numbers, pointers, `Option<fn>`.
        let $type { $($field),+ } = unsafe { place.assume_init_ref() };
        $lines.insert(format!("size {} {}", stringify!($type), size_of::<$type>()));
        $(
            let offset = $field as *const _ as usize - start as usize;
            let (owner, name, size) = (stringify!($type), stringify!($field), size_of_val($field));
            $lines.insert(format!("field {owner}.{name} {offset} {size}"));
        )+
    }};
}

macro_rules! constants {
    ($lines:ident, $($name:ident)+) => {
        $($lines.insert(format!("constant {} {}", stringify!($name), $name));)+
    };
}

/// Names each function, so that a missing symbol does not link.
macro_rules! symbols {
    ($lines:ident, $($name:ident)+) => {
        $(
            assert_ne!($name as *const () as usize, 0);
            $lines.insert(format!("symbol {}", stringify!($name)));
        )+
    };
}

fn abi_of_this_crate() -> BTreeSet<String> {
    let mut lines = BTreeSet::new();
    lines.insert(format!("size htree_status {}", size_of::<htree_status>()));
    lines.insert(format!("size htree_kind {}", size_of::<htree_kind>()));
    constants!(lines, HTREE_VERSION_MAJOR HTREE_VERSION_MINOR HTREE_VERSION_PATCH HTREE_OK
        HTREE_ERROR_ARGUMENT HTREE_ERROR_MEMORY HTREE_ERROR_LIMIT HTREE_ERROR_GEOMETRY
        HTREE_ERROR_CANCELLED HTREE_ERROR_UNSUPPORTED HTREE_ERROR_CORRUPT HTREE_ERROR_NO_DEVICE
        HTREE_ERROR_DEVICE HTREE_ERROR_DEVICE_LOST HTREE_ERROR_KERNEL HTREE_NONE HTREE_UG HTREE_KD HTREE_BVH_MEDIAN HTREE_BVH_SAH HTREE_SKD HTREE_H
        HTREE_AH HTREE_WIDE HTREE_FAST HTREE_BALANCED HTREE_BEST HTREE_STRICT HTREE_ANY_PLANES
        HTREE_LOOSE_PLANES HTREE_MORTON HTREE_LAZY HTREE_COMPACT HTREE_COLLAPSE HTREE_REBUILD
        HTREE_REFIT HTREE_BORROW);
    // All its digits, as C prints them: a float prints as few as tell it apart.
    lines.insert(format!("constant HTREE_COORDINATE_MAX {}", HTREE_COORDINATE_MAX as u64));
    layout!(lines, htree_ray { org, tmin, dir, tmax });
    layout!(lines, htree_hit { t, u, v, prim });
    layout!(lines, htree_box { lo, hi });
    layout!(lines, htree_objects { boxes, count, intersect, user });
    layout!(
        lines,
        htree_mesh {
            positions,
            position_stride,
            vertex_count,
            indices,
            triangle_count,
            objects,
            reserved
        }
    );
    layout!(lines, htree_allocator { allocate, release, user });
    layout!(lines, htree_tasks { run, user });
    layout!(lines, htree_progress { report, user });
    layout!(
        lines,
        htree_options {
            size,
            kind,
            flags,
            threads,
            buckets,
            axes,
            cost_skd,
            cost_bv2,
            cost_bv6,
            cost_intersect,
            cells_per_prim,
            few_prims,
            allocator,
            tasks,
            progress
        }
    );
    layout!(
        lines,
        htree_load_options { size, flags, threads, reserved, intersect, user, allocator, tasks }
    );
    layout!(lines, htree_counters { traversal_steps, leaf_steps, intersections, reserved });
    layout!(lines, htree_query { size, flags, threads, reserved, counters, progress });
    layout!(
        lines,
        htree_stats {
            size,
            kind,
            triangles,
            objects,
            invalid,
            degenerate,
            nodes,
            leaves,
            references,
            skd_nodes,
            bv2_nodes,
            bv6_nodes,
            link_nodes,
            bvo_nodes,
            ternary_nodes,
            depth,
            stack,
            bytes,
            peak_bytes,
            build_seconds,
            sah_cost,
            subtrees,
            subtrees_built
        }
    );
    layout!(
        lines,
        htree_view {
            size,
            kind,
            bounds,
            prims,
            triangle_count,
            object_count,
            stack,
            triangles,
            nodes,
            node_bytes,
            leaves,
            leaf_bytes,
            grid,
            grid_bytes
        }
    );
    symbols!(lines, htree_build htree_calibrate htree_check htree_complete htree_error_text
        htree_free htree_get_bounds htree_get_stats htree_get_view htree_intersect htree_kind_from_name
        htree_kind_name htree_load htree_load_options_init htree_occluded htree_options_init
        htree_query_init htree_save htree_status_name htree_update htree_version);
    lines
}

#[test]
fn layout_is_that_of_the_c_compiler() {
    let root = std::env::var("HTREE_SOURCE_DIR")
        .unwrap_or_else(|_| concat!(env!("CARGO_MANIFEST_DIR"), "/../../..").to_string());
    let path = Path::new(&root).join("tests/abi.txt");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{path:?}: {e}"));
    let wanted: BTreeSet<_> = text
        .lines()
        .filter(|line| !line.starts_with('#') && !line.is_empty())
        .map(str::to_string)
        .collect();
    let ours = abi_of_this_crate();
    let missing: Vec<_> = wanted.difference(&ours).collect();
    let strange: Vec<_> = ours.difference(&wanted).collect();
    assert!(wanted.len() > 100, "{} lines", wanted.len());
    assert!(
        missing.is_empty() && strange.is_empty(),
        "only in C {missing:?}, only here {strange:?}"
    );
}

#[test]
fn the_linked_library_is_of_this_header() {
    let version = unsafe { htree_version() };
    assert_eq!(version / 100, HTREE_VERSION_MAJOR * 100 + HTREE_VERSION_MINOR);
}
