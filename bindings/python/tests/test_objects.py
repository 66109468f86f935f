# SPDX-License-Identifier: MIT
"""Objects of one's own, in Python and in C."""

from __future__ import annotations

import gc
import math
import threading
import time
import weakref
from typing import Any

import numpy as np
import pytest

import htree
from htree.raw import ffi


class Stop(Exception):
    """What an object of these tests raises."""


def ball_at(centre: list[float], ray: htree.Ray) -> tuple[float, float, float] | None:
    """A sphere of radius 1."""
    o = [ray.org[i] - centre[i] for i in range(3)]
    a = sum(d * d for d in ray.dir)
    b = sum(o[i] * ray.dir[i] for i in range(3))
    under = b * b - a * (sum(x * x for x in o) - 1)
    if under < 0:
        return None
    for t in ((-b - math.sqrt(under)) / a, (-b + math.sqrt(under)) / a):
        if ray.tmin <= t <= ray.tmax:
            return t, 0.25, 0.5
    return None


CENTRES = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]]
BOXES = [[[c[0] - 1, -1, -1], [c[0] + 1, 1, 1]] for c in CENTRES]


def test_objects_are_hit_among_triangles() -> None:
    objects = htree.Objects(BOXES, lambda index, ray: ball_at(CENTRES[index], ray))
    wall = [[-9, -9, -2], [9, -9, -2], [0, 9, -2]]
    with htree.build(wall, [[0, 1, 2]], objects=objects) as tree:
        assert tree.stats.objects == 2 and "2 objects" in repr(tree)
        first = tree.intersect_one([0, 0, 9], [0, 0, -1])
        assert first == (8, 0.25, 0.5, 1)
        assert tree.intersect_one([3, 0, 9], [0, 0, -2]) == (4, 0.25, 0.5, 2)
        wall_hit = tree.intersect_one([1.5, 0, 9], [0, 0, -1])
        assert wall_hit is not None and (wall_hit.t, wall_hit.prim) == (11, 0)
        origins = np.array([[0, 0, 9], [3, 0, 9], [1.5, 0, 9], [0, 99, 9]])
        hits = tree.intersect(origins, [0, 0, -1], threads=0)
        assert hits.prim.tolist() == [1, 2, 0, htree.NONE]
        assert tree.occluded([3, 0, 9], [0, 0, -1], tmax=9)
    with htree.build(None, objects=objects, options="bvh-sah") as tree:
        assert tree.intersect_one([3, 0, 9], [0, 0, -1]) == (8, 0.25, 0.5, 1)


def test_what_an_object_raises_ends_the_query_and_is_raised() -> None:
    calls = 0

    def intersect(index: int, ray: htree.Ray) -> None:
        nonlocal calls
        calls += 1
        raise Stop

    with htree.build(None, objects=htree.Objects(BOXES, intersect)) as tree:
        rays = np.tile([[0, 0, 9, 0, 0, 0, -1, np.inf]], (5000, 1))
        for query in (tree.intersect, tree.occluded):
            calls = 0
            with pytest.raises(Stop):
                query(rays, threads=0)
            assert calls == 1


def test_objects_in_python_are_asked_on_the_calling_thread() -> None:
    threads = set()

    def intersect(index: int, ray: htree.Ray) -> None:
        threads.add(threading.get_ident())
        time.sleep(1e-5)  # another thread would get its turn

    with htree.build(None, objects=htree.Objects(BOXES, intersect)) as tree:
        rays = np.tile([[0, 0, 9, 0, 0, 0, -1, np.inf]], (3000, 1))
        assert not tree.occluded(rays, threads=0).any()
    assert threads == {threading.get_ident()}


