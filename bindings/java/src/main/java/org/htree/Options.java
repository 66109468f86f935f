// SPDX-License-Identifier: MIT
package org.htree;

import org.htree.raw.LibHTree;
import org.htree.raw.Structs;

/**
 * How to build. Immutable; the defaults are the library's.
 *
 * @param kind of tree; presets are replaced by what they stand for
 * @param strict refuse NaN, infinite and oversize coordinates instead of skipping them
 * @param anyPlanes H, AH: bounding nodes of any of 63 plane sets, not BV2 and BV6 only
 * @param loosePlanes AH: planes as the grid gives them, half a cell wide
 * @param morton WIDE: Morton order below the grid: faster to build, slower to trace
 * @param lazy WIDE: only the top is built, the rest by the first ray that gets there; see
 *     {@link HTree#complete}
 * @param compact WIDE: less than half of the memory, slower to build and to trace; not with lazy
 * @param collapse BVH, SKD, H, AH: collapses the finished tree into one of kind WIDE
 * @param threads of queries: 0 all cores, 1 the caller's, n at most n
 * @param buckets M of the paper's section 5, 2 to 64
 * @param axes 1: split along the widest extent only; 3: try all axes
 * @param costSkd C_SKD^T, traversing a node with two separating planes
 * @param costBv2 C_2PN^T, clipping by two planes
 * @param costBv6 C_6PN^T, clipping by six planes
 * @param costIntersect C_IT, one ray-object test
 * @param cellsPerPrim cells of the AH-tree's grid for each object, 1/64 to 64
 * @param fewPrims ranges of no more objects are built as an H-tree, 1 to 2^20
 * @param progress of the build, or null
 */
