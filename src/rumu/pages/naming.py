"""Names for the characters of a page from a text: what the ink looks like, and what stands next to what."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.pages.character_shapes import CharacterShape, joined_shape
from rumu.pages.free_page import FreePage, WrittenColumn
from rumu.pages.recutting import Draft, Words, cut_anew, look_of
from rumu.pages.text_alignment import Aligned, FoundCharacters, Step, align, distinct_characters, read_text

_BESIDE = 0.5
"""Share of the lower of two shapes at whose height the other must stand, where both may be one character."""


@dataclass(frozen=True, slots=True, eq=False)
class NamedShape:
    """A character with its name, None where the text has none for it, and how sure the name is, 0-1."""

    shape: CharacterShape
    name: str | None
    certainty: float


def name_characters(page: FreePage, text: str) -> list[list[NamedShape]]:
    """The characters of each column of a page, named by the text; parted or joined where the text says so."""
    given = read_text(text)
    different, which = distinct_characters(given.characters)
    words = Words(different, page.direction)
    shapes = [(column, shape) for column in page.columns for shape in column.shapes]
    if not shapes:
        return [[] for _ in page.columns]
    found = _found(shapes, words)
    steps = align(found, which, given.starts)
    drafts = _drafts(steps, shapes, which.tolist(), found)
    return _named(cut_anew([drafts[id(column)] for column in page.columns], page.columns, words), words)


def _found(shapes: list[tuple[WrittenColumn, CharacterShape]], words: Words) -> FoundCharacters:
    n = len(shapes)
    mergeable, beside = np.zeros((2, n), dtype=bool)
    both = []
    for k in range(n - 1):
        (column, first), (other, second) = shapes[k], shapes[k + 1]
        if column is other and _may_be_one(first, second, pace=column.places.pace):
            mergeable[k], beside[k] = True, first.small != second.small
            both.append((np.concatenate([first.y, second.y]), np.concatenate([first.x, second.x])))
    z = words.likeness([look_of(shape) for _, shape in shapes])
    z_merged = np.zeros_like(z)
    if both:
        z_merged[mergeable] = words.likeness(both)
    height = [np.ptp(shape.corners[:, 1]) / column.places.pace for column, shape in shapes]
    return FoundCharacters(
        z=z,
        z_merged=z_merged,
        mergeable=mergeable,
        beside=beside,
        small=np.array([shape.small is not None for _, shape in shapes]),
        height=np.array(height),
        first=np.array([k == 0 or shapes[k][0] is not shapes[k - 1][0] for k in range(n)]),
        known=words.known,
    )


def _may_be_one(first: CharacterShape, second: CharacterShape, *, pace: float) -> bool:
    """Whether two shapes of a column may be one character, above each other or its right and left part."""
    (top, bottom), (other_top, other_bottom) = (
        (shape.corners[:, 1].min(), shape.corners[:, 1].max()) for shape in (first, second)
    )
    if first.small == second.small:
        return bool(other_bottom - top < 1.6 * pace)
    overlap = min(bottom, other_bottom) - max(top, other_top)
    return bool(overlap > _BESIDE * min(bottom - top, other_bottom - other_top))


def _drafts(
    steps: list[Aligned],
    shapes: list[tuple[WrittenColumn, CharacterShape]],
    which: list[int],
    found: FoundCharacters,
) -> dict[int, list[Draft]]:
    """For each column, by its id, what the alignment says of its characters."""
    drafts: dict[int, list[Draft]] = {id(column): [] for column, _ in shapes}
    for step, after in zip(steps, [*steps[1:], None], strict=True):
        column, shape = shapes[min(step.found, len(shapes) - 1)]
        own = drafts[id(column)]
        if step.step == Step.SKIP_TEXT:
            alone = (
                after is not None
                and after.step == Step.MATCH
                and own
                and own[-1].which == which[step.text - 1]
            )
            if alone and step.text:  # between two neighbours that are in their places
                own.append(Draft(None, which[step.text]))
        elif step.step == Step.SKIP_FOUND:
            own.append(Draft(shape, None, found.z[step.found]))
        elif step.step == Step.MERGE:
            lower = shapes[step.found + 1][1]
            both = joined_shape(shape, lower, column.column)
            own.append(Draft(both, which[step.text], found.z_merged[step.found]))
        else:
            own.append(Draft(shape, which[step.text], found.z[step.found]))
            if step.step == Step.SPLIT:
                own.append(Draft(None, which[step.text + 1]))
    return drafts


def _named(drafts: list[list[Draft]], words: Words) -> list[list[NamedShape]]:
    return [[_name(draft.shape, draft, words) for draft in own if draft.shape is not None] for own in drafts]


def _name(shape: CharacterShape, draft: Draft, words: Words) -> NamedShape:
    if draft.which is None:
        return NamedShape(shape, None, 1.0)
    certainty = _certainty(draft.fit(), bool(words.known[draft.which]))
    return NamedShape(shape, words.different[draft.which], certainty)


def _certainty(z: float, known: bool) -> float:
    """How sure a name is whose character fits by z."""
    return float(np.clip(0.55 + 0.25 * (z - 0.5), 0.2, 1.0)) if known else 0.7
