# SPDX-License-Identifier: MIT
"""The library as it is: `lib` has every function and constant of htree.h, `ffi` its types.

Nothing here is checked. Handles from `lib.htree_build` are the caller's to free.
"""

import os
import sys
from pathlib import Path
from typing import Any

from ._abi import ffi as _ffi

__all__ = ["ffi", "lib"]

ffi: Any = _ffi


def _path() -> str:
    """HTREE_LIBRARY, for those who bring their own build, or the library beside this file."""
    own = os.environ.get("HTREE_LIBRARY")
    if own:
        return own
    suffix = {"win32": "htree.dll", "darwin": "libhtree.dylib"}.get(sys.platform, "libhtree.so")
    return str(Path(__file__).with_name(suffix))


def _open(path: str) -> Any:
    """Opens the library, if its ABI is that of the header that this package was built with."""
    lib = ffi.dlopen(path)
    number = lib.htree_version()
    found = (number // 10000, number // 100 % 100)
    wanted = (lib.HTREE_VERSION_MAJOR, lib.HTREE_VERSION_MINOR)
    same = found[0] == wanted[0] and (wanted[0] > 0 or found[1] == wanted[1])
    if not same:
        raise ImportError(
            f"{path} is libhtree {found[0]}.{found[1]}, this package needs {wanted[0]}.{wanted[1]}",
            name="htree",
            path=path,
        )
    return lib


lib: Any = _open(_path())
