"""Photographs of sheets as people hand them in: files, folders, zips, PDFs of a scanner."""

from __future__ import annotations

import contextlib
import hashlib
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from rumu.capture.decoded_size import MAX_PIXELS, Reduction
from rumu.capture.image import read_colours
from rumu.capture.photographs import PICTURE_SUFFIXES
from rumu.errors import ImageError
from rumu.inputs import open_file
from rumu.studio.unpacking import HEAD, unpack
from rumu.workspaces import temporary_folder

PHOTO_SIZE = Reduction(pixels=12_600_000, above=16_000_000)
"""How a photograph is reduced: a phone's 12 megapixels are enough."""

_SUFFIXES = frozenset({*PICTURE_SUFFIXES, ".pdf"})
_DPI = 300.0  # at which a scanner's page is looked at
_MOST_PAGES = 1000  # of one PDF
_CHUNK = 2**20


@dataclass(frozen=True, slots=True)
class SheetPhoto:
    """A photograph of a sheet. name: for people. path: of its file. page: in a PDF, from 0; else None."""

    name: str
    path: Path
    page: int | None = None

    def digest(self) -> str:
        """What tells this picture from all others."""
        found = hashlib.sha256(str(self.page).encode())
        with open_file(self.path, error_type=ImageError, expected="a photograph") as stream:
            while chunk := stream.read(_CHUNK):
                found.update(chunk)
        return found.hexdigest()[:24]


@contextlib.contextmanager
def sheet_photos(
    paths: Sequence[Path], *, names: Sequence[str] = (), most: int | None = None
) -> Iterator[list[SheetPhoto]]:
    """Yield the photographs of files, folders, zips and PDFs, in order of their names; zips are unpacked.

    names: of the files for people, where they are called otherwise. most: of the photographs.
    Raises ImageError when there is none, or there are more, or a PDF cannot be read; Unusable for a zip that
    cannot be used.
    """
    with contextlib.ExitStack() as stack:
        photos: list[SheetPhoto] = []
        for path, name in zip(paths, names or [path.name for path in paths], strict=True):
            photos += _of_path(path, name, stack)
        if not photos:
            raise ImageError(
                f"expected photographs of sheets in {', '.join(map(str, paths)) or 'nothing'}, found none",
                zh="沒有找到照片。",
            )
        if most is not None and len(photos) > most:
            raise ImageError(
                f"expected at most {most} photographs at a time, got {len(photos)}",
                zh=f"一次最多 {most} 張照片，這裡有 {len(photos)} 張；請分幾次。",
            )
        yield photos


def read_photo(photo: SheetPhoto) -> npt.NDArray[np.uint8]:
    """(H, W, 3) uint8 sRGB, upright as its file says. Raises ImageError."""
    if photo.page is not None:
        return _render(photo.path, photo.page)
    return read_colours(photo.path, reduction=PHOTO_SIZE)


def _of_path(path: Path, name: str, stack: contextlib.ExitStack) -> list[SheetPhoto]:
    if path.is_dir():
        found = sorted(Path(folder) / name for folder, _, names in os.walk(path) for name in names)
        pictures = [one for one in found if one.suffix.lower() in _SUFFIXES and not one.name.startswith(".")]
        return [photo for one in pictures for photo in _of_file(one, one.relative_to(path).as_posix())]
    with open_file(path, error_type=ImageError, expected="a photograph, a folder, a zip or a PDF") as stream:
        is_zip = stream.read(HEAD).startswith(b"PK\x03\x04")
    if not is_zip:
        return _of_file(path, name)
    folder = stack.enter_context(temporary_folder()) / "zip"
    unpack(path, folder)
    return _of_path(folder, name, stack)


def _of_file(path: Path, name: str) -> list[SheetPhoto]:
    with open_file(path, error_type=ImageError, expected="a photograph") as stream:
        is_pdf = b"%PDF-" in stream.read(1024)
    if not is_pdf:
        return [SheetPhoto(name, path)]
    count = 1  # where it cannot be read, that is told of its first page, and costs the other files nothing
    with contextlib.suppress(ImageError), _pdf(path) as document:
        count = len(document)
    if not 0 < count <= _MOST_PAGES:
        raise ImageError(f"expected a PDF of at most {_MOST_PAGES} pages, got {count}", name=path)
    return [SheetPhoto(f"{name} {page + 1}" if count > 1 else name, path, page) for page in range(count)]


@contextlib.contextmanager
def _pdf(path: Path) -> Iterator[Any]:
    """Yield the document of a PDF; everything that goes wrong with it is an ImageError."""
    import pypdfium2

    try:
        with contextlib.closing(pypdfium2.PdfDocument(path)) as document:
            yield document
    except (pypdfium2.PdfiumError, OSError, ValueError) as error:
        raise ImageError(
            f"expected a PDF that can be read, found a damaged or locked one ({error})",
            name=path,
            zh=f"{path.name}：PDF 讀不出來，可能已損壞或有密碼。",
        ) from error


def _render(path: Path, number: int) -> npt.NDArray[np.uint8]:
    """A page of a PDF as a picture, of the resolution at which scanners scan."""
    with _pdf(path) as document, contextlib.closing(document[number]) as page:
        width, height = page.get_size()
        if not (0 < width < 20_000 and 0 < height < 20_000):
            raise ImageError(f"expected a page of paper, got one of {width:g} x {height:g} points", name=path)
        scale = min(_DPI / 72, (PHOTO_SIZE.pixels / (width * height)) ** 0.5)
        if width * height * scale**2 > MAX_PIXELS or min(width, height) * scale < 8:
            raise ImageError(f"expected a page of paper, got one of {width:g} x {height:g} points", name=path)
        bitmap = page.render(scale=scale, rev_byteorder=True)
        with contextlib.closing(bitmap):
            pixels = np.array(bitmap.to_numpy()[..., :3])
    return np.ascontiguousarray(pixels)
