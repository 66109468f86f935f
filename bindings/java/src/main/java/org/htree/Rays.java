// SPDX-License-Identifier: MIT
package org.htree;

import java.nio.FloatBuffer;
import java.util.Objects;

/** A batch of rays: eight floats each, org x y z, tmin, dir x y z, tmax, in memory that C reads. */
public final class Rays {
    /** Floats of a ray. */
    public static final int FLOATS = 8;

    private final FloatBuffer floats;

    private Rays(FloatBuffer floats) {
        if (floats.capacity() % FLOATS != 0) {
            throw new IllegalArgumentException(
                    floats.capacity() + " floats: a ray has " + FLOATS);
        }
        this.floats = floats;
    }

    /**
     * Rays of zeros, to be filled.
     *
     * @param count of rays
     * @return the rays
     */
    public static Rays allocate(int count) {
        return new Rays(Direct.bytes(4L * FLOATS * count).asFloatBuffer());
    }

    /**
     * Rays in a buffer of yours, from its position to its limit, without a copy.
     *
     * @param floats direct, in the order of this machine, at a multiple of 4 bytes
     * @return rays that share its memory
     */
    public static Rays wrap(FloatBuffer floats) {
        FloatBuffer slice = floats.slice();
        if (!Direct.isReadable(slice, floats.order())) {
            throw new IllegalArgumentException(
                    "rays need a direct buffer in native order, at a multiple of 4 bytes");
        }
        return new Rays(slice);
    }

    /**
     * A copy of rays in an array.
     *
     * @param floats eight a ray
     * @return the rays
     */
    public static Rays copyOf(float... floats) {
        return new Rays(Direct.of(FloatBuffer.wrap(floats)));
    }

    /**
     * A batch of one.
     *
     * @param ray the ray
     * @return the batch
     */
    public static Rays of(Ray ray) {
        return allocate(1).set(0, ray);
    }

    /**
     * Writes a ray.
     *
     * @param index of the ray
     * @param ray the ray
     * @return this
     */
    public Rays set(int index, Ray ray) {
        return set(index, ray.orgX(), ray.orgY(), ray.orgZ(), ray.tmin(),
                ray.dirX(), ray.dirY(), ray.dirZ(), ray.tmax());
    }

    /**
     * Writes a ray without an object for it.
     *
     * @param index of the ray
     * @param orgX x of the origin
     * @param orgY y of the origin
     * @param orgZ z of the origin
     * @param tmin least t that counts
     * @param dirX x of the direction
     * @param dirY y of the direction
     * @param dirZ z of the direction
     * @param tmax greatest t that counts
     * @return this
     */
    public Rays set(int index, float orgX, float orgY, float orgZ, float tmin,
            float dirX, float dirY, float dirZ, float tmax) {
        int at = Objects.checkIndex(index, count()) * FLOATS;
        floats.put(at, orgX).put(at + 1, orgY).put(at + 2, orgZ).put(at + 3, tmin);
        floats.put(at + 4, dirX).put(at + 5, dirY).put(at + 6, dirZ).put(at + 7, tmax);
        return this;
    }

    /**
     * Reads a ray.
     *
     * @param index of the ray
     * @return a copy
     */
    public Ray get(int index) {
        int at = Objects.checkIndex(index, count()) * FLOATS;
        return new Ray(
                floats.get(at), floats.get(at + 1), floats.get(at + 2), floats.get(at + 3),
                floats.get(at + 4), floats.get(at + 5), floats.get(at + 6), floats.get(at + 7));
    }

    /**
     * How many there are.
     *
     * @return rays
     */
    public int count() {
        return floats.capacity() / FLOATS;
    }

    /**
     * The memory itself, to be filled in bulk.
     *
     * @return a buffer over all rays, at position 0
     */
    public FloatBuffer buffer() {
        return floats.duplicate();
    }
}
