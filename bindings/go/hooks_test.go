// SPDX-License-Identifier: MIT

package htree

import (
	"context"
	"errors"
	"htree/internal/cmemory"
	"sync"
	"sync/atomic"
	"testing"
	"time"
	"unsafe"
)

// shelves are horizontal unit squares, one above the other.
func shelves(count int) *Objects {
	objects := &Objects{Intersect: hitShelf}
	for z := 0; z < count; z++ {
		objects.Boxes = append(objects.Boxes, Box{
			Lo: [3]float32{0, 0, float32(z)}, Hi: [3]float32{1, 1, float32(z)}})
	}
	return objects
}

func hitShelf(object uint32, ray Ray) (t, u, v float32, ok bool) {
	t = (float32(object) - ray.Org[2]) / ray.Dir[2]
	at := ray.At(t)
	inside := 0 <= at[0] && at[0] <= 1 && 0 <= at[1] && at[1] <= 1
	return t, at[0], at[1], inside && ray.TMin <= t && t <= ray.TMax
}

var down = NewRay([3]float32{0.5, 0.25, 99}, [3]float32{0, 0, -1})

func repeat(ray Ray, count int) []Ray {
	rays := make([]Ray, count)
	for i := range rays {
		rays[i] = ray
	}
	return rays
}

func TestObjectsAreHitBesideTriangles(t *testing.T) {
	mesh := Mesh{Positions: []float32{-9, -9, -1, 9, -9, -1, 0, 9, -1}, Objects: shelves(30)}
	tree := build(t, mesh)
	if hit := must[Hit](t)(tree.IntersectOne(down)); hit != (Hit{70, 0.5, 0.25, 1 + 29}) {
		t.Error(hit)
	}
	beside := NewRay([3]float32{2, 0, 99}, [3]float32{0, 0, -1})
	if hit := must[Hit](t)(tree.IntersectOne(beside)); hit.Prim != 0 {
		t.Error(hit)
	}
	if stats := must[Stats](t)(tree.Stats()); stats.Objects != 30 {
		t.Error(stats)
	}
	for _, threads := range []uint32{1, 4} {
		for i, hit := range intersect(t, tree, repeat(down, 5000), WithThreads(threads)) {
			if hit.T != 70 {
				t.Fatal(i, hit)
			}
		}
	}
}

func TestProgressGrowsAndCancels(t *testing.T) {
	var seen []float64
	// Other threads may do all of the work before this one gets to any.
	tree := build(t, terrain(60), WithThreads(1), WithProgress(func(done float64) bool {
		seen = append(seen, done)
		return true
	}))
	for i := range seen {
		if seen[i] < 0 || seen[i] > 1 || i > 0 && seen[i] < seen[i-1] {
			t.Fatal(seen)
		}
	}
	if len(seen) < 4 {
		t.Error(seen)
	}
	rays, calls := raysDown(60, 50000), 0
	err := tree.Intersect(rays, make([]Hit, len(rays)), WithThreads(1), WithProgress(func(float64) bool {
		calls++
		return calls < 2
	}))
	if !errors.Is(err, ErrCancelled) || calls != 2 {
		t.Error(err, calls)
	}
}

func TestContextsCancel(t *testing.T) {
	ctx, cancel := context.WithCancel(context.Background())
	tree, rays := build(t, terrain(60)), raysDown(60, 200000)
	hits, occluded := make([]Hit, len(rays)), make([]bool, len(rays))
	if err := tree.IntersectContext(ctx, rays, hits); err != nil {
		t.Error(err)
	}
	stopping := WithProgress(func(float64) bool { cancel(); return true })
	err := tree.IntersectContext(ctx, rays, hits, WithThreads(1), stopping)
	if !errors.Is(err, ErrCancelled) || !errors.Is(err, context.Canceled) {
		t.Error("while it runs:", err)
	}
	for _, err := range []error{
		tree.IntersectContext(ctx, rays, hits),
		tree.OccludedContext(ctx, rays, occluded),
		func() error { _, err := BuildContext(ctx, terrain(60)); return err }(),
	} {
		if !errors.Is(err, ErrCancelled) || !errors.Is(err, context.Canceled) {
			t.Error("before it runs:", err)
		}
	}
	late, cancel := context.WithTimeout(context.Background(), time.Millisecond)
	defer cancel()
	mesh := terrain(700)
	if _, err := BuildContext(late, mesh); !errors.Is(err, context.DeadlineExceeded) {
		t.Error("a build of a million triangles in a millisecond:", err)
	}
}

