// SPDX-License-Identifier: MIT

package htree

// #include "bridge.h"
import "C"

import (
	"context"
	"runtime"
	"runtime/cgo"
	"unsafe"
)

// A Tree answers ray queries. Any number of goroutines may query it; only Update and Complete change it.
// Close frees it; the garbage collector does so too, but knows nothing of the memory that it holds.
type Tree struct {
	tree     *cTree
	threads  uint32
	hooks    *hooks
	handle   cgo.Handle // of hooks, 0 if there are none
	lazy     bool       // is built with WithLazy, and so again by Update
	borrowed loan       // what a lazy tree reads until it is complete
	turns
}

// Build builds a tree over the mesh, with the defaults of Balanced where no option says otherwise.
//
// Triangles with a NaN, infinite or oversize coordinate are skipped, those without area are never hit;
// both are counted in [Stats]. No triangles at all is fine: every ray misses.
func Build(mesh Mesh, options ...BuildOption) (*Tree, error) {
	return BuildContext(context.Background(), mesh, options...)
}

// BuildContext is as Build, and ends with ErrCancelled soon after the context is done.
func BuildContext(ctx context.Context, mesh Mesh, options ...BuildOption) (*Tree, error) {
	config := buildConfig{kind: Balanced}
	for _, option := range options {
		option.applyBuild(&config)
	}
	if err := verifyLibrary(); err != nil {
		return nil, err
	}
	how, err := config.options()
	if err != nil {
		return nil, err
	}
	numbers, err := mesh.numbers()
	if err != nil {
		return nil, err
	}
	tree := &Tree{hooks: &config.hooks, threads: uint32(how.threads)}
	tree.lazy = how.kind == C.HTREE_WIDE && how.flags&C.HTREE_LAZY != 0
	borrowed, err := mesh.lend(tree.lazy)
	if err != nil {
		return nil, err
	}
	if tree.lazy {
		tree.borrowed = borrowed
	}
	var boxes []Box
	boxes, config.hooks.intersect = mesh.objects()
	which := config.hooks.which()
	if which != 0 {
		tree.handle = cgo.NewHandle(tree.hooks)
	}
	built := false
	defer func() {
		if !built { // an error, or a panic of a hook's
			tree.Close()
		}
	}()
	runtime.SetFinalizer(tree, (*Tree).Close)
	report := newProgress(ctx, config.report, tree.hooks)
	err = report.run(which != 0, func(handle progressHandle) error {
		var out *cTree // by itself: C may not see the rest of the Tree
		err := rawBuild(&out, &numbers, borrowed.positions, borrowed.indices, boxes, &how,
			hookHandle{which, tree.handle}, handle)
		tree.tree = out
		return err
	})
	if err != nil {
		return nil, err
	}
	built = true
	return tree, nil
}

// Close frees the tree. Twice is harmless, and so is closing while queries run: the last of them frees it.
// Every later call gets ErrClosed. It implements io.Closer, and its error is always nil.
func (t *Tree) Close() error {
	runtime.SetFinalizer(t, nil)
	if t.close() {
		t.free()
	}
	return nil
}

// release ends what acquire or acquireAlone began.
func (t *Tree) release() {
	if t.leave() {
		t.free()
	}
}

// free is called once, by the last who uses the tree.
func (t *Tree) free() {
	rawFree(t.tree)
	if t.handle != 0 {
		t.handle.Delete()
	}
	t.borrowed.free()
	t.tree, t.handle = nil, 0
}

// Intersect writes the closest hit of every ray: hits[i] of rays[i]. It spreads a large batch over cores.
func (t *Tree) Intersect(rays []Ray, hits []Hit, options ...QueryOption) error {
	return t.IntersectContext(context.Background(), rays, hits, options...)
}

// IntersectContext is as Intersect, and ends with ErrCancelled soon after the context is done; then the
// hits are unspecified.
func (t *Tree) IntersectContext(ctx context.Context, rays []Ray, hits []Hit, options ...QueryOption) error {
	return t.query(ctx, len(rays), len(hits), options,
		func(query *cQuery, counters []Counters, progress progressHandle) error {
			return rawIntersect(t.tree, rays, len(rays), hits, query, counters, progress)
		})
}

// IntersectOne is the closest hit of one ray.
func (t *Tree) IntersectOne(ray Ray) (Hit, error) {
	hits := make([]Hit, 1)
	err := t.Intersect([]Ray{ray}, hits)
	return hits[0], err
}

// Occluded writes for every ray whether it hits anything. Otherwise as Intersect, and faster.
func (t *Tree) Occluded(rays []Ray, occluded []bool, options ...QueryOption) error {
	return t.OccludedContext(context.Background(), rays, occluded, options...)
}

// OccludedContext is as Occluded, and ends with ErrCancelled soon after the context is done; then the
// answers are unspecified.
func (t *Tree) OccludedContext(ctx context.Context, rays []Ray, occluded []bool, options ...QueryOption) error {
	return t.query(ctx, len(rays), len(occluded), options,
		func(query *cQuery, counters []Counters, progress progressHandle) error {
			return rawOccluded(t.tree, rays, len(rays), occluded, query, counters, progress)
		})
}

// OccludedOne says whether one ray hits anything.
func (t *Tree) OccludedOne(ray Ray) (bool, error) {
	occluded := make([]bool, 1)
	err := t.Occluded([]Ray{ray}, occluded)
	return occluded[0], err
}

// query reads the options and makes the call, while which the tree lives.
func (t *Tree) query(ctx context.Context, rays, answers int, options []QueryOption,
	call func(*cQuery, []Counters, progressHandle) error) error {
	var config queryConfig
	for _, option := range options {
		option.applyQuery(&config)
	}
	if rays != answers {
		return failure(ErrArgument, "%d rays and %d answers: must be equal", rays, answers)
	}
	if config.counting && len(config.counters) != rays {
		return failure(ErrArgument, "%d rays and %d counters: must be equal", rays, len(config.counters))
	}
	if err := t.acquire(); err != nil {
		return err
	}
	defer t.release()
	var query cQuery
	if err := rawQueryInit(&query, unsafe.Sizeof(query)); err != nil {
		return err
	}
	query.threads = C.uint32_t(t.threads)
	if config.threads != nil {
		query.threads = C.uint32_t(*config.threads)
	}
	needed := t.hooks.intersect != nil || t.hooks.tasks != nil
	return newProgress(ctx, config.report, t.hooks).run(needed, func(progress progressHandle) error {
		return call(&query, config.counters, progress)
	})
}