def test_an_object_may_query_and_raise_after_it(tree: htree.Tree) -> None:
    answers: list[bool] = []

    def intersect(index: int, ray: htree.Ray) -> None:
        if answers:
            raise Stop
        answers.append(tree.occluded_one(ray.org, ray.dir))

    with (
        htree.build(None, objects=htree.Objects(BOXES, intersect)) as outer,
        pytest.raises(Stop),
    ):
        outer.intersect_one([-9, 0, 0], [1, 0, 0])
    assert answers == [True]


def test_nothing_is_reported_after_an_error() -> None:
    events: list[str] = []

    def intersect(index: int, ray: htree.Ray) -> None:
        events.append("raise")
        raise Stop

    with htree.build(None, objects=htree.Objects(BOXES, intersect)) as tree:
        rays = np.zeros(50_000, htree.ray_dtype)
        rays["org"], rays["dir"], rays["tmax"] = [0, 99, 9], [0, 0, -1], np.inf
        rays["org"][20_000:, 1] = 0
        with pytest.raises(Stop):
            tree.intersect(rays, progress=lambda fraction: events.append("report"))
    assert events.count("raise") == 1 and events[0] == "report" and events[-1] == "raise"


@pytest.mark.parametrize("answer", [7, (1.0, 2.0), ("t", "u", "v"), (1, 2, 3, 4)])
def test_what_is_no_hit_is_an_error(answer: Any) -> None:
    with htree.build(None, objects=htree.Objects(BOXES, lambda index, ray: answer)) as tree:
        with pytest.raises((TypeError, ValueError)):
            tree.intersect_one([0, 0, 9], [0, 0, -1])


def test_queries_of_objects_on_many_threads_keep_their_errors_apart() -> None:
    def intersect(index: int, ray: htree.Ray) -> tuple[float, float, float] | None:
        if ray.org[0] > 2:
            raise Stop(threading.get_ident())
        return ball_at(CENTRES[index], ray)

    outcomes: list[bool] = []
    with htree.build(None, objects=htree.Objects(BOXES, intersect)) as tree:

        def query(fails: bool) -> None:
            for _ in range(50):
                try:
                    hits = tree.intersect(np.tile([3.0 * fails, 0, 9], (20, 1)), [0, 0, -1])
                    outcomes.append(not fails and bool((hits.t == 8).all()))
                except Stop as error:
                    outcomes.append(fails and error.args[0] == threading.get_ident())

        threads = [threading.Thread(target=query, args=(bool(i % 2),)) for i in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert len(outcomes) == 200 and all(outcomes)


def test_an_object_may_be_a_c_function() -> None:
    calls: list[int] = []

    @ffi.callback("htree_object_intersect")  # type: ignore[untyped-decorator, unused-ignore]
    def intersect(user: Any, index: int, ray: Any, hit: Any) -> int:
        calls.append(index)
        hit.t = ffi.from_handle(user)
        return 1

    number = ffi.new_handle(2.5)
    with htree.build(None, objects=htree.Objects(BOXES, intersect, number)) as tree:
        hits = tree.intersect(np.tile([[0, 0, 9, 0, 0, 0, -1, np.inf]], (5000, 1)), threads=0)
        assert (hits.t == 2.5).all() and (hits.prim == 0).all() and len(calls) == 5000


def test_objects_that_are_none_are_refused() -> None:
    with pytest.raises(TypeError, match="function"):
        htree.Objects(BOXES, "sphere")
    with pytest.raises(ValueError, match="boxes"):
        htree.Objects([[0, 0, 0]], ball_at)


def test_objects_live_as_long_as_their_tree() -> None:
    class Intersect:
        def __call__(self, index: int, ray: htree.Ray) -> tuple[float, float, float] | None:
            return ball_at(CENTRES[index], ray)

    function = Intersect()
    alive = weakref.ref(function)
    tree = htree.build(None, objects=htree.Objects(BOXES, function))
    del function
    gc.collect()
    assert alive() is not None and tree.occluded_one([0, 0, 9], [0, 0, -1])
    tree.close()
    gc.collect()
    assert alive() is None
