# SPDX-License-Identifier: MIT
"""What trees answer: hits, figures, and their own arrays."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._errors import check
from ._options import Kind, kind_name
from ._owner import Memory, Owner
from .raw import ffi, lib

NONE = 0xFFFFFFFF  # HTREE_NONE, the prim of a miss


class Hits(NamedTuple):
    """The closest hits of a batch: views of the fields of one array of htree.hit_dtype."""

    t: NDArray[np.float32]
    u: NDArray[np.float32]
    v: NDArray[np.float32]
    prim: NDArray[np.uint32]

    @property
    def hit(self) -> NDArray[np.bool_]:
        """Which rays hit something."""
        mask: NDArray[np.bool_] = self.prim != NONE
        return mask


class Hit(NamedTuple):
    """The closest hit of one ray."""

    t: float
    u: float
    v: float
    prim: int


class Stats(NamedTuple):
    """htree_stats: what the tree is made of, in the paper's terms."""

    kind: str
    triangles: int
    objects: int
    invalid: int
    degenerate: int
    nodes: int
    leaves: int
    references: int
    skd_nodes: int
    bv2_nodes: int
    bv6_nodes: int
    link_nodes: int
    bvo_nodes: int
    ternary_nodes: int
    depth: int
    stack: int
    bytes: int
    peak_bytes: int
    build_seconds: float
    sah_cost: float
    subtrees: int
    subtrees_built: int


class View(NamedTuple):
    """htree_view: the arrays of the tree itself, read-only. They keep its memory alive, even beyond
    `close`. Nodes, leaves and grid are bytes, laid out as lib/tree/layout.h says for it. Triangles
    are none in a wide tree: its leaves hold the corners."""

    kind: str
    bounds: NDArray[np.float32]
    prims: int
    triangle_count: int
    object_count: int
    stack: int
    triangles: NDArray[np.float32]
    nodes: NDArray[np.uint8]
    leaves: NDArray[np.uint8]
    grid: NDArray[np.uint8]


def stats_of(owner: Owner) -> Stats:
    """The figures of an open tree."""
    stats = ffi.new("htree_stats *", {"size": ffi.sizeof("htree_stats")})
    check(lib.htree_get_stats(owner.pointer, stats))
    numbers = (getattr(stats, name) for name in Stats._fields[1:])
    return Stats(Kind(kind_name(stats.kind)), *numbers)


def view_of(owner: Owner) -> View:
    """The arrays of an open tree."""
    view = ffi.new("htree_view *", {"size": ffi.sizeof("htree_view")})
    check(lib.htree_get_view(owner.pointer, view))
    count = 9 * view.triangle_count
    return View(
        kind=Kind(kind_name(view.kind)),
        bounds=box_array(view.bounds),
        prims=view.prims,
        triangle_count=view.triangle_count,
        object_count=view.object_count,
        stack=view.stack,
        triangles=Memory.array(owner, view.triangles, count, "=f4").reshape(-1, 3, 3),
        nodes=Memory.array(owner, view.nodes, view.node_bytes, "=u1"),
        leaves=Memory.array(owner, view.leaves, view.leaf_bytes, "=u1"),
        grid=Memory.array(owner, view.grid, view.grid_bytes, "=u1"),
    )


def box_array(box: Any) -> NDArray[np.float32]:
    """(2, 3): lo and hi of an htree_box."""
    return np.array([list(box.lo), list(box.hi)], np.float32)
