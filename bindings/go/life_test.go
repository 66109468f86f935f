// SPDX-License-Identifier: MIT

package htree

import (
	"errors"
	"os"
	"runtime"
	"runtime/debug"
	"strconv"
	"strings"
	"sync"
	"sync/atomic"
	"testing"
	"time"
)

func TestEveryCallOnAClosedTreeGetsErrClosed(t *testing.T) {
	tree := build(t, terrain(4))
	for i := 0; i < 3; i++ {
		if err := tree.Close(); err != nil {
			t.Error(err)
		}
	}
	_, one := tree.IntersectOne(down)
	_, bounds := tree.Bounds()
	_, stats := tree.Stats()
	_, occluded := tree.OccludedOne(down)
	_, update := tree.Update(terrain(4), Refit)
	look := func(View) error { t.Error("a view of a closed tree"); return nil }
	for _, err := range []error{
		tree.Intersect(nil, nil), tree.Occluded(nil, nil), tree.Check(), tree.View(look),
		tree.Complete(), one, bounds, stats, occluded, update,
	} {
		if !errors.Is(err, ErrClosed) {
			t.Error(err)
		}
	}
}

func TestManyGoroutinesQueryOneTree(t *testing.T) {
	tree, rays := build(t, terrain(40)), raysDown(40, 5000)
	want := intersect(t, tree, rays)
	var group sync.WaitGroup
	for i := uint32(0); i < 8; i++ {
		group.Add(1)
		go func(i uint32) {
			defer group.Done()
			hits := make([]Hit, len(rays))
			for round := uint32(0); round < 10; round++ {
				if err := tree.Intersect(rays, hits, WithThreads((i+round)%3)); err != nil {
					t.Error(err)
					return
				}
				for k := range want {
					if hits[k] != want[k] {
						t.Error(k, hits[k], want[k])
						return
					}
				}
			}
		}(i)
	}
	group.Wait()
}

func TestClosingWhileQueriesRunIsSafe(t *testing.T) {
	mesh, rays := terrain(20), raysDown(20, 3000)
	want := intersect(t, build(t, mesh), rays)
	for round := 0; round < 50; round++ {
		tree := build(t, mesh)
		var group sync.WaitGroup
		var done atomic.Int64
		for i := 0; i < 4; i++ {
			group.Add(1)
			go func() {
				defer group.Done()
				hits := make([]Hit, len(rays))
				for {
					err := tree.Intersect(rays, hits)
					if errors.Is(err, ErrClosed) {
						return
					}
					if err != nil || hits[7] != want[7] {
						t.Error(err, hits[7])
						return
					}
					done.Add(1)
				}
			}()
		}
		for done.Load() < 4 {
			runtime.Gosched()
		}
		for i := 0; i < 2; i++ {
			group.Add(1)
			go func() {
				defer group.Done()
				tree.Close()
			}()
		}
		group.Wait()
		if tree.tree != nil {
			t.Fatal("the last query did not free the tree")
		}
	}
}

func TestATreeMayBeClosedByItsOwnCallbacks(t *testing.T) {
	objects := shelves(1)
	var tree *Tree
	objects.Intersect = func(object uint32, ray Ray) (t, u, v float32, ok bool) {
		tree.Close()
		return hitShelf(object, ray)
	}
	tree = build(t, Mesh{Objects: objects})
	if hit := must[Hit](t)(tree.IntersectOne(down)); hit.T != 99 {
		t.Error(hit)
	}
	if tree.tree != nil {
		t.Error("the query did not free the tree")
	}
	tree = build(t, terrain(4), WithKind(H))
	err := tree.View(func(view View) error {
		tree.Close()
		if view.Triangles[3] != 1 || len(view.Nodes) == 0 {
			t.Error(view.Triangles[:9])
		}
		return tree.Check()
	})
	if !errors.Is(err, ErrClosed) || tree.tree != nil {
		t.Error(err)
	}
}

func TestErrorsKeepTheirTextOnTheirGoroutine(t *testing.T) {
	var group sync.WaitGroup
	for vertex := uint32(10); vertex < 20; vertex++ {
		group.Add(1)
		go func(vertex uint32) {
			defer group.Done()
			want := "triangle 0 refers to vertex " + strconv.Itoa(int(vertex)) + " of 3"
			for i := 0; i < 300; i++ {
				var err *Error
				mesh := Mesh{Positions: make([]float32, 9), Indices: []uint32{0, 1, vertex}}
				if !errors.As(buildError(mesh), &err) || err.Text != want {
					t.Errorf("%v, want %s", err, want)
					return
				}
			}
		}(vertex)
	}
	group.Wait()
}

func TestTreesCloseInAnyOrder(t *testing.T) {
	mesh := terrain(8)
	for _, order := range [][3]int{{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}} {
		trees := []*Tree{build(t, mesh), build(t, mesh, WithKind(KD)), build(t, Mesh{Objects: shelves(3)})}
		for i, closing := range order {
			trees[closing].Close()
			for _, open := range order[i+1:] {
				if err := trees[open].Check(); err != nil {
					t.Error(order, err)
				}
			}
		}
	}
}

func residentBytes(t *testing.T) int {
	text, err := os.ReadFile("/proc/self/statm")
	if err != nil {
		t.Skip("memory is counted on Linux only")
	}
	pages := must[int](t)(strconv.Atoi(strings.Fields(string(text))[1]))
	return pages * os.Getpagesize()
}

func TestAHundredThousandTreesLeaveNothingBehind(t *testing.T) {
	mesh, books := terrain(2), newLedger()
	mesh.Objects = shelves(1)
	round := func(count int, options ...BuildOption) {
		for i := 0; i < count; i++ {
			tree := must[*Tree](t)(Build(mesh, options...))
			if i%100 == 0 {
				intersect(t, tree, []Ray{down})
				buildError(Mesh{Positions: mesh.Positions, Indices: []uint32{0, 1, 99}})
			}
			tree.Close()
		}
		debug.FreeOSMemory()
	}
	round(20000)
	// Go's own heap breathes by megabytes, but a leak grows in every round: 32 bytes a tree by 3.2 million.
	least := 1 << 40
	for i := 0; i < 4 && least > 1<<20; i++ {
		before := residentBytes(t)
		round(100000)
		if growth := residentBytes(t) - before; growth < least {
			least = growth
		}
	}
	t.Logf("%d bytes more", least)
	if least > 1<<20 {
		t.Errorf("%d bytes more after 10^5 trees", least)
	}
	round(10000, WithAllocator(books))
	if out := books.out.Load(); out != 0 {
		t.Errorf("%d bytes out", out)
	}
}

func TestTheGarbageCollectorFreesTreesThatNobodyCloses(t *testing.T) {
	mesh, books := terrain(2), newLedger()
	mesh.Objects = shelves(1)
	for i := 0; i < 5000; i++ {
		must[*Tree](t)(Build(mesh, WithAllocator(books)))
	}
	deadline := time.Now().Add(20 * time.Second)
	for books.out.Load() > 0 && time.Now().Before(deadline) {
		runtime.GC()
		time.Sleep(10 * time.Millisecond)
	}
	if out := books.out.Load(); out != 0 {
		t.Errorf("%d bytes out", out)
	}
}
