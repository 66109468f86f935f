// SPDX-License-Identifier: MIT

package htree

// #include "bridge.h"
import "C"

import (
	"context"
	"runtime/cgo"
	"sync"
	"sync/atomic"
	"unsafe"
)

// An Allocator is memory of your own, from C's side: never Go's. It is called from any thread.
type Allocator interface {
	// Allocate returns bytes at a multiple of alignment, a power of two, or nil: then the call fails with
	// ErrMemory.
	Allocate(bytes, alignment uint64) unsafe.Pointer

	// Release takes back what Allocate gave for as many bytes. A panic here is swallowed.
	Release(memory unsafe.Pointer, bytes uint64)
}

// panics keeps those that must not unwind C's frames. A thread of C's cannot tell for which query it works,
// so a panic is counted, and goes on in every query that saw the count change: no wrong hits pass for right.
type panics struct {
	count atomic.Int64
	waits atomic.Bool // whether one waits to go on; until it does, nothing of the caller's is called
	mutex sync.Mutex
	first any
}

func (p *panics) catch(call func()) {
	if p.waits.Load() {
		p.count.Add(1)
		return
	}
	done := false
	defer func() {
		if done {
			return
		}
		value := recover()
		p.mutex.Lock()
		if !p.waits.Load() {
			p.first = value
			p.waits.Store(true)
		}
		p.mutex.Unlock()
		p.count.Add(1)
	}()
	call()
	done = true
}

// resume lets a panic go on that was caught since the count was before.
func (p *panics) resume(before int64) {
	if p.count.Load() == before {
		return
	}
	p.mutex.Lock()
	value := p.first
	p.first = nil
	p.waits.Store(false)
	p.mutex.Unlock()
	if value == nil {
		value = "htree: a hook or an object panicked in another query on this tree"
	}
	panic(value)
}

// hooks are the callbacks of one tree; C holds a handle of them until the tree is freed.
type hooks struct {
	intersect func(object uint32, ray Ray) (t, u, v float32, ok bool)
	tasks     func(count uint32, task func(index uint32))
	allocator Allocator
	panics    panics
}

// which are there.
func (h *hooks) which() (which uint32) {
	if h.intersect != nil {
		which |= C.HTREE_GO_OBJECTS
	}
	if h.tasks != nil {
		which |= C.HTREE_GO_TASKS
	}
	if h.allocator != nil {
		which |= C.HTREE_GO_ALLOCATOR
	}
	return which
}

//export htreeGoObject
func htreeGoObject(handle C.uintptr_t, object C.uint32_t, ray *C.htree_ray, hit *C.htree_hit) (is C.int32_t) {
	h := cgo.Handle(handle).Value().(*hooks)
	h.panics.catch(func() {
		t, u, v, ok := h.intersect(uint32(object), *(*Ray)(unsafe.Pointer(ray)))
		if ok {
			hit.t, hit.u, hit.v = C.float(t), C.float(u), C.float(v)
			is = 1
		}
	})
	return is
}

//export htreeGoTasks
func htreeGoTasks(handle C.uintptr_t, count C.uint32_t, task C.htree_go_task, data unsafe.Pointer) {
	h := cgo.Handle(handle).Value().(*hooks)
	// Once each, and all before the return, whatever run does: C relies on it.
	claimed := make([]atomic.Bool, count)
	var running sync.WaitGroup
	running.Add(int(count))
	once := func(index uint32) {
		if index < uint32(count) && claimed[index].CompareAndSwap(false, true) {
			C.htree_go_call(task, data, C.uint32_t(index))
			running.Done()
		}
	}
	h.panics.catch(func() { h.tasks(uint32(count), once) })
	for i := range claimed {
		once(uint32(i))
	}
	running.Wait()
}

//export htreeGoAllocate
func htreeGoAllocate(handle C.uintptr_t, bytes, alignment C.uint64_t) (memory unsafe.Pointer) {
	h := cgo.Handle(handle).Value().(*hooks)
	h.panics.catch(func() { memory = h.allocator.Allocate(uint64(bytes), uint64(alignment)) })
	return memory
}

//export htreeGoRelease
func htreeGoRelease(handle C.uintptr_t, memory unsafe.Pointer, bytes C.uint64_t) {
	defer func() { _ = recover() }()
	cgo.Handle(handle).Value().(*hooks).allocator.Release(memory, uint64(bytes))
}

// progress is what one call reports to. It also ends a query in which a hook panicked.
type progress struct {
	ctx    context.Context
	report func(float64) bool
	panics *panics
	before int64
	own    panics // of report
}

func newProgress(ctx context.Context, report func(float64) bool, h *hooks) *progress {
	return &progress{ctx: ctx, report: report, panics: &h.panics, before: h.panics.count.Load()}
}

// run calls C with a handle of the progress, or 0 if nobody needs it, and lets panics go on after it.
func (p *progress) run(needed bool, call func(progressHandle) error) error {
	if err := p.ctx.Err(); err != nil {
		return &Error{Status: ErrCancelled, Text: err.Error(), cause: err}
	}
	var handle cgo.Handle
	if needed || p.report != nil || p.ctx.Done() != nil {
		handle = cgo.NewHandle(p)
		defer handle.Delete()
	}
	err := call(progressHandle(handle))
	p.own.resume(0)
	p.panics.resume(p.before)
	if e, ok := err.(*Error); ok && e.Status == ErrCancelled {
		e.cause = p.ctx.Err()
	}
	return err
}

//export htreeGoProgress
func htreeGoProgress(handle C.uintptr_t, fraction C.double) C.int32_t {
	p := cgo.Handle(handle).Value().(*progress)
	if p.ctx.Err() != nil || p.panics.count.Load() != p.before {
		return 1
	}
	goOn := true
	if p.report != nil {
		goOn = false
		p.own.catch(func() { goOn = p.report(float64(fraction)) })
	}
	if goOn {
		return 0
	}
	return 1
}
