// SPDX-License-Identifier: MIT
package org.htree;

import org.htree.raw.Structs;

/**
 * A box along the axes.
 *
 * @param loX least x
 * @param loY least y
 * @param loZ least z
 * @param hiX greatest x
 * @param hiY greatest y
 * @param hiZ greatest z
 */
public record Box(float loX, float loY, float loZ, float hiX, float hiY, float hiZ) {
    static Box of(Structs.Box box) {
        return new Box(box.lo[0], box.lo[1], box.lo[2], box.hi[0], box.hi[1], box.hi[2]);
    }

    /**
     * Tells whether there is nothing inside: lo is above hi.
     *
     * @return true if the box is empty
     */
    public boolean isEmpty() {
        return loX > hiX || loY > hiY || loZ > hiZ;
    }
}
