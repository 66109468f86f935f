# SPDX-License-Identifier: MIT
"""make_abi.py HEADER OUT: writes the module that tells cffi what htree.h declares.

The header is the only description of the ABI: nothing of it is written again in Python. cffi parses
C declarations but no preprocessor, so what is between the include guard's extern "C" braces goes to
it without directives, but for constants that are plain integers.
"""

import re
import sys
from pathlib import Path

import cffi


def declarations(header: str) -> str:
    """The part of the header that cffi's parser takes."""
    text = re.sub(r"/\*.*?\*/", "", header, flags=re.DOTALL)
    text = text.replace('extern "C" {', "").replace("HTREE_API ", "")
    text = re.sub(r"#ifdef __cplusplus.*?#endif", "", text, flags=re.DOTALL)
    lines = text.splitlines()
    return "\n".join(
        line
        for line in lines
        if not line.startswith("#") or re.fullmatch(r"#define +HTREE_\w+ +\d+ *", line)
    )


def main() -> None:
    header, out = Path(sys.argv[1]), Path(sys.argv[2])
    ffi = cffi.FFI()
    ffi.set_source("htree._abi", None)
    ffi.cdef(declarations(header.read_text(encoding="ascii")))
    ffi.emit_python_code(str(out))


if __name__ == "__main__":
    main()
