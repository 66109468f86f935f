# SPDX-License-Identifier: MIT
"""Trees: built from a mesh, queried by rays, closed by their owner."""

from __future__ import annotations

import math
from enum import Enum
from mmap import mmap
from types import TracebackType
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _hooks
from ._errors import check
from ._mesh import Mesh
from ._options import Flag, Kind, Options, options_of
from ._owner import Owner
from ._values import Hit, Hits, Stats, View, box_array, stats_of, view_of
from .raw import ffi, lib

class How(str, Enum):
    """How `Tree.update` brings a tree to a mesh: that string may stand for it, too."""

    REBUILD = "rebuild"  # as htree.build would, in the memory of the builds before
    REFIT = "refit"  # wide: the same nodes around the new positions

    def __str__(self) -> str:
        return str(self.value)


_HOW = {How.REBUILD: lib.HTREE_REBUILD, How.REFIT: lib.HTREE_REFIT}


class Tree:
    """A tree, from `htree.build`. Any number of threads may query it; queries release the GIL. Only
    `update` and `complete` change it: they wait for the queries that run, and queries for them."""

    def __init__(self, owner: Owner, options: Options) -> None:
        self._owner: Owner | None = owner
        self._stats: Stats | None = None
        self.options = options

    # ---- Life -----------------------------------------------------------------------------------

    def close(self) -> None:
        """Frees the tree, once no query runs on it and no view is left. Again is harmless."""
        self._owner = None

    @property
    def closed(self) -> bool:
        return self._owner is None

    def _open(self) -> Owner:
        owner = self._owner
        if owner is None:
            raise ValueError("the tree is closed")
        return owner

    def __enter__(self) -> Tree:
        self._open()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def __reduce__(self) -> NoReturn:
        raise TypeError("a Tree cannot be pickled or copied: save it, or build it again")

    def __repr__(self) -> str:
        if self.closed:
            return "<htree.Tree closed>"
        s = self.stats
        objects = f" and {s.objects:,} objects" if s.objects else ""
        return (
            f"<htree.Tree {s.kind}: {s.triangles:,} triangles{objects}, {s.nodes:,} nodes, "
            f"depth {s.depth}, {s.bytes / 1024:,.1f} KiB, built in {s.build_seconds * 1e3:.3g} ms>"
        )

    # ---- Change ---------------------------------------------------------------------------------

    @property
    def _is_lazy(self) -> bool:
        return bool(self.options.flags & Flag.LAZY)

    def complete(self) -> None:
        """Builds what rays have not reached yet of a tree with htree.Flag.LAZY, and lets the arrays
        of its mesh go. Does nothing to any other tree. Hits are the same before and after."""
        owner = self._open()
        with owner.alone():
            _hooks.Call().run(lib.htree_complete, owner.pointer)
            owner.mesh.drop_arrays()

    def update(
        self,
        positions: ArrayLike | None,
        indices: ArrayLike | None = None,
        how: str = How.REFIT,
        *,
        objects: _hooks.Objects | None = None,
    ) -> float:
        """Brings the tree to new positions, or to another mesh, with the options that it was built
        with; a failure leaves it as it was. Refitting is for the same triangles, and rebuilds
        where it cannot do: see htree_update. Views must be gone, or it is a BufferError.

        Returns the expected cost of a ray over that when the tree was built: 1 after a rebuild;
        from about 1.5 on rebuilding pays.
        """
        owner = self._open()
        mesh = Mesh(positions, indices, objects)
        quality = ffi.new("double *", math.nan)  # written where the tree has changed
        number = _HOW[How(how)]
        with owner.alone():
            if owner.views:
                raise BufferError("a view of the tree is in use: update would change its arrays")
            try:
                _hooks.Call().run(lib.htree_update, owner.pointer, mesh.c, number, quality)
            finally:
                if not math.isnan(quality[0]):
                    self._stats = None
                    owner.mesh = mesh
                    if not self._is_lazy:
                        mesh.drop_arrays()
        return float(quality[0])

    # ---- Query ----------------------------------------------------------------------------------

    def intersect(
        self,
        rays: ArrayLike,
        directions: ArrayLike | None = None,
        *,
        tmin: ArrayLike | None = None,
        tmax: ArrayLike | None = None,
        out: NDArray[Any] | None = None,
        threads: int | None = None,
        counters: NDArray[Any] | None = None,
        progress: _hooks.Report | None = None,
    ) -> Hits:
        """The closest hit of every ray.

        rays, directions   an array of htree.ray_dtype or of (..., 8) float32, used as it is; or
                           origins and directions, (..., 3) each, which broadcast, with tmin
                           (default 0) and tmax (default infinity)
        out                an array of htree.hit_dtype for the hits, in the shape of the rays
        threads            0 all cores, 1 this thread, n at most n; default: as the tree was built
        counters           an array of htree.counters_dtype, for what each ray cost
        progress           a function of a fraction; the query stops when it returns true, and
                           htree.Cancelled or whatever it raised is raised
        """
        array = _arrays.rays(rays, directions, tmin, tmax)
        hits = _arrays.answers(out, [_arrays.hit_dtype], array.shape, "out")
        address = _arrays.pointer("htree_hit *", hits)
        self._query(lib.htree_intersect, array, hits, address, threads, counters, progress)
        return Hits(hits["t"], hits["u"], hits["v"], hits["prim"])

    def occluded(
        self,
        rays: ArrayLike,
        directions: ArrayLike | None = None,
        *,
        tmin: ArrayLike | None = None,
        tmax: ArrayLike | None = None,
        out: NDArray[Any] | None = None,
        threads: int | None = None,
        counters: NDArray[Any] | None = None,
        progress: _hooks.Report | None = None,
    ) -> NDArray[np.bool_]:
        """Whether each ray hits anything. As `intersect`, and faster; `out` is of bool or uint8."""
        array = _arrays.rays(rays, directions, tmin, tmax)
        answers = _arrays.answers(out, [np.dtype(bool), np.dtype("u1")], array.shape, "out")
        address = _arrays.pointer("uint8_t *", answers)
        self._query(lib.htree_occluded, array, answers, address, threads, counters, progress)
        return answers

    def intersect_one(
        self, org: ArrayLike, dir: ArrayLike, tmin: float = 0.0, tmax: float = np.inf
    ) -> Hit | None:
        """The closest hit of one ray, or None. A batch is much faster than many of these."""
        hits = self.intersect(org, dir, tmin=tmin, tmax=tmax)
        if hits.prim.shape != ():
            raise ValueError("org and dir must be of three numbers: intersect takes batches")
        if not hits.hit:
            return None
        return Hit(float(hits.t), float(hits.u), float(hits.v), int(hits.prim))

    def occluded_one(
        self, org: ArrayLike, dir: ArrayLike, tmin: float = 0.0, tmax: float = np.inf
    ) -> bool:
        """Whether one ray hits anything."""
        answer = self.occluded(org, dir, tmin=tmin, tmax=tmax)
        if answer.shape != ():
            raise ValueError("org and dir must be of three numbers: occluded takes batches")
        return bool(answer)

    def _query(
        self,
        function: Any,
        rays: NDArray[Any],
        answers: NDArray[Any],
        address: Any,
        threads: int | None,
        counters: NDArray[Any] | None,
        progress: _hooks.Report | None,
    ) -> None:
        owner = self._open()
        if np.may_share_memory(rays, answers):
            raise ValueError("rays and out overlap")
        call = _hooks.Call(progress)
        query = ffi.new("htree_query *")
        check(lib.htree_query_init(query, ffi.sizeof("htree_query")))
        query.threads = self.options.threads if threads is None else threads
        if counters is not None:
            _arrays.answers(counters, [_arrays.counters_dtype], rays.shape, "counters")
            query.counters = _arrays.pointer("htree_counters *", counters)
        start = _arrays.pointer("htree_ray *", rays)
        with owner.shared():
            if owner.mesh.one_thread:
                query.threads = 1
            if progress is not None or owner.mesh.one_thread:
                call.report_into(query.progress)
            call.run(function, owner.pointer, start, rays.size, address, query)

    # ---- Files ----------------------------------------------------------------------------------

    def save(self) -> bytes:
        """The tree as bytes, for `htree.load`. Objects are saved as their boxes."""
        owner = self._open()
        size = ffi.new("uint64_t *")
        with owner.shared():
            check(lib.htree_save(owner.pointer, ffi.NULL, 0, size))
            file = bytearray(size[0])
            check(lib.htree_save(owner.pointer, ffi.from_buffer(file), len(file), size))
        return bytes(file)

    # ---- Inspect --------------------------------------------------------------------------------

    @property
    def kind(self) -> str:
        """The structure that the tree is: "wide" for a collapsed one."""
        return self.stats.kind

    @property
    def stats(self) -> Stats:
        """What the tree is made of. Walks the tree once, a lazy one every time."""
        owner = self._open()
        with owner.shared():
            if self._stats is not None:
                return self._stats
            stats = stats_of(owner)
            if stats.subtrees == 0:
                self._stats = stats
            return stats

    @property
    def bounds(self) -> NDArray[np.float32]:
        """(2, 3): lo and hi of everything that can be hit; +inf and -inf if there is nothing."""
        owner = self._open()
        box = ffi.new("htree_box *")
        with owner.shared():
            check(lib.htree_get_bounds(owner.pointer, box))
        return box_array(box)

    def view(self) -> View:
        """The arrays of the tree itself, without a copy. A lazy tree has some once it is complete,
        a compact one never: that is htree.Unsupported."""
        owner = self._open()
        with owner.shared():
            return view_of(owner)

    def check(self) -> None:
        """Proves the structure; raises htree.CorruptError where it cannot."""
        owner = self._open()
        with owner.shared():
            check(lib.htree_check(owner.pointer))


