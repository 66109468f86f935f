// SPDX-License-Identifier: MIT
package org.htree;

/**
 * A ray: its points are org + t * dir for tmin &lt;= t &lt;= tmax; dir need not be normalised.
 *
 * @param orgX x of the origin
 * @param orgY y of the origin
 * @param orgZ z of the origin
 * @param tmin least t that counts
 * @param dirX x of the direction
 * @param dirY y of the direction
 * @param dirZ z of the direction
 * @param tmax greatest t that counts
 */
public record Ray(
        float orgX, float orgY, float orgZ, float tmin,
        float dirX, float dirY, float dirZ, float tmax) {

    /**
     * A ray from t = 0 to infinity.
     *
     * @param orgX x of the origin
     * @param orgY y of the origin
     * @param orgZ z of the origin
     * @param dirX x of the direction
     * @param dirY y of the direction
     * @param dirZ z of the direction
     */
    public Ray(float orgX, float orgY, float orgZ, float dirX, float dirY, float dirZ) {
        this(orgX, orgY, orgZ, 0, dirX, dirY, dirZ, Float.POSITIVE_INFINITY);
    }
}
