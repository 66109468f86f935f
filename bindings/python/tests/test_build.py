# SPDX-License-Identifier: MIT
"""Meshes in every shape that Python has for them, and options."""

from __future__ import annotations

import array
import dataclasses
import math
import pickle
import tracemalloc
from typing import Any

import numpy as np
import pytest
from scenes import Mesh, some_rays, sphere

import htree


def hits_of(*arguments: Any, **keywords: Any) -> bytes:
    """What a tree built so answers, in bytes."""
    rays = some_rays(2000)
    out = np.empty(len(rays), htree.hit_dtype)
    with htree.build(*arguments, **keywords) as tree:
        tree.intersect(rays, out=out)
    assert (out["prim"] != htree.NONE).any()
    return out.tobytes()


def test_the_same_mesh_in_any_form_gives_the_same_hits(ball: Mesh) -> None:
    vertices, faces = ball
    expected = hits_of(vertices, faces)
    wide = np.zeros((len(vertices), 8), np.float32)
    wide[:, 2:5] = vertices
    odd = np.zeros(len(vertices), [("point", "f4", 3), ("tag", "u1")])
    odd["point"] = vertices
    for positions in (
        vertices.astype(np.float64),
        vertices.tolist(),
        np.asfortranarray(vertices),
        vertices.ravel(),
        array.array("f", vertices.ravel().tolist()),
        vertices.data,
        vertices.astype(">f4"),
        wide[:, 2:5],
        odd["point"],
        vertices[::-1].copy()[::-1],
    ):
        assert hits_of(positions, faces) == expected
    for indices in (
        faces.astype(np.int32),
        faces.astype(np.int64),
        faces.astype(np.uint16),
        faces.tolist(),
        faces.ravel(),
        np.asfortranarray(faces),
        faces[::-1].copy()[::-1],
    ):
        assert hits_of(vertices, indices) == expected
    assert hits_of(vertices[faces].reshape(-1, 3)) == expected
    assert hits_of(vertices[faces].reshape(-1, 3), None) == expected


def test_arrays_at_odd_addresses_are_read_right(ball: Mesh) -> None:
    vertices, faces = ball
    store = bytearray(vertices.nbytes + 1)
    odd = np.frombuffer(store, np.uint8)[1:].view(np.float32).reshape(-1, 3)
    odd[:] = vertices
    assert not odd.flags.aligned
    assert hits_of(odd, faces) == hits_of(vertices, faces)


def test_float32_is_read_where_it_lies() -> None:
    vertices, faces = sphere(400)
    table = np.zeros((len(vertices), 4), np.float32)
    table[:, :3] = vertices
    used = {}
    for name, positions in (
        ("float32", vertices),
        ("strided", table[:, :3]),
        ("float64", vertices.astype(np.float64)),
    ):
        tracemalloc.start()
        htree.build(positions, faces, "bvh-median").close()
        used[name] = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert used["float32"] < 200_000 and used["strided"] < 200_000
    assert used["float64"] > vertices.nbytes  # it is converted, so this can tell


def test_nothing_is_a_mesh_too() -> None:
    for positions, indices in (([], []), ([], None), (None, None), (np.zeros((0, 3)), [])):
        with htree.build(positions, indices) as tree:
            assert not tree.intersect(some_rays(5)).hit.any()
            assert np.isposinf(tree.bounds[0]).all() and np.isneginf(tree.bounds[1]).all()
            assert tree.view().nodes.size == 0
            assert "0 triangles" in repr(tree)


@pytest.mark.parametrize(
    ("positions", "indices", "error"),
    [
        ([[0, 0]], None, ValueError),
        (np.zeros((3, 4)), None, ValueError),
        (np.zeros(4), None, ValueError),
        (np.zeros((2, 3, 3)), None, ValueError),
        (np.zeros((4, 3)), None, ValueError),
        (np.zeros((3, 3), complex), None, TypeError),
        ([["a", "b", "c"]] * 3, None, TypeError),
        (5, None, ValueError),
        (np.zeros((3, 3)), [[0, 1]], ValueError),
        (np.zeros((3, 3)), [0, 1], ValueError),
        (np.zeros((3, 3)), [[0.0, 1.0, 2.0]], TypeError),
        (np.zeros((3, 3)), [[0, 1, -1]], OverflowError),
        (np.zeros((3, 3)), np.array([[0, 1, -1]], np.int32), OverflowError),
        (np.zeros((3, 3)), [[0, 1, 2**32]], OverflowError),
        (np.zeros((3, 3)), [[0, 1, 3]], htree.GeometryError),
        (np.zeros((3, 3)), [[0, 1, 3]], ValueError),
    ],
)
def test_what_is_no_mesh_is_refused(positions: Any, indices: Any, error: type[Exception]) -> None:
    with pytest.raises(error):
        htree.build(positions, indices)


def test_numbers_that_are_no_coordinates_are_skipped_and_counted() -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [math.nan, 0, 0], [1e300, 0, 0]])
    with htree.build(vertices, [[0, 1, 2], [0, 1, 3], [0, 1, 4], [0, 0, 1]]) as tree:
        assert (tree.stats.triangles, tree.stats.invalid, tree.stats.degenerate) == (4, 2, 1)
        hit = tree.intersect_one([0.25, 0.5, 1], [0, 0, -1])
        assert hit == htree.Hit(t=1, u=0.25, v=0.5, prim=0)


# ---- Options ------------------------------------------------------------------------------------


def test_options_have_the_librarys_defaults() -> None:
    options = htree.Options("ah")
    assert options.kind == "ah" and options.threads == 0 and options.buckets >= 2
    assert options == htree.Options(htree.Kind.AH) and hash(options) == hash(htree.Options("ah"))
    assert htree.Options().kind in [str(kind) for kind in htree.Kind]
    assert pickle.loads(pickle.dumps(options)) == options
    assert dataclasses.replace(options, threads=3).threads == 3


def test_options_reach_the_library(ball: Mesh) -> None:
    with htree.build(*ball, "h") as one, htree.build(*ball, htree.Options("h", buckets=2)) as other:
        assert one.stats.sah_cost != other.stats.sah_cost
    options = htree.Options("h", flags=htree.Flag.ANY_PLANES)
    with htree.build(*ball, options) as tree:
        assert tree.options.flags == htree.Flag.ANY_PLANES
        assert tree.kind == "h" and str(tree.kind) == "h"


def test_kinds_have_names_and_numbers() -> None:
    for kind in htree.Kind:
        assert htree.kind_name(htree.kind_from_name(kind)) == kind == str(kind)
    assert htree.kind_name(0) is None
    for name in ("", "H", "h\0", "no such kind", "\udcff"):
        assert htree.kind_from_name(name) == 0
        with pytest.raises(ValueError, match="no kind"):
            htree.Options(name)


def test_numbers_that_are_no_options_are_refused(ball: Mesh) -> None:
    with pytest.raises(OverflowError):
        htree.build(*ball, htree.Options("h", threads=-1))
    with pytest.raises(TypeError):
        htree.build(*ball, htree.Options("h", threads="all"))  # type: ignore[arg-type]
    with pytest.raises(htree.ArgumentError, match="buckets"):
        htree.build(*ball, htree.Options("h", buckets=1))


def test_calibrate_measures_costs() -> None:
    options = htree.calibrate(htree.Options("h", buckets=7))
    assert options.buckets == 7 and options.cost_skd == 1
    assert all(cost > 0 for cost in (options.cost_bv2, options.cost_bv6, options.cost_intersect))
    assert htree.calibrate("ah").kind == "ah"
