# SPDX-License-Identifier: MIT
"""Triangles and objects on their way into a tree."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _arrays, _hooks
from .raw import ffi


class Mesh:
    """An htree_mesh, and what it points to: the caller's arrays where they are of the library's
    own layout, copies otherwise, and the objects' function."""

    def __init__(
        self,
        positions: ArrayLike | None,
        indices: ArrayLike | None,
        objects: _hooks.Objects | None,
    ) -> None:
        vertices = _arrays.rows([] if positions is None else positions, np.float32, 3, "positions")
        corners = None if indices is None else _arrays.indices(indices)
        if corners is None and len(vertices) % 3:
            raise ValueError(f"{len(vertices)} vertices without indices are no whole triangles")

        self.c: Any = ffi.new("htree_mesh *")
        self.c.positions = _arrays.pointer("float *", vertices)
        self.c.position_stride = vertices.strides[0] if vertices.size else 0
        self.c.vertex_count = len(vertices)
        self.c.triangle_count = len(vertices) // 3 if corners is None else len(corners)
        if corners is not None:
            self.c.indices = _arrays.pointer("uint32_t *", corners)
        self._arrays: Any = (vertices, corners)
        self._objects: Any = None
        if objects is not None:
            self.c.objects, *self._objects = objects.to_c()
        # An object's exception belongs to the query of its thread.
        self.one_thread = objects is not None and objects.is_python

    def refer(self, objects: Any, intersect: Any) -> None:
        """The objects of a tree that was loaded."""
        self._objects = objects
        self.one_thread = _hooks.is_python_function(intersect)

    def drop_arrays(self) -> None:
        """What is left is what any tree refers to: the objects' function."""
        self._arrays = self.c = None
