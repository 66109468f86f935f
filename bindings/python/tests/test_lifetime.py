# SPDX-License-Identifier: MIT
"""Trees end once, in any order, and take their memory with them."""

from __future__ import annotations

import copy
import gc
import itertools
import os
import pickle
import sys
import threading
import time
import weakref
from typing import Any

import numpy as np
import pytest
from scenes import Mesh, some_rays, sphere

import htree

MESH = ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])


def resident_pages() -> int:
    with open("/proc/self/statm", encoding="ascii") as statm:
        return int(statm.read().split()[1])


def test_close_is_harmless_again_and_use_after_it_is_an_error() -> None:
    tree = htree.build(*MESH)
    tree.stats  # known before, refused after  # noqa: B018
    assert not tree.closed
    tree.close()
    tree.close()
    assert tree.closed and repr(tree) == "<htree.Tree closed>"
    for use in (
        lambda: tree.intersect([0, 0, 1], [0, 0, -1]),
        lambda: tree.occluded([0, 0, 1], [0, 0, -1]),
        lambda: tree.intersect_one([0, 0, 1], [0, 0, -1]),
        lambda: tree.occluded_one([0, 0, 1], [0, 0, -1]),
        lambda: tree.bounds,
        lambda: tree.stats,
        tree.view,
        tree.check,
        tree.complete,
        lambda: tree.update(*MESH),
        tree.__enter__,
    ):
        with pytest.raises(ValueError, match="closed"):
            use()


def test_a_with_block_closes_also_after_an_error() -> None:
    with pytest.raises(KeyError), htree.build(*MESH) as tree:
        raise KeyError
    assert tree.closed


def test_every_order_of_ends() -> None:
    for order in itertools.permutations(range(4)):
        trees = [htree.build(*MESH) for _ in range(3)]
        ends: list[Any] = [trees[0].view().nodes, *trees]
        expected = ends[0].copy()
        del trees
        for index in order:
            if isinstance(ends[index], htree.Tree):
                ends[index].close()
            else:
                np.testing.assert_array_equal(ends[index], expected)
            ends[index] = None


def test_views_outlive_close_and_cannot_be_written(ball: Mesh) -> None:
    tree = htree.build(*ball, "h")
    view = tree.view()
    alive = weakref.ref(tree._open())
    before = view.nodes.copy()
    tree.close()
    gc.collect()
    trees = [htree.build(*ball, "h") for _ in range(20)]  # would take the memory if it were free
    np.testing.assert_array_equal(view.nodes, before)
    assert alive() is not None
    for array in (view.triangles, view.nodes, view.leaves):
        assert not array.flags.writeable
        with pytest.raises(ValueError, match="WRITEABLE"):
            array.flags.writeable = True
    part = view.triangles[3:4, 1]
    del view, array, trees
    assert alive() is not None
    del part
    assert alive() is None


def test_a_view_is_the_mesh(ball: Mesh) -> None:
    vertices, faces = ball
    with htree.build(*ball, "bvh-sah") as tree:
        view = tree.view()
        np.testing.assert_array_equal(view.triangles, vertices[faces])
        np.testing.assert_array_equal(view.bounds, tree.bounds)
        assert view.kind == "bvh-sah" and view.triangle_count == view.prims == len(faces)
        assert view.object_count == 0 and 0 < view.stack == tree.stats.stack
        # lib/tree/layout.h: 32 bytes a node, lo and child, hi and tag; the root holds everything.
        nodes = view.nodes.view([("lo", "f4", 3), ("child", "u4"), ("hi", "f4", 3), ("tag", "u4")])
        assert len(nodes) == tree.stats.nodes
        assert (nodes["lo"][0] <= view.bounds[0]).all() and (nodes["hi"][0] >= view.bounds[1]).all()
    with htree.build(*ball, "ug") as tree:
        assert tree.view().grid.size and tree.view().leaves.size
    with htree.build(*ball, "wide") as tree:
        assert tree.view().triangles.shape == (0, 3, 3) and tree.view().leaves.size


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="needs /proc")
def test_a_hundred_thousand_trees_leave_nothing() -> None:
    def churn(count: int) -> None:
        for index in range(count):
            tree = htree.build(*MESH)
            if index % 2:
                tree.close()
            if index % 10 == 0:
                loop: list[Any] = [tree]
                loop.append(loop)  # only the collector finds it

    churn(5_000)
    gc.collect()
    before, handles = resident_pages(), len(weakref.finalize._registry)  # type: ignore[attr-defined]
    churn(100_000)
    gc.collect()
    assert len(weakref.finalize._registry) == handles  # type: ignore[attr-defined]
    grown = (resident_pages() - before) * os.sysconf("SC_PAGE_SIZE")
    assert grown < 8 << 20, f"{grown} bytes; a tree is {htree.build(*MESH).stats.bytes}"


