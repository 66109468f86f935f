# SPDX-License-Identifier: MIT
"""Python functions that the library calls back. No exception crosses C: what a hook raises is kept
by the call that it happened in, ends that call as soon as may be, and is raised when it returns."""

from __future__ import annotations

import operator
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ._arrays import Array, rows
from ._errors import check
from .raw import ffi

Report = Callable[[float], object]
Tasks = Callable[[int, Callable[[int], None]], object]


class _Thread(threading.local):
    call: Call | None = None


_thread = _Thread()


class Call:
    """One call into the library."""

    def __init__(self, progress: Report | None = None) -> None:
        self.progress = progress
        self.handle: Any = None
        self.error: BaseException | None = None

    def run(self, function: Any, *arguments: Any) -> None:
        """Raises what a hook raised, else what the library says."""
        with self.here():
            status = function(*arguments)
        self.handle = None
        error, self.error = self.error, None
        if error is not None:
            try:
                raise error
            finally:
                del error  # or frame and traceback would hold each other
        check(status)

    @contextmanager
    def here(self) -> Iterator[None]:
        """Hooks that run on this thread belong to this call."""
        outer, _thread.call = _thread.call, self
        try:
            yield
        finally:
            _thread.call = outer

    def fail(self, error: BaseException) -> None:
        if self.error is None:
            self.error = error

    def report_into(self, hook: Any) -> None:
        """Writes a progress hook for this call into a C struct."""
        self.handle = ffi.new_handle(self)
        hook.report, hook.user = _report, self.handle


def _on_report(user: Any, fraction: float) -> int:
    call: Call = ffi.from_handle(user)
    try:
        return int(call.error is not None or bool(call.progress and call.progress(fraction)))
    except BaseException as error:
        call.fail(error)
        return 1


_report = ffi.callback("int32_t(void *, double)", _on_report, error=1)


# ---- Objects ------------------------------------------------------------------------------------


class Ray(NamedTuple):
    """A ray as an object's function sees it."""

    org: tuple[float, float, float]
    tmin: float
    dir: tuple[float, float, float]
    tmax: float


Intersect = Callable[[int, Ray], "tuple[float, float, float] | None"]


class Objects:
    """Objects of your own, known by box and function.

    boxes       (n, 6) or (n, 2, 3): lo and hi of boxes that contain the objects
    intersect   a function of (object, ray) that returns (t, u, v) at the smallest t with
                tmin <= t <= tmax, or None for a miss. Queries of a tree with such a function use
                one thread. Or a C function `htree_object_intersect`, which threads may share.
    user        the `user` of a C function
    """

    def __init__(self, boxes: ArrayLike, intersect: Intersect | Any, user: Any = None) -> None:
        array = np.asarray(boxes)
        if array.ndim == 3 and array.shape[1:] == (2, 3):
            array = array.reshape(-1, 6)
        self.boxes: Array = np.ascontiguousarray(rows(array, np.float32, 6, "boxes"))
        self.is_python = is_python_function(intersect)
        self.intersect = intersect
        self.user = user

    def to_c(self) -> tuple[Any, list[Any]]:
        """A C struct, and what must live as long as a tree that knows of it."""
        made = ffi.new("htree_objects *")
        made.boxes = ffi.cast("htree_box *", self.boxes.ctypes.data)
        made.count = len(self.boxes)
        return made, [self, intersect_into(made, self.intersect, self.user)]


def is_python_function(intersect: Intersect | Any) -> bool:
    """Whether it is one; else it is a C function. Anything else is refused."""
    if isinstance(intersect, ffi.CData):
        return False
    if not callable(intersect):
        raise TypeError("intersect must be a function")
    return True


def intersect_into(made: Any, intersect: Intersect | Any, user: Any = None) -> Any:
    """Writes `intersect` and `user` into a C struct; what it returns must live as long."""
    if is_python_function(intersect):
        user = ffi.new_handle(intersect)
        made.intersect, made.user = _intersect, user
    else:
        made.intersect, made.user = intersect, ffi.NULL if user is None else user
    return user


def _on_intersect(user: Any, object: int, ray: Any, hit: Any) -> int:
    call = _thread.call
    if call is not None and call.error is not None:
        return 0
    try:
        found = ffi.from_handle(user)(
            object, Ray(tuple(ray.org), ray.tmin, tuple(ray.dir), ray.tmax)
        )
        if found is None:
            return 0
        hit.t, hit.u, hit.v = found
        return 1
    except BaseException as error:
        if call is None:
            raise
        call.fail(error)
        return 0


_intersect = ffi.callback("int32_t(void *, uint32_t, htree_ray *, htree_hit *)", _on_intersect)


# ---- Tasks --------------------------------------------------------------------------------------


class _Batch:
    """The tasks of one parallel loop. The library goes on when the hook returns, so whatever the
    hook did or raised, each task has run once by then, and none is begun after."""

    def __init__(self, count: int, task: Any, data: Any, call: Call) -> None:
        self.task, self.data, self.call = task, data, call
        self.waiting = set(range(count))
        self.running = 0
        self.finished = False
        self.changed = threading.Condition()

    def __call__(self, index: int) -> None:
        index = operator.index(index)
        with self.changed:
            if index not in self.waiting:
                raise ValueError(f"task {index!r} is none of this batch, or was begun before")
            self.waiting.remove(index)
            self.running += 1
        try:
            with self.call.here():
                self.task(self.data, index)
        finally:
            with self.changed:
                self.running -= 1
                self.changed.notify_all()

    def finish(self) -> None:
        while True:
            with self.changed:
                if not self.waiting:
                    self.changed.wait_for(lambda: self.running == 0)
                    self.finished = True
                    return
                index = next(iter(self.waiting))
            with suppress(ValueError):  # another thread was quicker
                self(index)


def _on_run(user: Any, count: int, task: Any, data: Any) -> None:
    call = _thread.call or Call()
    batch = _Batch(count, task, data, call)
    try:
        ffi.from_handle(user)(count, batch)
    except BaseException as error:
        call.fail(error)
    while not batch.finished:
        try:
            batch.finish()
        except BaseException as error:  # an interrupt: the library may go on no sooner for it
            call.fail(error)


_run = ffi.callback("void(void *, uint32_t, void(*)(void *, uint32_t), void *)", _on_run)


def tasks_into(hook: Any, run: Tasks) -> Any:
    """Writes a tasks hook into a C struct; what it returns must live as long as the hook."""
    handle = ffi.new_handle(run)
    hook.run, hook.user = _run, handle
    return handle
