"""How a page without printed lines lies, told by its columns and rows of characters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.capture.image import Bytes
from rumu.pages.page_ink import find_page_ink
from rumu.pages.page_parts import weighted_quantile
from rumu.pages.vanishing_points import VanishingSettings, other_point, turn_matrix, view_from_above
from rumu.values import BoolArray, FloatArray


@dataclass(frozen=True, slots=True)
class TextViewSettings:
    """How the gaps between columns and rows are looked for.

    The ink is laid onto a line across the columns, and the sharper the steps of its sums are, the better the
    view. points: of ink that are asked, at most; least: at least. largest: the longer side of a part that may
    be a character, as a share of the picture's. step: of the sums, in sizes of a character.
    lean: how far columns and rows may lean from the way both run best, in degrees; angles: between two that
    are tried. narrowing: by how much columns may come nearer to each other from the middle of the picture to
    its edge, as a share; narrowings: how many are tried; gain: how much sharper the steps must become for
    columns that are not parallel. clear: how much sharper than at other angles the
    steps must be.
    """

    points: int = 24_000
    least: int = 1_500
    largest: float = 0.15
    step: float = 0.15
    lean: float = 8.0
    angles: float = 0.25
    narrowing: float = 0.3
    narrowings: int = 13
    gain: float = 1.12
    clear: float = 1.6


def view_by_text(
    picture: Bytes, *, vanishing: VanishingSettings, settings: TextViewSettings | None = None
) -> FloatArray | None:
    """(3, 3) the view from above of a reduced photograph, centred points; None where no columns show.

    picture: (h, w, 3) uint8 sRGB. Where only columns or only rows show clearly, the page is taken to be as
    little tilted as they allow.
    """
    settings = settings or TextViewSettings()
    points, size = _points_of_ink(find_page_ink(picture).ink, settings)
    if len(points) < settings.least:
        return None
    longer = max(picture.shape[:2])
    step = max(1.0, settings.step * size)
    turns = np.arange(-45.0, 45.0, 1.0)
    sharp = np.array([_sharpness(points, turn, 0.0, longer, step) for turn in turns])
    sharp_across = np.array([_sharpness(points, turn + 90, 0.0, longer, step) for turn in turns])
    base = float(turns[np.argmax(np.maximum(sharp, sharp_across))])
    usual = float(np.median(np.concatenate([sharp, sharp_across])))
    found = [_best_family(points, base + way, longer, step, settings) for way in (0.0, 90.0)]
    clear = [one[0] > settings.clear * usual for one in found]
    if not any(clear):
        return None
    down, right = (_vanishing_point(turn, narrowing, longer) for _, turn, narrowing in found)
    if not clear[0]:
        down = other_point(right, longer, settings=vanishing)
    if not clear[1]:
        right = other_point(down, longer, settings=vanishing)
    back = turn_matrix(-base)
    matrix = view_from_above(back @ right, back @ down, longer, settings=vanishing)
    return None if matrix is None else matrix @ back


def _points_of_ink(ink: BoolArray, settings: TextViewSettings) -> tuple[FloatArray, float]:
    """(n, 2) centred points of parts that may be characters, and about what a character measures."""
    import cv2

    _, labels, stats, _ = cv2.connectedComponentsWithStats(ink.view(np.uint8), connectivity=8)
    sides = stats[:, 2:4].astype(float)
    chosen = (sides.max(axis=1) < settings.largest * max(ink.shape)) & (sides.min(axis=1) > 2)
    chosen[0] = False
    if not chosen.any():
        return np.zeros((0, 2)), 1.0
    size = weighted_quantile(sides[chosen].min(axis=1), stats[chosen, 4].astype(float), 0.75)
    y, x = np.nonzero(chosen[labels])
    every = max(1, len(y) // settings.points)
    points = np.column_stack([x, y]).astype(float)[::every]
    return points - (np.array(ink.shape[::-1]) - 1) / 2, size


def _sharpness(points: FloatArray, turn: float, narrowing: float, longer: int, step: float) -> float:
    """How sharp the steps are of the ink summed along lines down the page, turned by so many degrees.

    narrowing: see `TextViewSettings`.
    """
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    across = points[:, 0] * c + points[:, 1] * s
    if narrowing:
        across = across / (1 + narrowing * (points[:, 1] * c - points[:, 0] * s) / (longer / 2))
    place = np.floor((across + longer) / step).astype(np.intp)
    sums = np.bincount(np.clip(place, 0, int(2 * longer / step)), minlength=int(2 * longer / step) + 1)
    return float((np.diff(sums.astype(float)) ** 2).sum()) / len(points) ** 2


def _best_family(
    points: FloatArray, turn: float, longer: int, step: float, settings: TextViewSettings
) -> tuple[float, float, float]:
    """Sharpness, turn and narrowing of the lines near a turn whose steps are sharpest."""
    turns = turn + np.arange(-settings.lean, settings.lean + 1e-6, 2 * settings.angles)
    narrowings = np.linspace(-settings.narrowing, settings.narrowing, settings.narrowings)
    tried = [(_sharpness(points, a, n, longer, step), float(a), float(n)) for a in turns for n in narrowings]
    parallel = max(one for one in tried if abs(one[2]) < 1e-9)
    sharpest = max(tried)
    if sharpest[0] < settings.gain * parallel[0]:
        near = parallel[1] + settings.angles * np.arange(-2, 3)
        return max((_sharpness(points, a, 0.0, longer, step), float(a), 0.0) for a in near)
    _, best_turn, best_narrowing = sharpest
    fine = (narrowings[1] - narrowings[0]) * np.array([-0.5, -0.25, 0.0, 0.25, 0.5])
    near = best_turn + settings.angles * np.arange(-2, 3)
    return max(
        (_sharpness(points, a, best_narrowing + n, longer, step), float(a), float(best_narrowing + n))
        for a in near
        for n in fine
    )


def _vanishing_point(turn: float, narrowing: float, longer: int) -> FloatArray:
    """(3,) homogeneous: where lines turned so run to that narrow so."""
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    along = np.array([-s, c])
    return np.array([*(-along * longer / 2), narrowing])
