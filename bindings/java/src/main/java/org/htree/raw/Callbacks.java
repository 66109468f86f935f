// SPDX-License-Identifier: MIT
package org.htree.raw;

import com.sun.jna.Callback;
import com.sun.jna.Pointer;

/** The types of functions in {@code htree.h}. */
public final class Callbacks {
    private Callbacks() {}

    /** {@code htree_object_intersect}. */
    public interface ObjectIntersect extends Callback {
        /**
         * Intersects an object with a ray.
         *
         * @param user what {@link Structs.Objects#user} holds
         * @param object number of the object
         * @param ray the {@code htree_ray}
         * @param hit the {@code htree_hit} to fill
         * @return nonzero if the object is hit
         */
        int invoke(Pointer user, int object, Pointer ray, Pointer hit);
    }

    /** {@code htree_progress.report}. */
    public interface Report extends Callback {
        /**
         * Reports progress.
         *
         * @param user what {@link Structs.Progress#user} holds
         * @param fraction of the work that is done
         * @return nonzero to cancel
         */
        int invoke(Pointer user, double fraction);
    }

    /** {@code htree_allocator.allocate}. */
    public interface Allocate extends Callback {
        /**
         * Allocates memory.
         *
         * @param user what {@link Structs.Allocator#user} holds
         * @param bytes how many
         * @param alignment a power of two
         * @return the memory, or null
         */
        Pointer invoke(Pointer user, long bytes, long alignment);
    }

    /** {@code htree_allocator.release}. */
    public interface Release extends Callback {
        /**
         * Releases memory.
         *
         * @param user what {@link Structs.Allocator#user} holds
         * @param memory from {@link Allocate}
         * @param bytes as they were asked for
         */
        void invoke(Pointer user, Pointer memory, long bytes);
    }

    /** {@code htree_tasks.run}. */
    public interface Run extends Callback {
        /**
         * Calls a task for every index.
         *
         * @param user what {@link Structs.Tasks#user} holds
         * @param count of indices
         * @param task the function to call as {@code task(data, index)}
         * @param data its first argument
         */
        void invoke(Pointer user, int count, Pointer task, Pointer data);
    }
}
