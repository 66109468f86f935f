// SPDX-License-Identifier: MIT

// Package htree answers ray queries over triangle meshes, by hierarchies that are cheap enough to build
// anew for every frame. It is libhtree for Go, by cgo.
//
// Data takes one way: [Mesh] -> [Build] -> [Tree.Intersect] -> [Hit]. A tree copies what it keeps, and any
// number of goroutines may query it; [Tree.Update] brings it to another mesh. The closest hit is the same bits for every
// [Kind], batch and number of threads. Queries take whole batches and spread them over all cores; a call
// into C costs some tens of nanoseconds, so batches are the way to speed.
package htree

// #include "bridge.h"
import "C"

import (
	"fmt"
	"math"
	"unsafe"
)

// Version of this package.
const Version = "0.1.0"

// None is the Prim of a miss.
const None = C.HTREE_NONE

// CoordinateMax is 2^60: triangles with larger coordinates are skipped, rays from farther away miss.
const CoordinateMax = 1 << 60

// LibraryVersion is the version of the C library: major, minor, patch.
func LibraryVersion() (major, minor, patch int) {
	version := int(C.htree_version())
	return version / 10000, version / 100 % 100, version % 100
}

// verifyLibrary refuses a library of another ABI, as an installed one may be.
func verifyLibrary() error {
	major, minor, patch := LibraryVersion()
	if major == C.HTREE_VERSION_MAJOR && minor == C.HTREE_VERSION_MINOR {
		return nil
	}
	return failure(ErrUnsupported, "libhtree %d.%d.%d is linked, and this package is compiled for %d.%d",
		major, minor, patch, C.HTREE_VERSION_MAJOR, C.HTREE_VERSION_MINOR)
}

// A Ray is the points Org + t * Dir with TMin <= t <= TMax. Dir need not be normalised. A ray with a NaN,
// or with TMin > TMax, misses; mind that the zero TMax ends a ray where it begins.
type Ray struct {
	Org  [3]float32
	TMin float32
	Dir  [3]float32
	TMax float32
}

// NewRay is the ray from org without end.
func NewRay(org, dir [3]float32) Ray {
	return Ray{Org: org, Dir: dir, TMax: float32(math.Inf(1))}
}

// At is the point at t.
func (r Ray) At(t float32) [3]float32 {
	return [3]float32{r.Org[0] + t*r.Dir[0], r.Org[1] + t*r.Dir[1], r.Org[2] + t*r.Dir[2]}
}

// A Hit is where a ray meets its closest triangle (v0, v1, v2): (1 - U - V) v0 + U v1 + V v2. A miss has
// the Prim None and the ray's TMax as T.
type Hit struct {
	T, U, V float32
	Prim    uint32 // triangle i of the mesh is i; object j is j + the number of triangles
}

// IsHit says whether anything was hit.
func (h Hit) IsHit() bool {
	return h.Prim != None
}

// Counters are what one ray cost, in the paper's terms; see [WithCounters].
type Counters struct {
	TraversalSteps uint32 // N_TS: nodes (cells) visited, leaves included
	LeafSteps      uint32 // N_ETS: leaves (cells) visited
	Intersections  uint32 // N_IT: triangles and objects tested
	_              uint32
}

// A Box is an axis-aligned box.
type Box struct {
	Lo, Hi [3]float32
}

// IsEmpty says whether the box contains nothing, as the bounds of a tree without triangles do.
func (b Box) IsEmpty() bool {
	return b.Lo[0] > b.Hi[0] || b.Lo[1] > b.Hi[1] || b.Lo[2] > b.Hi[2]
}

// The same bytes in C and in Go, or this does not compile.
var (
	_ [unsafe.Sizeof(Ray{})]byte                      = [C.sizeof_htree_ray]byte{}
	_ [unsafe.Offsetof(Ray{}.TMin)]byte               = [unsafe.Offsetof(C.htree_ray{}.tmin)]byte{}
	_ [unsafe.Offsetof(Ray{}.Dir)]byte                = [unsafe.Offsetof(C.htree_ray{}.dir)]byte{}
	_ [unsafe.Offsetof(Ray{}.TMax)]byte               = [unsafe.Offsetof(C.htree_ray{}.tmax)]byte{}
	_ [unsafe.Sizeof(Hit{})]byte                      = [C.sizeof_htree_hit]byte{}
	_ [unsafe.Offsetof(Hit{}.Prim)]byte               = [unsafe.Offsetof(C.htree_hit{}.prim)]byte{}
	_ [unsafe.Sizeof(Counters{})]byte                 = [C.sizeof_htree_counters]byte{}
	_ [unsafe.Offsetof(Counters{}.LeafSteps)]byte     = [unsafe.Offsetof(C.htree_counters{}.leaf_steps)]byte{}
	_ [unsafe.Offsetof(Counters{}.Intersections)]byte = [unsafe.Offsetof(C.htree_counters{}.intersections)]byte{}
	_ [unsafe.Sizeof(Box{})]byte                      = [C.sizeof_htree_box]byte{}
	_ [unsafe.Offsetof(Box{}.Hi)]byte                 = [unsafe.Offsetof(C.htree_box{}.hi)]byte{}
)

// A Kind is a structure to build, or what to build it for.
type Kind int32

// The kinds. Fast, Balanced and Best are for those who do not want to choose.
const (
	UG        Kind = C.HTREE_UG         // uniform grid
	KD        Kind = C.HTREE_KD         // kd-tree by the surface area heuristic (SAH)
	BVHMedian Kind = C.HTREE_BVH_MEDIAN // bounding volume hierarchy, spatial median
	BVHSAH    Kind = C.HTREE_BVH_SAH    // bounding volume hierarchy, SAH over buckets of centroids
	SKD       Kind = C.HTREE_SKD        // spatial kd-tree: two planes a node
	H         Kind = C.HTREE_H          // H-tree: spatial kd-tree with sparse bounding volumes
	AH        Kind = C.HTREE_AH         // H-tree by a 3D grid and a summed-area table
	Wide      Kind = C.HTREE_WIDE       // eight children a node, for vector units
	Fast      Kind = C.HTREE_FAST       // build every frame, trace a few rays a triangle
	Balanced  Kind = C.HTREE_BALANCED   // the default
	Best      Kind = C.HTREE_BEST       // build once, trace for long
)

// String is the kind's name, as "bvh-sah".
func (k Kind) String() string {
	if name := C.htree_kind_name(C.htree_kind(k)); name != nil {
		return C.GoString(name)
	}
	return fmt.Sprintf("Kind(%d)", int32(k))
}

// ParseKind is the kind of that name.
func ParseKind(name string) (Kind, error) {
	if kind := kindFromName(name); kind != 0 {
		return kind, nil
	}
	return 0, failure(ErrArgument, "no kind is called %q", name)
}
