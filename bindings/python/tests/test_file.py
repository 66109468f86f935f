# SPDX-License-Identifier: MIT
"""A tree that is saved and loaded is the same tree, and what is no tree is not loaded."""

from __future__ import annotations

import mmap
from pathlib import Path

import numpy as np
import pytest
from scenes import Mesh, some_rays

import htree


@pytest.mark.parametrize("kind", [k for k in htree.Kind if k == htree.Options(k).kind])
def test_a_tree_comes_back(ball: Mesh, kind: str) -> None:
    rays = some_rays(500)
    with htree.build(*ball, kind) as tree:
        file = tree.save()
        wanted = tree.intersect(rays)
        shadows = tree.occluded(rays)
    for data in (file, bytearray(file), memoryview(b"?" + file)[1:]):
        with htree.load(data, threads=1) as back:
            assert back.kind == kind and back.options.threads == 1
            assert back.save() == file
            hits = back.intersect(rays)
            assert all(np.array_equal(a, b) for a, b in zip(hits, wanted, strict=True))
            assert np.array_equal(back.occluded(rays), shadows)
            back.check()


def test_a_mapped_file_is_a_tree(tree: htree.Tree, tmp_path: Path) -> None:
    path = tmp_path / "ball.htree"
    path.write_bytes(tree.save())
    with path.open("rb") as opened:
        mapped = mmap.mmap(opened.fileno(), 0, access=mmap.ACCESS_READ)
    back = htree.load(mapped, borrow=True)
    assert back.stats.bytes < 4096  # the arrays are not its own
    rays = some_rays(100)
    assert np.array_equal(back.intersect(rays).prim, tree.intersect(rays).prim)
    with pytest.raises(BufferError):  # the tree keeps it
        mapped.close()
    back.close()
    del back
    mapped.close()


def test_objects_need_their_function_again() -> None:
    boxes = [[0, 0, 0, 1, 1, 1], [2, 0, 0, 3, 1, 1]]

    def at_the_top(object: int, ray: htree.Ray) -> tuple[float, float, float] | None:
        return ((1 - ray.org[2]) / ray.dir[2], 0, object)

    tree = htree.build(None, objects=htree.Objects(boxes, at_the_top))
    file = tree.save()
    with pytest.raises(htree.ArgumentError, match="intersect"):
        htree.load(file)
    with pytest.raises(TypeError):
        htree.load(file, intersect=3)
    back = htree.load(file, intersect=at_the_top)
    hit = back.intersect_one([2.5, 0.5, 5], [0, 0, -1])
    assert hit == (4, 0, 1, 1) and back.stats.objects == 2


def test_what_is_no_tree_is_not_loaded(tree: htree.Tree) -> None:
    file = tree.save()
    for bad in (b"", file[:100], file[:-1], file + b"\0", b"no tree at all" * 99):
        with pytest.raises(htree.CorruptError):
            htree.load(bad)
    changed = bytearray(file)
    changed[len(file) // 2] ^= 1
    with pytest.raises(htree.CorruptError, match="checksum"):
        htree.load(changed)
    odd = np.frombuffer(b"?" * 65 + file, np.uint8)
    with pytest.raises(htree.ArgumentError, match="multiple"):
        htree.load(odd[65 - (odd.ctypes.data + 65) % 64 + 1 :], borrow=True)


def test_a_closed_tree_is_not_saved(ball: Mesh) -> None:
    tree = htree.build(*ball)
    tree.close()
    with pytest.raises(ValueError, match="closed"):
        tree.save()
