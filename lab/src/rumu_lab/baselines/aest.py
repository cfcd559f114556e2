"""AEST-based grader (our reconstruction): coordination, balance, distribution.

After Ma and Su, "Aesthetics evaluation for robotic Chinese calligraphy", IEEE Transactions on Cognitive and
Developmental Systems 9(1), 2017, of which the abstract was read.

Known from there: a robot plans each stroke so that the whole looks best; how good it looks is characterised
by three indexes. That they are coordination, balance and distribution, and are summed with weights, is how
later authors report it.
Reconstructed by us: every formula, and the weights.

Decided where the reconstruction left it open: a robot knows its strokes, a picture does not, so lines of
copy and reference are paired after both are brought to one centre and size (`stroke_pairs`). A relation of
two strokes weighs the product of their lengths, as the direction of a spur or a dot is chance, and
coordination is multiplied by the share of all length that has a partner, so that missing and extra strokes
cost. The mesh is elastic in that each character has its own: inner lines that leave a third of the ink on
either side. Gaps are taken at one size, since balance charges size; two strokes that no longer face each
other differ by one unit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from rumu.values import FloatArray
from rumu_lab.baselines.cell import SIDE, Cell, Raw
from rumu_lab.baselines.lines import StrokeLine, lines_of, skeleton_of
from rumu_lab.baselines.stroke_pairs import (
    Curves,
    curves_of,
    cut_alike,
    directions_apart,
    middles_apart,
    pair_lines,
)
from rumu_lab.baselines.white_gaps import elastic_shares, mesh_of, white_gaps

INDEXES = ("coordination", "balance", "distribution")


@dataclass(frozen=True, slots=True)
class AestSettings:
    """What counts as one unit of difference, and where each index falls to 1/e.

    weights: of the INDEXES in the grade. doubling: ratio of lengths, or of widths, that is one unit; angle:
    degrees that are. units: mean units at which coordination falls to 1/e. offset: of the centre, in cells,
    at which balance does; gap: difference of white, in cells, at which distribution does. reach: of a
    pair's places, in cells.
    """

    weights: tuple[float, float, float] = (0.4, 0.3, 0.3)
    doubling: float = 2.0
    angle: float = 30.0
    units: float = 3.0
    offset: float = 0.06
    gap: float = 0.08
    reach: float = 0.1


def raw(probe: Cell, reference: Cell) -> Raw:
    """The weighted sum of the three indexes.

    features: the three INDEXES, each in [0, 1]; paired, the share of the strokes'
    length that has a partner; ink, the share of the mesh that agrees; white, of the gaps.
    """
    settings = AestSettings()
    lines = _pair_lines(probe, reference, settings)
    coordination = lines.coordination(settings)
    ink = 1.0 - 0.5 * float(np.abs(_shares(probe) - _shares(reference)).sum())
    white = _white(probe, reference, lines, settings)
    indexes = np.array([coordination, balance(probe, reference, settings=settings), ink * white])
    grade = float(indexes @ np.array(settings.weights))
    values = dict(zip(INDEXES, map(float, indexes), strict=True))
    return Raw(float(np.clip(grade, 0.0, 1.0)), {**values, "paired": lines.share, "ink": ink, "white": white})


# --- coordination ---------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class _LinePairs:
    """Lines of both, cut alike, in pixels of their cells.

    pairs: numbers (reference, copy). scale: what makes
    the copy as large as the reference.
    """

    reference: tuple[StrokeLine, ...]
    copy: tuple[StrokeLine, ...]
    pairs: tuple[tuple[int, int], ...]
    scale: float

    @property
    def share(self) -> float:
        """Of the length of all lines, those paired counted once, in [0, 1]."""
        with_partner, lone = (sum(line.length for line in lines) for lines in self._split())
        return with_partner / (with_partner + lone)

    def _split(self) -> tuple[list[StrokeLine], list[StrokeLine]]:
        """Lines of the reference that have a partner; lines of both that have none."""
        i, j = ({pair[k] for pair in self.pairs} for k in (0, 1))
        alone = [line for k, line in enumerate(self.reference) if k not in i]
        alone += [line for k, line in enumerate(self.copy) if k not in j]
        return [self.reference[k] for k in sorted(i)], alone

    def coordination(self, settings: AestSettings) -> float:
        """How well the relations among strokes, of length, direction and width, agree; in [0, 1]."""
        if len(self.pairs) < 2:  # a single stroke has no relations
            return self.share
        i, j = np.array(self.pairs, dtype=np.intp).T
        one, two = curves_of([self.reference[n] for n in i]), curves_of([self.copy[n] for n in j])
        upper = np.triu_indices(len(i), k=1)
        weight = np.outer(one.length, one.length)[upper]
        mean = float(weight @ relations_apart(one, two, settings=settings)[upper] / weight.sum())
        return self.share * float(np.exp(-mean / settings.units))


def relations_apart(one: Curves, two: Curves, *, settings: AestSettings) -> FloatArray:
    """(k, k) units by which the relation of lines i and j in `two` differs from that in `one`."""
    unit = np.log(settings.doubling)
    lengths, widths = (
        np.log(np.maximum(a, 1e-6) / np.maximum(b, 1e-6))
        for a, b in ((one.length, two.length), (one.radius.mean(axis=1), two.radius.mean(axis=1)))
    )
    turned = (one.direction - two.direction) % 180.0
    bend = np.abs(turned[:, None] - turned[None])
    bend = np.minimum(bend, 180.0 - bend)
    of_length, of_width = (np.abs(v[:, None] - v[None]) / unit for v in (lengths, widths))
    return np.asarray(of_length + bend / settings.angle + of_width)


def _pair_lines(probe: Cell, reference: Cell, settings: AestSettings) -> _LinePairs:
    """The lines of both paired where the copy is brought to the reference's centre and size."""
    own, model = lines_of(probe), lines_of(reference)
    (p, p_radius), (q, q_radius) = _frame(own), _frame(model)
    scale = q_radius / p_radius
    moved = [replace(line, points=(line.points - p) * scale + q, radius=line.radius * scale) for line in own]
    copy, lines = cut_alike(moved, model, width=skeleton_of(reference).width)
    one, two = (
        curves_of([StrokeLine(line.points / SIDE, line.radius / SIDE) for line in some])
        for some in (lines, copy)
    )
    lengths = one.length[:, None], two.length[None]
    worth = (
        np.exp(-middles_apart(one, two) / settings.reach)
        + np.minimum(*lengths) / np.maximum(*lengths)
        + np.maximum(0.0, 1.0 - directions_apart(one, two) / 45.0)
    ) / 3.0
    back = tuple(
        replace(line, points=(line.points - q) / scale + p, radius=line.radius / scale) for line in copy
    )
    return _LinePairs(tuple(lines), back, tuple(pair_lines(worth, one, two)), scale)


