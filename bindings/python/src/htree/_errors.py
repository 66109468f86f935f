# SPDX-License-Identifier: MIT
"""Statuses of the library as exceptions: one table."""

from __future__ import annotations

from enum import IntEnum

from .raw import ffi, lib


class Status(IntEnum):
    """What a call of the library returns."""

    OK = lib.HTREE_OK
    ARGUMENT = lib.HTREE_ERROR_ARGUMENT
    MEMORY = lib.HTREE_ERROR_MEMORY
    LIMIT = lib.HTREE_ERROR_LIMIT
    GEOMETRY = lib.HTREE_ERROR_GEOMETRY
    CANCELLED = lib.HTREE_ERROR_CANCELLED
    UNSUPPORTED = lib.HTREE_ERROR_UNSUPPORTED
    CORRUPT = lib.HTREE_ERROR_CORRUPT
    NO_DEVICE = lib.HTREE_ERROR_NO_DEVICE
    DEVICE = lib.HTREE_ERROR_DEVICE
    DEVICE_LOST = lib.HTREE_ERROR_DEVICE_LOST
    KERNEL = lib.HTREE_ERROR_KERNEL


class Error(Exception):
    """A call of the library failed: `code` is its status, `name` that status in words, and the text
    is the library's sentence about this failure."""

    def __init__(self, code: int, text: str = "") -> None:
        super().__init__(code, text)
        self.code = code
        self.text = text

    @property
    def name(self) -> str:
        return status_name(self.code)

    def __str__(self) -> str:
        return self.text or self.name


class ArgumentError(Error, ValueError):
    """A size, a flag or a number that the call does not take."""


class OutOfMemory(Error, MemoryError):
    """The allocator returned nothing."""


class LimitError(Error, OverflowError):
    """More objects than the structure can address."""


class GeometryError(Error, ValueError):
    """An index beyond the vertices; with Flag.STRICT bad coordinates too."""


class Cancelled(Error):
    """The progress hook asked to stop."""


class Unsupported(Error, NotImplementedError):
    """This build of the library lacks the kind that was asked for."""


class CorruptError(Error):
    """`Tree.check` found a broken tree, or `load` bytes that are none."""


class DeviceError(Error):
    """A device is missing, failed, is lost, or refused a kernel."""


_ERRORS: dict[int, type[Error]] = {
    Status.ARGUMENT: ArgumentError,
    Status.MEMORY: OutOfMemory,
    Status.LIMIT: LimitError,
    Status.GEOMETRY: GeometryError,
    Status.CANCELLED: Cancelled,
    Status.UNSUPPORTED: Unsupported,
    Status.CORRUPT: CorruptError,
    Status.NO_DEVICE: DeviceError,
    Status.DEVICE: DeviceError,
    Status.DEVICE_LOST: DeviceError,
    Status.KERNEL: DeviceError,
}


def check(status: int) -> None:
    """Raises what `status` means, with the text of the call that has just failed on this thread."""
    if status:
        raise _ERRORS.get(status, Error)(status, error_text())


def error_text() -> str:
    """The text of the last call that failed on this thread; every exception carries its own."""
    return _text(lib.htree_error_text())


def status_name(status: int) -> str:
    """The library's name of a status."""
    return _text(lib.htree_status_name(status))


def _text(characters: object) -> str:
    return str(ffi.string(characters).decode("utf-8", "replace"))
