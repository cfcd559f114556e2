"""Masters for a search: a folder of pictures, or a labels.csv with what they show."""

from __future__ import annotations

import csv
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from rumu.errors import GalleryError

LABELS = "labels.csv"
PICTURES = frozenset({".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".bmp"})

MasterPaths = str | Path | Sequence[str | Path]


@dataclass(frozen=True, slots=True)
class Master:
    """A picture of a character. character, hand, work: None where the labels do not give them."""

    path: Path
    character: str | None = None
    hand: str | None = None
    work: str | None = None


def read_masters(paths: MasterPaths) -> tuple[Master, ...]:
    """The masters of one path or of several, in the order of the labels or file names.

    paths: a labels.csv with the columns file and, where known, character, calligrapher_zh (or calligrapher)
        and work; or a folder, with a labels.csv or with pictures only.
    Raises GalleryError when there is no such file or folder, no picture in it, or no column `file`.
    """
    several = (paths,) if isinstance(paths, str | Path) else tuple(paths)
    masters = [master for path in several for master in _read_path(Path(path))]
    if not masters:
        raise GalleryError(f"expected pictures of masters in {', '.join(map(str, several)) or 'nothing'}")
    return tuple(dict.fromkeys(masters))


def _read_path(path: Path) -> Iterator[Master]:
    if path.is_dir():
        if (path / LABELS).is_file():
            yield from _read_labels(path / LABELS)
            return
        pictures = (Path(folder) / name for folder, _, names in os.walk(path) for name in names)
        yield from (Master(one) for one in sorted(pictures) if one.suffix.lower() in PICTURES)
    elif path.suffix.lower() == ".csv" and path.is_file():
        yield from _read_labels(path)
    else:
        raise GalleryError(f"{path}: expected a folder of pictures or a {LABELS}, found neither")


def label_rows(table: Path) -> Iterator[dict[str, str | None]]:
    """The rows of a labels.csv. Raises GalleryError if it is no CSV with a column `file`."""
    try:
        with table.open(encoding="utf-8-sig", newline="") as stream:
            rows = csv.DictReader(stream)
            if "file" not in (rows.fieldnames or ()):
                found = ", ".join(rows.fieldnames or ()) or "nothing"
                raise GalleryError(f"{table}: expected a column 'file', found {found}")
            yield from rows
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise GalleryError(f"{table}: expected a CSV in UTF-8, cannot read it ({error})") from error


def _read_labels(table: Path) -> Iterator[Master]:
    for row in label_rows(table):
        hand = row.get("calligrapher_zh") or row.get("calligrapher") or None
        if row["file"]:
            yield Master(
                table.parent / row["file"], row.get("character") or None, hand, row.get("work") or None
            )
