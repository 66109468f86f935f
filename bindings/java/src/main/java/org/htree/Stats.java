// SPDX-License-Identifier: MIT
package org.htree;

import org.htree.raw.Structs;

/**
 * What a tree is made of, in the paper's terms.
 *
 * @param kind of tree
 * @param triangles as given
 * @param objects as given
 * @param invalid skipped: NaN, infinite or oversize coordinates
 * @param degenerate skipped: triangles without area
 * @param nodes N_NS, all nodes
 * @param leaves N_E
 * @param references N_ER, references from leaves to triangles and objects
 * @param skdNodes with two separating planes
 * @param bv2Nodes with two bounding planes
 * @param bv6Nodes with six bounding planes
 * @param linkNodes links
 * @param bvoNodes with another set of bounding planes
 * @param ternaryNodes with a shelf of oversize objects
 * @param depth nodes on the longest way from the root to a leaf
 * @param stack entries that a traversal stack can need at most
 * @param bytes memory of the finished tree, geometry included
 * @param peakBytes most memory held at any time of the build
 * @param buildSeconds T_C, wall clock
 * @param sahCost expected cost of a random ray that meets the bounds, in the options' unit
 * @param subtrees of a lazy tree: left to rays; else 0
 * @param subtreesBuilt of these, built by now
 */
public record Stats(
        Kind kind, long triangles, long objects, long invalid, long degenerate,
        long nodes, long leaves, long references, long skdNodes, long bv2Nodes, long bv6Nodes,
        long linkNodes, long bvoNodes, long ternaryNodes, int depth, int stack,
        long bytes, long peakBytes, double buildSeconds, double sahCost,
        long subtrees, long subtreesBuilt) {

    static Stats of(Structs.Stats s) {
        return new Stats(Kind.of(s.kind), s.triangles, s.objects, s.invalid, s.degenerate,
                s.nodes, s.leaves, s.references, s.skdNodes, s.bv2Nodes, s.bv6Nodes,
                s.linkNodes, s.bvoNodes, s.ternaryNodes, s.depth, s.stack,
                s.bytes, s.peakBytes, s.buildSeconds, s.sahCost, s.subtrees, s.subtreesBuilt);
    }
}
