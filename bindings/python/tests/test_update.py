# SPDX-License-Identifier: MIT
"""Trees that are built by the rays that come, compact and collapsed ones, and trees that are brought
to another mesh."""

from __future__ import annotations

import gc
import itertools
import threading
import weakref
from functools import partial
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scenes import Mesh, some_rays, sphere

import htree

LAZY = htree.Options("wide", flags=htree.Flag.LAZY)
MORTON = htree.Options("wide", flags=htree.Flag.MORTON)


def bent(vertices: NDArray[np.float32]) -> NDArray[np.float32]:
    """Other positions for the same triangles."""
    made = vertices.copy()
    made[:, 0] += np.float32(0.3) * vertices[:, 1] * vertices[:, 2]
    return made


def answers(tree: htree.Tree, count: int = 3000) -> NDArray[Any]:
    out = np.empty(count, htree.hit_dtype)
    tree.intersect(some_rays(count), out=out)
    return out


def assert_answers_as(tree: htree.Tree, positions: Any, indices: Any) -> None:
    tree.check()
    with htree.build(positions, indices, "bvh-sah") as other:
        np.testing.assert_array_equal(answers(tree), answers(other))
        np.testing.assert_array_equal(tree.bounds, other.bounds)


# ---- Compact, collapsed -------------------------------------------------------------------------


def test_compact_trees_answer_alike_in_less_than_half_of_the_memory() -> None:
    vertices, faces = sphere(60)
    options = htree.Options("wide", flags=htree.Flag.COMPACT)
    with htree.build(vertices, faces, "wide") as whole:
        tree = htree.build(vertices, faces, options)
        assert 2 * tree.stats.bytes < whole.stats.bytes
    with pytest.raises(htree.Unsupported, match="compact"):
        tree.view()
    assert_answers_as(tree, vertices, faces)
    with htree.load(tree.save()) as back:
        assert_answers_as(back, vertices, faces)
    assert tree.update(bent(vertices), faces, "refit") == 1
    assert_answers_as(tree, bent(vertices), faces)
    lazily = htree.Options("wide", flags=htree.Flag.COMPACT | htree.Flag.LAZY)
    with pytest.raises(htree.ArgumentError, match="not both"):
        htree.build(vertices, faces, lazily)


def test_collapsed_trees_are_wide() -> None:
    vertices, faces = sphere(60)
    assert htree.Options("best").flags == htree.Flag.COLLAPSE
    for kind in ("bvh-median", "ah", "best"):
        collapsing = htree.Options(kind, flags=htree.Flag.COLLAPSE)
        with htree.build(vertices, faces, collapsing) as tree:
            assert tree.stats.kind == tree.kind == "wide"
            assert_answers_as(tree, vertices, faces)
        plain = htree.Options(kind, flags=0)
        with htree.build(vertices, faces, plain) as tree:
            assert tree.stats.kind == tree.kind == plain.kind


# ---- Lazy ---------------------------------------------------------------------------------------


def test_rays_build_a_lazy_tree_and_complete_builds_the_rest() -> None:
    vertices, faces = sphere(60)
    with htree.build(vertices, faces, LAZY) as tree, htree.build(vertices, faces, MORTON) as eager:
        subtrees = tree.stats.subtrees
        assert subtrees > 10 and tree.stats.subtrees_built == 0 == eager.stats.subtrees
        assert tree.intersect_one([3, 0.1, 0.1], [-1, 0, 0]) is not None
        assert 0 < tree.stats.subtrees_built < subtrees
        with pytest.raises(htree.Unsupported, match="htree_complete"):
            tree.view()
        assert_answers_as(tree, vertices, faces)
        tree.complete()
        assert tree.stats.subtrees == tree.stats.subtrees_built == 0
        np.testing.assert_array_equal(tree.view().nodes, eager.view().nodes)
        np.testing.assert_array_equal(tree.view().leaves, eager.view().leaves)
        tree.complete()
        assert_answers_as(tree, vertices, faces)


@pytest.mark.parametrize("ending", [htree.Tree.complete, htree.Tree.close])
def test_a_lazy_tree_keeps_the_arrays_until_it_is_complete_or_closed(ending: Any) -> None:
    vertices, faces = sphere(40)
    kept = weakref.ref(vertices), weakref.ref(faces)
    eager = htree.build(vertices, faces)
    tree = htree.build(vertices, faces, LAZY)
    del vertices, faces
    gc.collect()
    assert all(array() is not None for array in kept)
    ending(tree)
    assert all(array() is None for array in kept)
    eager.close()


def test_a_lazy_tree_keeps_copies_that_were_made_for_it() -> None:
    vertices, faces = sphere(60)
    tree = htree.build(vertices.tolist(), faces.astype(np.int64), LAZY)
    taken = [np.full(count, 0xFF, np.uint8) for count in (vertices.nbytes, faces.nbytes) * 20]
    assert_answers_as(tree, vertices, faces)
    del taken


def test_threads_meet_in_a_lazy_tree() -> None:
    vertices, faces = sphere(80)
    expected = answers(htree.build(vertices, faces), 20_000)
    for _ in range(5):
        tree = htree.build(vertices, faces, LAZY)
        wrong: list[int] = []

        def query(tree: htree.Tree = tree, wrong: list[int] = wrong) -> None:
            wrong.append(int((answers(tree, 20_000) != expected).sum()))

        threads = [threading.Thread(target=query) for _ in range(4)]
        for thread in threads:
            thread.start()
        tree.complete()
        for thread in threads:
            thread.join()
        assert wrong == [0] * 4


