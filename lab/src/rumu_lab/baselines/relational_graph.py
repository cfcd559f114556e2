"""Attributed relational graph: lines with what each is, and how each pair stands to one another.

Known from the publication's abstract and captions: the reference is such a graph; stroke types D dot,
H horizontal, V vertical, S slash, B back slash, T tick, K hook. The attributes, the angles that part the
types and the five relations are our reconstruction. All lengths are in sides of the character's box, y up.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rumu.values import FloatArray, IntArray
from rumu_lab.baselines.lines import StrokeLine, angles_between

RELATIONS = ("apart", "parallel", "end-joint", "T-joint", "cross")
"""What an entry of `Graph.relation` stands for."""


@dataclass(frozen=True, slots=True)
class GraphSettings:
    """Angles and lengths that part the types of strokes and of relations.

    dot: length below which a line is a dot. upright: degrees from an axis for H and V. tick: steepest
    rising line, in degrees, that is a tick and no slash. hook: longest hook, and hook_turn: degrees it must
    turn from the line that it ends. parallel: degrees between parallels, overlap: share of the shorter one
    that faces the other, facing: the farthest apart that counts, in box sides.
    """

    dot: float = 0.18
    upright: float = 20.0
    tick: float = 45.0
    hook: float = 0.18
    hook_turn: float = 60.0
    parallel: float = 20.0
    overlap: float = 0.5
    facing: float = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """Where a character's box stands: (p - centre) / side with y turned up takes pixels to box sides."""

    centre: FloatArray
    side: float

    def to_box(self, line: StrokeLine) -> StrokeLine:
        """A line in pixels, y down, as one in box sides, y up."""
        return StrokeLine((line.points - self.centre) * (1.0, -1.0) / self.side, line.radius / self.side)


def frame_of(lines: Sequence[StrokeLine]) -> Frame:
    """The box around all lines in pixels, its longer side taken for both, so that directions stay.

    A line shorter than a tenth of the longest and far out would stretch the box: only the ends of lines that
    together hold 98 % of all length count.
    """
    lengths = np.array([line.length for line in lines])
    order = np.argsort(-lengths, kind="stable")
    kept = order[: 1 + int(np.searchsorted(np.cumsum(lengths[order]), 0.98 * lengths.sum()))]
    points = np.concatenate([lines[k].points for k in kept])
    low, high = points.min(axis=0), points.max(axis=0)
    return Frame((low + high) / 2, max(1.0, float((high - low).max())))


@dataclass(frozen=True, slots=True, eq=False)
class Traits:
    """Attributes of n directed lines. three: (n, 3, 2) start, middle, end. length: (n,).

    direction: (n,) degrees of the chord in (-180, 180], counter-clockwise from +x.
    """

    three: FloatArray
    length: FloatArray
    direction: FloatArray


def traits_of(lines: Sequence[StrokeLine]) -> Traits:
    """Start, middle, end, length and direction of directed lines."""
    three = np.array([line.at(np.array([0.0, 0.5, 1.0])) for line in lines]).reshape(-1, 3, 2)
    chords = three[:, 2] - three[:, 0]
    direction = np.degrees(np.arctan2(chords[:, 1], chords[:, 0]))
    return Traits(three, np.array([line.length for line in lines]), direction)


@dataclass(frozen=True, slots=True, eq=False)
class Graph:
    """The reference. lines: directed, in box sides. kinds: a letter of D H V S B T K for each.

    between: (n, n, 2), vector from the middle of i to that of j. bend: (n, n), direction of j less that of i,
    degrees in (-180, 180]. relation: (n, n), a number of RELATIONS.
    """

    lines: tuple[StrokeLine, ...]
    traits: Traits
    kinds: tuple[str, ...]
    between: FloatArray
    bend: FloatArray
    relation: IntArray


def graph_of(lines: Sequence[StrokeLine], *, width: float, settings: GraphSettings | None = None) -> Graph:
    """The relational graph of lines in box sides; width: of a stroke, in box sides.

    Each line is directed as a brush writes it: to the right, or downward where it falls steeply.
    """
    settings = settings or GraphSettings()
    written = tuple(line if _forward(line) else line.reversed() for line in lines)
    traits = traits_of(written)
    kinds = tuple(_kind(k, traits, width=width, settings=settings) for k in range(len(written)))
    between, bend = differences(traits)
    relation = relations(traits, width=width, settings=settings)
    return Graph(written, traits, kinds, between, bend, relation)


def _forward(line: StrokeLine) -> bool:
    """To the right, or down; what rises to the right at less than the angle of a tick is written so."""
    right, up = line.chord
    return bool(right > up) if right >= 0 else bool(-up >= -right)


def differences(traits: Traits) -> tuple[FloatArray, FloatArray]:
    """(n, n, 2) vectors from middle i to middle j, and (n, n) turning from direction i to direction j."""
    middle = traits.three[:, 1]
    bend = wrap_degrees(traits.direction[None] - traits.direction[:, None])
    return np.asarray(middle[None] - middle[:, None]), bend


