// SPDX-License-Identifier: MIT

package htree

import (
	"fmt"
	"strconv"
	"testing"
)

// forEachTree calls check with every scene of the conformance file in every kind.
func forEachTree(t *testing.T, threads uint32, check func(*testing.T, *scene, Kind, *Tree)) {
	file := readConformance(t)
	for i := range file.Scenes {
		for _, name := range file.Kinds {
			scene, kind := &file.Scenes[i], must[Kind](t)(ParseKind(name))
			t.Run(scene.Name+"/"+name, func(t *testing.T) {
				check(t, scene, kind, build(t, scene.mesh(), WithKind(kind), WithThreads(threads)))
			})
		}
	}
}

func sameWords(t *testing.T, what string, got, want []uint32) {
	t.Helper()
	if len(got) != len(want) {
		t.Fatalf("%s: %d words, want %d", what, len(got), len(want))
	}
	for i := range want {
		if got[i] != want[i] {
			t.Fatalf("%s: word %d is %#x, want %#x", what, i, got[i], want[i])
		}
	}
}

func sameAnswers(t *testing.T, got []bool, want []uint32) {
	t.Helper()
	for i := range want {
		if got[i] != (want[i] != 0) {
			t.Fatalf("ray %d: occluded is %v", i, got[i])
		}
	}
}

// answersOfC compares hits and occlusion of a scene's rays.
func answersOfC(t *testing.T, scene *scene, tree *Tree) {
	t.Helper()
	rays := scene.rays()
	sameWords(t, "hits", words(intersect(t, tree, rays)), scene.Hits)
	occluded := make([]bool, len(rays))
	if err := tree.Occluded(rays, occluded); err != nil {
		t.Fatal(err)
	}
	sameAnswers(t, occluded, scene.Occluded)
	if err := tree.Check(); err != nil {
		t.Fatal(err)
	}
}

func TestLazyTreesAndCompleteOnesAnswerAsC(t *testing.T) {
	file := readConformance(t)
	for i := range file.Scenes {
		tree := build(t, file.Scenes[i].mesh(), WithKind(Wide), WithLazy())
		answersOfC(t, &file.Scenes[i], tree)
		if err := tree.Complete(); err != nil {
			t.Fatal(err)
		}
		answersOfC(t, &file.Scenes[i], tree)
	}
}

func TestATreeThatGoesFromSceneToSceneAnswersAsC(t *testing.T) {
	file := readConformance(t)
	for _, name := range file.Kinds {
		tree := build(t, Mesh{}, WithKind(must[Kind](t)(ParseKind(name))))
		for i := range file.Scenes {
			for _, how := range []How{Rebuild, Refit} {
				must[float64](t)(tree.Update(file.Scenes[i].mesh(), how))
				answersOfC(t, &file.Scenes[i], tree)
			}
		}
	}
}

func TestHitsAreThoseOfCToTheBit(t *testing.T) {
	for _, threads := range []uint32{0, 1} {
		forEachTree(t, threads, func(t *testing.T, scene *scene, kind Kind, tree *Tree) {
			rays := scene.rays()
			sameWords(t, "hits", words(intersect(t, tree, rays)), scene.Hits)
			occluded := make([]bool, len(rays))
			if err := tree.Occluded(rays, occluded, WithThreads(threads)); err != nil {
				t.Fatal(err)
			}
			sameAnswers(t, occluded, scene.Occluded)
			if err := tree.Check(); err != nil {
				t.Fatal(err)
			}
		})
	}
}

func TestARayAloneGetsTheHitThatItGetsInABatch(t *testing.T) {
	forEachTree(t, 0, func(t *testing.T, scene *scene, kind Kind, tree *Tree) {
		for i, ray := range scene.rays() {
			hit := must[Hit](t)(tree.IntersectOne(ray))
			sameWords(t, fmt.Sprint("ray ", i), words([]Hit{hit}), scene.Hits[4*i:4*i+4])
			if occluded := must[bool](t)(tree.OccludedOne(ray)); occluded != hit.IsHit() {
				t.Fatalf("ray %d: occluded is %v", i, occluded)
			}
		}
	})
}

func TestBoundsAndCountsAreThoseOfC(t *testing.T) {
	forEachTree(t, 0, func(t *testing.T, scene *scene, kind Kind, tree *Tree) {
		bounds := must[Box](t)(tree.Bounds())
		sameWords(t, "bounds", words([]Box{bounds}), scene.Bounds[:])
		stats, want := must[Stats](t)(tree.Stats()), scene.Stats
		if stats.Kind != kind || stats.Triangles != want.Triangles || stats.Objects != want.Objects ||
			stats.Invalid != want.Invalid || stats.Degenerate != want.Degenerate {
			t.Fatalf("%+v, want %+v", stats, want)
		}
		err := tree.View(func(view View) error {
			floats := 9 * int(want.Triangles)
			if kind == Wide {
				floats = 0
			}
			if view.Kind != kind || view.Bounds != bounds || len(view.Triangles) != floats ||
				uint64(view.Prims) != want.Triangles-want.Invalid-want.Degenerate {
				t.Errorf("view of %v: %d prims, %d floats", view.Kind, view.Prims, len(view.Triangles))
			}
			if (len(view.Nodes) == 0) != (view.Prims == 0) {
				t.Errorf("%d bytes of nodes for %d prims", len(view.Nodes), view.Prims)
			}
			return nil
		})
		if err != nil {
			t.Fatal(err)
		}
	})
}

func TestVersionsAndStatusesAreThoseOfC(t *testing.T) {
	file := readConformance(t)
	major, minor, patch := LibraryVersion()
	if version := fmt.Sprintf("%d.%d.%d", major, minor, patch); version != file.Library {
		t.Errorf("library %s, want %s", version, file.Library)
	}
	ours := map[string]Status{
		"OK": 0, "ARGUMENT": ErrArgument, "MEMORY": ErrMemory, "LIMIT": ErrLimit, "GEOMETRY": ErrGeometry,
		"CANCELLED": ErrCancelled, "UNSUPPORTED": ErrUnsupported, "CORRUPT": ErrCorrupt,
		"NO_DEVICE": ErrNoDevice, "DEVICE": ErrDevice, "DEVICE_LOST": ErrDeviceLost, "KERNEL": ErrKernel,
	}
	if len(ours) != len(file.Statuses) {
		t.Errorf("%d statuses, want %d", len(ours), len(file.Statuses))
	}
	for name, code := range file.Statuses {
		status, known := ours[name]
		if !known || int32(status) != code {
			t.Errorf("%s is %d, want %d", name, status, code)
		}
		if want := file.StatusNames[strconv.Itoa(int(code))]; status.Error() != want {
			t.Errorf("%s is called %q, want %q", name, status.Error(), want)
		}
	}
}
