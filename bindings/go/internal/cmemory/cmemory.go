// SPDX-License-Identifier: MIT

// Package cmemory is memory of C's for the tests of allocators: test files cannot use cgo themselves.
package cmemory

// #include <stdlib.h>
import "C"

import "unsafe"

// Allocate returns bytes at a multiple of alignment, a power of two, or nil.
func Allocate(bytes, alignment uint64) (memory unsafe.Pointer) {
	if least := uint64(unsafe.Sizeof(memory)); alignment < least {
		alignment = least
	}
	if C.posix_memalign(&memory, C.size_t(alignment), C.size_t(bytes)) != 0 {
		return nil
	}
	return memory
}

// Release frees what Allocate gave.
func Release(memory unsafe.Pointer) {
	C.free(memory)
}
