// SPDX-License-Identifier: MIT

package htree

import (
	"encoding/json"
	"math"
	"os"
	"testing"
	"unsafe"
)

// terrain is side x side wavy squares.
func terrain(side int) Mesh {
	row := side + 1
	var mesh Mesh
	for i := 0; i < row*row; i++ {
		x, y := i%row, i/row
		z := math.Sin(0.7*float64(x)) + math.Cos(0.3*float64(y))
		mesh.Positions = append(mesh.Positions, float32(x), float32(y), float32(z))
	}
	for i := 0; i < side*side; i++ {
		a := uint32(i%side + i/side*row)
		b, c, d := a+1, a+uint32(row), a+uint32(row)+1
		mesh.Indices = append(mesh.Indices, a, b, c, b, d, c)
	}
	return mesh
}

// raysDown are slanted rays from above a terrain of that side; some pass it by.
func raysDown(side, count int) []Ray {
	spread := func(i int, step float64) float32 {
		_, fraction := math.Modf(step * float64(i))
		return float32(1.2 * float64(side) * fraction)
	}
	rays := make([]Ray, count)
	for i := range rays {
		rays[i] = NewRay([3]float32{spread(i, 0.618034), spread(i, 0.414214), 5}, [3]float32{0.1, 0.2, -1})
	}
	return rays
}

// must ends the test on an error.
func must[T any](t testing.TB) func(value T, err error) T {
	return func(value T, err error) T {
		t.Helper()
		if err != nil {
			t.Fatal(err)
		}
		return value
	}
}

// build is a tree that the test closes at its end.
func build(t testing.TB, mesh Mesh, options ...BuildOption) *Tree {
	t.Helper()
	tree := must[*Tree](t)(Build(mesh, options...))
	t.Cleanup(func() { tree.Close() })
	return tree
}

func intersect(t testing.TB, tree *Tree, rays []Ray, options ...QueryOption) []Hit {
	t.Helper()
	hits := make([]Hit, len(rays))
	if err := tree.Intersect(rays, hits, options...); err != nil {
		t.Fatal(err)
	}
	return hits
}

func sameHits(t testing.TB, got, want []Hit, format string, arguments ...any) {
	t.Helper()
	for i := range want {
		if got[i] != want[i] {
			t.Fatalf("ray %d: %v, want %v: "+format, append([]any{i, got[i], want[i]}, arguments...)...)
		}
	}
}

// The conformance file that every binding reads: floats are their bits.
type conformance struct {
	Format      int
	Library     string
	Scenes      []scene
	Kinds       []string
	Statuses    map[string]int32
	StatusNames map[string]string `json:"status_names"`
	Misuse      []struct{ Case, Status string }
}

type scene struct {
	Name      string
	Positions []uint32
	Indices   []uint32
	Bounds    [6]uint32
	Stats     struct{ Triangles, Objects, Invalid, Degenerate uint64 }
	Rays      []uint32
	Hits      []uint32
	Occluded  []uint32
}

func readConformance(t *testing.T) (file conformance) {
	t.Helper()
	path := os.Getenv("HTREE_CONFORMANCE")
	if path == "" {
		path = "../../build/release/conformance.json"
	}
	text, err := os.ReadFile(path)
	if err != nil {
		t.Fatal(err, "(HTREE_CONFORMANCE names the file)")
	}
	if err := json.Unmarshal(text, &file); err != nil {
		t.Fatal(err)
	}
	if file.Format != 1 || len(file.Scenes) < 2 || len(file.Kinds) < 7 || len(file.Misuse) < 25 {
		t.Fatalf("%s: format %d, %d scenes, %d kinds, %d mistakes", path, file.Format,
			len(file.Scenes), len(file.Kinds), len(file.Misuse))
	}
	return file
}

// words are the bits of a slice of 4-byte numbers, or of structs of them, and back.
func words[T any](slice []T) []uint32 {
	return unsafe.Slice(first[uint32](slice), len(slice)*int(unsafe.Sizeof(*new(T)))/4)
}

func (s *scene) mesh() Mesh {
	positions := unsafe.Slice(first[float32](s.Positions), len(s.Positions))
	return Mesh{Positions: positions, Indices: s.Indices}
}

func (s *scene) rays() []Ray {
	return unsafe.Slice(first[Ray](s.Rays), len(s.Rays)/8)
}
