"""A tetrahedron, a million rays."""

import numpy as np

import htree

vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], np.float32)
faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], np.uint32)

with htree.build(vertices, faces) as tree:
    print(tree)
    print(tree.intersect_one([2, 2, 2], [-1, -1, -1]))

    origins = np.random.default_rng(1).uniform(-1, 2, (1_000_000, 3))
    hits = tree.intersect(origins, [0, 0, -1])  # t, u, v, prim: an array each
    print(f"{hits.hit.mean():.1%} hit, the nearest at t = {hits.t.min():.4f}")
