// SPDX-License-Identifier: MIT

//go:build libhtree

package htree

// The installed library, by its htree.pc. With the tag htreeenv instead, CGO_CFLAGS and CGO_LDFLAGS name
// header and library.

// #cgo pkg-config: htree
import "C"
