"""Names for the characters of a page from a text: what the ink looks like, and what stands next to what."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.pages.character_shapes import CharacterShape, cut_shape, joined_shape
from rumu.pages.free_page import FreePage, WrittenColumn
from rumu.pages.glyph_likeness import Floats, describe_ink, describe_printed, likeness
from rumu.pages.page import Direction
from rumu.pages.text_alignment import (
    Aligned,
    FoundCharacters,
    Step,
    align,
    lay_out,
    read_text,
)
from rumu.values import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class NamedShape:
    """A character with its name, None where the text has none for it, and how sure the name is, 0-1."""

    shape: CharacterShape
    name: str | None
    certainty: float


@dataclass(frozen=True, slots=True, eq=False)
class _Text:
    """The text as the alignment needs it: its different characters, their looks, which stands where."""

    different: list[str]
    printed: Floats
    known: BoolArray
    which: IntArray
    starts: BoolArray


def name_characters(page: FreePage, text: str) -> list[list[NamedShape]]:
    """The characters of each column of a page, named by the text; parted or joined where the text says so."""
    given = read_text(text)
    different, which = lay_out(given.characters)
    printed, known = describe_printed(different)
    words = _Text(different, printed, known, which, given.starts)
    shapes = [(column, shape) for column in page.columns for shape in column.shapes]
    z, found = _found(shapes, words, page.direction)
    named: dict[int, list[NamedShape]] = {id(column): [] for column in page.columns}
    for step in align(found, which, given.starts):
        if step.step != Step.SKIP_TEXT:
            named[id(shapes[step.found][0])] += _named(step, shapes, words, z, page.direction)
    return [named[id(column)] for column in page.columns]


def _found(
    shapes: list[tuple[WrittenColumn, CharacterShape]], words: _Text, direction: Direction
) -> tuple[FloatArray, FoundCharacters]:
    n = len(shapes)
    one = [_upright(shape.y, shape.x, direction) for _, shape in shapes]
    mergeable = np.zeros(n, dtype=bool)
    both = []
    for k in range(n - 1):
        (column, upper), (other, lower) = shapes[k], shapes[k + 1]
        high = lower.corners[:, 1].max() - upper.corners[:, 1].min()
        if column is other and upper.small == lower.small and high < 1.6 * column.places.pace:
            mergeable[k] = True
            y, x = np.concatenate([upper.y, lower.y]), np.concatenate([upper.x, lower.x])
            both.append(_upright(y, x, direction))
    z = likeness(describe_ink(one), words.printed, words.known)
    z_merged = np.zeros_like(z)
    if both:
        z_merged[mergeable] = likeness(describe_ink(both), words.printed, words.known)
    first = [k == 0 or shapes[k][0] is not shapes[k - 1][0] for k in range(n)]
    height = [np.ptp(shape.corners[:, 1]) / column.places.pace for column, shape in shapes]
    return z, FoundCharacters(
        z=z,
        z_merged=z_merged,
        mergeable=mergeable,
        small=np.array([shape.small is not None for _, shape in shapes]),
        height=np.array(height),
        first=np.array(first),
        known=words.known,
    )


def _upright(y: IntArray, x: IntArray, direction: Direction) -> tuple[IntArray, IntArray]:
    """Rows and columns on the page of pixels, which were swapped where the page is written in rows."""
    return (y, x) if direction == "vertical" else (x, y)


def _named(
    step: Aligned,
    shapes: list[tuple[WrittenColumn, CharacterShape]],
    words: _Text,
    z: FloatArray,
    direction: Direction,
) -> list[NamedShape]:
    """The named characters that one step of the alignment makes."""
    column, shape = shapes[step.found]
    if step.step == Step.SKIP_FOUND:
        return [NamedShape(shape, None, 1.0)]
    which = int(words.which[step.text])
    if step.step == Step.MATCH:
        return [
            NamedShape(shape, words.different[which], _certainty(z[step.found, which], words.known[which]))
        ]
    if step.step == Step.MERGE:
        whole = joined_shape(shape, shapes[step.found + 1][1], column.column)
        return [NamedShape(whole, words.different[which], 0.7)]
    after = int(words.which[step.text + 1])
    halves = _best_cut(shape, column, words, (which, after), direction)
    return [NamedShape(half, words.different[k], 0.6) for half, k in zip(halves, (which, after), strict=True)]


def _best_cut(
    shape: CharacterShape,
    column: WrittenColumn,
    words: _Text,
    which: tuple[int, int],
    direction: Direction,
) -> tuple[CharacterShape, CharacterShape]:
    """A shape cut in two where its halves look most like these two characters of the text."""
    top, bottom = shape.y.min(), shape.y.max() + 1
    rows = np.unique(np.rint(np.linspace(top + 0.25 * (bottom - top), top + 0.75 * (bottom - top), 9)))
    made = [cut_shape(shape, float(row), column.column) for row in rows]
    cuts = [cut for cut in made if cut is not None] or [(shape, shape)]
    looks = describe_ink([_upright(half.y, half.x, direction) for cut in cuts for half in cut])
    alike = looks @ words.printed[list(which)].T
    best = int(np.argmax(alike[0::2, 0] + alike[1::2, 1]))
    return cuts[best]


def _certainty(z: float, known: bool) -> float:
    """How sure a name is whose character fits by z."""
    return float(np.clip(0.55 + 0.25 * (z - 0.5), 0.2, 1.0)) if known else 0.7
