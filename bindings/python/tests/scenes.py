# SPDX-License-Identifier: MIT
"""What tests share: meshes and rays made in code."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import htree

REPOSITORY = Path(__file__).parents[3]
Mesh = tuple[NDArray[np.float32], NDArray[np.uint32]]


def sphere(steps: int) -> Mesh:
    """A closed sphere of radius 1 with about 4 * steps^2 triangles."""
    polar = np.linspace(0, np.pi, steps + 1)[1:-1]
    round = np.linspace(0, 2 * np.pi, 2 * steps, endpoint=False)
    a, b = (grid.ravel() for grid in np.meshgrid(polar, round, indexing="ij"))
    rings = np.stack([np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)], axis=1)
    vertices = np.concatenate([rings, [[0, 0, 1], [0, 0, -1]]]).astype(np.float32)

    n, m = steps - 1, 2 * steps
    here = np.arange(m)
    there = (here + 1) % m
    faces = [np.stack([np.full(m, n * m), here, there], 1)]
    for ring in range(n - 1):
        low, high = ring * m, (ring + 1) * m
        faces.append(np.stack([low + here, high + here, high + there], 1))
        faces.append(np.stack([low + here, high + there, low + there], 1))
    last = (n - 1) * m
    faces.append(np.stack([np.full(m, n * m + 1), last + there, last + here], 1))
    return vertices, np.concatenate(faces).astype(np.uint32)


def some_rays(count: int, seed: int = 1) -> NDArray[Any]:
    """Rays from a shell around the unit sphere, most of them towards it."""
    dice = np.random.default_rng(seed)
    rays = np.zeros(count, htree.ray_dtype)
    org = dice.normal(size=(count, 3))
    rays["org"] = 3 * org / np.linalg.norm(org, axis=1, keepdims=True)
    rays["dir"] = dice.uniform(-1.2, 1.2, (count, 3)) - rays["org"]
    rays["tmax"] = np.inf
    return rays
