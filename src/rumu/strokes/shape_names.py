"""Which characters the shapes on a page are, from what they look like: all of a page at once.

Shapes of one page that are alike are judged together, since a page repeats its characters; characters that
stand in common words are a little more likely; and a page that is sure of traditional characters has no
simplified ones. A name is given only where the best stands clear of all others: 己 and 已 seldom do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rumu.errors import RumuError
from rumu.registration.descriptor import describe_canvas
from rumu.registration.points import canvas_of
from rumu.strokes.recognition_model import RecognitionModel, Reform, recognition_model
from rumu.values import BoolArray, FloatArray, IntArray

Look = tuple[IntArray, IntArray]
"""Rows and columns of the ink of one character, (k,) each."""


@dataclass(frozen=True, slots=True)
class ShapeNamingSettings:
    """How shapes are named; likeness is a cosine.

    usage: what a character gains for each unit of the logarithm of its use. together: above which likeness
        two shapes of a page are judged together. clear: by how much the best must stand clear of the next.
    even, steep: the lead at which an answer is as often wrong as right, and by how much more of it the odds
        grow e-fold. reformed: share of the sure characters of the rarer kind, traditional or simplified,
        below which the page has none of that kind. elsewhere: what characters lose that no reference shows.
    fewest: pixels of ink that a shape must have.
    """

    usage: float = 0.01
    together: float = 0.5
    clear: float = 0.11
    even: float = 0.01
    steep: float = 0.027
    reformed: float = 0.2
    elsewhere: float = 0.05
    fewest: int = 30


NAMING = ShapeNamingSettings()


@dataclass(frozen=True, slots=True)
class ShapeName:
    """What a shape is taken for, None where that is not certain. certainty: 0-1, that the best is right."""

    character: str | None
    certainty: float


@dataclass(frozen=True, slots=True, eq=False)
class ReferenceShapes:
    """Characters as one hand writes or one print shows them. vectors: (n, L) descriptions."""

    characters: tuple[str, ...]
    vectors: FloatArray

    def __post_init__(self) -> None:
        if not self.characters or len(self.characters) != len(self.vectors):
            raise RumuError(
                f"expected a description for each of 1 or more reference characters, "
                f"got {len(self.vectors)} for {len(self.characters)}"
            )


def name_shapes(
    looks: Sequence[Look],
    *,
    references: ReferenceShapes | None = None,
    settings: ShapeNamingSettings = NAMING,
) -> list[ShapeName]:
    """Name the shapes of one page.

    looks: the ink of each, upright. references: with them, only their characters are named.
    """
    model = recognition_model()
    described = [_describe(look, settings) for look in looks]
    seen = [k for k, vector in enumerate(described) if vector is not None]
    names = [ShapeName(None, 0.0)] * len(looks)
    if not seen:
        return names
    vectors = model.project(np.array([vector for vector in described if vector is not None]))
    candidates = _candidates(vectors, model, references, settings)
    scores = _judged_together(vectors, candidates.scores, settings)
    order = np.argsort(-scores, axis=1)
    for row, k in enumerate(seen):
        first, second = order[row, :2]
        lead = float(scores[row, first] - scores[row, second])
        certainty = 1 / (1 + np.exp((settings.even - lead) / settings.steep))
        named = lead >= settings.clear and candidates.may_be_named[first]
        names[k] = ShapeName(candidates.characters[first] if named else None, float(certainty))
    return names


def describe_look(look: Look) -> FloatArray:
    """(L,): the description of the ink of one character. Raises RumuError where there is none to speak of."""
    y, x = look
    ink = np.zeros((int(np.ptp(y)) + 3, int(np.ptp(x)) + 3), dtype=bool)
    ink[y - y.min() + 1, x - x.min() + 1] = True
    return describe_canvas(canvas_of(ink).ink)


def _describe(look: Look, settings: ShapeNamingSettings) -> FloatArray | None:
    if len(look[0]) < settings.fewest:
        return None
    try:
        return describe_look(look)
    except RumuError:
        return None


@dataclass(frozen=True, slots=True, eq=False)
class _Candidates:
    """Characters that the shapes may be. scores: (shapes, n). may_be_named: (n,)."""

    characters: list[str]
    scores: FloatArray
    may_be_named: BoolArray


def _candidates(
    vectors: FloatArray,
    model: RecognitionModel,
    references: ReferenceShapes | None,
    settings: ShapeNamingSettings,
) -> _Candidates:
    scores = vectors @ model.vectors.T + settings.usage * model.usage
    characters = [chr(point) for point in model.code_points.tolist()]
    scores[:, _not_on_this_page(scores, model, settings)] = -1.0
    if references is None:
        return _Candidates(characters, scores, np.ones(len(characters), dtype=bool))
    column = {character: k for k, character in enumerate(characters)}
    for one in references.characters:
        column.setdefault(one, len(column))
    wider = np.full((len(vectors), len(column)), -1.0, dtype=np.float32)
    wider[:, : scores.shape[1]] = scores
    wanted = np.zeros(len(column), dtype=bool)
    wanted[[column[one] for one in references.characters]] = True
    wider[:, ~wanted] -= settings.elsewhere
    shown = vectors @ model.project(references.vectors).T
    usage = dict(zip(characters, model.usage.tolist(), strict=True))
    for k, one in enumerate(references.characters):
        own = shown[:, k] + settings.usage * usage.get(one, 0.0)
        wider[:, column[one]] = np.maximum(wider[:, column[one]], own)
    return _Candidates(list(column), wider, wanted)


def _not_on_this_page(
    scores: FloatArray, model: RecognitionModel, settings: ShapeNamingSettings
) -> BoolArray:
    """(n,) bool: simplified characters on a page of traditional ones, or traditional on one of simplified."""
    best = np.partition(scores, -2, axis=1)[:, -2:]
    sure = model.reform[scores.argmax(axis=1)[best[:, 1] - best[:, 0] >= settings.clear]]
    counts = {kind: np.count_nonzero(sure == kind) for kind in (Reform.TRADITIONAL, Reform.SIMPLIFIED)}
    rarer = min(counts, key=lambda kind: counts[kind])
    if counts[rarer] >= settings.reformed * sum(counts.values()):  # neither, or both
        return np.zeros(len(model.reform), dtype=bool)
    return np.asarray(model.reform == rarer)


def _judged_together(vectors: FloatArray, scores: FloatArray, settings: ShapeNamingSettings) -> FloatArray:
    """(shapes, n): for each shape the mean of its own scores and of those of shapes that are like it."""
    weights = np.maximum(vectors @ vectors.T - settings.together, 0.0)
    np.fill_diagonal(weights, 1 - settings.together)
    weights /= weights.sum(axis=1, keepdims=True)
    return np.asarray(weights @ scores)