public record Options(
        Kind kind, boolean strict, boolean anyPlanes, boolean loosePlanes,
        boolean morton, boolean lazy, boolean compact, boolean collapse,
        int threads, int buckets, int axes,
        float costSkd, float costBv2, float costBv6, float costIntersect,
        float cellsPerPrim, int fewPrims, Progress progress) {

    private static final int STRICT = 1;
    private static final int ANY_PLANES = 2;
    private static final int LOOSE_PLANES = 4;
    private static final int MORTON = 8;
    private static final int LAZY = 16;
    private static final int COMPACT = 32;
    private static final int COLLAPSE = 64;

    /**
     * The defaults of a kind.
     *
     * @param kind of tree, or a preset
     * @return the options
     */
    public static Options of(Kind kind) {
        Structs.Options struct = new Structs.Options();
        HTreeException.check(LibHTree.htree_options_init(struct, struct.size(), kind.code()));
        return of(struct, null);
    }

    /**
     * A builder that holds the defaults of a kind.
     *
     * @param kind of tree, or a preset
     * @return the builder
     */
    public static Builder builder(Kind kind) {
        return of(kind).toBuilder();
    }

    /**
     * A builder that holds these options.
     *
     * @return the builder
     */
    public Builder toBuilder() {
        return new Builder(this);
    }

    /**
     * These options with the four costs as measured on this machine, which takes some milliseconds.
     * What it finds depends on timing, and so will the tree.
     *
     * @return new options
     */
    public Options calibrated() {
        Structs.Options struct = toStruct(null);
        HTreeException.check(LibHTree.htree_calibrate(struct));
        return of(struct, progress);
    }

    private static Options of(Structs.Options s, Progress progress) {
        return new Options(Kind.of(s.kind), (s.flags & STRICT) != 0,
                (s.flags & ANY_PLANES) != 0, (s.flags & LOOSE_PLANES) != 0,
                (s.flags & MORTON) != 0, (s.flags & LAZY) != 0,
                (s.flags & COMPACT) != 0, (s.flags & COLLAPSE) != 0,
                s.threads, s.buckets, s.axes, s.costSkd, s.costBv2, s.costBv6, s.costIntersect,
                s.cellsPerPrim, s.fewPrims, progress);
    }

    Structs.Options toStruct(ProgressCallback callback) {
        Structs.Options s = new Structs.Options();
        HTreeException.check(LibHTree.htree_options_init(s, s.size(), kind.code()));
        s.flags = (strict ? STRICT : 0) | (anyPlanes ? ANY_PLANES : 0)
                | (loosePlanes ? LOOSE_PLANES : 0) | (morton ? MORTON : 0) | (lazy ? LAZY : 0)
                | (compact ? COMPACT : 0) | (collapse ? COLLAPSE : 0);
        s.threads = Query.requireThreads(threads);
        s.buckets = buckets;
        s.axes = axes;
        s.costSkd = costSkd;
        s.costBv2 = costBv2;
        s.costBv6 = costBv6;
        s.costIntersect = costIntersect;
        s.cellsPerPrim = cellsPerPrim;
        s.fewPrims = fewPrims;
        s.progress.report = callback;
        return s;
    }

    /** Builds {@link Options}. */
    public static final class Builder {
        private final Kind kind;
        private boolean strict;
        private boolean anyPlanes;
        private boolean loosePlanes;
        private boolean morton;
        private boolean lazy;
        private boolean compact;
        private boolean collapse;
        private int threads;
        private int buckets;
        private int axes;
        private float costSkd;
        private float costBv2;
        private float costBv6;
        private float costIntersect;
        private float cellsPerPrim;
        private int fewPrims;
        private Progress progress;

        private Builder(Options from) {
            kind = from.kind;
            strict = from.strict;
            anyPlanes = from.anyPlanes;
            loosePlanes = from.loosePlanes;
            morton = from.morton;
            lazy = from.lazy;
            compact = from.compact;
            collapse = from.collapse;
            threads = from.threads;
            buckets = from.buckets;
            axes = from.axes;
            costSkd = from.costSkd;
            costBv2 = from.costBv2;
            costBv6 = from.costBv6;
            costIntersect = from.costIntersect;
            cellsPerPrim = from.cellsPerPrim;
            fewPrims = from.fewPrims;
            progress = from.progress;
        }

        /**
         * Refuses bad coordinates instead of skipping them.
         *
         * @param value NaN, infinite and oversize ones throw GEOMETRY
         * @return this
         */
        public Builder strict(boolean value) {
            strict = value;
            return this;
        }

        /**
         * Lets H and AH bound nodes by any of 63 plane sets, not BV2 and BV6 only.
         *
         * @param value true for any
         * @return this
         */
        public Builder anyPlanes(boolean value) {
            anyPlanes = value;
            return this;
        }

        /**
         * Lets AH keep planes as its grid gives them, half a cell wide (section 7.1).
         *
         * @param value true for loose ones
         * @return this
         */
        public Builder loosePlanes(boolean value) {
            loosePlanes = value;
            return this;
        }

        /**
         * Lets WIDE order what lies below its grid by Morton codes: faster to build, slower to
         * trace.
         *
         * @param value true for Morton order
         * @return this
         */
        public Builder morton(boolean value) {
            morton = value;
            return this;
        }

        /**
         * Lets WIDE build only its top, and the rest by the first ray that gets there. The tree
         * keeps the mesh until {@link HTree#complete} or {@link HTree#close}, and the mesh's direct
         * buffers must not change before.
         *
         * @param value true for a lazy tree
         * @return this
         */
        public Builder lazy(boolean value) {
            lazy = value;
            return this;
        }

        /**
         * Lets WIDE take less than half of the memory. Such a tree is slower to build and to trace,
         * has no {@link HTree#view}, and cannot be lazy.
         *
         * @param value true for a compact tree
         * @return this
         */
        public Builder compact(boolean value) {
            compact = value;
            return this;
        }

        /**
         * Collapses the finished tree of a BVH, SKD, H or AH into one of kind WIDE, as BEST does.
         *
         * @param value true for a wide tree
         * @return this
         */
        public Builder collapse(boolean value) {
            collapse = value;
            return this;
        }

        /**
         * Sets the threads of queries.
         *
         * @param value 0 all cores, 1 the caller's, n at most n
         * @return this
         */
        public Builder threads(int value) {
            threads = value;
            return this;
        }

        /**
         * Sets at how many planes the cost is evaluated.
         *
         * @param value planes and one, 2 to 64
         * @return this
         */
        public Builder buckets(int value) {
            buckets = value;
            return this;
        }

        /**
         * Sets the axes to try.
         *
         * @param value 1 or 3
         * @return this
         */
        public Builder axes(int value) {
            axes = value;
            return this;
        }

        /**
         * Sets the costs of section 6.3, in any common unit.
         *
         * @param skd traversing a node with two separating planes
         * @param bv2 clipping by two planes
         * @param bv6 clipping by six planes
         * @param intersect one ray-object test
         * @return this
         */
        public Builder costs(float skd, float bv2, float bv6, float intersect) {
            costSkd = skd;
            costBv2 = bv2;
            costBv6 = bv6;
            costIntersect = intersect;
            return this;
        }

        /**
         * Sets the size of the AH-tree's grid.
         *
         * @param value cells for each object, 1/64 to 64
         * @return this
         */
        public Builder cellsPerPrim(float value) {
            cellsPerPrim = value;
            return this;
        }

        /**
         * Sets what the AH-tree hands to the H-tree.
         *
         * @param value objects, 1 to 2^20
         * @return this
         */
        public Builder fewPrims(int value) {
            fewPrims = value;
            return this;
        }

        /**
         * Sets who hears of the build.
         *
         * @param value or null
         * @return this
         */
        public Builder progress(Progress value) {
            progress = value;
            return this;
        }

        /**
         * Ends the builder's work.
         *
         * @return the options
         */
        public Options build() {
            return new Options(kind, strict, anyPlanes, loosePlanes, morton, lazy, compact,
                    collapse, threads, buckets, axes, costSkd, costBv2, costBv6, costIntersect,
                    cellsPerPrim, fewPrims, progress);
        }
    }
}
