// SPDX-License-Identifier: MIT
package org.htree;

import org.htree.raw.LibHTree;

/** The structures, and the presets for those who do not want to choose. */
public enum Kind {
    /** Uniform grid. */
    UG(1),
    /** Kd-tree by the surface area heuristic (SAH). */
    KD(2),
    /** Bounding volume hierarchy, spatial median. */
    BVH_MEDIAN(3),
    /** Bounding volume hierarchy, SAH over buckets of centroids. */
    BVH_SAH(4),
    /** Spatial kd-tree: two planes a node. */
    SKD(5),
    /** H-tree: spatial kd-tree with sparse bounding volumes. */
    H(6),
    /** H-tree by a 3D grid and a summed-area table. */
    AH(7),
    /** Eight children a node, eight triangles a leaf: for vector units. */
    WIDE(8),
    /** Build every frame, trace a few rays a triangle. */
    FAST(101),
    /** The default. */
    BALANCED(102),
    /** Build once, trace for long. */
    BEST(103);

    private final int code;

    Kind(int code) {
        this.code = code;
    }

    /**
     * The library's number.
     *
     * @return the number of {@code htree_kind}
     */
    public int code() {
        return code;
    }

    /**
     * The library's name, as its programs take it.
     *
     * @return for example "bvh-sah"
     */
    public String label() {
        return LibHTree.htree_kind_name(code);
    }

    /**
     * The kind of a name.
     *
     * @param label for example "bvh-sah"
     * @return the kind
     * @throws IllegalArgumentException if no kind has that name
     */
    public static Kind fromLabel(String label) {
        int code = LibHTree.htree_kind_from_name(label);
        if (code == 0) {
            throw new IllegalArgumentException("no kind is named " + label);
        }
        return of(code);
    }

    /**
     * The kind of a number.
     *
     * @param code a number of {@code htree_kind}
     * @return the kind
     * @throws IllegalArgumentException if no kind has that number
     */
    public static Kind of(int code) {
        for (Kind kind : values()) {
            if (kind.code == code) {
                return kind;
            }
        }
        throw new IllegalArgumentException("no kind has number " + code);
    }
}
