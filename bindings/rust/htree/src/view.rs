// SPDX-License-Identifier: MIT
use crate::{Aabb, Kind};
use htree_sys as sys;
use std::ffi::c_void;
use std::slice;

/// What a tree is made of, in the paper's columns; see [`Tree::stats`](crate::Tree::stats).
///
/// ```
/// use htree::{Mesh, Tree};
/// let tree = Tree::new(&Mesh::new(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))?;
/// let stats = tree.stats()?;
/// assert_eq!((stats.triangles, stats.leaves), (1, 1));
/// # Ok::<(), htree::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Stats {
    /// The structure.
    pub kind: Kind,
    /// Triangles as given.
    pub triangles: u64,
    /// Objects as given.
    pub objects: u64,
    /// Skipped: NaN, infinite or oversize coordinates.
    pub invalid: u64,
    /// Skipped: triangles without area.
    pub degenerate: u64,
    /// N_NS, all nodes.
    pub nodes: u64,
    /// N_E, leaves.
    pub leaves: u64,
    /// N_ER, references from leaves to triangles and objects.
    pub references: u64,
    /// Nodes with two separating planes.
    pub skd_nodes: u64,
    /// Nodes that clip by two planes.
    pub bv2_nodes: u64,
    /// Nodes that clip by six planes.
    pub bv6_nodes: u64,
    /// Nodes that lead to another chunk.
    pub link_nodes: u64,
    /// Bounding nodes with another set of planes.
    pub bvo_nodes: u64,
    /// Nodes with a shelf of oversize objects.
    pub ternary_nodes: u64,
    /// Nodes on the longest way from the root to a leaf.
    pub depth: u32,
    /// Entries that a traversal stack can need at most.
    pub stack: u32,
    /// Memory of the finished tree, geometry included.
    pub bytes: u64,
    /// Most memory held at any time of the build.
    pub peak_bytes: u64,
    /// T_C, wall clock.
    pub build_seconds: f64,
    /// Expected cost of a random ray that meets the bounds, in the unit of the options' costs.
    pub sah_cost: f64,
    /// Of a [`LazyTree`](crate::LazyTree): left to rays; else 0.
    pub subtrees: u64,
    /// Of these, built by now.
    pub subtrees_built: u64,
}

impl Stats {
    pub(crate) fn from_raw(raw: &sys::htree_stats) -> Self {
        Self {
            kind: Kind::from_code(raw.kind),
            triangles: raw.triangles,
            objects: raw.objects,
            invalid: raw.invalid,
            degenerate: raw.degenerate,
            nodes: raw.nodes,
            leaves: raw.leaves,
            references: raw.references,
            skd_nodes: raw.skd_nodes,
            bv2_nodes: raw.bv2_nodes,
            bv6_nodes: raw.bv6_nodes,
            link_nodes: raw.link_nodes,
            bvo_nodes: raw.bvo_nodes,
            ternary_nodes: raw.ternary_nodes,
            depth: raw.depth,
            stack: raw.stack,
            bytes: raw.bytes,
            peak_bytes: raw.peak_bytes,
            build_seconds: raw.build_seconds,
            sah_cost: raw.sah_cost,
            subtrees: raw.subtrees,
            subtrees_built: raw.subtrees_built,
        }
    }
}

/// The arrays of a finished tree, as long as it lives; see [`Tree::view`](crate::Tree::view).
///
/// The layout of `nodes`, `leaves` and `grid` is that of `lib/tree/layout.h`, and holds for one minor
/// version.
///
/// ```
/// use htree::{Mesh, Tree};
/// let tree = Tree::new(&Mesh::new(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]))?;
/// let view = tree.view()?;
/// assert_eq!((view.kind, view.prims), (htree::Kind::WIDE, 1));
/// assert!(!view.leaves.is_empty() && view.triangles.is_empty());
/// # Ok::<(), htree::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct View<'t> {
    /// The structure.
    pub kind: Kind,
    /// Bounds of everything that can be hit.
    pub bounds: Aabb,
    /// Triangles and objects that can be hit; 0: there are no nodes.
    pub prims: u32,
    /// Objects as given; their prims come after the triangles.
    pub object_count: u32,
    /// Entries that a traversal stack can need at most.
    pub stack: u32,
    /// Three corners a triangle; a skipped one is all 0. WIDE: empty, its leaves hold the corners.
    pub triangles: &'t [[[f32; 3]; 3]],
    /// Nodes, root first.
    pub nodes: &'t [u8],
    /// UG, KD: u32 prims by leaf; WIDE: blocks of triangles; else empty.
    pub leaves: &'t [u8],
    /// UG: its shape; else empty.
    pub grid: &'t [u8],
}

impl View<'_> {
    /// # Safety
    ///
    /// The arrays are as long as they say, and live and stay the same for the lifetime.
    pub(crate) unsafe fn from_raw(raw: &sys::htree_view) -> Self {
        let bytes = |start: *const c_void, len| unsafe { array(start.cast::<u8>(), len) };
        Self {
            kind: Kind::from_code(raw.kind),
            bounds: Aabb { lo: raw.bounds.lo, hi: raw.bounds.hi },
            prims: raw.prims,
            object_count: raw.object_count,
            stack: raw.stack,
            triangles: unsafe { array(raw.triangles.cast(), raw.triangle_count.into()) },
            nodes: bytes(raw.nodes, raw.node_bytes),
            leaves: bytes(raw.leaves, raw.leaf_bytes),
            grid: bytes(raw.grid, raw.grid_bytes),
        }
    }
}

/// C may say NULL where there is nothing, and a slice may not.
unsafe fn array<'t, T>(start: *const T, len: u64) -> &'t [T] {
    if start.is_null() || len == 0 {
        return &[];
    }
    unsafe { slice::from_raw_parts(start, len as usize) }
}
