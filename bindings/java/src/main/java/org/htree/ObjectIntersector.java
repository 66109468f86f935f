// SPDX-License-Identifier: MIT
package org.htree;

/**
 * Intersects objects of your own with a ray: a pure function.
 *
 * <p>It is called from every thread that works for a query, so it must be safe to call from several
 * at once. Each call crosses from C into Java, which costs far more than a triangle: see the
 * README.
 * It must not refer to the tree it serves, or that tree is freed by {@link HTree#close} only.
 */
@FunctionalInterface
public interface ObjectIntersector {
    /**
     * Finds where the ray hits the object. What this throws is thrown out of the query.
     *
     * @param object number of the object, from 0
     * @param ray the ray; the hit counts if its t is from tmin to tmax
     * @return the hit of smallest such t, or null for a miss; its prim is ignored
     */
    Hit intersect(int object, Ray ray);
}