func TestTasksRunOnceEachWhateverTheLoopDoes(t *testing.T) {
	objects := shelves(1)
	var calls atomic.Int64
	objects.Intersect = func(object uint32, ray Ray) (t, u, v float32, ok bool) {
		calls.Add(1)
		return hitShelf(object, ray)
	}
	late := make(chan func(), 1000)
	loops := map[string]func(count uint32, task func(uint32)){
		"goroutines": func(count uint32, task func(uint32)) {
			var group sync.WaitGroup
			for i := uint32(0); i < count; i++ {
				group.Add(1)
				go func(i uint32) {
					defer group.Done()
					task(i)
				}(i)
			}
			group.Wait()
		},
		"nothing": func(uint32, func(uint32)) {},
		"twice and beyond": func(count uint32, task func(uint32)) {
			for i := uint32(0); i < 2*count; i++ {
				task(i % (count + 9))
			}
		},
		"does not wait": func(count uint32, task func(uint32)) {
			for i := uint32(0); i < count; i++ {
				go task(i)
			}
		},
		"too late": func(count uint32, task func(uint32)) {
			late <- func() { task(0) }
		},
	}
	for name, run := range loops {
		tree := build(t, Mesh{Objects: objects}, WithTasks(run))
		for round := 0; round < 20; round++ {
			calls.Store(0)
			rays := repeat(down, 5000)
			for i, hit := range intersect(t, tree, rays, WithThreads(2)) {
				if hit.T != 99 {
					t.Fatal(name, i, hit)
				}
			}
			if calls.Load() != int64(len(rays)) {
				t.Fatalf("%s: %d calls for %d rays", name, calls.Load(), len(rays))
			}
		}
		tree.Close()
	}
	for len(late) > 0 {
		(<-late)() // of queries that are over, on a tree that is gone
	}
	tree := build(t, terrain(20), WithTasks(func(_ uint32, task func(uint32)) {
		task(0)
		panic("the pool is closed")
	}))
	value := panicOf(func() { intersect(t, tree, raysDown(20, 5000), WithThreads(2)) })
	if value != "the pool is closed" {
		t.Error(value)
	}
}

func TestAQueryWaitsForTasksThatItsLoopLeftRunning(t *testing.T) {
	objects := shelves(1)
	var calls atomic.Int64
	objects.Intersect = func(object uint32, ray Ray) (t, u, v float32, ok bool) {
		if calls.Add(1) == 1 {
			time.Sleep(50 * time.Millisecond)
		}
		return hitShelf(object, ray)
	}
	tree := build(t, Mesh{Objects: objects}, WithTasks(func(_ uint32, task func(uint32)) {
		go task(0)
		for calls.Load() == 0 {
			time.Sleep(time.Millisecond)
		}
	}))
	if hits := intersect(t, tree, repeat(down, 2000), WithThreads(2)); hits[0].T != 99 || hits[511].T != 99 {
		t.Error(hits[0], hits[511])
	}
}

func TestThreadsSayWhetherTheLoopRuns(t *testing.T) {
	loops := 0
	loop := WithTasks(func(uint32, func(uint32)) { loops++ })
	rays, mesh := repeat(down, 2000), Mesh{Objects: shelves(1)}
	for _, c := range []struct {
		build   uint32
		options []QueryOption
		want    int
	}{{1, nil, 0}, {2, nil, 1}, {1, []QueryOption{WithThreads(2)}, 1}, {2, []QueryOption{WithThreads(1)}, 0}} {
		tree := build(t, mesh, WithThreads(c.build), loop)
		loops = 0
		intersect(t, tree, rays, c.options...)
		if loops != c.want {
			t.Errorf("%d threads, %v: %d loops, want %d", c.build, c.options, loops, c.want)
		}
	}
}

