# SPDX-License-Identifier: MIT
"""Rays in every shape that Python has for them, and what comes back."""

from __future__ import annotations

import ctypes
import tracemalloc
from typing import Any

import numpy as np
import pytest
from scenes import Mesh, some_rays

import htree


def test_rays_in_any_form_give_the_same_hits(tree: htree.Tree) -> None:
    rays = some_rays(1000)
    plain = rays.view(np.float32).reshape(-1, 8)
    expected = tree.intersect(rays)
    assert expected.hit.any() and not expected.hit.all()
    records = (CRay * len(rays)).from_buffer(rays.data)
    for form in (
        plain,
        plain.astype(np.float64),
        plain.tolist(),
        np.asfortranarray(plain),
        np.repeat(rays, 2)[::2],
        rays.data,
        records,
    ):
        hits = tree.intersect(form)
        for field, other in zip(hits, expected, strict=True):
            np.testing.assert_array_equal(field, other)
    hits = tree.intersect(rays["org"], rays["dir"].astype(np.float64))
    np.testing.assert_array_equal(hits.t, expected.t)
    np.testing.assert_array_equal(tree.occluded(rays), expected.hit)


class CRay(ctypes.Structure):
    _fields_ = (
        ("org", ctypes.c_float * 3),
        ("tmin", ctypes.c_float),
        ("dir", ctypes.c_float * 3),
        ("tmax", ctypes.c_float),
    )


def test_answers_have_the_shape_of_the_rays(tree: htree.Tree) -> None:
    rays = some_rays(24)
    flat = tree.intersect(rays)
    grid = tree.intersect(rays.reshape(2, 3, 4))
    assert grid.t.shape == grid.prim.shape == (2, 3, 4)
    np.testing.assert_array_equal(grid.t.ravel(), flat.t)
    assert tree.occluded(rays.reshape(4, 6)).shape == (4, 6)
    assert tree.intersect(rays[0]).t.shape == ()
    assert tree.intersect(rays[:0]).t.shape == (0,)
    assert tree.intersect(np.zeros((0, 3)), np.zeros((0, 3))).prim.dtype == np.uint32
    # One origin, many directions, an interval each.
    hits = tree.intersect([0, 0, 3], rays["dir"].reshape(4, 6, 3), tmin=np.zeros((4, 1)), tmax=9)
    assert hits.t.shape == (4, 6)


def test_hits_are_views_of_one_array(tree: htree.Tree) -> None:
    out = np.empty(9, htree.hit_dtype)
    hits = tree.intersect(some_rays(9), out=out)
    assert all(np.shares_memory(field, out) for field in hits)
    fresh = tree.intersect(some_rays(9))
    assert fresh.t.base is fresh.prim.base
    np.testing.assert_array_equal(out["t"], fresh.t)
    t, u, v, prim = fresh
    assert t.dtype == u.dtype == v.dtype == np.float32 and prim.dtype == np.uint32


def test_hits_are_right(ball: Mesh, tree: htree.Tree) -> None:
    vertices, faces = ball
    rays = some_rays(500)
    hits = tree.intersect(rays)
    a, b, c = (vertices[faces[hits.prim[hits.hit]]].astype(np.float64)[:, i] for i in range(3))
    u, v = hits.u[hits.hit, None], hits.v[hits.hit, None]
    on_triangle = (1 - u - v) * a + u * b + v * c
    on_ray = rays["org"][hits.hit] + hits.t[hits.hit, None] * rays["dir"][hits.hit]
    np.testing.assert_allclose(on_triangle, on_ray, atol=2e-6)
    np.testing.assert_array_equal(hits.prim[~hits.hit], htree.NONE)
    assert np.isposinf(hits.t[~hits.hit]).all()


def test_intervals_are_kept(tree: htree.Tree) -> None:
    first = tree.intersect_one([0, 0.1, 3], [0, 0, -1])
    assert first is not None and 1.9 < first.t < 2.1
    second = tree.intersect_one([0, 0.1, 3], [0, 0, -1], tmin=first.t + 0.1)
    assert second is not None and 3.9 < second.t < 4.1 and second.prim != first.prim
    assert tree.intersect_one([0, 0.1, 3], [0, 0, -1], tmax=first.t) == first
    assert tree.intersect_one([0, 0.1, 3], [0, 0, -1], tmax=1.5) is None
    assert tree.occluded_one([0, 0.1, 3], [0, 0, -1]) is True
    assert tree.occluded_one([0, 0.1, 3], [0, 0, 1]) is False
    assert type(first.t) is float and type(first.prim) is int


def test_rays_and_hits_in_place_are_not_copied(tree: htree.Tree) -> None:
    rays = some_rays(200_000)
    out = np.empty(len(rays), htree.hit_dtype)
    flags = np.empty(len(rays), bool)
    used = {}
    for name, given in (
        ("float32", rays),
        ("float64", rays.view("f4").reshape(-1, 8).astype(float)),
    ):
        tracemalloc.start()
        tree.intersect(given, out=out)
        tree.occluded(given, out=flags)
        used[name] = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert used["float32"] < 100_000
    assert used["float64"] >= rays.nbytes  # it is converted, so this can tell