def wrap_degrees(degrees: FloatArray) -> FloatArray:
    """Degrees brought to (-180, 180]."""
    return np.asarray(180.0 - np.mod(180.0 - degrees, 360.0))


def _kind(k: int, traits: Traits, *, width: float, settings: GraphSettings) -> str:
    length, direction = float(traits.length[k]), float(traits.direction[k])
    if length < settings.hook and _ends_another(k, traits, width=width, settings=settings):
        return "K"
    if length < settings.dot:
        return "D"
    if abs(direction) < settings.upright:
        return "H"
    if abs(abs(direction) - 90.0) < settings.upright:
        return "V"
    if 0.0 < direction <= settings.tick:
        return "T"
    return "B" if -90.0 < direction < 0.0 else "S"


def _ends_another(k: int, traits: Traits, *, width: float, settings: GraphSettings) -> bool:
    """Whether line k starts or stops where a line twice as long stops, and turns sharply from it."""
    tips = traits.three[k][[0, 2]]
    others = [j for j in range(len(traits.length)) if traits.length[j] > 2.0 * traits.length[k]]
    for j in others:
        gaps = np.linalg.norm(tips - traits.three[j, 2], axis=1)
        near = int(gaps.argmin())
        away = tips[1 - near] - tips[near]
        if (
            gaps[near] < width
            and angles_between(traits.three[j, 2] - traits.three[j, 1], away) > settings.hook_turn
        ):
            return True
    return False


def relations(traits: Traits, *, width: float, settings: GraphSettings | None = None) -> IntArray:
    """(n, n) numbers of RELATIONS, symmetric, the diagonal 0.

    Each line counts as two straight pieces through its middle. Nearer than a stroke's width they touch: at
    an end of both, of one, or of none. Without touching they are parallel, or apart.
    """
    settings = settings or GraphSettings()
    gap, place_one, place_two = _nearest(traits)
    inner_one, inner_two = (
        np.minimum(place, 1.0 - place) * length > 0.6 * width
        for place, length in ((place_one, traits.length[:, None]), (place_two, traits.length[None]))
    )
    touching = gap <= width
    codes = np.where(touching, 2 + inner_one.astype(int) + inner_two.astype(int), 0)
    codes = np.where(~touching & _parallel(traits, settings), 1, codes)
    np.fill_diagonal(codes, 0)
    return np.asarray(codes, dtype=np.intp)


def _parallel(traits: Traits, settings: GraphSettings) -> np.ndarray:
    chords = traits.three[:, 2] - traits.three[:, 0]
    lengths = np.maximum(np.linalg.norm(chords, axis=1), 1e-9)
    units = chords / lengths[:, None]
    rel = traits.three[None, :, ::2] - traits.three[:, None, :1]  # ends of j from the start of i
    share = np.sort((rel * units[:, None, None]).sum(axis=-1), axis=-1)
    common = np.minimum(share[..., 1], lengths[:, None]) - np.maximum(share[..., 0], 0.0)
    faces = common >= settings.overlap * np.minimum(lengths[:, None], lengths[None])
    bend = np.abs(wrap_degrees(traits.direction[None] - traits.direction[:, None]))
    near = np.linalg.norm(traits.three[None, :, 1] - traits.three[:, None, 1], axis=-1) <= settings.facing
    return np.asarray((np.minimum(bend, 180.0 - bend) <= settings.parallel) & near & (faces | faces.T))


def _nearest(traits: Traits) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(n, n) least distance between lines i and j, and where on i and on j, as shares of their length."""
    best: list[FloatArray] | None = None
    for a in (0, 1):
        for b in (0, 1):
            first = traits.three[:, None, a], traits.three[:, None, a + 1]
            second = traits.three[None, :, b], traits.three[None, :, b + 1]
            gap, one, two = _between_pieces(*first, *second)
            found = [gap, (a + one) / 2, (b + two) / 2]
            if best is None:
                best = found
            else:
                nearer = gap < best[0] - 1e-9
                best = [np.where(nearer, new, old) for new, old in zip(found, best, strict=True)]
    assert best is not None
    return best[0], best[1], best[2]


def _between_pieces(
    p: FloatArray, p_end: FloatArray, q: FloatArray, q_end: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Least distance of straight pieces (..., 2), broadcast, and the shares along each where it is taken."""
    u, v, w = p_end - p, q_end - q, p - q
    a, b, c = (u * u).sum(-1), (u * v).sum(-1), (v * v).sum(-1)
    d, e = (u * w).sum(-1), (v * w).sum(-1)
    area = a * c - b * b
    s = np.clip((b * e - c * d) / np.where(area > 1e-12, area, 1.0), 0.0, 1.0) * (area > 1e-12)
    t = np.clip((b * s + e) / np.maximum(c, 1e-12), 0.0, 1.0)
    s = np.clip((b * t - d) / np.maximum(a, 1e-12), 0.0, 1.0)
    gap = np.linalg.norm(w + s[..., None] * u - t[..., None] * v, axis=-1)
    return np.asarray(gap), np.asarray(s), np.asarray(t)
