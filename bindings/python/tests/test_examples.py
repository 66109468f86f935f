# SPDX-License-Identifier: MIT
"""The examples run, and the README shows them as they are."""

from __future__ import annotations

import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest
from matplotlib import image
from scenes import REPOSITORY

FOLDER = REPOSITORY / "bindings/python"


def test_the_readme_shows_the_quickstart(capsys: pytest.CaptureFixture[str]) -> None:
    readme = (FOLDER / "README.md").read_text(encoding="ascii")
    blocks = re.findall(r"```python\n(.*?)```", readme, re.DOTALL)
    quickstart = FOLDER / "examples/quickstart.py"
    assert blocks[0] == quickstart.read_text(encoding="ascii")
    runpy.run_path(str(quickstart), run_name="__main__")
    printed = capsys.readouterr().out
    assert "4 triangles" in printed and "Hit(t=1.666" in printed and "% hit" in printed
    assert printed.strip().splitlines()[-1] in readme


def test_the_readmes_other_blocks_run() -> None:
    readme = (FOLDER / "README.md").read_text(encoding="ascii")
    blocks = re.findall(r"```python\n(.*?)```", readme, re.DOTALL)[1:]
    assert blocks
    for block in blocks:
        exec(compile(block, "README.md", "exec"), {"__name__": "readme"})


def test_ambient_occlusion_draws_a_picture(tmp_path: Path) -> None:
    picture = tmp_path / "ao.png"
    script = FOLDER / "examples/ambient_occlusion.py"
    subprocess.run([sys.executable, script, picture], check=True, capture_output=True, timeout=300)
    pixels = image.imread(picture)
    assert pixels.shape[:2] == (720, 960)
    inner = pixels[150:700, 100:860, :3].mean(axis=2)
    assert (inner < 0.45).mean() > 0.02  # shadows under the knot
    assert (inner > 0.85).mean() > 0.2  # open floor


def test_dask_paints_what_one_process_paints(tmp_path: Path) -> None:
    script = FOLDER / "examples/dask_render.py"
    for workers in ("0", "2"):
        command = [sys.executable, str(script), str(tmp_path / workers), workers]
        subprocess.run(command, check=True, capture_output=True, timeout=300)
    frames = sorted(path.name for path in (tmp_path / "0").iterdir())
    assert len(frames) == 4
    for frame in frames:
        alone, together = ((tmp_path / workers / frame).read_bytes() for workers in ("0", "2"))
        assert alone == together
        assert max(alone[20:]) > 200
    assert (tmp_path / "0" / frames[0]).read_bytes() != (tmp_path / "0" / frames[1]).read_bytes()
