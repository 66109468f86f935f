# SPDX-License-Identifier: MIT
"""Python functions that the library calls: progress, tasks, objects; and memory, from C."""

from __future__ import annotations

import gc
import math
import os
import signal
import threading
import time
import weakref
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from scenes import Mesh, some_rays, sphere

import htree
from htree.raw import ffi

SOUP = np.random.default_rng(5).random((60_000, 3)).astype(np.float32)


class Stop(Exception):
    """What a hook of these tests raises."""


# ---- Progress -----------------------------------------------------------------------------------


def test_progress_rises_on_the_calling_thread(tree: htree.Tree) -> None:
    seen: list[float] = []
    threads = set()

    def report(fraction: float) -> None:
        seen.append(fraction)
        threads.add(threading.get_ident())

    htree.build(SOUP, options="ah", progress=report)
    assert len(seen) > 3 and seen == sorted(seen) and 0 <= seen[0] and seen[-1] <= 1
    seen.clear()
    tree.intersect(some_rays(50_000), progress=report)
    assert len(seen) > 3 and seen == sorted(seen) and 0 <= seen[0] and seen[-1] <= 1
    assert threads == {threading.get_ident()}


def test_progress_can_stop_a_call_at_any_report(tree: htree.Tree) -> None:
    rays = some_rays(50_000)
    for stop_at in (1, 2, 5):
        for call in (
            lambda hook: htree.build(SOUP, progress=hook),
            lambda hook: tree.intersect(rays, progress=hook),
            lambda hook: tree.occluded(rays, progress=hook),
        ):
            seen: list[float] = []

            def hook(fraction: float, seen: list[float] = seen, last: int = stop_at) -> bool:
                seen.append(fraction)
                return len(seen) == last

            with pytest.raises(htree.Cancelled) as caught:
                call(hook)
            assert caught.value.code == htree.Status.CANCELLED and len(seen) == stop_at


def test_what_progress_raises_ends_the_call_and_is_raised(tree: htree.Tree) -> None:
    rays = some_rays(50_000)
    count = 0

    def hook(fraction: float) -> None:
        nonlocal count
        count += 1
        raise Stop(fraction)

    for call in (
        lambda: htree.build(SOUP, progress=hook),
        lambda: tree.intersect(rays, progress=hook),
        lambda: tree.occluded(rays, progress=hook),
    ):
        count = 0
        with pytest.raises(Stop) as caught:
            call()
        assert count == 1 and caught.value.args[0] >= 0
    assert tree.intersect(rays).hit.any()


def test_control_c_ends_a_query_that_reports(tree: htree.Tree) -> None:
    def hook(fraction: float) -> None:
        os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        tree.intersect(some_rays(200_000), progress=hook)


def test_a_hook_may_query(tree: htree.Tree) -> None:
    rays = some_rays(5000)
    inner: list[bool] = []

    def hook(fraction: float) -> None:
        inner.append(tree.intersect(rays[:3], progress=lambda fraction: None).t.shape == (3,))

    tree.intersect(rays, progress=hook)
    assert inner and all(inner)


def test_hooks_are_let_go(ball: Mesh, tree: htree.Tree) -> None:
    class Hook:
        def __call__(self, fraction: float) -> None:
            if fails:
                raise Stop

    for fails in (False, True):
        hook = Hook()
        alive = weakref.ref(hook)
        try:
            tree.intersect(some_rays(5000), progress=hook)
        except Stop:
            pass
        del hook
        gc.collect()
        assert alive() is None


# ---- Tasks --------------------------------------------------------------------------------------


def in_pool(count: int, task: Callable[[int], None]) -> None:
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(task, range(count)))


def test_a_pool_of_python_threads_runs_the_tasks(ball: Mesh, tree: htree.Tree) -> None:
    calls: list[int] = []

    def run(count: int, task: Callable[[int], None]) -> None:
        calls.append(count)
        in_pool(count, task)

    rays = some_rays(20_000)
    with htree.build(*ball, htree.Options("h", tasks=run)) as own:
        np.testing.assert_array_equal(own.intersect(rays).prim, tree.intersect(rays).prim)
        assert calls and max(calls) > 10
        calls.clear()
        own.intersect(rays, threads=1)
        assert not calls


