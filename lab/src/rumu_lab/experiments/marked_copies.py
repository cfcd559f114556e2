"""Learners' brush copies with the marks that people gave them: the E3C data, read in one place.

Sun et al., SRAFE, CAAI Trans. Intell. Technol. 2023; each copy was marked 1-10 by about ten people. The
panel's mark is their mean times ten. The copies came in two parts, which are alike but for their characters.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

from rumu.errors import CalibrationError
from rumu_lab.experiments.run_settings import RunSettings

FOLDERS = ("e3c", "e3c-more")
"""Under DATA: 652 copies of 17 characters, and 158 of 8 others."""
TABLES = tuple(f"{folder}/scores.csv" for folder in FOLDERS)
"""The tables of marks, under DATA."""


@dataclass(frozen=True, slots=True)
class Copy:
    """One row of scores.csv. mark: the panel's mark, 0-100; ratings: one a rater, 1-10."""

    image: Path
    template: Path
    character: str
    mark: float
    ratings: tuple[float, ...]


def read_copies(data: Path) -> list[Copy]:
    """The rows of both tables, paths resolved. Raises CalibrationError when one is not there."""
    return [copy for name in TABLES for copy in read_table(data / name)]


def read_templates(data: Path) -> list[Path]:
    """The masters that were copied, as far as they are there."""
    return [path for folder in FOLDERS for path in sorted((data / folder / "templates").glob("*.png"))]


def chosen_copies(settings: RunSettings) -> list[Copy]:
    """The marked copies; a few of a few characters when quick."""
    copies = read_copies(settings.data)
    if not settings.quick:
        return copies
    quick = settings.protocol.plain["quick"]
    chosen = []
    for character in quick["characters"]:
        chosen += [c for c in copies if c.character == character][: quick["copies_of_each"]]
    return chosen


def read_table(table: Path) -> list[Copy]:
    """The rows of one table, paths resolved. Raises CalibrationError when it is not there."""
    if not table.is_file():
        raise CalibrationError(
            f"{table}: expected the E3C marks here (set RUMU_DATA or --data), found nothing"
        )
    with table.open(encoding="utf-8", newline="") as stream:
        return [
            Copy(
                table.parent / row["image"],
                table.parent / row["template"],
                row["character"],
                10.0 * float(row["mean_score"]),
                tuple(map(float, row["ratings"].split())),
            )
            for row in csv.DictReader(stream)
        ]