def _frame(lines: Sequence[StrokeLine]) -> tuple[FloatArray, float]:
    """Centroid and rms radius of all lines, each point weighing the length it stands for."""
    points = np.concatenate([line.points for line in lines])
    weight = np.concatenate([np.gradient(line.along) for line in lines])
    centre = weight @ points / weight.sum()
    radius = float(np.sqrt(weight @ ((points - centre) ** 2).sum(axis=1) / weight.sum()))
    return centre, max(radius, 1e-6)


# --- balance --------------------------------------------------------------------------------------------


def balance(probe: Cell, reference: Cell, *, settings: AestSettings) -> float:
    """How near the centre of the ink and its spread in both directions are to the reference's; in [0, 1]."""
    (g, M), (g_ref, M_ref) = _moments(probe), _moments(reference)
    offset = float(np.linalg.norm(g - g_ref))
    spread = float(np.linalg.norm(M - M_ref) / max(float(np.linalg.norm(M_ref)), 1e-12))
    return float(np.exp(-offset / settings.offset - spread))


@lru_cache(maxsize=64)
def _moments(cell: Cell) -> tuple[FloatArray, FloatArray]:
    """(2,) centroid of the ink and (2, 2) covariance, in cells."""
    mass = _mass(cell)
    at = (np.arange(SIDE) + 0.5) / SIDE
    total = float(mass.sum())
    across, down = mass.sum(axis=0) / total, mass.sum(axis=1) / total
    x, y = float(across @ at), float(down @ at)
    xy = float((at - y) @ mass @ (at - x)) / total
    return np.array([x, y]), np.array(
        [[float(across @ (at - x) ** 2), xy], [xy, float(down @ (at - y) ** 2)]]
    )


def _mass(cell: Cell) -> FloatArray:
    """(SIDE, SIDE) float64: the density on the ink; the ink itself where it has none."""
    mass = np.where(cell.ink, cell.density, 0.0).astype(float)
    return mass if mass.sum() > 0 else cell.ink.astype(float)


# --- distribution ---------------------------------------------------------------------------------------


@lru_cache(maxsize=64)
def _shares(cell: Cell) -> FloatArray:
    """(9,) share of the ink in each cell of the character's own mesh."""
    mass = _mass(cell)
    return elastic_shares(mass, mesh_of(mass))


def _white(probe: Cell, reference: Cell, lines: _LinePairs, settings: AestSettings) -> float:
    """exp(-mean difference of the gaps between neighbours of the reference that were both found)."""
    width = skeleton_of(reference).width
    model = white_gaps(reference.ink, lines.reference, least=width)
    own = white_gaps(probe.ink, lines.copy, least=0.5 * width / lines.scale)
    partner = dict(lines.pairs)
    apart = []
    for (i, j), gap in model.items():
        if i in partner and j in partner:
            a, b = sorted((partner[i], partner[j]))
            apart.append(abs(gap - lines.scale * own[a, b]) if (a, b) in own else settings.gap)
    return float(np.exp(-np.mean(apart) / settings.gap)) if apart else 1.0
