// SPDX-License-Identifier: MIT

/* As types.mts, for programs that require. */

import htree = require('htree');

const tree: htree.HTree = htree.HTree.build({ positions: [0, 0, 0, 1, 0, 0, 0, 1, 0] });
const hits: htree.Hits = tree.intersect([0, 0, 1, 0, 0, 0, -1, Infinity]);
const prim: number = hits.prim(0) & htree.NONE;
prim.toFixed();

// @ts-expect-error no such class
new htree.Tree();
