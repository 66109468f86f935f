# SPDX-License-Identifier: MIT
"""Every scene of the conformance file, bit for bit, and every misuse that it names."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scenes import some_rays

import htree
from htree.raw import ffi, lib

U32 = np.uint32


def floats(bits: list[int], *shape: int) -> NDArray[np.float32]:
    return np.array(bits, U32).view(np.float32).reshape(shape)


def test_hits_are_the_same_bits_for_every_kind_and_thread_count(
    conformance: dict[str, Any],
) -> None:
    assert conformance["kinds"] and conformance["scenes"]
    for scene in conformance["scenes"]:
        positions = floats(scene["positions"], -1, 3)
        indices = scene["indices"]
        corners = None if indices is None else np.array(indices, U32).reshape(-1, 3)
        rays = floats(scene["rays"], -1, 8)
        expected = np.array(scene["hits"], U32).reshape(-1, 4)
        occluded = np.array(scene["occluded"], bool)
        assert len(rays) == len(expected) == len(occluded) > 0
        for kind in conformance["kinds"]:
            with htree.build(positions, corners, kind) as tree:
                for threads in (1, 0):
                    where = f"{scene['name']}, {kind}, {threads} threads"
                    out = np.empty(len(rays), htree.hit_dtype)
                    tree.intersect(rays, out=out, threads=threads)
                    np.testing.assert_array_equal(out.view(U32).reshape(-1, 4), expected, where)
                    answers = tree.occluded(rays, threads=threads)
                    np.testing.assert_array_equal(answers, occluded, where)
                bounds = floats(scene["bounds"], 2, 3)
                np.testing.assert_array_equal(tree.bounds.view(U32), bounds.view(U32))
                stats = tree.stats
                assert {name: getattr(stats, name) for name in scene["stats"]} == scene["stats"]
                tree.check()


def assert_answers(scene: dict[str, Any], tree: htree.Tree) -> None:
    rays = floats(scene["rays"], -1, 8)
    out = np.empty(len(rays), htree.hit_dtype)
    tree.check()
    tree.intersect(rays, out=out)
    np.testing.assert_array_equal(out.view(U32), np.array(scene["hits"], U32), scene["name"])
    np.testing.assert_array_equal(tree.occluded(rays), np.array(scene["occluded"], bool))


def mesh_of(scene: dict[str, Any]) -> tuple[NDArray[np.float32], NDArray[U32] | None]:
    indices = scene["indices"]
    return floats(scene["positions"], -1, 3), None if indices is None else np.array(indices, U32)


def test_lazy_trees_and_complete_ones_give_the_same_bits(conformance: dict[str, Any]) -> None:
    for scene in conformance["scenes"]:
        options = htree.Options("wide", flags=htree.Flag.LAZY)
        with htree.build(*mesh_of(scene), options) as tree:
            assert_answers(scene, tree)
            tree.complete()
            assert_answers(scene, tree)


def test_a_tree_that_goes_from_scene_to_scene_gives_the_same_bits(
    conformance: dict[str, Any],
) -> None:
    for kind in conformance["kinds"]:
        with htree.build(None, [], kind) as tree:
            for scene in conformance["scenes"]:
                for how in ("rebuild", "refit"):
                    tree.update(*mesh_of(scene), how)
                    assert_answers(scene, tree)


def test_statuses_are_those_of_the_library(conformance: dict[str, Any]) -> None:
    assert {status.name: int(status) for status in htree.Status} == conformance["statuses"]
    for number, name in conformance["status_names"].items():
        assert htree.status_name(int(number)) == name


def test_the_library_is_the_one_that_the_file_is_about(conformance: dict[str, Any]) -> None:
    assert ".".join(map(str, htree.lib_version())) == conformance["library"]


# ---- Misuse -------------------------------------------------------------------------------------

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
FACE = np.array([[0, 1, 2]], U32)


def build_with(**changes: Any) -> Callable[[], object]:
    return lambda: htree.build(CORNERS, FACE, htree.Options("h", **changes))


def strict_nan() -> None:
    corners = CORNERS.copy()
    corners[1, 1] = np.nan
    htree.build(corners, FACE, htree.Options("h", flags=htree.Flag.STRICT))


def cancelled_query() -> None:
    with htree.build(CORNERS, FACE) as tree:
        tree.intersect(some_rays(100_000), progress=lambda fraction: True, threads=1)


def cancelled_build() -> None:
    points = np.random.default_rng(1).random((30_000, 3))
    htree.build(points, progress=lambda fraction: True)


# The rest cannot be said with arrays and keywords: it is said to the raw layer.

THREE_POINTS = ffi.new("float[9]", CORNERS.ravel().tolist())


def raw_call(name: str, *arguments: object) -> Callable[[], object]:
    def call() -> None:
        from htree._errors import check

        check(getattr(lib, name)(*arguments))

    return call


def raw_build(out: bool = True, mesh: bool = True, kind: int = 0, **fields: int) -> Any:
    values = {"positions": THREE_POINTS, "vertex_count": 3, "triangle_count": 1, **fields}
    if not values["positions"]:
        values["positions"] = ffi.NULL
    described = ffi.new("htree_mesh *", values)
    options = ffi.new("htree_options *")
    lib.htree_options_init(options, ffi.sizeof("htree_options"), lib.HTREE_H)
    options.kind = kind or lib.HTREE_H
    pointer = ffi.new("htree **")
    call = raw_call(
        "htree_build", pointer if out else ffi.NULL, described if mesh else ffi.NULL, options
    )

    def checked() -> None:
        try:
            call()
        finally:
            assert pointer[0] == ffi.NULL

    return checked


def raw_query(rays: bool = True, hits: bool = True, tree: bool = True, flags: int = 0) -> Any:
    def call() -> None:
        ray, hit = ffi.new("htree_ray *"), ffi.new("htree_hit *")
        query = ffi.new("htree_query *")
        lib.htree_query_init(query, ffi.sizeof("htree_query"))
        query.flags = flags
        with htree.build(CORNERS, FACE) as made:
            owner = made._open()
            raw_call(
                "htree_intersect",
                owner.pointer if tree else ffi.NULL,
                ray if rays else ffi.NULL,
                1,
                hit if hits else ffi.NULL,
                query,
            )()

    return call


def lazy_view() -> None:
    points = np.random.default_rng(1).random((9000, 3))
    htree.build(points, options=htree.Options("wide", flags=htree.Flag.LAZY)).view()


def raw_update(how: int, mesh: bool = True) -> Any:
    def call() -> None:
        described = ffi.new("htree_mesh *")
        with htree.build(CORNERS, FACE) as made:
            pointer = made._open().pointer
            raw_call("htree_update", pointer, described if mesh else ffi.NULL, how, ffi.NULL)()

    return call


def raw_size(function: str, struct: str) -> Any:
    def call() -> None:
        with htree.build(CORNERS, FACE) as made:
            raw_call(function, made._open().pointer, ffi.new(struct))()

    return call


MISUSE: dict[str, Callable[[], object]] = {
    "build-index-out-of-range": lambda: htree.build(CORNERS, [[0, 1, 3]]),
    "build-strict-nan": strict_nan,
    "build-kind-unknown": raw_build(kind=99),
    "build-buckets-1": build_with(buckets=1),
    "build-axes-2": build_with(axes=2),
    "build-flags-unknown": build_with(flags=0x80000000),
    "build-cost-nan": build_with(cost_bv2=float("nan")),
    "build-cost-zero": build_with(cost_intersect=0.0),
    "build-cells-huge": build_with(cells_per_prim=1e9),
    "build-few-prims-0": build_with(few_prims=0),
    "build-stride-8": raw_build(position_stride=8),
    "build-too-few-vertices": raw_build(triangle_count=2),
    "build-positions-null": raw_build(positions=0),
    "build-cancelled": cancelled_build,
    "query-cancelled": cancelled_query,
    "query-flags-unknown": raw_query(flags=1),
    "options-size-0": raw_call("htree_options_init", ffi.new("htree_options *"), 0, 6),
    "query-size-0": raw_call("htree_query_init", ffi.new("htree_query *"), 0),
    "stats-size-0": raw_size("htree_get_stats", "htree_stats *"),
    "view-size-0": raw_size("htree_get_view", "htree_view *"),
    "view-lazy": lazy_view,
    "update-how-3": raw_update(3),
    "update-index-out-of-range": lambda: htree.build(CORNERS, FACE).update(CORNERS, [[0, 1, 3]]),
    "update-mesh-null": raw_update(lib.HTREE_REFIT, mesh=False),
    "complete-null": raw_call("htree_complete", ffi.NULL),
    "rays-null": raw_query(rays=False),
    "hits-null": raw_query(hits=False),
    "tree-null": raw_query(tree=False),
    "out-null": raw_build(out=False),
    "mesh-null": raw_build(mesh=False),
}


def outcome(call: Callable[[], object]) -> str:
    """The status that a call ends with; it comes with its name and a sentence."""
    try:
        call()
    except htree.Error as error:
        assert error.name == htree.status_name(error.code)
        assert str(error) == error.text != ""
        return htree.Status(error.code).name
    return "OK"


def test_every_misuse_is_refused_with_its_status(conformance: dict[str, Any]) -> None:
    expected = {case["case"]: case["status"] for case in conformance["misuse"]}
    assert {name: outcome(call) for name, call in MISUSE.items()} == expected
