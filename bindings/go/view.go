// SPDX-License-Identifier: MIT

package htree

// #include "bridge.h"
import "C"

import "unsafe"

// Stats are what a tree is made of, in the paper's columns.
type Stats struct {
	Kind       Kind
	Triangles  uint64 // as given
	Objects    uint64 // as given
	Invalid    uint64 // skipped: NaN, infinite or oversize coordinates
	Degenerate uint64 // skipped: triangles without area

	Nodes        uint64 // N_NS, all nodes
	Leaves       uint64 // N_E
	References   uint64 // N_ER, references from leaves to triangles and objects
	SKDNodes     uint64 // nodes with two separating planes
	BV2Nodes     uint64 // nodes that clip by two planes
	BV6Nodes     uint64 // nodes that clip by six planes
	LinkNodes    uint64 // nodes that lead to another chunk
	BVONodes     uint64 // bounding nodes with another set of planes
	TernaryNodes uint64 // nodes with a shelf of oversize objects

	Depth        uint32  // nodes on the longest way from the root to a leaf
	Stack        uint32  // entries that a traversal stack can need at most
	Bytes        uint64  // memory of the finished tree, geometry included
	PeakBytes    uint64  // most memory held at any time of the build
	BuildSeconds float64 // T_C, wall clock
	SAHCost      float64 // expected cost of a random ray that meets the bounds, in the unit of the costs

	Subtrees, SubtreesBuilt uint64 // WithLazy: left to rays, and built by now; else 0
}

// Stats counts the tree's parts; it walks all of it.
func (t *Tree) Stats() (Stats, error) {
	if err := t.acquire(); err != nil {
		return Stats{}, err
	}
	defer t.release()
	s := cStats{size: C.sizeof_htree_stats}
	if err := rawGetStats(t.tree, &s); err != nil {
		return Stats{}, err
	}
	return Stats{
		Kind:         Kind(s.kind),
		Triangles:    uint64(s.triangles),
		Objects:      uint64(s.objects),
		Invalid:      uint64(s.invalid),
		Degenerate:   uint64(s.degenerate),
		Nodes:        uint64(s.nodes),
		Leaves:       uint64(s.leaves),
		References:   uint64(s.references),
		SKDNodes:     uint64(s.skd_nodes),
		BV2Nodes:     uint64(s.bv2_nodes),
		BV6Nodes:     uint64(s.bv6_nodes),
		LinkNodes:    uint64(s.link_nodes),
		BVONodes:     uint64(s.bvo_nodes),
		TernaryNodes: uint64(s.ternary_nodes),
		Depth:        uint32(s.depth),
		Stack:        uint32(s.stack),
		Bytes:        uint64(s.bytes),
		PeakBytes:    uint64(s.peak_bytes),
		BuildSeconds: float64(s.build_seconds),
		SAHCost:      float64(s.sah_cost),

		Subtrees:      uint64(s.subtrees),
		SubtreesBuilt: uint64(s.subtrees_built),
	}, nil
}

// Bounds are those of everything that can be hit.
func (t *Tree) Bounds() (Box, error) {
	var bounds Box
	if err := t.acquire(); err != nil {
		return bounds, err
	}
	defer t.release()
	err := rawGetBounds(t.tree, &bounds)
	return bounds, err
}

// Check proves the structure: every box and plane contains what lies below it, every triangle is reached.
// It is for tests, and walks all of the tree.
func (t *Tree) Check() error {
	if err := t.acquire(); err != nil {
		return err
	}
	defer t.release()
	before := t.hooks.panics.count.Load()
	err := rawCheck(t.tree)
	t.hooks.panics.resume(before) // of the allocator's
	return err
}

// A View is the arrays of a tree, for devices, viewers and files. They are C's memory: read them only. The
// layout of Nodes, Leaves and Grid is that of lib/tree/layout.h, and holds for one minor version.
type View struct {
	Kind        Kind
	Bounds      Box
	Prims       uint32    // that can be hit; 0: there are no nodes
	ObjectCount uint32    // as given; their prims come after the triangles
	Stack       uint32    // entries that a traversal stack can need at most
	Triangles   []float32 // nine a triangle, v0 v1 v2; a skipped one is all 0. Wide: empty, see Leaves
	Nodes       []byte    // root first
	Leaves      []byte    // UG, KD: uint32 prims by leaf; Wide: blocks of corners; else empty
	Grid        []byte    // UG: its shape; else empty
}

// View calls look with the tree's arrays, which must not be used after look has returned: the tree is kept
// alive until then, even if it is closed meanwhile. A compact tree, and a lazy one that is not complete,
// has none to show, and gets ErrUnsupported.
func (t *Tree) View(look func(View) error) error {
	if err := t.acquire(); err != nil {
		return err
	}
	defer t.release()
	v := cView{size: C.sizeof_htree_view}
	if err := rawGetView(t.tree, &v); err != nil {
		return err
	}
	return look(View{
		Kind:        Kind(v.kind),
		Bounds:      *(*Box)(unsafe.Pointer(&v.bounds)),
		Prims:       uint32(v.prims),
		ObjectCount: uint32(v.object_count),
		Stack:       uint32(v.stack),
		Triangles:   array[float32](unsafe.Pointer(v.triangles), 9*C.uint64_t(v.triangle_count)),
		Nodes:       array[byte](v.nodes, v.node_bytes),
		Leaves:      array[byte](v.leaves, v.leaf_bytes),
		Grid:        array[byte](v.grid, v.grid_bytes),
	})
}

// array is nil where C says NULL.
func array[T any](start unsafe.Pointer, count C.uint64_t) []T {
	if start == nil {
		return nil
	}
	return unsafe.Slice((*T)(start), int(count))
}