def test_a_finaliser_frees_at_once_where_references_are_counted() -> None:
    if sys.implementation.name != "cpython":
        pytest.skip("no reference counts")
    tree = htree.build(*MESH)
    alive = weakref.ref(tree._open())
    del tree
    assert alive() is None


def test_closing_during_queries_waits_for_them() -> None:
    vertices, faces = sphere(60)
    rays = some_rays(60_000)
    expected = htree.build(vertices, faces).intersect(rays).t
    for _ in range(10):
        tree = htree.build(vertices, faces)
        answers: list[Any] = []
        errors: list[Exception] = []

        def query(tree: htree.Tree = tree, answers: Any = answers, errors: Any = errors) -> None:
            try:
                while True:
                    answers.append(tree.intersect(rays, threads=1).t)
            except ValueError as closed:
                errors.append(closed)

        threads = [threading.Thread(target=query) for _ in range(3)]
        for thread in threads:
            thread.start()
        time.sleep(0.03)
        tree.close()
        for thread in threads:
            thread.join()
        assert len(errors) == 3 and all("closed" in str(error) for error in errors)
        for answer in answers:
            np.testing.assert_array_equal(answer, expected)


def test_trees_cannot_be_pickled_or_copied(tree: htree.Tree) -> None:
    for copying in (pickle.dumps, copy.copy, copy.deepcopy):
        with pytest.raises(TypeError, match="build it again"):
            copying(tree)


def test_repr_tells_what_it_is(tree: htree.Tree) -> None:
    text = repr(tree)
    assert text.startswith(f"<htree.Tree {tree.kind}: {tree.stats.triangles:,} triangles, ")
    assert f"depth {tree.stats.depth}" in text


def test_errors_can_be_pickled() -> None:
    with pytest.raises(htree.GeometryError) as caught:
        htree.build(MESH[0], [[0, 1, 7]])
    error = pickle.loads(pickle.dumps(caught.value))
    assert type(error) is htree.GeometryError and error.code == htree.Status.GEOMETRY
    assert str(error) == str(caught.value) == htree.error_text()
    assert str(htree.Error(6)) == htree.status_name(6)


def test_errors_are_pythons_own_too() -> None:
    assert issubclass(htree.ArgumentError, ValueError)
    assert issubclass(htree.GeometryError, ValueError)
    assert issubclass(htree.OutOfMemory, MemoryError)
    assert issubclass(htree.LimitError, OverflowError)
    assert issubclass(htree.Unsupported, NotImplementedError)
    from htree._errors import _ERRORS, check

    assert _ERRORS.keys() == set(htree.Status) - {htree.Status.OK}
    for status, kind in _ERRORS.items():
        with pytest.raises(kind) as caught:
            check(status)
        assert isinstance(caught.value, htree.Error) and caught.value.code == status
    check(htree.Status.OK)
    with pytest.raises(htree.Error) as caught:
        check(1000)
    assert type(caught.value) is htree.Error
