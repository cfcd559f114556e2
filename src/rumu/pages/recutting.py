"""Characters of a column cut anew where the text says what they are: where both look most like themselves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from rumu.pages.character_shapes import CharacterShape, cut_shape, joined_shape
from rumu.pages.free_page import WrittenColumn
from rumu.pages.glyph_likeness import Floats, describe_ink, describe_printed, likeness
from rumu.pages.page import Direction
from rumu.values import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class RecutSettings:
    """When neighbours are cut anew; lengths as shares of the pace of the column.

    poor: likeness below which a character may have been cut in a wrong place. touching: how far apart the
    two are at most. reach: how far from where they meet the new cut lies at most. rows: how many cuts are
    tried. better: by how much the likeness of both together must rise. least: what both halves must have
    where one character becomes two.
    """

    poor: float = 1.4
    touching: float = 0.12
    reach: float = 0.35
    rows: int = 9
    better: float = 0.25
    least: float = 0.6


@dataclass(frozen=True, slots=True, eq=False)
class Draft:
    """A character as the alignment has it.

    shape: its ink; None for one of the text whose ink is in its neighbour, if anywhere. which: which of the
    different characters of the text it is, None for ink that the text does not have. fits: (u,) how well each
    of them fits the ink, see `Words.likeness`; None without ink.
    """

    shape: CharacterShape | None
    which: int | None
    fits: FloatArray | None = None

    def fit(self) -> float:
        """How well its own name fits its ink; minus infinity without either."""
        return -np.inf if self.fits is None or self.which is None else float(self.fits[self.which])


@dataclass(frozen=True, eq=False)
class Words:
    """The different characters of a text, and what they look like; direction: of the page's columns."""

    different: list[str]
    direction: Direction

    @cached_property
    def _printed(self) -> tuple[Floats, BoolArray]:
        return describe_printed(self.different)

    @property
    def known(self) -> BoolArray:
        """(u,) bool: whether the strokes of each are known."""
        return self._printed[1]

    def likeness(self, looks: list[tuple[IntArray, IntArray]]) -> FloatArray:
        """(n, u): how well each of them fits ink of these rows and columns, swapped on a page of rows."""
        upright = looks if self.direction == "vertical" else [(x, y) for y, x in looks]
        return likeness(describe_ink(upright), *self._printed)


def look_of(shape: CharacterShape) -> tuple[IntArray, IntArray]:
    """The pixels of a shape."""
    return shape.y, shape.x


@dataclass(frozen=True, slots=True, eq=False)
class _Trial:
    """Two neighbours, the first at this place of a column's drafts, and ways to cut their ink.

    now: the likeness of both as they are, minus infinity where one of them has no ink yet.
    """

    column: int
    at: int
    names: tuple[int, int]
    halves: list[tuple[CharacterShape, CharacterShape]]
    now: float


def cut_anew(
    drafts: list[list[Draft]],
    columns: Sequence[WrittenColumn],
    words: Words,
    *,
    settings: RecutSettings | None = None,
) -> list[list[Draft]]:
    """The characters of each column, touching ones cut where both fit their names best."""
    settings = settings or RecutSettings()
    trials = _trials(drafts, columns, words.known, settings)
    z = words.likeness([look_of(half) for trial in trials for cut in trial.halves for half in cut])
    new, first = [list(own) for own in drafts], 0
    changed: set[tuple[int, int]] = set()
    for trial in trials:
        own = z[first : first + 2 * len(trial.halves)]
        first += len(own)
        upper, lower = own[0::2, trial.names[0]], own[1::2, trial.names[1]]
        best = int(np.argmax(upper + lower))
        fits = upper[best] + lower[best] > trial.now + settings.better
        if not np.isfinite(trial.now):
            fits = min(upper[best], lower[best]) > settings.least
        places = {(trial.column, trial.at), (trial.column, trial.at + 1)}
        if fits and not changed & places:
            changed |= places
            for k, half in enumerate(trial.halves[best]):
                new[trial.column][trial.at + k] = Draft(half, trial.names[k], own[2 * best + k])
    return new


def _trials(
    drafts: list[list[Draft]], columns: Sequence[WrittenColumn], known: BoolArray, settings: RecutSettings
) -> list[_Trial]:
    trials = []
    for c, (own, column) in enumerate(zip(drafts, columns, strict=True)):
        for k, (upper, lower) in enumerate(pairwise(own)):
            if upper.which is None or lower.which is None:
                continue
            names = upper.which, lower.which
            if not known[list(names)].all():
                continue
            if upper.shape is not None and lower.shape is not None:
                now = upper.fit() + lower.fit()
                poor = min(upper.fit(), lower.fit()) < settings.poor
                halves = _neighbours_cut(upper.shape, lower.shape, column, settings) if poor else []
            else:
                now, whole = -np.inf, upper.shape or lower.shape
                halves = [] if whole is None else _halves(whole, column, settings)
            if halves:
                trials.append(_Trial(c, k, names, halves, now))
    return sorted(trials, key=lambda trial: np.isfinite(trial.now))  # what has no ink yet comes first


def _neighbours_cut(
    upper: CharacterShape, lower: CharacterShape, column: WrittenColumn, settings: RecutSettings
) -> list[tuple[CharacterShape, CharacterShape]]:
    """Two neighbours, cut in other places; nothing where they do not touch."""
    pace = column.places.pace
    end, begin = upper.corners[:, 1].max(), lower.corners[:, 1].min()
    if begin - end > settings.touching * pace or upper.small != lower.small:
        return []
    rows = (end + begin) / 2 + np.linspace(-settings.reach, settings.reach, settings.rows) * pace
    return _cuts(joined_shape(upper, lower, column.column), rows, column)


def _halves(
    whole: CharacterShape, column: WrittenColumn, settings: RecutSettings
) -> list[tuple[CharacterShape, CharacterShape]]:
    """One shape, cut in two in several places."""
    top, bottom = whole.corners[:, 1].min(), whole.corners[:, 1].max()
    return _cuts(whole, top + np.linspace(0.2, 0.8, settings.rows) * (bottom - top), column)


def _cuts(
    ink: CharacterShape, rows: FloatArray, column: WrittenColumn
) -> list[tuple[CharacterShape, CharacterShape]]:
    made = [cut_shape(ink, float(row), column.column) for row in np.unique(np.rint(rows))]
    return [cut for cut in made if cut is not None]
