// SPDX-License-Identifier: MIT

package htree

// #include "bridge.h"
// #include <stdlib.h>
import "C"

import (
	"runtime/cgo"
	"unsafe"
)

// How [Tree.Update] brings a tree to a mesh.
type How int32

// The ways of an update.
const (
	Rebuild How = C.HTREE_REBUILD // as Build would, in the memory of the builds before
	Refit   How = C.HTREE_REFIT   // Wide: the same nodes around the new positions
)

// Complete builds what rays have not reached yet of a tree that was built with WithLazy, on all cores, and
// frees its copy of the mesh. It does nothing to any other tree. Hits are the same before and after.
//
// It waits for the queries that run on the tree, and queries wait for it, so it must not be called in a
// function that a query calls, nor in View.
func (t *Tree) Complete() error {
	if err := t.acquireAlone(); err != nil {
		return err
	}
	defer t.release()
	before := t.hooks.panics.count.Load()
	err := rawComplete(t.tree)
	if err == nil {
		t.borrowed.free()
	}
	t.hooks.panics.resume(before)
	return err
}

// Update brings the tree to new positions, or with Rebuild to any mesh at all, with the options that it was
// built with. After an error the tree is as it was.
//
// Refit is for a mesh of as many triangles and objects. The tree is rebuilt where refitting cannot do: other
// kinds, a lazy or a compact tree, or other triangles than before that can be hit. The quality is the expected
// cost of a ray over that when the tree was built: 1 after a rebuild; from about 1.5 on rebuilding pays.
//
// It waits for the queries that run on the tree, and queries wait for it, so it must not be called in a
// function that a query calls, nor in View.
func (t *Tree) Update(mesh Mesh, how How) (quality float64, err error) {
	numbers, err := mesh.numbers()
	if err != nil {
		return 0, err
	}
	if err := t.acquireAlone(); err != nil {
		return 0, err
	}
	defer t.release()
	loan, err := mesh.lend(t.lazy)
	if err != nil {
		return 0, err
	}
	old := t.hooks.intersect
	var boxes []Box
	boxes, t.hooks.intersect = mesh.objects()
	which := t.hooks.which()
	if which != 0 && t.handle == 0 {
		t.handle = cgo.NewHandle(t.hooks)
	}
	before := t.hooks.panics.count.Load()
	err = rawUpdate(t.tree, &numbers, loan.positions, loan.indices, boxes, hookHandle{which, t.handle},
		how, &quality)
	if err != nil {
		t.hooks.intersect = old
		loan.free()
	} else {
		t.borrowed.free()
		t.borrowed = loan
	}
	t.hooks.panics.resume(before)
	return quality, err
}

// A loan is the arrays that C reads: the caller's, for the length of a call, or copies in C's memory, for a
// lazy tree reads them after it.
type loan struct {
	positions []float32
	indices   []uint32
	copied    bool
}

// lend copies the arrays for a lazy tree.
func (m *Mesh) lend(lazy bool) (loan, error) {
	if !lazy {
		return loan{positions: m.Positions, indices: m.Indices}, nil
	}
	positions, ok := cCopy(m.Positions)
	indices, ok2 := cCopy(m.Indices)
	copies := loan{positions, indices, true}
	if !ok || !ok2 {
		copies.free()
		return loan{}, failure(ErrMemory, "no memory for a copy of the mesh")
	}
	return copies, nil
}

// free forgets the arrays, and frees them if they are copies.
func (l *loan) free() {
	if l.copied {
		C.free(unsafe.Pointer(first[C.float](l.positions)))
		C.free(unsafe.Pointer(first[C.uint32_t](l.indices)))
	}
	*l = loan{}
}

// cCopy is a copy in C's memory; false: there is none.
func cCopy[T any](slice []T) (copied []T, ok bool) {
	if len(slice) == 0 {
		return nil, true
	}
	bytes := C.uint64_t(uintptr(len(slice)) * unsafe.Sizeof(slice[0]))
	memory := C.htree_go_copy(unsafe.Pointer(&slice[0]), bytes)
	if memory == nil {
		return nil, false
	}
	return unsafe.Slice((*T)(memory), len(slice)), true
}
