// SPDX-License-Identifier: MIT

package htree_test

import (
	"context"
	"errors"
	"fmt"
	"log"
	"math"
	"time"

	"htree"
)

// A square of two triangles.
var square = htree.Mesh{
	Positions: []float32{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0},
	Indices:   []uint32{0, 1, 2, 0, 2, 3},
}

func Example() {
	tree, err := htree.Build(square, htree.WithKind(htree.Fast))
	if err != nil {
		log.Fatal(err)
	}
	defer tree.Close()

	rays := make([]htree.Ray, 4)
	for i := range rays {
		rays[i] = htree.NewRay([3]float32{0.2 + 0.4*float32(i), 0.1, 2}, [3]float32{0, 0, -1})
	}
	hits := make([]htree.Hit, len(rays))
	if err := tree.Intersect(rays, hits); err != nil {
		log.Fatal(err)
	}
	fmt.Println(hits[0].Prim, hits[0].T, hits[3].IsHit())
	// Output: 0 2 false
}

func ExampleBuild_errors() {
	broken := htree.Mesh{Positions: square.Positions, Indices: []uint32{0, 1, 7}}
	_, err := htree.Build(broken)
	fmt.Println(errors.Is(err, htree.ErrGeometry))
	fmt.Println(err)
	// Output:
	// true
	// htree: bad geometry: triangle 0 refers to vertex 7 of 4
}

func ExampleTree_IntersectContext() {
	tree, err := htree.Build(square)
	if err != nil {
		log.Fatal(err)
	}
	defer tree.Close()
	ctx, cancel := context.WithTimeout(context.Background(), time.Minute)
	cancel()
	rays := make([]htree.Ray, 1000)
	err = tree.IntersectContext(ctx, rays, make([]htree.Hit, len(rays)))
	fmt.Println(errors.Is(err, htree.ErrCancelled), errors.Is(err, context.Canceled))
	// Output: true true
}

func ExampleTree_Occluded() {
	tree, err := htree.Build(square)
	if err != nil {
		log.Fatal(err)
	}
	defer tree.Close()
	lamp := htree.NewRay([3]float32{0.5, 0.2, -1}, [3]float32{0, 0, 1})
	near := lamp
	near.TMax = 0.5 // a lamp before the square
	shadow := make([]bool, 2)
	if err := tree.Occluded([]htree.Ray{lamp, near}, shadow); err != nil {
		log.Fatal(err)
	}
	fmt.Println(shadow)
	// Output: [true false]
}

func ExampleObjects() {
	// A unit sphere at the origin.
	sphere := &htree.Objects{
		Boxes: []htree.Box{{Lo: [3]float32{-1, -1, -1}, Hi: [3]float32{1, 1, 1}}},
		Intersect: func(_ uint32, ray htree.Ray) (t, u, v float32, ok bool) {
			dot := func(a, b [3]float32) float64 {
				return float64(a[0]*b[0]) + float64(a[1]*b[1]) + float64(a[2]*b[2])
			}
			a, b, c := dot(ray.Dir, ray.Dir), dot(ray.Org, ray.Dir), dot(ray.Org, ray.Org)-1
			t = float32((-b - math.Sqrt(b*b-a*c)) / a)
			return t, 0, 0, ray.TMin <= t && t <= ray.TMax
		},
	}
	tree, err := htree.Build(htree.Mesh{Objects: sphere})
	if err != nil {
		log.Fatal(err)
	}
	defer tree.Close()
	hit, err := tree.IntersectOne(htree.NewRay([3]float32{0, 0, 5}, [3]float32{0, 0, -1}))
	fmt.Println(hit.Prim, hit.T, err)
	// Output: 0 4 <nil>
}

func ExampleTree_View() {
	tree, err := htree.Build(square, htree.WithKind(htree.H))
	if err != nil {
		log.Fatal(err)
	}
	defer tree.Close()
	err = tree.View(func(view htree.View) error {
		fmt.Println(view.Kind, view.Prims, view.Triangles[:9])
		return nil
	})
	fmt.Println(err)
	// Output:
	// h 2 [0 0 0 1 0 0 1 1 0]
	// <nil>
}

func ExampleWithCounters() {
	tree, err := htree.Build(square)
	if err != nil {
		log.Fatal(err)
	}
	defer tree.Close()
	rays := []htree.Ray{htree.NewRay([3]float32{0.5, 0.2, 1}, [3]float32{0, 0, -1})}
	counters := make([]htree.Counters, 1)
	if err := tree.Intersect(rays, make([]htree.Hit, 1), htree.WithCounters(counters)); err != nil {
		log.Fatal(err)
	}
	fmt.Println(counters[0].Intersections > 0)
	// Output: true
}

func ExampleFloats() {
	points := [][3]float32{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}
	mesh := htree.Mesh{Positions: htree.Floats(points), Indices: htree.Indices([][3]uint32{{0, 1, 2}})}
	fmt.Println(len(mesh.Positions), len(mesh.Indices))
	// Output: 9 3
}

func ExampleParseKind() {
	kind, err := htree.ParseKind("bvh-sah")
	fmt.Println(kind == htree.BVHSAH, kind, err)
	// Output: true bvh-sah <nil>
}
