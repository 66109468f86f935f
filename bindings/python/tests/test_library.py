# SPDX-License-Identifier: MIT
"""The package around the library: versions, coverage of the header, refusal of a stranger."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from importlib.metadata import distribution
from pathlib import Path

import pytest
from scenes import REPOSITORY

import htree
from htree.raw import ffi, lib

HEADER = (REPOSITORY / "include/htree.h").read_text(encoding="ascii")
PACKAGE = Path(htree.__file__).parent


def test_versions_are_those_of_the_header() -> None:
    numbers = re.findall(r"#define HTREE_VERSION_\w+ (\d+)", HEADER)
    assert htree.__version__ == ".".join(numbers)
    assert htree.lib_version() == tuple(map(int, numbers))


def test_every_function_and_constant_is_in_the_raw_layer_and_used() -> None:
    functions = re.findall(r"^HTREE_API [^;(]*?(htree_\w+)\(", HEADER, re.MULTILINE)
    constants = re.findall(r"^    (HTREE_\w+) = ", HEADER, re.MULTILINE)
    assert len(functions) > 15 and len(constants) > 20
    sources = "".join(path.read_text(encoding="ascii") for path in PACKAGE.glob("[!.]*.py"))
    for name in functions + constants:
        assert hasattr(lib, name), name
        assert f"lib.{name}" in sources, f"{name} is not used by the package"


def test_layouts_are_those_of_the_library() -> None:
    for dtype, name in (
        (htree.ray_dtype, "htree_ray"),
        (htree.hit_dtype, "htree_hit"),
        (htree.counters_dtype, "htree_counters"),
    ):
        assert dtype.itemsize == ffi.sizeof(name)
        assert dtype.names is not None and dtype.fields is not None
        for field in dtype.names:
            assert dtype.fields[field][1] == ffi.offsetof(name, field), field
    assert htree.NONE == 2**32 - 1
    value = re.search(r"HTREE_COORDINATE_MAX (\S+)f", HEADER)
    assert value is not None and float(value.group(1)) == htree.COORDINATE_MAX


def test_the_installed_package_is_whole() -> None:
    files = {Path(str(file)).name for file in distribution("htree").files or ()}
    assert {"libhtree.so", "libhtree.dylib", "htree.dll"} & files
    assert {"py.typed", "LICENSE", "_abi.py"} <= files
    tags = distribution("htree").read_text("WHEEL")
    assert tags is not None and "Tag: py3-none-" in tags


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
@pytest.mark.parametrize(
    ("number", "accepted"), [(100, True), (199, True), (200, False), (10100, False)]
)
def test_a_library_of_another_abi_is_refused(tmp_path: Path, number: int, accepted: bool) -> None:
    source, library = tmp_path / "other.c", tmp_path / "libother.so"
    source.write_text(f"unsigned htree_version(void) {{ return {number}; }}\n", encoding="ascii")
    subprocess.run(["cc", "-shared", "-fPIC", "-o", library, source], check=True)
    done = subprocess.run(
        [sys.executable, "-c", "import htree.raw"],
        env={**os.environ, "HTREE_LIBRARY": str(library)},
        capture_output=True,
        text=True,
    )
    # A library that is accepted still lacks everything else.
    refused = "ImportError" in done.stderr and "this package needs 0.1" in done.stderr
    assert refused != accepted, done.stderr