@pytest.mark.parametrize(
    "run",
    [
        lambda count, task: None,
        lambda count, task: [task(index) for index in range(0, count, 2)],
        lambda count, task: [task(index) for index in reversed(range(count))],
        lambda count, task: threading.Thread(
            target=lambda: [task(index) for index in range(count // 2)]
        ).start(),
    ],
    ids=["none", "half", "backwards", "left behind"],
)
def test_every_task_runs_once_whatever_the_hook_does(
    ball: Mesh, tree: htree.Tree, run: Any, recwarn: Any
) -> None:
    threading.excepthook, before = lambda arguments: None, threading.excepthook
    try:
        rays = some_rays(20_000)
        with htree.build(*ball, htree.Options("h", tasks=run)) as own:
            for _ in range(5):
                np.testing.assert_array_equal(own.intersect(rays).prim, tree.intersect(rays).prim)
        time.sleep(0.05)
    finally:
        threading.excepthook = before


def test_tasks_of_another_time_are_refused(ball: Mesh) -> None:
    kept: list[Callable[[int], None]] = []

    def run(count: int, task: Callable[[int], None]) -> None:
        kept.append(task)
        task(0)
        for wrong in (0, count, -1):
            with pytest.raises(ValueError, match="task"):
                task(wrong)

    with htree.build(*ball, htree.Options("h", tasks=run)) as own:
        own.intersect(some_rays(20_000))
    assert kept
    with pytest.raises(ValueError, match="begun before"):
        kept[0](1)


def test_what_tasks_raise_is_raised(ball: Mesh) -> None:
    def run(count: int, task: Callable[[int], None]) -> None:
        task(0)
        raise Stop

    with htree.build(*ball, htree.Options("h", tasks=run)) as own:
        with pytest.raises(Stop):
            own.intersect(some_rays(20_000))
        assert own.intersect(some_rays(100)).hit.any()  # too few to be cut into tasks


# ---- Objects ------------------------------------------------------------------------------------


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
        hits = tree.intersect([[0, 0, 9], [3, 0, 9], [1.5, 0, 9], [0, 99, 9]], [0, 0, -1], threads=0)
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
                    hits = tree.intersect([[3.0 * fails, 0, 9]] * 20, [0, 0, -1])
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


# ---- Memory -------------------------------------------------------------------------------------


class Ledger:
    """An allocator that keeps books, and fails after `limit` allocations."""

    def __init__(self, limit: int = 10**9) -> None:
        self.live: dict[int, Any] = {}
        self.limit = limit
        self.hook = ffi.new("htree_allocator *")
        self.functions = (
            ffi.callback("void *(void *, uint64_t, uint64_t)", self.allocate),
            ffi.callback("void(void *, void *, uint64_t)", self.release),
        )
        self.hook.allocate, self.hook.release = self.functions

    def allocate(self, user: Any, size: int, alignment: int) -> Any:
        if self.limit == 0:
            return ffi.NULL
        self.limit -= 1
        block = ffi.new("char[]", size + alignment)
        start = int(ffi.cast("uintptr_t", block))
        start += -start % alignment
        self.live[start] = block, size
        return ffi.cast("void *", start)

    def release(self, user: Any, memory: Any, size: int) -> None:
        _block, given = self.live.pop(int(ffi.cast("uintptr_t", memory)))
        assert given == size


def test_memory_comes_from_the_allocator_and_goes_back() -> None:
    vertices, faces = sphere(8)
    ledger = Ledger()
    options = htree.Options("h", threads=1, allocator=ledger.hook[0])
    tree = htree.build(vertices, faces, options)
    assert ledger.live
    assert sum(size for _, size in ledger.live.values()) <= tree.stats.peak_bytes
    tree.close()
    assert not ledger.live


def test_an_allocator_may_fail_at_any_time() -> None:
    vertices, faces = sphere(8)
    for limit in range(100):
        ledger = Ledger(limit)
        options = htree.Options("h", threads=1, allocator=ledger.hook[0])
        try:
            htree.build(vertices, faces, options).close()
            break
        except MemoryError as error:
            assert isinstance(error, htree.OutOfMemory)
        assert not ledger.live
    assert limit > 1 and not ledger.live
