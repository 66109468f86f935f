// SPDX-License-Identifier: MIT

//go:build !libhtree && !htreeenv

package htree

// The library that `make lib` builds in this checkout.

// #cgo CFLAGS: -I${SRCDIR}/../../include
// #cgo LDFLAGS: ${SRCDIR}/../../build/release/libhtree.a -lm -lpthread
import "C"
