// SPDX-License-Identifier: MIT

//go:build !cgo

package htree

// Without cgo there is no library: this line is the error that says so.
var _ = htree_needs_cgo_and_a_C_compiler_so_set_CGO_ENABLED_to_1
