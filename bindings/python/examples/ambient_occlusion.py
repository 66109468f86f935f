# SPDX-License-Identifier: MIT
"""Ambient occlusion of a torus knot on a dented floor, by millions of short rays.

A script of cells: editors that know `# %%` run it piece by piece, `python ambient_occlusion.py
[PICTURE.png]` runs it whole.
"""

# %% A scene: meshes are arrays, so numpy can make them.
import sys
import time

import numpy as np
from numpy.typing import NDArray

import htree

Floats = NDArray[np.float64]


def grid_faces(rows: int, columns: int, wraps: bool) -> NDArray[np.uint32]:
    """Two triangles for each cell of a grid of vertices."""
    i, j = np.meshgrid(
        np.arange(rows - (not wraps)), np.arange(columns - (not wraps)), indexing="ij"
    )
    i1, j1 = (i + 1) % rows, (j + 1) % columns
    a, b, c, d = (x * columns + y for x, y in ((i, j), (i1, j), (i1, j1), (i, j1)))
    faces = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], -2)
    return faces.reshape(-1, 3).astype(np.uint32)


def knot(along: int = 500, around: int = 48) -> tuple[Floats, NDArray[np.uint32]]:
    """A tube around a (2, 3) torus knot."""
    s = np.linspace(0, 2 * np.pi, along, endpoint=False)
    radius = 1 + 0.4 * np.cos(3 * s)
    line = np.stack(
        [radius * np.cos(2 * s), radius * np.sin(2 * s), 0.55 * np.sin(3 * s) + 0.95], -1
    )
    tangent = np.roll(line, -1, 0) - np.roll(line, 1, 0)
    side = np.cross(tangent, [0, 0, 1])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, tangent)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    turn = np.linspace(0, 2 * np.pi, around, endpoint=False)[:, None]
    tube = line[:, None] + 0.24 * (np.cos(turn) * side[:, None] + np.sin(turn) * up[:, None])
    return tube.reshape(-1, 3), grid_faces(along, around, wraps=True)


def floor(size: int = 220) -> tuple[Floats, NDArray[np.uint32]]:
    """A plane with dents like those of an egg box."""
    x, y = np.meshgrid(np.linspace(-4, 4, size), np.linspace(-4, 4, size), indexing="ij")
    z = -0.07 * (np.cos(5 * x) * np.cos(5 * y))
    return np.stack([x, y, z], -1).reshape(-1, 3), grid_faces(size, size, wraps=False)


(knot_vertices, knot_faces), (floor_vertices, floor_faces) = knot(), floor()
vertices = np.concatenate([knot_vertices, floor_vertices]).astype(np.float32)
faces = np.concatenate([knot_faces, floor_faces + np.uint32(len(knot_vertices))])
tree = htree.build(vertices, faces)
print(tree)

# %% A camera: one ray a pixel, as an array in the shape of the picture.
HEIGHT, WIDTH, SAMPLES = 360, 480, 48
eye = np.array([2.2, -3.0, 3.6])
ahead = np.array([0, 0, 0.7]) - eye
ahead /= np.linalg.norm(ahead)
right = np.cross(ahead, [0, 0, 1])
right /= np.linalg.norm(right)
x = np.linspace(-1, 1, WIDTH)[:, None] * 0.52
y = np.linspace(1, -1, HEIGHT)[:, None, None] * 0.52 * HEIGHT / WIDTH
hits = tree.intersect(eye, ahead + x * right + y * np.cross(right, ahead))
print(f"{hits.hit.mean():.0%} of {HEIGHT} x {WIDTH} pixels show something")

# %% From each point that the camera sees, rays into the hemisphere above it, by the cosine.
corners = vertices[faces[hits.prim[hits.hit]]].astype(np.float64)
u, v = hits.u[hits.hit, None], hits.v[hits.hit, None]
points = (1 - u - v) * corners[:, 0] + u * corners[:, 1] + v * corners[:, 2]
normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
normals /= np.linalg.norm(normals, axis=1, keepdims=True)
normals *= np.sign(np.sum(normals * (eye - points), axis=1, keepdims=True))  # towards the eye

dice = np.random.default_rng(1)
directions = dice.normal(size=(len(points), SAMPLES, 3))
directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
directions += normals[:, None] * 1.001  # a point of the sphere on top of the normal: the cosine

started = time.perf_counter()
dark = tree.occluded((points + 1e-4 * normals)[:, None], directions, tmax=1.2)
seconds = time.perf_counter() - started
print(f"{dark.size:,} rays in {seconds:.2f} s: {dark.size / seconds / 1e6:.1f} million a second")

picture = np.full((HEIGHT, WIDTH), np.nan)
picture[hits.hit] = 1 - dark.mean(axis=1)

# %% The picture.
import matplotlib  # noqa: E402

if len(sys.argv) > 1:
    matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

figure, axes = plt.subplots(figsize=(8, 6), layout="tight")
axes.imshow(picture, cmap=plt.get_cmap("gray").with_extremes(bad="#c6d6e4"), vmin=0, vmax=1.1)
axes.set_title(f"{len(faces):,} triangles, {dark.size:,} rays of ambient occlusion")
axes.set_axis_off()
if len(sys.argv) > 1:
    figure.savefig(sys.argv[1], dpi=120)
else:
    plt.show()
