"""Everything that rumu raises on purpose.

    RumuError
    ├── ImageError          a file or array that is no usable image
    ├── CaptureError        photographs, lamps or masks that do not belong together
    ├── SurfaceError        no surface can be computed from what was given
    ├── RegistrationError   two surfaces that cannot be compared at all
    ├── RefusedImage        a picture that holds nothing to mark: blank, black, noise
    ├── CalibrationError    marks that cannot carry a calibration
    ├── GalleryError        a work that is not there or not whole
    ├── DatabaseBusy        a database that is locked or cannot be reached at present
    └── OutputError         a file or folder that cannot be written
        └── DiskFull        there is no space for it

Each message names what was given, what was expected and what came.
"""

from __future__ import annotations

from typing import Any


class RumuError(Exception):
    """Base of every error raised on purpose.

    Parameters
    ----------
    message
        One clear line for a person: what was given, what was expected and what came.
    name
        The file that it is about. It stands before the message in the error's text, but not in `en`, which
        the service shows: its readers must not see where files lie.
    zh
        The message in Chinese, where it is known; the pages of the service show it.
    """

    zh: str | None = None

    def __init__(self, message: str = "", *, name: object = None, zh: str | None = None) -> None:
        super().__init__(message if name is None else f"{name}: {message}")
        self.en = message
        if zh is not None:
            self.zh = zh


class ImageError(RumuError):
    """A file or an array that is no usable image."""


class CaptureError(RumuError):
    """Photographs, lamps or masks that do not belong together."""


class SurfaceError(RumuError):
    """No surface can be computed from what was given."""


class RegistrationError(RumuError):
    """Two surfaces that cannot be compared at all."""


class RefusedImage(RumuError):  # noqa: N818  what it is, not that it went wrong
    """A picture that holds nothing to mark; `reason` is the short word for it."""

    def __init__(self, message: str, *, reason: str, name: object = None, zh: str | None = None) -> None:
        super().__init__(message, name=name, zh=zh)
        self.reason = reason

    def __reduce__(self) -> Any:  # as it comes back from another process
        return Exception.__new__, (type(self), *self.args), self.__dict__


class CalibrationError(RumuError):
    """Marks that cannot carry a calibration."""


class GalleryError(RumuError):
    """A work that is not there or not whole."""


class OutputError(RumuError):
    """A file or folder that cannot be written."""


class DatabaseBusy(RumuError):  # noqa: N818  what it is, not that it went wrong
    """A database that is locked by another process, or cannot be reached at present."""


class DiskFull(OutputError):  # noqa: N818  what it is, not that it went wrong
    """There is no space left, on the disk or in a quota; what was begun is deleted.

    place: the folder. needed: bytes at least, None if unknown.
    """

    def __init__(self, place: object, needed: int | None = None) -> None:
        size = "" if needed is None else f"{max(0.1, needed / 2**20):.1f} MB"
        least = f"at least {size}" if size else "more space"
        super().__init__(
            f"the disk or quota is full, nothing is half-written; {least} is needed there",
            name=place,
            zh=f"磁碟或配額已滿，沒有留下寫了一半的東西。那裡至少要有{f' {size} ' if size else '更多'}空間。",
        )
        self.needed = size

    def __reduce__(self) -> Any:  # as it comes back from another process
        return Exception.__new__, (type(self), *self.args), self.__dict__
