# SPDX-License-Identifier: MIT
"""Memory of a tree: who may use it, and what must live as long."""

from __future__ import annotations

import threading
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._mesh import Mesh
from .raw import ffi, lib


class Owner:
    """Memory of a tree. It goes when the last of its users does: the Tree until it is closed, every
    call while it runs, every array of a view. So close never has to wait. What changes the tree
    waits for the calls that read it, and they for it."""

    def __init__(self, pointer: Any, hooks: list[Any], mesh: Mesh) -> None:
        self.pointer = pointer
        self.views: weakref.WeakSet[Memory] = weakref.WeakSet()
        self._kept = {"hooks": hooks, "mesh": mesh}
        self._changed = threading.Condition()
        self._readers: list[int] = []  # the thread of each call that runs
        self._writer: int | None = None
        # Not at exit: daemon threads may still be in a query, and the system takes memory back.
        weakref.finalize(self, _free, pointer, self._kept).atexit = False

    @property
    def mesh(self) -> Mesh:
        """What the tree was made of last, as far as it still refers to it."""
        mesh: Mesh = self._kept["mesh"]  # type: ignore[assignment]
        return mesh

    @mesh.setter
    def mesh(self, mesh: Mesh) -> None:
        self._kept["mesh"] = mesh

    @contextmanager
    def shared(self) -> Iterator[None]:
        """For a call that leaves the tree as it is."""
        me = threading.get_ident()
        with self._changed:
            self._wait(lambda: self._writer is None, self._writer == me)
            self._readers.append(me)
        try:
            yield
        finally:
            with self._changed:
                self._readers.remove(me)
                self._changed.notify_all()

    @contextmanager
    def alone(self) -> Iterator[None]:
        """For a call that changes the tree."""
        me = threading.get_ident()
        with self._changed:
            self._wait(
                lambda: self._writer is None and not self._readers,
                self._writer == me or me in self._readers,
            )
            self._writer = me
        try:
            yield
        finally:
            with self._changed:
                self._writer = None
                self._changed.notify_all()

    def _wait(self, ready: Callable[[], bool], never: bool) -> None:
        if never:
            raise RuntimeError("a hook cannot use the tree that its call changes, nor change it")
        self._changed.wait_for(ready)


def _free(pointer: Any, kept: dict[str, Any]) -> None:
    lib.htree_free(pointer)
    kept.clear()


class Memory:
    """Bytes of a tree as numpy sees them: read-only, and holding the tree's memory."""

    def __init__(self, owner: Owner, address: Any, count: int, kind: str) -> None:
        self.owner = owner
        start = int(ffi.cast("uintptr_t", address))
        self.__array_interface__ = {
            "version": 3, "shape": (count,), "typestr": kind, "data": (start, True)
        }  # fmt: skip
        owner.views.add(self)

    @classmethod
    def array(cls, owner: Owner, address: Any, count: int, kind: str) -> NDArray[Any]:
        if count == 0 or address == ffi.NULL:
            return np.frombuffer(b"", kind)
        return np.asarray(cls(owner, address, count, kind))
