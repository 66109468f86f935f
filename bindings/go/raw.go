// SPDX-License-Identifier: MIT

package htree

// #include "bridge.h"
// #include <stdlib.h>
import "C"

import (
	"runtime"
	"runtime/cgo"
	"unsafe"
)

// The functions of htree.h, one for one, with Go's slices, errors and handles. They check nothing: that is
// what the library does.

type (
	cTree    = C.htree
	cMesh    = C.htree_mesh
	cOptions = C.htree_options
	cQuery   = C.htree_query
	cStats   = C.htree_stats
	cView    = C.htree_view
)

// Handles into Go for one build or tree, and for one call; 0 is none.
type (
	hookHandle struct {
		which  uint32
		handle cgo.Handle
	}
	progressHandle cgo.Handle
)

// check calls C and makes an error of its status. The text of a failure is kept per thread, so the
// goroutine stays on its thread until it has it.
func check(call func() C.htree_status) error {
	runtime.LockOSThread()
	defer runtime.UnlockOSThread()
	status := call()
	if status == C.HTREE_OK {
		return nil
	}
	return &Error{Status: Status(status), Text: C.GoString(C.htree_error_text())}
}

// first is the address of a slice for C, NULL if it is empty.
func first[To, From any](slice []From) *To {
	if len(slice) == 0 {
		return nil
	}
	return (*To)(unsafe.Pointer(&slice[0]))
}

func kindFromName(name string) Kind {
	text := C.CString(name)
	defer C.free(unsafe.Pointer(text))
	if len(C.GoString(text)) != len(name) {
		return 0 // a 0 within
	}
	return Kind(C.htree_kind_from_name(text))
}

func rawOptionsInit(options *cOptions, size uintptr, kind Kind) error {
	return check(func() C.htree_status {
		return C.htree_options_init(options, C.uint64_t(size), C.htree_kind(kind))
	})
}

func rawCalibrate(options *cOptions) error {
	return check(func() C.htree_status { return C.htree_calibrate(options) })
}

func rawBuild(out **cTree, mesh *cMesh, positions []float32, indices []uint32, boxes []Box,
	options *cOptions, hooks hookHandle, progress progressHandle) error {
	return check(func() C.htree_status {
		return C.htree_go_build(out, mesh, first[C.float](positions), first[C.uint32_t](indices),
			first[C.htree_box](boxes), C.uint64_t(len(boxes)), options,
			C.uint32_t(hooks.which), C.uintptr_t(hooks.handle), C.uintptr_t(progress))
	})
}

func rawLoad(out **cTree, file []byte, threads uint32, hooks hookHandle) error {
	return check(func() C.htree_status {
		return C.htree_go_load(out, unsafe.Pointer(first[byte](file)), C.uint64_t(len(file)),
			C.uint32_t(threads), C.uint32_t(hooks.which), C.uintptr_t(hooks.handle))
	})
}

func rawSave(tree *cTree, file []byte, size *uint64) error {
	return check(func() C.htree_status {
		return C.htree_save(tree, unsafe.Pointer(first[byte](file)), C.uint64_t(len(file)),
			(*C.uint64_t)(unsafe.Pointer(size)))
	})
}

func rawComplete(tree *cTree) error {
	return check(func() C.htree_status { return C.htree_complete(tree) })
}

func rawUpdate(tree *cTree, mesh *cMesh, positions []float32, indices []uint32, boxes []Box,
	hooks hookHandle, how How, quality *float64) error {
	return check(func() C.htree_status {
		return C.htree_go_update(tree, mesh, first[C.float](positions), first[C.uint32_t](indices),
			first[C.htree_box](boxes), C.uint64_t(len(boxes)), C.uint32_t(hooks.which),
			C.uintptr_t(hooks.handle), C.int32_t(how), (*C.double)(quality))
	})
}

func rawFree(tree *cTree) {
	C.htree_free(tree)
}

func rawQueryInit(query *cQuery, size uintptr) error {
	return check(func() C.htree_status { return C.htree_query_init(query, C.uint64_t(size)) })
}

func rawIntersect(tree *cTree, rays []Ray, count int, hits []Hit, query *cQuery, counters []Counters,
	progress progressHandle) error {
	return check(func() C.htree_status {
		return C.htree_go_intersect(tree, first[C.htree_ray](rays), C.uint64_t(count),
			first[C.htree_hit](hits), query, first[C.htree_counters](counters), C.uintptr_t(progress))
	})
}

// rawOccluded writes 0 or 1, which are the bytes of Go's bools.
func rawOccluded(tree *cTree, rays []Ray, count int, occluded []bool, query *cQuery,
	counters []Counters, progress progressHandle) error {
	return check(func() C.htree_status {
		return C.htree_go_occluded(tree, first[C.htree_ray](rays), C.uint64_t(count),
			first[C.uint8_t](occluded), query, first[C.htree_counters](counters), C.uintptr_t(progress))
	})
}

func rawGetBounds(tree *cTree, bounds *Box) error {
	return check(func() C.htree_status {
		return C.htree_get_bounds(tree, (*C.htree_box)(unsafe.Pointer(bounds)))
	})
}

func rawGetStats(tree *cTree, stats *cStats) error {
	return check(func() C.htree_status { return C.htree_get_stats(tree, stats) })
}

func rawGetView(tree *cTree, view *cView) error {
	return check(func() C.htree_status { return C.htree_get_view(tree, view) })
}

func rawCheck(tree *cTree) error {
	return check(func() C.htree_status { return C.htree_check(tree) })
}
