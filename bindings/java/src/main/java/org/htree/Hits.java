// SPDX-License-Identifier: MIT
package org.htree;

import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.util.Objects;

/** The answers to a batch of rays: t, u, v and prim of each, in memory that C writes. */
public final class Hits {
    /** Bytes of a hit. */
    public static final int BYTES = 16;

    private final ByteBuffer bytes;

    private Hits(ByteBuffer bytes) {
        if (bytes.capacity() % BYTES != 0) {
            throw new IllegalArgumentException(bytes.capacity() + " bytes: a hit has " + BYTES);
        }
        if (!Direct.isAligned(bytes)) {
            throw new IllegalArgumentException("hits must begin at a multiple of 4 bytes");
        }
        this.bytes = bytes;
    }

    /**
     * Room for answers.
     *
     * @param count of rays
     * @return the hits, all zero
     */
    public static Hits allocate(int count) {
        return new Hits(Direct.bytes((long) BYTES * count));
    }

    /**
     * Hits in a buffer of yours, from its position to its limit, without a copy.
     *
     * @param bytes direct and writable, 16 a hit, at a multiple of 4 bytes
     * @return hits that share its memory
     */
    public static Hits wrap(ByteBuffer bytes) {
        return new Hits(Direct.writable(bytes));
    }

    /**
     * Where the ray hit, in lengths of its direction; its tmax if it missed.
     *
     * @param index of the ray
     * @return t
     */
    public float t(int index) {
        return bytes.getFloat(at(index));
    }

    /**
     * The weight of the triangle's second vertex.
     *
     * @param index of the ray
     * @return u
     */
    public float u(int index) {
        return bytes.getFloat(at(index) + 4);
    }

    /**
     * The weight of the triangle's third vertex.
     *
     * @param index of the ray
     * @return v
     */
    public float v(int index) {
        return bytes.getFloat(at(index) + 8);
    }

    /**
     * What was hit.
     *
     * @param index of the ray
     * @return an unsigned number, {@link Hit#NONE} for a miss
     */
    public int prim(int index) {
        return bytes.getInt(at(index) + 12);
    }

    /**
     * Tells a hit from a miss.
     *
     * @param index of the ray
     * @return true if something was hit
     */
    public boolean isHit(int index) {
        return prim(index) != Hit.NONE;
    }

    /**
     * Reads a hit.
     *
     * @param index of the ray
     * @return a copy
     */
    public Hit get(int index) {
        return new Hit(t(index), u(index), v(index), prim(index));
    }

    /**
     * How many there are.
     *
     * @return hits
     */
    public int count() {
        return bytes.capacity() / BYTES;
    }

    /**
     * The memory itself.
     *
     * @return a buffer over all hits, at position 0, in the order of this machine
     */
    public ByteBuffer buffer() {
        return bytes.duplicate().order(ByteOrder.nativeOrder());
    }

    private int at(int index) {
        return Objects.checkIndex(index, count()) * BYTES;
    }
}
