// SPDX-License-Identifier: MIT

package htree

import (
	"sync"
	"sync/atomic"
	"testing"
)

// panicOf is what call panics with.
func panicOf(call func()) (value any) {
	defer func() { value = recover() }()
	call()
	return nil
}

func TestAPanicInAnObjectGoesOnInTheQueryOnAnyThread(t *testing.T) {
	var armed, calls atomic.Int64
	objects := shelves(1)
	objects.Intersect = func(object uint32, ray Ray) (t, u, v float32, ok bool) {
		calls.Add(1)
		if armed.Load() != 0 {
			panic("an object gives up")
		}
		return hitShelf(object, ray)
	}
	tree := build(t, Mesh{Objects: objects})
	rays := repeat(down, 20000)
	for _, threads := range []uint32{1, 4} {
		armed.Store(1)
		calls.Store(0)
		value := panicOf(func() { intersect(t, tree, rays, WithThreads(threads)) })
		if value != "an object gives up" || calls.Load() > int64(threads) {
			t.Errorf("%v after %d calls with %d threads", value, calls.Load(), threads)
		}
		armed.Store(0)
		if hits := intersect(t, tree, rays, WithThreads(threads)); hits[0].T != 99 || hits[19999].T != 99 {
			t.Error("hits after a panic:", hits[0])
		}
	}
}

func TestNoQueryBesideAPanicReturnsWrongHits(t *testing.T) {
	objects := shelves(1)
	objects.Intersect = func(object uint32, ray Ray) (t, u, v float32, ok bool) {
		if ray.TMax < 0 {
			panic("a ray that ends before it begins")
		}
		return hitShelf(object, ray)
	}
	tree := build(t, Mesh{Objects: objects})
	var panics atomic.Int64
	var group sync.WaitGroup
	for i := 0; i < 4; i++ {
		bad := i == 0
		group.Add(1)
		go func() {
			defer group.Done()
			for round := 0; round < 200; round++ {
				rays, hits := repeat(down, 100), make([]Hit, 100)
				if bad && round%10 == 0 {
					rays[50] = Ray{[3]float32{0.5, 0.25, -99}, -100, [3]float32{0, 0, -1}, -50}
				}
				if value := panicOf(func() { _ = tree.Intersect(rays, hits) }); value != nil {
					panics.Add(1)
					continue
				}
				for _, hit := range hits {
					if hit.T != 99 {
						t.Error("a miss that is none:", hit)
						return
					}
				}
			}
		}()
	}
	group.Wait()
	if panics.Load() < 20 {
		t.Errorf("%d panics, want 20 or more", panics.Load())
	}
}

func TestAPanicThatWaitsIsSeenByEveryQueryBesideIt(t *testing.T) {
	var p panics
	guilty := p.count.Load()
	p.catch(func() { panic("first") })
	beside := p.count.Load() // a query that starts while the panic waits
	p.catch(func() { t.Error("called while a panic waits") })
	if value := panicOf(func() { p.resume(guilty) }); value != "first" {
		t.Error(value)
	}
	if value := panicOf(func() { p.resume(beside) }); value == nil || value == "first" {
		t.Error("misses for hits:", value)
	}
	after, called := p.count.Load(), false
	p.catch(func() { called = true })
	if value := panicOf(func() { p.resume(after) }); value != nil || !called {
		t.Error("after it has gone on:", value, called)
	}
}

func TestAPanicInProgressCancelsAndGoesOn(t *testing.T) {
	impatient := WithProgress(func(float64) bool { panic("no patience") })
	if value := panicOf(func() { _ = buildError(terrain(60), impatient) }); value != "no patience" {
		t.Error(value)
	}
	tree, rays := build(t, terrain(60)), raysDown(60, 50000)
	if value := panicOf(func() { intersect(t, tree, rays, impatient) }); value != "no patience" {
		t.Error(value)
	}
	intersect(t, tree, rays)
}
