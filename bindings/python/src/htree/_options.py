# SPDX-License-Identifier: MIT
"""How to build: kinds, flags, options."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from enum import Enum, IntFlag
from typing import Any

from . import _hooks
from ._errors import check
from .raw import ffi, lib


def kind_name(kind: int) -> str | None:
    """ "h", "bvh-sah", "fast", ... or None for a number that is no kind."""
    name = lib.htree_kind_name(kind)
    return None if name == ffi.NULL else str(ffi.string(name).decode("ascii"))


def kind_from_name(name: str) -> int:
    """The number of a kind, 0 for a name that is none."""
    return int(lib.htree_kind_from_name(name.encode("utf-8", "replace").replace(b"\0", b"?")))


class Kind(str, Enum):
    """The structures, and three presets for those who do not want to choose. Each is the string
    that names it, and that string may stand wherever a kind is asked for."""

    UG = kind_name(lib.HTREE_UG)
    KD = kind_name(lib.HTREE_KD)
    BVH_MEDIAN = kind_name(lib.HTREE_BVH_MEDIAN)
    BVH_SAH = kind_name(lib.HTREE_BVH_SAH)
    SKD = kind_name(lib.HTREE_SKD)
    H = kind_name(lib.HTREE_H)
    AH = kind_name(lib.HTREE_AH)
    WIDE = kind_name(lib.HTREE_WIDE)
    FAST = kind_name(lib.HTREE_FAST)
    BALANCED = kind_name(lib.HTREE_BALANCED)
    BEST = kind_name(lib.HTREE_BEST)

    def __str__(self) -> str:
        return str(self.value)


class Flag(IntFlag):
    """Flags of Options. Those that are given take the place of a preset's own:
    `Options("best").flags | Flag.STRICT` adds one."""

    STRICT = lib.HTREE_STRICT
    ANY_PLANES = lib.HTREE_ANY_PLANES
    LOOSE_PLANES = lib.HTREE_LOOSE_PLANES
    MORTON = lib.HTREE_MORTON
    LAZY = lib.HTREE_LAZY
    COMPACT = lib.HTREE_COMPACT
    COLLAPSE = lib.HTREE_COLLAPSE


_DEFAULT: Any = None  # as htree_options_init has it
_HOOKS = ("tasks", "allocator")


@dataclass(frozen=True)
class Options:
    """How to build. What is not given has the library's default for the kind, and the kind of a
    preset is the one that the library puts in its place. See htree.h for every field.

    tasks       a function f(count, task) that calls task(i) once for every 0 <= i < count, on any
                threads, and returns when all are done; the library's own threads otherwise
    allocator   a C struct `htree_allocator` of htree.raw: no Python function may hand out memory
    """

    kind: str = Kind.BALANCED
    flags: int = _DEFAULT
    threads: int = _DEFAULT
    buckets: int = _DEFAULT
    axes: int = _DEFAULT
    cost_skd: float = _DEFAULT
    cost_bv2: float = _DEFAULT
    cost_bv6: float = _DEFAULT
    cost_intersect: float = _DEFAULT
    cells_per_prim: float = _DEFAULT
    few_prims: int = _DEFAULT
    tasks: _hooks.Tasks | None = None
    allocator: Any = None

    def __post_init__(self) -> None:
        defaults = _defaults(self.kind)
        object.__setattr__(self, "kind", Kind(kind_name(defaults.kind)))
        for field in fields(self):
            if field.name not in _HOOKS and getattr(self, field.name) is _DEFAULT:
                object.__setattr__(self, field.name, getattr(defaults, field.name))

    def to_c(self) -> tuple[Any, list[Any]]:
        """A C struct, and what must live as long as anything that is built with it."""
        made = _defaults(self.kind)
        keep: list[Any] = [self.allocator]
        for field in fields(self):
            if field.name != "kind" and field.name not in _HOOKS:
                setattr(made, field.name, getattr(self, field.name))
        if self.allocator is not None:
            made.allocator = self.allocator
        if self.tasks is not None:
            keep.append(_hooks.tasks_into(made.tasks, self.tasks))
        return made, keep


def _defaults(kind: str) -> Any:
    number = kind_from_name(kind)
    if number == 0:
        raise ValueError(f"no kind is called {str(kind)!r}")
    made = ffi.new("htree_options *")
    check(lib.htree_options_init(made, ffi.sizeof("htree_options"), number))
    return made


def options_of(options: Options | str) -> Options:
    """Options, or the defaults of the kind of that name."""
    return options if isinstance(options, Options) else Options(options)


def calibrate(options: Options | str = Kind.BALANCED) -> Options:
    """The options with the four costs as measured on this machine, in some milliseconds. What it
    finds depends on timing, and so will the tree."""
    options = options_of(options)
    made, _keep = options.to_c()
    _hooks.Call().run(lib.htree_calibrate, made)
    costs = ("cost_skd", "cost_bv2", "cost_bv6", "cost_intersect")
    return replace(options, **{name: getattr(made, name) for name in costs})
