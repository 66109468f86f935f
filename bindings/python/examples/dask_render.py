# SPDX-License-Identifier: MIT
"""A turn around a knot: frames, cut into tiles, over the workers of a Dask cluster.

    python dask_render.py FOLDER [WORKERS]

The tree is built once, goes to each worker as bytes when the worker starts, and stays there. Without
WORKERS this process paints all tiles itself; the pictures are the same bytes.
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import htree

FRAMES, SIZE, ROWS = 4, 256, 64  # a tile is ROWS rows of a frame
NAME = "htree"  # of what a worker keeps


def knot(along: int = 600, around: int = 40) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """A tube around a (2, 3) torus knot."""
    s = np.linspace(0, 2 * np.pi, along, endpoint=False)
    radius = 1 + 0.4 * np.cos(3 * s)
    line = np.stack([radius * np.cos(2 * s), radius * np.sin(2 * s), 0.55 * np.sin(3 * s)], -1)
    tangent = np.roll(line, -1, 0) - np.roll(line, 1, 0)
    side = np.cross(tangent, [0, 0, 1])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, tangent)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    turn = np.linspace(0, 2 * np.pi, around, endpoint=False)[:, None]
    tube = line[:, None] + 0.24 * (np.cos(turn) * side[:, None] + np.sin(turn) * up[:, None])
    i, j = np.meshgrid(np.arange(along), np.arange(around), indexing="ij")
    i1, j1 = (i + 1) % along, (j + 1) % around
    a, b, c, d = (x * around + y for x, y in ((i, j), (i1, j), (i1, j1), (i, j1)))
    faces = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], -2)
    return tube.reshape(-1, 3).astype(np.float32), faces.reshape(-1, 3).astype(np.uint32)


def paint(tree: htree.Tree, frame: int, top: int) -> NDArray[np.uint8]:
    """Rows `top` to `top + ROWS` of a frame: nearer is lighter."""
    angle = 2 * np.pi * frame / FRAMES
    ahead = -np.array([np.cos(angle), np.sin(angle), 0.5])
    right = np.array([-np.sin(angle), np.cos(angle), 0.0])
    x = np.linspace(-0.5, 0.5, SIZE)[:, None]
    y = np.linspace(0.5, -0.5, SIZE)[top : top + ROWS, None, None]
    hits = tree.intersect(-4 * ahead, ahead + x * right + y * np.cross(right, ahead))
    light = np.where(hits.hit, np.clip((5.5 - hits.t) / 3, 0, 1), 0)
    return (255 * light).astype(np.uint8)


def paint_by_cluster(file: bytes, workers: int) -> dict[tuple[int, int], NDArray[np.uint8]]:
    from dask.distributed import Client, Worker, WorkerPlugin, get_worker

    class BringTree(WorkerPlugin):
        """A tree for every worker, also for those that join later."""

        name = NAME

        def setup(self, worker: Worker) -> None:
            setattr(worker, NAME, htree.load(file, threads=1))  # as many workers as cores

    def task(frame: int, top: int) -> NDArray[np.uint8]:
        return paint(getattr(get_worker(), NAME), frame, top)

    cluster = Client(  # type: ignore[no-untyped-call]
        n_workers=workers, threads_per_worker=1, dashboard_address=None
    )
    with cluster as client:
        client.register_plugin(BringTree())
        tiles = {
            (frame, top): client.submit(task, frame, top)
            for frame in range(FRAMES)
            for top in range(0, SIZE, ROWS)
        }
        painted: dict[tuple[int, int], NDArray[np.uint8]] = client.gather(tiles)
    return painted


def main(folder: Path, workers: int) -> None:
    tree = htree.build(*knot())
    if workers:
        tiles = paint_by_cluster(tree.save(), workers)
    else:
        tiles = {(f, top): paint(tree, f, top) for f in range(FRAMES) for top in range(0, SIZE, ROWS)}
    folder.mkdir(parents=True, exist_ok=True)
    for frame in range(FRAMES):
        rows = [tiles[frame, top] for top in range(0, SIZE, ROWS)]
        header = f"P5 {SIZE} {SIZE} 255\n".encode()
        (folder / f"frame{frame}.pgm").write_bytes(header + np.concatenate(rows).tobytes())
    print(f"{FRAMES} frames of {tree.stats.triangles:,} triangles in {folder}")


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0)
