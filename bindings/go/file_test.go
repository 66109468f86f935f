// SPDX-License-Identifier: MIT

package htree

import (
	"bytes"
	"errors"
	"testing"
	"unsafe"
)

func TestASavedTreeComesBack(t *testing.T) {
	rays := raysDown(20, 2000)
	for _, kind := range []Kind{UG, KD, BVHMedian, BVHSAH, SKD, H, AH, Wide} {
		tree := build(t, terrain(20), WithKind(kind))
		file := must[[]byte](t)(tree.Save())
		back := must[*Tree](t)(Load(file, WithThreads(1)))
		sameHits(t, intersect(t, back, rays), intersect(t, tree, rays), "kind %v", kind)
		if again := must[[]byte](t)(back.Save()); !bytes.Equal(again, file) {
			t.Fatalf("%v: %d bytes became %d others", kind, len(file), len(again))
		}
		if stats := must[Stats](t)(back.Stats()); stats.Kind != kind {
			t.Fatalf("%v came back as %v", kind, stats.Kind)
		}
		back.Close()
	}
}

func TestObjectsNeedTheirFunctionAgain(t *testing.T) {
	top := func(object uint32, ray Ray) (float32, float32, float32, bool) {
		return (1 - ray.Org[2]) / ray.Dir[2], 0, float32(object), true
	}
	boxes := []Box{{Hi: [3]float32{1, 1, 1}}, {Lo: [3]float32{2, 0, 0}, Hi: [3]float32{3, 1, 1}}}
	tree := build(t, Mesh{Objects: &Objects{Boxes: boxes, Intersect: top}})
	file := must[[]byte](t)(tree.Save())
	if _, err := Load(file); !errors.Is(err, ErrArgument) {
		t.Fatalf("without a function: %v", err)
	}
	back := must[*Tree](t)(Load(file, WithIntersect(top)))
	defer back.Close()
	hit := must[Hit](t)(back.IntersectOne(NewRay([3]float32{2.5, 0.5, 5}, [3]float32{0, 0, -1})))
	if hit != (Hit{T: 4, V: 1, Prim: 1}) {
		t.Fatalf("hit %v", hit)
	}
}

func TestWhatIsNoTreeIsNotLoaded(t *testing.T) {
	tree := build(t, terrain(5))
	file := must[[]byte](t)(tree.Save())
	changed := bytes.Clone(file)
	changed[len(file)/2] ^= 1
	for i, bad := range [][]byte{nil, {}, file[:100], file[:len(file)-1], append(bytes.Clone(file), 0), changed} {
		if _, err := Load(bad); !errors.Is(err, ErrCorrupt) {
			t.Fatalf("case %d: %v", i, err)
		}
	}
	tree.Close()
	if _, err := tree.Save(); !errors.Is(err, ErrClosed) {
		t.Fatalf("closed: %v", err)
	}
}

type noMemory struct{ panics bool }

func (m noMemory) Allocate(bytes, alignment uint64) unsafe.Pointer {
	if m.panics {
		panic("no more")
	}
	return nil
}

func (m noMemory) Release(memory unsafe.Pointer, bytes uint64) {}

func TestALoadMayFindNoMemory(t *testing.T) {
	file := must[[]byte](t)(build(t, terrain(5)).Save())
	if _, err := Load(file, WithAllocator(noMemory{})); !errors.Is(err, ErrMemory) {
		t.Fatalf("no memory: %v", err)
	}
	defer func() {
		if recover() != "no more" {
			t.Fatal("the panic of an allocator got lost")
		}
	}()
	Load(file, WithAllocator(noMemory{panics: true}))
}
