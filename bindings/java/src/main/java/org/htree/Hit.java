// SPDX-License-Identifier: MIT
package org.htree;

/**
 * The closest hit of a ray. On a triangle (v0, v1, v2) the point is (1 - u - v) v0 + u v1 + v v2.
 *
 * @param t where on the ray; tmax of the ray for a miss
 * @param u weight of v1
 * @param v weight of v2
 * @param prim triangle i of the mesh is i, object j is triangleCount + j; {@link #NONE} for a miss;
 *     an unsigned number
 */
public record Hit(float t, float u, float v, int prim) {
    /** The prim of a miss: 2^32 - 1 as an unsigned number. */
    public static final int NONE = -1;

    /**
     * A hit of an object, for an {@link ObjectIntersector}.
     *
     * @param t where on the ray
     * @param u the first of two numbers that the query hands on
     * @param v the second
     */
    public Hit(float t, float u, float v) {
        this(t, u, v, NONE);
    }

    /**
     * Tells a hit from a miss.
     *
     * @return true if something was hit
     */
    public boolean isHit() {
        return prim != NONE;
    }
}
