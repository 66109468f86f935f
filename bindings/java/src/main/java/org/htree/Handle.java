// SPDX-License-Identifier: MIT
package org.htree;

import com.sun.jna.Pointer;
import java.util.concurrent.atomic.AtomicBoolean;
import java.util.concurrent.atomic.AtomicInteger;
import java.util.concurrent.atomic.AtomicLong;
import org.htree.raw.LibHTree;

/**
 * A tree of the library and how many use it: its owner, and every call that runs on it. The last to
 * let go frees it, so closing during a query waits for nothing and breaks nothing, not even from a
 * callback of that query.
 */
final class Handle implements Runnable {
    private static final AtomicLong LIVE = new AtomicLong();

    private final Pointer tree;
    private final ObjectCallback callback;
    private final AtomicBoolean closed = new AtomicBoolean();
    private final AtomicInteger users = new AtomicInteger(1);

    Handle(Pointer tree, ObjectCallback callback) {
        this.tree = tree;
        this.callback = callback;
        LIVE.incrementAndGet();
    }

    /** Trees that are not freed yet, for tests. */
    static long live() {
        return LIVE.get();
    }

    /** The callback of the tree's objects, or null. C knows but its address; this keeps it. */
    ObjectCallback callback() {
        return callback;
    }

    /** The tree, until {@link #release}. */
    Pointer acquire() {
        int now;
        do {
            now = users.get();
            if (closed.get() || now == 0) {
                throw new IllegalStateException("the tree is closed");
            }
        } while (!users.compareAndSet(now, now + 1));
        return tree;
    }

    void release() {
        if (users.decrementAndGet() == 0) {
            LibHTree.htree_free(tree);
            LIVE.decrementAndGet();
        }
    }

    boolean isClosed() {
        return closed.get();
    }

    /** Closes: the owner lets go, once. */
    @Override
    public void run() {
        if (closed.compareAndSet(false, true)) {
            release();
        }
    }
}
