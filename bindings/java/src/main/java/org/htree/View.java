// SPDX-License-Identifier: MIT
package org.htree;

import java.nio.ByteBuffer;
import java.nio.FloatBuffer;
import org.htree.raw.Structs;

/**
 * Copies of a tree's arrays, for backends and tools of your own: read-only, in the order of this
 * machine. Nodes, leaves and grid are laid out as {@code lib/tree/layout.h} says, which holds for
 * one minor version.
 *
 * @param kind of tree
 * @param bounds of what can be hit
 * @param prims that can be hit; 0: there are no nodes, and every ray misses
 * @param triangleCount of the mesh; prims from here on are objects
 * @param objectCount of the mesh
 * @param stack entries that a traversal stack can need at most
 * @param triangles nine floats a triangle, v0 v1 v2; a skipped one is all 0. Empty in WIDE, whose
 *     leaves hold the corners
 * @param nodes root first
 * @param leaves empty in kinds that have none
 * @param grid empty in kinds that have none
 */
public record View(
        Kind kind, Box bounds, int prims, int triangleCount, int objectCount, int stack,
        FloatBuffer triangles, ByteBuffer nodes, ByteBuffer leaves, ByteBuffer grid) {

    static View copyOf(Structs.View v) {
        long triangleBytes = 36 * Integer.toUnsignedLong(v.triangleCount);
        return new View(Kind.of(v.kind), Box.of(v.bounds), v.prims, v.triangleCount, v.objectCount,
                v.stack, Direct.copy(v.triangles, triangleBytes).asFloatBuffer(),
                Direct.copy(v.nodes, v.nodeBytes), Direct.copy(v.leaves, v.leafBytes),
                Direct.copy(v.grid, v.gridBytes));
    }
}
