// SPDX-License-Identifier: MIT

package htree

import (
	"errors"
	"math"
	"strings"
	"testing"
	"unsafe"
)

func triangle() Mesh {
	return Mesh{Positions: []float32{0, 0, 0, 1, 0, 0, 0, 1, 0}}
}

func buildError(mesh Mesh, options ...BuildOption) error {
	tree, err := Build(mesh, options...)
	if tree != nil {
		tree.Close()
	}
	return err
}

func floatBits(bits uint32) float32 { return math.Float32frombits(bits) }

func stop(float64) bool { return false }

// rawBuildOf builds by the raw layer what change makes of one triangle.
func rawBuildOf(t *testing.T, change func(mesh *cMesh, options *cOptions, positions *[]float32)) error {
	options := must[cOptions](t)((&buildConfig{kind: H}).options())
	mesh := triangle()
	numbers := must[cMesh](t)(mesh.numbers())
	change(&numbers, &options, &mesh.Positions)
	var out *cTree
	err := rawBuild(&out, &numbers, mesh.Positions, mesh.Indices, nil, &options, hookHandle{}, 0)
	if out != nil {
		t.Error("a tree beside an error")
		rawFree(out)
	}
	return err
}

// mistakes are the cases of the conformance file: by the package where its types allow them, else by its raw
// layer. Go's slices have no NULL, sizes and unknown flags cannot be said.
func mistakes(t *testing.T) map[string]func() error {
	tree := build(t, triangle())
	ray, hits := []Ray{NewRay([3]float32{}, [3]float32{0, 0, 1})}, make([]Hit, 1)
	nan := floatBits(0x7fc00000)
	of := func(options ...BuildOption) func() error {
		return func() error { return buildError(triangle(), options...) }
	}
	raw := func(change func(*cMesh, *cOptions, *[]float32)) func() error {
		return func() error { return rawBuildOf(t, change) }
	}
	var query cQuery
	if err := rawQueryInit(&query, unsafe.Sizeof(query)); err != nil {
		t.Fatal(err)
	}
	flagged := query
	flagged.flags = 1
	return map[string]func() error{
		"build-index-out-of-range": func() error {
			return buildError(Mesh{Positions: triangle().Positions, Indices: []uint32{0, 1, 3}})
		},
		"build-strict-nan": func() error {
			return buildError(Mesh{Positions: []float32{nan, 0, 0, 1, 0, 0, 0, 1, 0}}, WithStrict())
		},
		"build-kind-unknown": of(WithKind(99)),
		"build-buckets-1":    of(WithBuckets(1)),
		"build-axes-2":       of(WithAxes(2)),
		"build-cost-nan":     of(WithCosts(Costs{nan, 1, 1, 1})),
		"build-cost-zero":    of(WithCosts(Costs{1, 1, 1, 0})),
		"build-cells-huge":   of(WithKind(AH), WithCellsPerPrim(1e9)),
		"build-few-prims-0":  of(WithKind(AH), WithFewPrims(0)),
		"build-stride-8": func() error {
			return buildError(Mesh{Positions: triangle().Positions, PositionStride: 8})
		},
		"build-positions-null": func() error { return buildError(Mesh{Indices: []uint32{0, 0, 0}}) },
		"build-cancelled":      func() error { return buildError(terrain(40), WithProgress(stop)) },
		"query-cancelled": func() error {
			rays := raysDown(20, 100000)
			return build(t, terrain(20)).Intersect(rays, make([]Hit, len(rays)), WithProgress(stop))
		},
		"build-flags-unknown": raw(func(_ *cMesh, options *cOptions, _ *[]float32) {
			options.flags = 0x80000000
		}),
		"build-too-few-vertices": raw(func(mesh *cMesh, _ *cOptions, _ *[]float32) {
			mesh.triangle_count = 2
		}),
		"query-flags-unknown": func() error { return rawIntersect(tree.tree, ray, 1, hits, &flagged, nil, 0) },
		"options-size-0":      func() error { return rawOptionsInit(&cOptions{}, 0, H) },
		"query-size-0":        func() error { return rawQueryInit(&cQuery{}, 0) },
		"stats-size-0":        func() error { return rawGetStats(tree.tree, &cStats{}) },
		"view-size-0":         func() error { return rawGetView(tree.tree, &cView{}) },
		"view-lazy": func() error {
			return build(t, terrain(side), WithKind(Wide), WithLazy()).View(func(View) error { return nil })
		},
		"update-how-3": func() error { _, err := tree.Update(triangle(), 3); return err },
		"update-index-out-of-range": func() error {
			_, err := tree.Update(Mesh{Positions: triangle().Positions, Indices: []uint32{0, 1, 3}}, Rebuild)
			return err
		},
		"update-mesh-null": func() error {
			return rawUpdate(tree.tree, nil, nil, nil, nil, hookHandle{}, Refit, nil)
		},
		"complete-null": func() error { return rawComplete(nil) },
		"rays-null":     func() error { return rawIntersect(tree.tree, nil, 1, hits, &query, nil, 0) },
		"hits-null":     func() error { return rawIntersect(tree.tree, ray, 1, nil, &query, nil, 0) },
		"tree-null":     func() error { return rawIntersect(nil, ray, 1, hits, nil, nil, 0) },
		"out-null": func() error {
			options := must[cOptions](t)((&buildConfig{kind: H}).options())
			return rawBuild(nil, &cMesh{}, nil, nil, nil, &options, hookHandle{}, 0)
		},
		"mesh-null": func() error {
			var out *cTree
			return rawBuild(&out, nil, nil, nil, nil, nil, hookHandle{}, 0)
		},
	}
}

