// SPDX-License-Identifier: MIT
package org.htree;

/** How {@link HTree#update} brings a tree to a mesh. */
public enum How {
    /** As {@link HTree#build} would, in the memory of the builds before. */
    REBUILD(1),
    /** WIDE: the same nodes around the new positions. */
    REFIT(2);

    private final int code;

    How(int code) {
        this.code = code;
    }

    /**
     * The library's number.
     *
     * @return HTREE_REBUILD or HTREE_REFIT
     */
    public int code() {
        return code;
    }
}
