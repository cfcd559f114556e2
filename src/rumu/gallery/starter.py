"""The starter gallery: works and sample copies that are part of the package.

The files in `starter/` (thirty works, six characters in five scripts, and samples) and in `starter_brush/`
(two characters by four brush hands) are written by scripts/make_starter.py: works.json and samples.json give
the metadata, source and licence of each picture.
"""

from __future__ import annotations

import difflib
import functools
import json
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from rumu.errors import GalleryError
from rumu.values import SCRIPTS, Bilingual, Level, Script

_FOLDER = Path(str(resources.files("rumu.gallery").joinpath("starter")))
_BRUSH_FOLDER = Path(str(resources.files("rumu.gallery").joinpath("starter_brush")))


@dataclass(frozen=True, slots=True)
class StarterWork:
    """A character in one script by one hand.

    id: ASCII, unique, e.g. 'regular-shui'. character: one character. hand: who wrote or drew it.
    period: when, as far as the source says. material: what the picture shows.
    source: where the glyph was taken from. licence: SPDX name or words. attribution: the credit to give.
    path: 8-bit gray PNG, 512 x 512, black ink on white. sha256: of that file.
    """

    id: str
    title: Bilingual
    character: str
    script: Script
    hand: Bilingual
    period: Bilingual
    material: Bilingual
    source: str
    licence: str
    attribution: str
    path: Path
    sha256: str


@dataclass(frozen=True, slots=True)
class SampleFault:
    """A fault that was simulated in a sample copy.

    fault: name in the simulation's table. severity: 0 (none) to 5 (gross).
    size: how large, in `unit`; angles positive clockwise, pixels those of the picture.
    region: (x0, y0, x1, y1) in fractions of the cell, origin top left, when the fault was applied.
    """

    fault: str
    severity: float
    size: float
    unit: str
    region: tuple[float, float, float, float]
    description: Bilingual


@dataclass(frozen=True, slots=True)
class Sample:
    """A simulated copy of a work with known faults, which nobody wrote or marked.

    work: id of the work that it copies. degree: how bad it was made, by convention; it is no mark.
    simulated: always True, so that no list shows it as handwriting.
    """

    id: str
    work: str
    degree: Level
    faults: tuple[SampleFault, ...]
    simulated: bool
    note: Bilingual
    licence: str
    attribution: str
    path: Path
    sha256: str


def starter_works(*, script: str | None = None, character: str | None = None) -> tuple[StarterWork, ...]:
    """The thirty works, by script (seal first) and character; of one script or character if given.

    Raises GalleryError for an unknown script, or when files of the package are missing.
    """
    if script is not None and script not in SCRIPTS:
        raise GalleryError(f"expected a script among {', '.join(SCRIPTS)}, got {script!r}")
    works = _read_works(_FOLDER)
    return tuple(w for w in works if script in (None, w.script) and character in (None, w.character))


def brush_works() -> tuple[StarterWork, ...]:
    """The works by brush hands, by character and hand. Raises GalleryError as `starter_works`."""
    return _read_works(_BRUSH_FOLDER)


def find_work(work_id: str) -> StarterWork:
    """The work of the package with this id. Raises GalleryError that names the closest when there is none."""
    every = (*_read_works(_FOLDER), *brush_works())
    for work in every:
        if work.id == work_id:
            return work
    of_character = [work.id for work in every if work.character in work_id]
    hint = suggest(work_id, [work.id for work in every], of_character)
    raise GalleryError(f"no work {work_id!r} in the starter gallery{hint}")


def starter_samples(*, work: str | None = None) -> tuple[Sample, ...]:
    """The simulated copies of the package, best first; of one work if its id is given.

    Raises GalleryError when that work does not exist, or when files of the package are missing.
    """
    if work is not None:
        find_work(work)
    return tuple(sample for sample in _samples() if work in (None, sample.work))


def suggest(asked: str, known: Sequence[str], of_character: Sequence[str]) -> str:
    """The end of an error about an unknown id: the ids that may be meant, or some of all.

    known: all ids. of_character: those of the character that was typed; ids seldom hold it.
    """
    close = difflib.get_close_matches(asked, known, n=3, cutoff=0.5) or of_character[:5]
    return f"; did you mean {', '.join(close)}?" if close else f"; there are {', '.join(known[:5])}, ..."


@functools.cache
def _read_works(folder: Path) -> tuple[StarterWork, ...]:
    entries = _entries(folder / "works.json")
    return tuple(StarterWork(**_fields(entry), path=_file(folder, entry)) for entry in entries)


@functools.cache
def _samples() -> tuple[Sample, ...]:
    samples = []
    for entry in _entries(_FOLDER / "samples.json"):
        faults = tuple(
            SampleFault(**_fields(fault) | {"region": tuple(fault["region"])}) for fault in entry["faults"]
        )
        samples.append(Sample(**_fields(entry) | {"faults": faults}, path=_file(_FOLDER, entry)))
    return tuple(samples)


def _fields(entry: dict[str, Any]) -> dict[str, Any]:
    """The fields of a value from its JSON entry, without its file."""
    return {
        name: Bilingual(**value) if isinstance(value, dict) else value
        for name, value in entry.items()
        if name != "file"
    }


def _entries(path: Path) -> list[dict[str, Any]]:
    try:
        entries: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise GalleryError(
            f"{path}: expected the starter gallery's list, cannot read it ({error})"
        ) from error
    return entries


def _file(folder: Path, entry: dict[str, Any]) -> Path:
    path = folder / str(entry["file"])
    if not path.is_file():
        raise GalleryError(f"{path}: the picture of {entry['id']} is missing from the package")
    return path