def build(
    positions: ArrayLike | None,
    indices: ArrayLike | None = None,
    options: Options | str = Kind.BALANCED,
    *,
    objects: _hooks.Objects | None = None,
    progress: _hooks.Report | None = None,
) -> Tree:
    """Builds a tree over triangles and objects. It keeps no reference to the arrays, but with
    htree.Flag.LAZY: then it reads them until `Tree.complete`, and they must not change before.

    positions   (n, 3): vertices. float32 is read where it lies, also with space between the rows
    indices     (m, 3): vertices of each triangle; None: every three vertices are a triangle
    options     htree.Options or the name of a kind
    objects     objects of your own; object j is prim m + j
    progress    a function of a fraction; the build stops when it returns true, and
                htree.Cancelled or whatever it raised is raised
    """
    options = options_of(options)
    mesh = Mesh(positions, indices, objects)
    settings, hooks = options.to_c()
    call = _hooks.Call(progress)
    if progress is not None:
        call.report_into(settings.progress)
    out = ffi.new("htree **")
    try:
        call.run(lib.htree_build, out, mesh.c, settings)
    except BaseException:
        lib.htree_free(out[0])  # there is one where a hook raised and the library went on
        raise
    tree = Tree(Owner(out[0], hooks, mesh), options)
    if not tree._is_lazy:
        mesh.drop_arrays()
    return tree


