// SPDX-License-Identifier: MIT

package htree

import "sync"

// turns says who may use a tree: any number of calls that leave it as it is, or one that changes it. The
// last to leave after it was closed frees it. Calls that are waited for may begin others: a call that
// changes the tree holds nobody up while it waits.
type turns struct {
	mutex    sync.Mutex
	changed  *sync.Cond // made by the first who waits
	users    int
	changing bool
	closed   bool
}

// wait returns when something has changed. The mutex is locked.
func (t *turns) wait() {
	if t.changed == nil {
		t.changed = sync.NewCond(&t.mutex)
	}
	t.changed.Wait()
}

func (t *turns) tell() {
	if t.changed != nil {
		t.changed.Broadcast()
	}
}

// acquire is for a call that leaves the tree as it is, until leave.
func (t *turns) acquire() error {
	t.mutex.Lock()
	defer t.mutex.Unlock()
	for t.changing && !t.closed {
		t.wait()
	}
	if t.closed {
		return ErrClosed
	}
	t.users++
	return nil
}

// acquireAlone is for a call that changes the tree, until leave.
func (t *turns) acquireAlone() error {
	t.mutex.Lock()
	defer t.mutex.Unlock()
	for t.users > 0 && !t.closed {
		t.wait()
	}
	if t.closed {
		return ErrClosed
	}
	t.users++
	t.changing = true
	return nil
}

// leave says whether the tree is to be freed now.
func (t *turns) leave() bool {
	t.mutex.Lock()
	defer t.mutex.Unlock()
	t.users--
	t.changing = false
	t.tell()
	return t.closed && t.users == 0
}

// close says whether the tree is to be freed now.
func (t *turns) close() bool {
	t.mutex.Lock()
	defer t.mutex.Unlock()
	last := !t.closed && t.users == 0
	t.closed = true
	t.tell()
	return last
}
