// SPDX-License-Identifier: MIT

// Render draws a torus on a floor by the directions of its triangles, darker in the corners that the sky
// sees less of, as a PNG: go run ./examples/render torus.png
package main

import (
	"fmt"
	"image"
	"image/color"
	"image/png"
	"log"
	"math"
	"math/rand"
	"os"

	"htree"
)

const (
	width, height = 320, 200
	skyRays       = 16 // a pixel
)

type vec [3]float32

func (a vec) plus(s float32, b vec) vec {
	return vec{a[0] + s*b[0], a[1] + s*b[1], a[2] + s*b[2]}
}

func (a vec) dot(b vec) float32 {
	return a[0]*b[0] + a[1]*b[1] + a[2]*b[2]
}

func (a vec) cross(b vec) vec {
	return vec{a[1]*b[2] - a[2]*b[1], a[2]*b[0] - a[0]*b[2], a[0]*b[1] - a[1]*b[0]}
}

func (a vec) unit() vec {
	return vec{}.plus(float32(1/math.Sqrt(float64(a.dot(a)))), a)
}

// scene is a torus of n by n squares, and a floor of two triangles below it.
func scene(n uint32) htree.Mesh {
	var mesh htree.Mesh
	sinCos := func(i uint32) (sin, cos float64) {
		return math.Sincos(2 * math.Pi * float64(i) / float64(n))
	}
	index := func(i, j uint32) uint32 { return i%n*n + j%n }
	for i := uint32(0); i < n; i++ {
		for j := uint32(0); j < n; j++ {
			s, c := sinCos(i)
			z, outward := sinCos(j)
			radius := 1 + 0.4*outward
			mesh.Positions = append(mesh.Positions, float32(radius*c), float32(radius*s), float32(0.4*z))
			mesh.Indices = append(mesh.Indices, index(i, j), index(i+1, j), index(i+1, j+1),
				index(i, j), index(i+1, j+1), index(i, j+1))
		}
	}
	f := n * n
	mesh.Positions = append(mesh.Positions, -9, -9, -0.4, 9, -9, -0.4, 9, 9, -0.4, -9, 9, -0.4)
	mesh.Indices = append(mesh.Indices, f, f+1, f+2, f, f+2, f+3)
	return mesh
}

// cameraRays are one for each pixel, row by row.
func cameraRays() []htree.Ray {
	eye := vec{0, -3.2, 2.2}
	forward := vec{}.plus(-1, eye).unit()
	right := forward.cross(vec{0, 0, 1}).unit()
	up := right.cross(forward)
	rays := make([]htree.Ray, 0, width*height)
	for y := 0; y < height; y++ {
		for x := 0; x < width; x++ {
			dx, dy := (float32(x)+0.5-width/2)*0.9/height, (height/2-float32(y)-0.5)*0.9/height
			rays = append(rays, htree.NewRay(eye, forward.plus(dx, right).plus(dy, up)))
		}
	}
	return rays
}

// normals are those of the triangles that were hit, towards the eye; zero for the sky.
func normals(mesh htree.Mesh, rays []htree.Ray, hits []htree.Hit) []vec {
	normals := make([]vec, len(hits))
	for i, hit := range hits {
		if !hit.IsHit() {
			continue
		}
		var corners [3]vec
		for k, vertex := range mesh.Indices[3*hit.Prim:][:3] {
			copy(corners[k][:], mesh.Positions[3*vertex:])
		}
		a, b, c := corners[0], corners[1], corners[2]
		normals[i] = b.plus(-1, a).cross(c.plus(-1, a)).unit()
		if normals[i].dot(rays[i].Dir) > 0 {
			normals[i] = vec{}.plus(-1, normals[i])
		}
	}
	return normals
}

// sky are rays from every hit into the half space of its normal; those of the sky end at once.
func sky(rays []htree.Ray, hits []htree.Hit, normals []vec) []htree.Ray {
	random := rand.New(rand.NewSource(1))
	component := func() float32 { return float32(random.NormFloat64()) }
	up := make([]htree.Ray, 0, skyRays*len(rays))
	for i, hit := range hits {
		for k := 0; k < skyRays; k++ {
			if !hit.IsHit() {
				up = append(up, htree.Ray{TMax: -1})
				continue
			}
			dir := vec{component(), component(), component()}.unit().plus(1, normals[i])
			up = append(up, htree.NewRay(vec(rays[i].At(hit.T)).plus(1e-3, normals[i]), dir))
		}
	}
	return up
}

func render() (image.Image, error) {
	mesh := scene(96)
	tree, err := htree.Build(mesh, htree.WithKind(htree.Fast))
	if err != nil {
		return nil, err
	}
	defer tree.Close()
	rays := cameraRays()
	hits := make([]htree.Hit, len(rays))
	if err := tree.Intersect(rays, hits); err != nil {
		return nil, err
	}
	normals := normals(mesh, rays, hits)
	up := sky(rays, hits, normals)
	occluded := make([]bool, len(up))
	if err := tree.Occluded(up, occluded); err != nil {
		return nil, err
	}
	picture := image.NewRGBA(image.Rect(0, 0, width, height))
	for i, normal := range normals {
		open := float32(0)
		for _, hidden := range occluded[skyRays*i : skyRays*(i+1)] {
			if !hidden {
				open += 1.0 / skyRays
			}
		}
		shade := func(component float32) uint8 { return uint8(255 * open * (0.7 + 0.3*component)) }
		picture.SetRGBA(i%width, i/width, color.RGBA{shade(normal[0]), shade(normal[1]), shade(normal[2]), 255})
	}
	return picture, nil
}

func main() {
	log.SetFlags(0)
	if len(os.Args) != 2 {
		log.Fatal("usage: render OUT.png")
	}
	picture, err := render()
	if err != nil {
		log.Fatal(err)
	}
	file, err := os.Create(os.Args[1])
	if err != nil {
		log.Fatal(err)
	}
	if err := png.Encode(file, picture); err != nil {
		log.Fatal(err)
	}
	if err := file.Close(); err != nil {
		log.Fatal(err)
	}
	fmt.Printf("%s: %d x %d\n", os.Args[1], width, height)
}
