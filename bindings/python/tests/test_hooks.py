# SPDX-License-Identifier: MIT
"""Hooks: progress and tasks in Python, memory in C."""

from __future__ import annotations

import gc
import os
import signal
import threading
import time
import weakref
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from typing import Any

import numpy as np
import pytest
from scenes import Mesh, some_rays, sphere

import htree
from htree._hooks import Call, _Batch
from htree.raw import ffi

SOUP = np.random.default_rng(5).random((60_000, 3)).astype(np.float32)


class Stop(Exception):
    """What a hook of these tests raises."""


# ---- Progress -----------------------------------------------------------------------------------
#
# On one thread: with more, how much of a batch the reporting thread gets is the system's choice.


def test_progress_rises_on_the_calling_thread(tree: htree.Tree) -> None:
    seen: list[float] = []
    threads = set()

    def report(fraction: float) -> None:
        seen.append(fraction)
        threads.add(threading.get_ident())

    htree.build(SOUP, options="ah", progress=report)
    assert len(seen) > 3 and seen == sorted(seen) and min(seen) >= 0 and max(seen) <= 1
    seen.clear()
    tree.intersect(some_rays(50_000), progress=report, threads=1)
    assert len(seen) > 3 and seen == sorted(seen) and min(seen) >= 0 and max(seen) <= 1
    assert threads == {threading.get_ident()}


def test_progress_can_stop_a_call_at_any_report(tree: htree.Tree) -> None:
    rays = some_rays(50_000)
    for stop_at in (1, 2, 5):
        for call in (
            lambda hook: htree.build(SOUP, options=htree.Options(threads=1), progress=hook),
            lambda hook: tree.intersect(rays, progress=hook, threads=1),
            lambda hook: tree.occluded(rays, progress=hook, threads=1),
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
        lambda: tree.intersect(rays, progress=hook, threads=1),
        lambda: tree.occluded(rays, progress=hook, threads=1),
    ):
        count = 0
        with pytest.raises(Stop) as caught:
            call()
        assert count == 1 and caught.value.args[0] >= 0
    assert tree.intersect(rays).hit.any()


def test_control_c_ends_a_query_that_reports(tree: htree.Tree) -> None:
    def hook(fraction: float) -> None:
        os.kill(os.getpid(), signal.SIGINT)

    # A shell's background jobs ignore it.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            tree.intersect(some_rays(50_000), progress=hook, threads=1)
    finally:
        signal.signal(signal.SIGINT, before)


def test_a_hook_may_query(tree: htree.Tree) -> None:
    rays = some_rays(5000)
    inner: list[bool] = []

    def hook(fraction: float) -> None:
        inner.append(tree.intersect(rays[:3], progress=lambda fraction: None).t.shape == (3,))

    tree.intersect(rays, progress=hook, threads=1)
    assert inner and all(inner)


def test_hooks_are_let_go(ball: Mesh, tree: htree.Tree) -> None:
    class Hook:
        def __init__(self, fails: bool) -> None:
            self.fails = fails

        def __call__(self, fraction: float) -> None:
            if self.fails:
                raise Stop

    for fails in (False, True):
        hook = Hook(fails)
        alive = weakref.ref(hook)
        with suppress(Stop):
            tree.intersect(some_rays(5000), progress=hook, threads=1)
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


def test_threads_of_the_options_hold_for_queries(ball: Mesh) -> None:
    calls: list[int] = []

    def run(count: int, task: Callable[[int], None]) -> None:
        calls.append(count)

    with htree.build(*ball, htree.Options("h", threads=1, tasks=run)) as own:
        own.intersect(some_rays(20_000))
        own.occluded(some_rays(20_000), progress=lambda fraction: None)
        assert not calls
        own.intersect(some_rays(20_000), threads=0)
        assert calls


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


def test_what_is_no_task_takes_none_away(ball: Mesh, tree: htree.Tree) -> None:
    def run(count: int, task: Callable[[Any], None]) -> None:
        for index in range(count):
            for wrong in (float(index), str(index), None):
                with pytest.raises(TypeError):
                    task(wrong)

    rays = some_rays(20_000)
    with htree.build(*ball, htree.Options("h", tasks=run)) as own:
        np.testing.assert_array_equal(own.intersect(rays).prim, tree.intersect(rays).prim)


def test_a_task_that_runs_elsewhere_is_waited_for() -> None:
    begun = threading.Event()
    done: list[int] = []

    def slow(data: object, index: int) -> None:
        begun.set()
        time.sleep(0.2)
        done.append(index)

    batch = _Batch(1, slow, None, Call())
    thread = threading.Thread(target=batch, args=(0,))
    thread.start()
    begun.wait()
    batch.finish()
    assert done == [0]
    thread.join()


def test_what_tasks_raise_is_raised(ball: Mesh) -> None:
    def run(count: int, task: Callable[[int], None]) -> None:
        task(0)
        raise Stop

    with htree.build(*ball, htree.Options("h", tasks=run)) as own:
        with pytest.raises(Stop):
            own.intersect(some_rays(20_000))
        assert own.intersect(some_rays(100)).hit.any()  # too few to be cut into tasks


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


def test_an_error_at_any_report_leaves_no_memory() -> None:
    ledger = Ledger()
    options = htree.Options("h", threads=1, allocator=ledger.hook[0])
    built = False
    for stop_at in range(1, 1000):
        reports = iter(range(1, 1000))

        def hook(fraction: float, last: int = stop_at, reports: Any = reports) -> None:
            if next(reports) == last:
                raise Stop

        with suppress(Stop):
            htree.build(SOUP[:9000], None, options, progress=hook).close()
            built = True
        assert not ledger.live
        if built:
            break
    assert built and stop_at > 10


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
