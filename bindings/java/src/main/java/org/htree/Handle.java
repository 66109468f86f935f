// SPDX-License-Identifier: MIT
package org.htree;

import com.sun.jna.Pointer;
import java.util.ArrayList;
import java.util.List;
import java.util.concurrent.atomic.AtomicLong;
import org.htree.raw.LibHTree;

/**
 * A tree of the library and the calls that use it: any number that leave it as it is, or one that
 * changes it. The last to let go of a closed tree frees it, so closing during a query waits for
 * nothing and breaks nothing, not even from a callback of that query.
 */
final class Handle implements Runnable {
    private static final AtomicLong LIVE = new AtomicLong();

    private final Pointer tree;
    private final boolean lazy;
    private Mesh mesh;
    private ObjectCallback callback;
    private final List<Thread> users = new ArrayList<>();
    private boolean changing;
    private boolean closed;

    Handle(Pointer tree, boolean lazy, Mesh mesh, ObjectCallback callback) {
        this.tree = tree;
        this.lazy = lazy;
        keep(mesh, callback);
        LIVE.incrementAndGet();
    }

    /** Trees that are not freed yet, for tests. */
    static long live() {
        return LIVE.get();
    }

    /** What C knows by address only: the tree's objects, and what a lazy one reads. */
    void keep(Mesh newMesh, ObjectCallback newCallback) {
        mesh = lazy ? newMesh : null;
        callback = newCallback;
    }

    /** The arrays are not needed any more. */
    void dropMesh() {
        mesh = null;
    }

    /** The callback of the tree's objects, or null. Call {@link #acquire} first. */
    ObjectCallback callback() {
        return callback;
    }

    /** The tree as it is, until {@link #release}. */
    synchronized Pointer acquire() {
        boolean interrupted = false;
        while (changing && !closed) {
            interrupted |= waitForRelease();
        }
        return enter(interrupted);
    }

    /** The tree for a call that changes it, until {@link #release}. */
    synchronized Pointer acquireAlone() {
        if (users.contains(Thread.currentThread())) {
            throw new IllegalStateException("a callback cannot change the tree that it serves");
        }
        boolean interrupted = false;
        while (!users.isEmpty() && !closed) {
            interrupted |= waitForRelease();
        }
        Pointer alone = enter(interrupted);
        changing = true;
        return alone;
    }

    private boolean waitForRelease() {
        try {
            wait();
            return false;
        } catch (InterruptedException interrupt) {
            return true;
        }
    }

    private Pointer enter(boolean interrupted) {
        if (interrupted) {
            Thread.currentThread().interrupt();
        }
        if (closed) {
            throw new IllegalStateException("the tree is closed");
        }
        users.add(Thread.currentThread());
        return tree;
    }

    synchronized void release() {
        users.remove(Thread.currentThread());
        changing = false;
        notifyAll();
        freeIfUnused();
    }

    synchronized boolean isClosed() {
        return closed;
    }

    /** Closes: the owner lets go, once. */
    @Override
    public synchronized void run() {
        if (!closed) {
            closed = true;
            notifyAll();
            freeIfUnused();
        }
    }

    private void freeIfUnused() {
        if (closed && users.isEmpty()) {
            LibHTree.htree_free(tree);
            mesh = null;
            callback = null;
            LIVE.decrementAndGet();
        }
    }
}
