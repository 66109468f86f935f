// SPDX-License-Identifier: MIT
/**
 * Ray queries over hierarchies that are cheap enough to build anew for every frame.
 *
 * <p>Data takes one way: {@link org.htree.Mesh}, {@link org.htree.HTree#build}, {@link
 * org.htree.HTree}, {@link org.htree.HTree#intersect(Rays)}, {@link org.htree.Hits}. The closest
 * hit has the same bits in every kind of tree and on any number of threads.
 */
package org.htree;