func TestEveryMistakeGetsItsStatus(t *testing.T) {
	file := readConformance(t)
	known := mistakes(t)
	for _, entry := range file.Misuse {
		t.Run(entry.Case, func(t *testing.T) {
			mistake, ok := known[entry.Case]
			if !ok {
				t.Fatal("this test does not know the case")
			}
			err := mistake()
			var failure *Error
			if !errors.As(err, &failure) {
				t.Fatalf("no error of this package: %v", err)
			}
			status := Status(file.Statuses[entry.Status])
			if failure.Status != status || !errors.Is(err, status) || errors.Is(err, status+1) {
				t.Errorf("%v, want %v", err, status)
			}
			if failure.Text == "" || !strings.HasPrefix(err.Error(), "htree: "+status.Error()+": ") {
				t.Errorf("its text is %q", err)
			}
		})
	}
}

func TestLengthsThatDifferAreRefused(t *testing.T) {
	tree := build(t, triangle())
	ray := make([]Ray, 1)
	for _, err := range []error{
		tree.Intersect(ray, nil),
		tree.Occluded(ray, make([]bool, 2)),
		tree.Intersect(ray, make([]Hit, 1), WithCounters(nil)),
		tree.Occluded(ray, make([]bool, 1), WithCounters(make([]Counters, 2))),
	} {
		if !errors.Is(err, ErrArgument) {
			t.Error(err)
		}
	}
	if err := tree.Intersect(nil, nil, WithCounters(nil)); err != nil {
		t.Error(err)
	}
}

func TestMeshesThatAreNotWholeAreRefused(t *testing.T) {
	points := triangle().Positions
	for _, refused := range []struct {
		mesh   Mesh
		status Status
	}{
		{Mesh{Positions: points[:8]}, ErrArgument},
		{Mesh{Positions: points, Indices: []uint32{0, 1}}, ErrArgument},
		{Mesh{Positions: points[:6]}, ErrGeometry},
		{Mesh{Positions: points, PositionStride: 13}, ErrArgument},
		{Mesh{Positions: points, PositionStride: 4}, ErrArgument},
		{Mesh{Positions: points, PositionStride: -1}, ErrArgument},
		{Mesh{Positions: points, PositionStride: -4}, ErrGeometry}, // one vertex fits, no triangle
		{Mesh{Positions: points, PositionStride: math.MaxInt &^ 3}, ErrGeometry},
		{Mesh{Objects: &Objects{Boxes: make([]Box, 1)}}, ErrArgument},
	} {
		if err := buildError(refused.mesh); !errors.Is(err, refused.status) {
			t.Errorf("%+v: %v", refused.mesh, err)
		}
	}
	for _, empty := range []Mesh{{}, {Positions: points, Indices: []uint32{}}, {Objects: &Objects{}}} {
		if err := buildError(empty); err != nil {
			t.Error(err)
		}
	}
}

func TestFlagsAddUp(t *testing.T) {
	nan := Mesh{Positions: []float32{floatBits(0x7fc00000), 0, 0, 1, 0, 0, 0, 1, 0}}
	if err := buildError(nan, WithStrict(), WithAnyPlanes(), WithLoosePlanes()); !errors.Is(err, ErrGeometry) {
		t.Error(err)
	}
	if err := buildError(nan, WithAnyPlanes()); err != nil {
		t.Error(err)
	}
}

func TestAStrideReadsNoFurtherThanTheSlice(t *testing.T) {
	// The last vertex has no room for a whole stride, and needs none.
	mesh := Mesh{Positions: []float32{0, 0, 0, 9, 1, 0, 0, 9, 0, 1, 0}, PositionStride: 16}
	if bounds := must[Box](t)(build(t, mesh).Bounds()); bounds.Hi != [3]float32{1, 1, 0} {
		t.Error(bounds)
	}
}

func TestNamesOfKindsGoThereAndBack(t *testing.T) {
	for _, kind := range []Kind{UG, KD, BVHMedian, BVHSAH, SKD, H, AH, Wide, Fast, Balanced, Best} {
		if back, err := ParseKind(kind.String()); back != kind {
			t.Error(kind, back, err)
		}
	}
	for _, name := range []string{"", "H", "h ", "bvh", "h\x00"} {
		if _, err := ParseKind(name); !errors.Is(err, ErrArgument) {
			t.Errorf("%q: %v", name, err)
		}
	}
	if name := Kind(99).String(); name != "Kind(99)" {
		t.Error(name)
	}
}
