# SPDX-License-Identifier: MIT
"""What tests share: the conformance file, and a tree."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest
from scenes import REPOSITORY, Mesh, sphere

import htree


@pytest.fixture(scope="session")
def conformance() -> dict[str, Any]:
    default = REPOSITORY / "build/release/conformance.json"
    path = Path(os.environ.get("HTREE_CONFORMANCE", default))
    assert path.is_file(), f"no conformance file at {path}: HTREE_CONFORMANCE says where it is"
    document: dict[str, Any] = json.loads(path.read_text(encoding="ascii"))
    assert document["format"] == 1
    return document


@pytest.fixture(scope="session")
def ball() -> Mesh:
    return sphere(24)


@pytest.fixture(scope="session")
def tree(ball: Mesh) -> htree.Tree:
    return htree.build(*ball)
