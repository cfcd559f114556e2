"""The masters that a search looks through: a folder of pictures, or a labels.csv that says what they are."""

from __future__ import annotations

import csv
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from rumu.errors import GalleryError

LABELS = "labels.csv"
PICTURES = frozenset({".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".bmp"})

Places = str | Path | Sequence[str | Path]


@dataclass(frozen=True, slots=True)
class Master:
    """One picture of one character. character, hand, work: None where the labels do not say."""

    path: Path
    character: str | None = None
    hand: str | None = None
    work: str | None = None


def read_masters(places: Places) -> tuple[Master, ...]:
    """The masters of a place or of several, in the order of the labels, or of the names.

    places: a labels.csv with the columns file and, where known, character, calligrapher_zh (or calligrapher)
        and work; or a folder, whose labels.csv is read when there is one and whose pictures are taken as they
        are otherwise.
    Raises GalleryError when there is no such place, no picture in it, or no column `file`.
    """
    one = (places,) if isinstance(places, str | Path) else tuple(places)
    found = [master for place in one for master in _of_place(Path(place))]
    if not found:
        raise GalleryError(f"expected pictures of masters in {', '.join(map(str, one)) or 'nothing'}")
    return tuple(dict.fromkeys(found))


def _of_place(place: Path) -> Iterator[Master]:
    if place.is_dir():
        if (place / LABELS).is_file():
            yield from _labelled(place / LABELS)
            return
        pictures = (Path(folder) / name for folder, _, names in os.walk(place) for name in names)
        yield from (Master(path) for path in sorted(pictures) if path.suffix.lower() in PICTURES)
    elif place.suffix.lower() == ".csv" and place.is_file():
        yield from _labelled(place)
    else:
        raise GalleryError(f"{place}: expected a folder of pictures or a {LABELS}, found neither")


def label_rows(table: Path) -> Iterator[dict[str, str | None]]:
    """The rows of a labels.csv as they stand. Raises GalleryError where it is no CSV with a column `file`."""
    try:
        with table.open(encoding="utf-8-sig", newline="") as stream:
            rows = csv.DictReader(stream)
            if "file" not in (rows.fieldnames or ()):
                found = ", ".join(rows.fieldnames or ()) or "nothing"
                raise GalleryError(f"{table}: expected a column 'file', found {found}")
            yield from rows
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise GalleryError(f"{table}: expected a CSV in UTF-8, cannot read it ({error})") from error


def _labelled(table: Path) -> Iterator[Master]:
    for row in label_rows(table):
        hand = row.get("calligrapher_zh") or row.get("calligrapher") or None
        if row["file"]:
            yield Master(
                table.parent / row["file"], row.get("character") or None, hand, row.get("work") or None
            )