def load(
    file: bytes | bytearray | memoryview | mmap | NDArray[np.uint8],
    *,
    threads: int = 0,
    intersect: _hooks.Intersect | Any = None,
    user: Any = None,
    borrow: bool = False,
) -> Tree:
    """The tree that `Tree.save` wrote: the same hits. Whatever the bytes are, what is returned has
    been proved; htree.CorruptError says that they are no tree.

    file        bytes, or anything with a buffer of bytes
    threads     of queries: 0 all cores, 1 this thread, n at most n
    intersect   of a tree with objects: as in htree.Objects, and so is `user`
    borrow      refer to the bytes, a mapped file's perhaps, instead of copying them. They lie at a
                multiple of 64, stay as they are, and are kept alive by the tree
    """
    made = ffi.new("htree_load_options *")
    check(lib.htree_load_options_init(made, ffi.sizeof("htree_load_options")))
    made.threads = threads
    made.flags = lib.HTREE_BORROW if borrow else 0
    hooks: list[Any] = []
    mesh = Mesh(None, None, None)
    if intersect is not None:
        mesh.refer(_hooks.intersect_into(made, intersect, user), intersect)
    data = ffi.from_buffer(file)
    if borrow:
        hooks.append(data)
    out = ffi.new("htree **")
    _hooks.Call().run(lib.htree_load, out, data, len(data), made)
    owner = Owner(out[0], hooks, mesh)
    options = Options(Kind(stats_of(owner).kind), threads=threads)
    return Tree(owner, options)