# ---- Update -------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [str(kind) for kind in htree.Kind])
def test_a_rebuilt_tree_answers_as_a_new_one(kind: str, ball: Mesh) -> None:
    with htree.build(*ball, kind) as tree:
        for vertices, faces in (sphere(9), ball, (bent(ball[0]), ball[1])):
            assert tree.update(vertices, faces, "rebuild") == 1
            assert tree.stats.triangles == len(faces)
            assert_answers_as(tree, vertices, faces)
        tree.update(None, [], htree.How.REBUILD)
        assert tree.stats.triangles == 0


@pytest.mark.parametrize("options", [htree.Options("wide"), MORTON, LAZY])
def test_a_refitted_tree_answers_as_a_new_one(options: htree.Options, ball: Mesh) -> None:
    vertices, faces = ball
    with htree.build(vertices, faces, options) as tree:
        assert tree.update(vertices, faces) == pytest.approx(1)
        for _ in range(3):
            vertices = bent(vertices)
            quality = tree.update(vertices, faces, htree.How.REFIT)
            assert (quality == 1) == (options is LAZY)  # which is built anew
            assert 0.2 < quality < 20
            assert_answers_as(tree, vertices, faces)


def test_refitting_keeps_the_nodes(ball: Mesh) -> None:
    with htree.build(*ball) as tree:
        before = tree.view().nodes.ctypes.data
        tree.update(bent(ball[0]), ball[1])
        assert tree.view().nodes.ctypes.data == before


def test_the_arrays_of_the_last_update_are_kept_by_a_lazy_tree() -> None:
    vertices, faces = sphere(40)
    others = bent(vertices)
    kept, next = weakref.ref(vertices), weakref.ref(others)
    tree = htree.build(vertices, faces, LAZY)
    del vertices
    with pytest.raises(htree.GeometryError):
        tree.update(others[:100], faces)
    assert kept() is not None
    tree.update(others, faces)
    assert kept() is None and tree.stats.subtrees > 0
    expected = others.copy()
    del others
    assert next() is not None
    assert_answers_as(tree, expected, faces)
    tree.complete()
    assert next() is None


def test_what_cannot_be_updated_leaves_the_tree_as_it_was(ball: Mesh) -> None:
    vertices, faces = ball
    with htree.build(vertices, faces) as tree:
        for positions, indices, how, error in (
            (vertices[:50], faces, "refit", htree.GeometryError),
            (vertices[:50], faces, "rebuild", htree.GeometryError),
            (vertices, faces[:, :2], "refit", ValueError),
            (vertices, faces, "recline", ValueError),
            (vertices, faces, 1, ValueError),
        ):
            with pytest.raises(error):
                tree.update(positions, indices, how)  # type: ignore[arg-type]
            assert_answers_as(tree, vertices, faces)


def test_objects_are_those_of_the_last_update() -> None:
    boxes = [[-1, -1, -1, 1, 1, 1]]
    tree = htree.build(None, None, objects=htree.Objects(boxes, lambda object, ray: (2, 0, 0)))
    for t, how in itertools.product((2.25, 2.5), ("refit", "rebuild")):

        class At:
            def __init__(self, t: float) -> None:
                self.t = t

            def __call__(self, object: int, ray: htree.Ray) -> tuple[float, float, float]:
                return self.t, 0, 0

        at = At(t)
        alive = weakref.ref(at)
        tree.update(None, None, how, objects=htree.Objects(boxes, at))
        del at
        gc.collect()
        assert alive() is not None
        assert tree.intersect_one([0, 0, 3], [0, 0, -1]) == htree.Hit(t, 0, 0, 0)
    tree.update(*sphere(4), "rebuild")
    gc.collect()
    assert alive() is None


# ---- One at a time ------------------------------------------------------------------------------


def test_views_keep_a_tree_from_changing(ball: Mesh) -> None:
    with htree.build(*ball) as tree:
        part = tree.view().nodes[5:]
        for how in htree.How:
            with pytest.raises(BufferError, match="view"):
                tree.update(*ball, how)
        del part
        tree.update(*ball)


def test_updates_and_queries_on_threads_wait_for_each_other(ball: Mesh) -> None:
    vertices, faces = ball
    forms = [vertices, bent(vertices)]
    expected = [answers(htree.build(form, faces), 20_000).tobytes() for form in forms]
    tree = htree.build(vertices, faces)
    wrong: list[int] = []
    done = threading.Event()

    def query() -> None:
        while not done.is_set():
            if answers(tree, 20_000).tobytes() not in expected:
                wrong.append(1)

    threads = [threading.Thread(target=query) for _ in range(3)]
    for thread in threads:
        thread.start()
    for index in range(60):
        tree.update(forms[index % 2], faces, ["refit", "rebuild"][index // 2 % 2])
    done.set()
    for thread in threads:
        thread.join()
    assert not wrong


def test_hooks_cannot_change_the_tree_that_is_queried(ball: Mesh) -> None:
    with htree.build(*ball) as tree:
        for change in (tree.complete, partial(tree.update, *ball)):
            report = partial(lambda change, fraction: change(), change)
            with pytest.raises(RuntimeError, match="hook"):
                tree.intersect(some_rays(100), progress=report)
        tree.update(*ball)


def test_hooks_cannot_use_the_tree_that_changes(ball: Mesh) -> None:
    used: list[htree.Tree] = []

    def tasks(count: int, task: Any) -> None:
        for tree in used:
            tree.check()

    with htree.build(*ball, htree.Options("wide", tasks=tasks)) as tree:
        used.append(tree)
        with pytest.raises(RuntimeError, match="hook"):
            tree.update(bent(ball[0]), ball[1], how="rebuild")
        used.clear()
        assert_answers_as(tree, bent(ball[0]), ball[1])
