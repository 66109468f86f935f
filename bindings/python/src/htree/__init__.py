# SPDX-License-Identifier: MIT
"""Ray queries over triangle meshes.

    tree = htree.build(vertices, faces)
    hits = tree.intersect(origins, directions)  # hits.t, hits.u, hits.v, hits.prim

The library underneath is libhtree; its header htree.h is the contract of every call.
"""

from importlib.metadata import version as _version

from ._arrays import counters_dtype, hit_dtype, ray_dtype
from ._errors import (
    ArgumentError,
    Cancelled,
    CorruptError,
    DeviceError,
    Error,
    GeometryError,
    LimitError,
    OutOfMemory,
    Status,
    Unsupported,
    error_text,
    status_name,
)
from ._hooks import Objects, Ray
from ._options import Flag, Kind, Options, calibrate, kind_from_name, kind_name
from ._tree import How, Tree, build, load
from ._values import NONE, Hit, Hits, Stats, View
from .raw import lib as _lib

__all__ = [
    "COORDINATE_MAX", "NONE", "ArgumentError", "Cancelled", "CorruptError", "DeviceError", "Error",
    "Flag", "GeometryError", "Hit", "Hits", "How", "Kind", "LimitError", "Objects", "Options",
    "OutOfMemory", "Ray", "Stats", "Status", "Tree", "Unsupported", "View", "build", "calibrate",
    "counters_dtype", "error_text", "hit_dtype", "kind_from_name", "kind_name", "lib_version",
    "load", "ray_dtype", "status_name",
]  # fmt: skip

__version__ = _version("htree")
COORDINATE_MAX = 2.0**60  # HTREE_COORDINATE_MAX


def lib_version() -> tuple[int, int, int]:
    """Version of the library underneath: major, minor, patch."""
    number = int(_lib.htree_version())
    return number // 10000, number // 100 % 100, number % 100
