// SPDX-License-Identifier: MIT

package htree

import (
	"context"
	"runtime"
	"runtime/cgo"
)

// Save is the tree as bytes, for Load; objects are saved as their boxes.
func (t *Tree) Save() ([]byte, error) {
	if err := t.acquire(); err != nil {
		return nil, err
	}
	defer t.release()
	var size uint64
	if err := rawSave(t.tree, nil, &size); err != nil {
		return nil, err
	}
	file := make([]byte, size)
	return file, rawSave(t.tree, file, &size)
}

// Load is the tree that Save wrote: the same hits. It copies the bytes. Whatever they are, what is returned
// has been proved; ErrCorrupt says that they are no tree. One with objects needs WithIntersect.
func Load(file []byte, options ...LoadOption) (*Tree, error) {
	var config loadConfig
	for _, option := range options {
		option.applyLoad(&config)
	}
	if err := verifyLibrary(); err != nil {
		return nil, err
	}
	tree := &Tree{hooks: &config.hooks, threads: config.threads}
	which := config.hooks.which()
	if which != 0 {
		tree.handle = cgo.NewHandle(tree.hooks)
	}
	loaded := false
	defer func() {
		if !loaded { // an error, or a panic of a hook's
			tree.Close()
		}
	}()
	runtime.SetFinalizer(tree, (*Tree).Close)
	err := newProgress(context.Background(), nil, tree.hooks).run(false, func(progressHandle) error {
		var out *cTree
		err := rawLoad(&out, file, config.threads, hookHandle{which, tree.handle})
		tree.tree = out
		return err
	})
	if err != nil {
		return nil, err
	}
	loaded = true
	return tree, nil
}
