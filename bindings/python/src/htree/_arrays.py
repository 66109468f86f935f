# SPDX-License-Identifier: MIT
"""Arrays on their way in and out: the library's own memory layout passes through, the rest is
converted here and nowhere else."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .raw import ffi

Array = NDArray[Any]

ray_dtype = np.dtype([("org", "f4", 3), ("tmin", "f4"), ("dir", "f4", 3), ("tmax", "f4")])
hit_dtype = np.dtype([("t", "f4"), ("u", "f4"), ("v", "f4"), ("prim", "u4")])
counters_dtype = np.dtype(
    [("traversal_steps", "u4"), ("leaf_steps", "u4"), ("intersections", "u4"), ("reserved", "u4")]
)


def as_c(values: Any, dtype: Any) -> Array:
    """`values` as a C-contiguous, aligned array of `dtype`: itself where it is one, else a copy.
    Numbers too large for float32 become infinite, as C would have it."""
    array = np.asarray(values)
    dtype = np.dtype(dtype)
    if array.dtype != dtype and array.size and (array.dtype.kind not in "biuf" or dtype.names):
        raise TypeError(f"cannot take {array.dtype} for {dtype}")
    with np.errstate(over="ignore"):
        array = np.asarray(array, dtype=dtype, order="C")
    # numpy takes packed records for aligned at any address; C does not.
    return array.copy() if address(array) % 4 else array


def address(array: Array) -> int:
    return int(array.__array_interface__["data"][0])


def pointer(kind: str, array: Array) -> Any:
    """The array's first item as a C pointer. Does not keep the array alive."""
    return ffi.cast(kind, address(array)) if array.size else ffi.NULL


def rows(values: ArrayLike, dtype: Any, width: int, what: str) -> Array:
    """`values` as an (n, width) array; a flat array of n * width numbers will do."""
    array = np.asarray(values)
    if array.ndim == 1 and array.size % width == 0:
        array = array.reshape(-1, width)
    if array.ndim != 2 or array.shape[1] != width:
        raise ValueError(f"{what} must be (n, {width}), not {array.shape}")
    return array if _is_strided(array, dtype) else as_c(array, dtype)


def _is_strided(array: Array, dtype: Any) -> bool:
    """Whether the rows are dense and the library can step from one to the next by itself, as in
    `vertices[:, :3]` of interleaved records."""
    return bool(
        array.dtype == dtype
        and array.size
        and array.strides[1] == array.itemsize
        and array.strides[0] >= array.itemsize * array.shape[1]
        and array.strides[0] % 4 == 0
        and address(array) % 4 == 0
    )


def indices(values: ArrayLike) -> Array:
    """Three indices a triangle as uint32."""
    array = np.asarray(values)
    if array.size and array.dtype.kind not in "iu":
        raise TypeError(f"indices must be integers, not {array.dtype}")
    if array.dtype != np.uint32 and array.size and not 0 <= array.min() <= array.max() < 2**32:
        raise OverflowError("an index is negative or does not fit into 32 bits")
    if array.dtype == np.int32:
        array = array.view(np.uint32)
    array = rows(array, np.uint32, 3, "indices")
    return np.ascontiguousarray(array)


def rays(
    given: ArrayLike, directions: ArrayLike | None, tmin: ArrayLike | None, tmax: ArrayLike | None
) -> Array:
    """Rays of any shape: `given` as ray_dtype or (..., 8) numbers, or origins with directions."""
    if directions is None:
        if tmin is not None or tmax is not None:
            raise TypeError("tmin and tmax go with origins and directions; rays have their own")
        array = np.asarray(given)
        if array.dtype == ray_dtype:
            return as_c(array, ray_dtype)
        if array.dtype.names or array.ndim == 0 or array.shape[-1] != 8:
            raise TypeError(
                "rays must be of htree.ray_dtype or (..., 8) numbers, or come with directions; "
                f"this is {array.dtype} {array.shape}"
            )
        return as_c(array, np.float32).view(ray_dtype)[..., 0]
    org = _vectors(given, "origins")
    dir = _vectors(directions, "directions")
    first = as_c(0 if tmin is None else tmin, np.float32)
    last = as_c(np.inf if tmax is None else tmax, np.float32)
    shape = np.broadcast_shapes(org.shape[:-1], dir.shape[:-1], first.shape, last.shape)
    array = np.empty(shape, ray_dtype)
    array["org"], array["dir"], array["tmin"], array["tmax"] = org, dir, first, last
    return array


def _vectors(values: ArrayLike, what: str) -> Array:
    array = as_c(values, np.float32)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{what} must be (..., 3), not {array.shape}")
    return array


def answers(out: Any, dtypes: Sequence[Any], shape: tuple[int, ...], what: str) -> Array:
    """`out` if it can take the answers, or a fresh array where it is None."""
    if out is None:
        return np.empty(shape, dtypes[0])
    if not isinstance(out, np.ndarray) or not any(out.dtype == dtype for dtype in dtypes):
        raise TypeError(f"{what} must be an array of {dtypes[0]}")
    if out.shape != shape:
        raise ValueError(f"{what} must be {shape}, not {out.shape}")
    flags = out.flags
    if not (flags.c_contiguous and flags.writeable) or address(out) % min(4, out.itemsize):
        raise ValueError(f"{what} must be C-contiguous, aligned and writeable")
    return out
