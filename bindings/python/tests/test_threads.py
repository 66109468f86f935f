# SPDX-License-Identifier: MIT
"""Python threads: the GIL is free while the library works, and one tree serves all."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import numpy as np
from scenes import Mesh, some_rays, sphere

import htree


def turns_meanwhile(work: Callable[[], object]) -> int:
    """How often this thread gets to run while another does `work`."""
    begun, done = threading.Event(), threading.Event()

    def run() -> None:
        begun.set()
        work()
        done.set()

    thread = threading.Thread(target=run)
    thread.start()
    begun.wait()
    turns = 0
    while not done.is_set():
        time.sleep(0.001)
        turns += 1
    thread.join()
    return turns


def test_the_gil_is_free_during_queries_and_builds(ball: Mesh) -> None:
    rays = some_rays(400_000)
    points = np.random.default_rng(2).random((300_000, 3)).astype(np.float32)
    with htree.build(*ball) as tree:
        for work in (
            lambda: tree.intersect(rays, threads=1),
            lambda: tree.occluded(rays, threads=1),
            lambda: htree.build(points, options=htree.Options("h", threads=1)),
        ):
            started = time.perf_counter()
            turns = turns_meanwhile(work)
            took = time.perf_counter() - started
            assert turns > 5, f"{turns} turns in {took:.3f} s"


def test_many_threads_query_one_tree() -> None:
    with htree.build(*sphere(40)) as tree:
        rays = [some_rays(5000, seed) for seed in range(4)]
        expected = [tree.intersect(each, threads=1).t for each in rays]
        wrong: list[int] = []

        def query(index: int) -> None:
            for _ in range(20):
                if not np.array_equal(tree.intersect(rays[index]).t, expected[index]):
                    wrong.append(index)

        threads = [threading.Thread(target=query, args=(index,)) for index in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert not wrong


def test_texts_of_errors_belong_to_their_thread() -> None:
    texts: dict[int, set[str]] = {2: set(), 3: set()}

    def fail(corner: int) -> None:
        for _ in range(500):
            try:
                htree.build(np.zeros((2, 3)), [[0, 1, corner]])
            except htree.GeometryError as error:
                texts[corner].add(str(error))

    threads = [threading.Thread(target=fail, args=(corner,)) for corner in texts]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(texts[2]) == len(texts[3]) == 1 and texts[2] != texts[3]