// ledger is C's memory, by books that tell what is out; one allocation may fail or panic.
type ledger struct {
	out, left atomic.Int64
	panics    bool
}

func newLedger() *ledger {
	var l ledger
	l.left.Store(1 << 60)
	return &l
}

func (l *ledger) Allocate(bytes, alignment uint64) unsafe.Pointer {
	if l.left.Add(-1) == -1 {
		if l.panics {
			panic("the purse is empty")
		}
		return nil
	}
	l.out.Add(int64(bytes))
	return cmemory.Allocate(bytes, alignment)
}

func (l *ledger) Release(memory unsafe.Pointer, bytes uint64) {
	l.out.Add(-int64(bytes))
	cmemory.Release(memory)
	if l.panics {
		panic("swallowed")
	}
}

func TestEveryByteComesBackAlsoWhereAllocationsFail(t *testing.T) {
	mesh := terrain(10)
	full := newLedger()
	tree := build(t, mesh, WithKind(AH), WithAllocator(full))
	if stats := must[Stats](t)(tree.Stats()); uint64(full.out.Load()) != stats.Bytes {
		t.Errorf("%d bytes out, %d in the tree", full.out.Load(), stats.Bytes)
	}
	full.left.Store(0)
	if err := tree.Check(); !errors.Is(err, ErrMemory) {
		t.Error(err)
	}
	full.left.Store(0)
	full.panics = true
	if value := panicOf(func() { tree.Check() }); value != "the purse is empty" {
		t.Error(value)
	}
	if err := tree.Check(); err != nil {
		t.Error(err)
	}
	tree.Close()
	if full.out.Load() != 0 {
		t.Errorf("%d bytes out", full.out.Load())
	}
	failures := int64(0)
	for ; ; failures++ {
		short := &ledger{}
		short.left.Store(failures)
		err := buildError(mesh, WithKind(AH), WithThreads(1), WithAllocator(short))
		if err == nil {
			break
		}
		if !errors.Is(err, ErrMemory) || short.out.Load() != 0 {
			t.Fatal(failures, err, short.out.Load())
		}
		short.left.Store(failures)
		short.panics = true
		value := panicOf(func() { _ = buildError(mesh, WithKind(AH), WithThreads(1), WithAllocator(short)) })
		if value != "the purse is empty" || short.out.Load() != 0 {
			t.Fatal(failures, value, short.out.Load())
		}
	}
	if failures < 4 {
		t.Errorf("%d allocations", failures)
	}
}

func TestCountersCountAndChangeNothing(t *testing.T) {
	tree, rays := build(t, terrain(30)), raysDown(30, 2000)
	counters := make([]Counters, len(rays))
	hits := intersect(t, tree, rays, WithCounters(counters))
	sameHits(t, hits, intersect(t, tree, rays), "with counters")
	for i, cost := range counters {
		if hits[i].IsHit() && (cost.Intersections == 0 || cost.LeafSteps == 0) ||
			cost.LeafSteps > cost.TraversalSteps {
			t.Fatal(i, hits[i], cost)
		}
	}
}

func TestMeasuredCostsChangeNoHit(t *testing.T) {
	costs := must[Costs](t)(Calibrate())
	if costs.SKD != 1 || costs.BV2 <= 0 || costs.BV6 <= 0 || costs.Intersect <= 0 {
		t.Error(costs)
	}
	rays := raysDown(20, 2000)
	want := intersect(t, build(t, terrain(20)), rays)
	sameHits(t, intersect(t, build(t, terrain(20), WithCosts(costs)), rays), want, "measured costs")
	for _, option := range []BuildOption{WithAnyPlanes(), WithLoosePlanes(), WithAxes(3), WithBuckets(5)} {
		sameHits(t, intersect(t, build(t, terrain(20), WithKind(AH), option), rays), want, "an option")
	}
}
