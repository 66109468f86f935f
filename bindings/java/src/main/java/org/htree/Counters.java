// SPDX-License-Identifier: MIT
package org.htree;

import java.nio.IntBuffer;
import java.util.Objects;

/** What each ray of a batch cost, in the paper's terms; to be handed to {@link Query}. */
public final class Counters {
    private static final int INTS = 4;

    private final IntBuffer ints;

    private Counters(IntBuffer ints) {
        this.ints = ints;
    }

    /**
     * Room for counters.
     *
     * @param count of rays
     * @return the counters, all zero
     */
    public static Counters allocate(int count) {
        return new Counters(Direct.bytes(4L * INTS * count).asIntBuffer());
    }

    /**
     * N_TS: nodes visited, leaves included.
     *
     * @param index of the ray
     * @return steps
     */
    public int traversalSteps(int index) {
        return ints.get(at(index));
    }

    /**
     * N_ETS: leaves visited.
     *
     * @param index of the ray
     * @return steps
     */
    public int leafSteps(int index) {
        return ints.get(at(index) + 1);
    }

    /**
     * N_IT: objects tested.
     *
     * @param index of the ray
     * @return tests
     */
    public int intersections(int index) {
        return ints.get(at(index) + 2);
    }

    /**
     * How many rays there is room for.
     *
     * @return rays
     */
    public int count() {
        return ints.capacity() / INTS;
    }

    /**
     * The memory itself: four ints a ray, the last of them reserved.
     *
     * @return a buffer over all counters, at position 0
     */
    public IntBuffer buffer() {
        return ints.duplicate();
    }

    private int at(int index) {
        return Objects.checkIndex(index, count()) * INTS;
    }
}
