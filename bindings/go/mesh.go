// SPDX-License-Identifier: MIT

package htree

// #include "bridge.h"
import "C"

import "unsafe"

// A Mesh is what Build and Update read: triangles, and objects of your own if any. Its slices are read while
// they run, and not kept; what a lazy tree reads after that is a copy of them in C's memory.
type Mesh struct {
	// Positions are x y z of every vertex; see Floats for points.
	Positions []float32

	// PositionStride is the bytes from one vertex to the next, for vertices that carry more than a
	// position: a multiple of 4, at least 12. 0 means 12.
	PositionStride int

	// Indices are three vertices for each triangle. Nil: triangle i is the vertices 3i, 3i+1, 3i+2.
	Indices []uint32

	// Objects are beside the triangles; nil: none.
	Objects *Objects
}

// Objects are known by box and callback: spheres, cones, terrain, ...
type Objects struct {
	// Boxes contain the objects, one each; they are copied by Build.
	Boxes []Box

	// Intersect is where the ray meets that object first, with TMin <= t <= TMax, and two numbers that
	// come back in the Hit; ok is false for a miss. It must depend on its arguments only, and the point
	// must lie in the object's box. It is called from any thread that works for a query; a panic cancels
	// the queries that run on the tree, and goes on in each of them.
	//
	// A call from C into Go costs some hundred nanoseconds, for every ray that comes near.
	Intersect func(object uint32, ray Ray) (t, u, v float32, ok bool)
}

// Floats are the coordinates of points, without a copy.
func Floats(points [][3]float32) []float32 {
	return unsafe.Slice(first[float32](points), 3*len(points))
}

// Indices are the corners of triangles, without a copy.
func Indices(triangles [][3]uint32) []uint32 {
	if triangles == nil {
		return nil
	}
	if len(triangles) == 0 {
		return []uint32{}
	}
	return unsafe.Slice(first[uint32](triangles), 3*len(triangles))
}

// objects are the boxes and the function of what is there.
func (m *Mesh) objects() ([]Box, func(object uint32, ray Ray) (t, u, v float32, ok bool)) {
	if m.Objects == nil {
		return nil, nil
	}
	return m.Objects.Boxes, m.Objects.Intersect
}

// numbers are the mesh for C without its arrays.
func (m *Mesh) numbers() (cMesh, error) {
	stride := uint64(m.PositionStride)
	if stride == 0 {
		stride = 12
	}
	if stride == 12 && len(m.Positions)%3 != 0 {
		return cMesh{}, failure(ErrArgument, "%d positions are not three a vertex", len(m.Positions))
	}
	if len(m.Indices)%3 != 0 {
		return cMesh{}, failure(ErrArgument, "%d indices are not three a triangle", len(m.Indices))
	}
	if m.Objects != nil && m.Objects.Intersect == nil && len(m.Objects.Boxes) > 0 {
		return cMesh{}, failure(ErrArgument, "mesh.Objects.Intersect is nil")
	}
	// As many as lie wholly in the slice. The library refuses a bad stride before it reads the first.
	vertices := uint64(0)
	if len(m.Positions) >= 3 {
		vertices = (4*uint64(len(m.Positions))-12)/stride + 1
	}
	triangles := uint64(len(m.Indices)) / 3
	if m.Indices == nil {
		triangles = vertices/3 + (vertices%3+2)/3 // rounded up: the library refuses what is left over
	}
	return cMesh{
		position_stride: C.uint64_t(m.PositionStride),
		vertex_count:    C.uint64_t(vertices),
		triangle_count:  C.uint64_t(triangles),
	}, nil
}
