// SPDX-License-Identifier: MIT
package org.htree;

import com.sun.jna.CallbackThreadInitializer;
import com.sun.jna.Native;
import com.sun.jna.Pointer;
import java.util.concurrent.atomic.AtomicLong;
import org.htree.raw.Callbacks;

/** Carries calls of C to an {@link ObjectIntersector}, and what it throws past C. */
final class ObjectCallback implements Callbacks.ObjectIntersect {
    private final ObjectIntersector intersector;
    private final AtomicLong failures = new AtomicLong();
    private volatile Throwable lastThrown;

    ObjectCallback(ObjectIntersector intersector) {
        this.intersector = intersector;
        // A thread of the library joins the VM at its first call and leaves it when it ends, not
        // anew at every call.
        Native.setCallbackThreadInitializer(
                this, new CallbackThreadInitializer(true, false, "htree"));
    }

    @Override
    public int invoke(Pointer user, int object, Pointer ray, Pointer hit) {
        try {
            Hit found = intersector.intersect(object, read(ray));
            if (found == null) {
                return 0;
            }
            hit.setFloat(0, found.t());
            hit.setFloat(4, found.u());
            hit.setFloat(8, found.v());
            return 1;
        } catch (Throwable thrown) {
            lastThrown = thrown;
            failures.incrementAndGet();
            return 0;
        }
    }

    private static Ray read(Pointer ray) {
        return new Ray(ray.getFloat(0), ray.getFloat(4), ray.getFloat(8), ray.getFloat(12),
                ray.getFloat(16), ray.getFloat(20), ray.getFloat(24), ray.getFloat(28));
    }

    /**
     * How often the intersector threw. A query that sees the number change throws; of two at once
     * both do, for neither can tell whose hits are wrong.
     */
    long failures() {
        return failures.get();
    }

    /** What the intersector threw last. */
    RuntimeException thrown() {
        return Thrown.unchecked(lastThrown);
    }
}