def test_out_is_filled(tree: htree.Tree) -> None:
    rays = some_rays(50)
    expected = tree.intersect(rays).hit
    for dtype in (bool, np.uint8):
        out = np.full(50, 1, dtype)
        assert tree.occluded(rays, out=out) is out
        np.testing.assert_array_equal(out.astype(bool), expected)


def readonly() -> Any:
    out = np.empty(4, htree.hit_dtype)
    out.flags.writeable = False
    return out


@pytest.mark.parametrize(
    ("out", "error"),
    [
        (np.empty(3, htree.hit_dtype), ValueError),
        (np.empty((2, 2), htree.hit_dtype), ValueError),
        (np.empty(8, htree.hit_dtype)[::2], ValueError),
        (np.frombuffer(bytearray(66), np.uint8)[2:].view(htree.hit_dtype), ValueError),
        (readonly(), ValueError),
        (np.empty((4, 4), np.float32), TypeError),
        (bytearray(64), TypeError),
    ],
)
def test_an_out_that_cannot_take_the_hits_is_refused(
    tree: htree.Tree, out: Any, error: type[Exception]
) -> None:
    if isinstance(out, np.ndarray) and out.flags.owndata is False and out.ctypes.data % 4 == 0:
        assert not out.flags.c_contiguous
    with pytest.raises(error):
        tree.intersect(some_rays(4), out=out)


def test_rays_and_hits_may_not_overlap(tree: htree.Tree) -> None:
    store = np.zeros(256, np.uint8)
    rays = store[:128].view(htree.ray_dtype)
    out = store[64:128].view(htree.hit_dtype)
    with pytest.raises(ValueError, match="overlap"):
        tree.intersect(rays, out=out)


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ((np.zeros((4, 7)),), TypeError),
        ((np.zeros(4, htree.hit_dtype),), TypeError),
        ((np.zeros(4, htree.ray_dtype.newbyteorder()),), TypeError),
        (("rays",), TypeError),
        ((3,), TypeError),
        ((np.zeros((4, 3)), np.zeros((5, 3))), ValueError),
        ((np.zeros((4, 2)), np.zeros((4, 2))), ValueError),
        ((np.zeros((4, 3), complex), np.zeros((4, 3))), TypeError),
        ((np.zeros((4, 3)), "up"), TypeError),
    ],
)
def test_what_are_no_rays_is_refused(
    tree: htree.Tree, arguments: tuple[Any, ...], error: type[Exception]
) -> None:
    for method in (tree.intersect, tree.occluded):
        with pytest.raises(error):
            method(*arguments)


def test_other_bad_arguments_are_refused(tree: htree.Tree) -> None:
    rays = some_rays(4)
    with pytest.raises(TypeError, match="tmin"):
        tree.intersect(rays, tmin=1)
    with pytest.raises(OverflowError):
        tree.intersect(rays, threads=-1)
    with pytest.raises(ValueError, match="batches"):
        tree.intersect_one(rays["org"], rays["dir"])
    with pytest.raises(ValueError, match="batches"):
        tree.occluded_one(rays["org"], rays["dir"])
    with pytest.raises(TypeError):
        tree.intersect(rays, counters=np.zeros(4, np.uint32))
    with pytest.raises(ValueError, match="counters"):
        tree.intersect(rays, counters=np.zeros(5, htree.counters_dtype))


def test_rays_with_strange_numbers_miss(tree: htree.Tree) -> None:
    rays = some_rays(6)
    rays["org"][0, 0] = rays["dir"][1, 1] = rays["tmax"][2] = rays["tmin"][3] = np.nan
    rays["dir"][4] = 0
    rays["org"][5] = np.inf
    assert not tree.intersect(rays).hit.any()
    assert not tree.intersect(np.full((2, 3), 1e300), [0, 0, 1]).hit.any()


def test_counters_count(tree: htree.Tree) -> None:
    rays = some_rays(300)
    counters = np.zeros(len(rays), htree.counters_dtype)
    hits = tree.intersect(rays, counters=counters)
    assert (counters["traversal_steps"] >= counters["leaf_steps"]).all()
    assert (counters["intersections"][hits.hit] >= 1).all()
    np.testing.assert_array_equal(hits.t, tree.intersect(rays).t)
    tree.occluded(rays, counters=counters)
    assert (counters["intersections"][hits.hit] >= 1).all()


def test_threads_change_nothing(tree: htree.Tree) -> None:
    rays = some_rays(20_000)
    expected = tree.intersect(rays, threads=1)
    for threads in (0, 2, 7):
        np.testing.assert_array_equal(tree.intersect(rays, threads=threads).t, expected.t)
