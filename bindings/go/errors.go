// SPDX-License-Identifier: MIT

package htree

// #include "bridge.h"
import "C"

import (
	"errors"
	"fmt"
)

// A Status is which way a call failed, by its number in htree.h. Statuses are what errors.Is takes.
type Status int32

// The statuses of the C library.
const (
	ErrArgument    Status = C.HTREE_ERROR_ARGUMENT    // a size, a flag or a number that the call does not take
	ErrMemory      Status = C.HTREE_ERROR_MEMORY      // out of memory
	ErrLimit       Status = C.HTREE_ERROR_LIMIT       // more objects than the structure can address
	ErrGeometry    Status = C.HTREE_ERROR_GEOMETRY    // an index beyond the vertices; WithStrict: bad numbers too
	ErrCancelled   Status = C.HTREE_ERROR_CANCELLED   // the context or the progress function asked to stop
	ErrUnsupported Status = C.HTREE_ERROR_UNSUPPORTED // the library lacks the kind, or is of another version
	ErrCorrupt     Status = C.HTREE_ERROR_CORRUPT     // Tree.Check found a broken tree
	ErrNoDevice    Status = C.HTREE_ERROR_NO_DEVICE   // no OpenCL here, or no device of that name
	ErrDevice      Status = C.HTREE_ERROR_DEVICE      // a call to the device failed
	ErrDeviceLost  Status = C.HTREE_ERROR_DEVICE_LOST // the device is gone, with all that was on it
	ErrKernel      Status = C.HTREE_ERROR_KERNEL      // the device's compiler refused a kernel
)

// ErrClosed is the error of every call on a closed tree.
var ErrClosed = errors.New("htree: use of a closed tree")

// Error is what the C library calls the status.
func (s Status) Error() string {
	return C.GoString(C.htree_status_name(C.htree_status(s)))
}

// An Error says which way a call failed, and why in a sentence. errors.Is finds its status in it, and
// after a cancelled context the context's error.
type Error struct {
	Status Status
	Text   string
	cause  error
}

func (e *Error) Error() string {
	return "htree: " + e.Status.Error() + ": " + e.Text
}

// Is reports whether target is the status.
func (e *Error) Is(target error) bool {
	return target == error(e.Status)
}

// Unwrap is the context's error, or nil.
func (e *Error) Unwrap() error {
	return e.cause
}

// failure is an error that the package notices by itself.
func failure(status Status, format string, arguments ...any) error {
	return &Error{Status: status, Text: fmt.Sprintf(format, arguments...)}
}
