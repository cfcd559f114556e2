"""VICP-based grader (our reconstruction): disk B-spline vectorisation and iterative closest points.

After Wang, Fu, Wang, Wu and Zhou, "Evaluation of Chinese calligraphy by using DBSC vectorization and ICP
algorithm", Mathematical Problems in Engineering, 2016, of which the abstract and the opening were read.

Known from there: a character of any size, place and slant; promising candidates from a data base by angular
difference relations, so that it need not be known; these, vectorised as disk B-spline curves, are checked by
ICP on the skeleton and the best one wins; global and local (stroke) similarity make one composite score.
Reconstructed by us: the fit (`disk_spline`), the pairs and starts of ICP (`similarity_icp`), which stroke is
which (`stroke_pairs`), and every formula of the similarities below.

The character is known here, so the retrieval of candidates is left out. Decided where the reconstruction left
it open: the seven starts lie within 45 degrees of upright, as a turn of
90 makes another character of some; strokes are cut at corners; distances are in sides of the cell; the
weights of the strokes run over the reference's and over those of the copy that have no partner, which count
0, so that both a missing and an extra stroke cost. Slant, size and place are removed by ICP, reported, and
not charged: that is the idea of the method.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rumu.values import BoolArray, FloatArray
from rumu_lab.baselines.cell import SIDE, Cell, Raw
from rumu_lab.baselines.disk_spline import fit_disk_spline, sweep
from rumu_lab.baselines.lines import StrokeLine, lines_of, skeleton_of
from rumu_lab.baselines.overlap import iou
from rumu_lab.baselines.similarity_icp import Similarity, SimilarityIcpSettings, similarity_icp
from rumu_lab.baselines.stroke_pairs import (
    Curves,
    curves_of,
    cut_alike,
    directions_apart,
    middles_apart,
    orient,
    pair_lines,
)


@dataclass(frozen=True, slots=True)
class VicpSettings:
    """Where the similarities of strokes fall, and what the parts weigh.

    points: of the skeleton for ICP. position, shape: the distances, in cells,
    at which these similarities fall to 1/e; askew: degrees at which that of direction reaches 0. whole: share
    of the global similarity in the composite.
    """

    points: int = 800
    position: float = 0.1
    shape: float = 0.05
    askew: float = 45.0
    whole: float = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class VectorCharacter:
    """A character as disk B-spline curves.

    lines: their centre lines, pixels. skeleton: (n, 2) points evenly
    along them. width: of a stroke, pixels.
    """

    lines: tuple[StrokeLine, ...]
    skeleton: FloatArray
    width: float


@lru_cache(maxsize=64)
def vectorise(cell: Cell) -> VectorCharacter:
    """The strokes of a cell as disk B-spline curves, with what ICP needs of them."""
    width = skeleton_of(cell).width
    lines = tuple(fit_disk_spline(line, width=width).line() for line in lines_of(cell))
    return VectorCharacter(lines, _evenly(lines, VicpSettings().points), width)


def _evenly(lines: Sequence[StrokeLine], count: int) -> FloatArray:
    """About `count` points at equal steps along all lines."""
    total = sum(line.length for line in lines)
    shares = [
        (np.arange(k) + 0.5) / k for line in lines for k in [max(2, round(count * line.length / total))]
    ]
    return np.concatenate([line.at(share) for line, share in zip(lines, shares, strict=True)])


# --- grading --------------------------------------------------------------------------------------------


@lru_cache(maxsize=32)
def lay_on(probe: Cell, reference: Cell) -> Similarity:
    """The copy's skeleton laid on the reference's, in pixels of the cell."""
    return similarity_icp(
        vectorise(probe).skeleton, vectorise(reference).skeleton, settings=SimilarityIcpSettings()
    )


def raw(probe: Cell, reference: Cell) -> Raw:
    """The composite of global and local similarity.

    features: whole, the overlap of the areas; strokes, the mean similarity of the strokes;
    its five parts position, length, direction, shape, thickness over those paired; paired, their share of the
    length; residual, of ICP, in cells; size, ln of the scale that was needed, and lean, degrees clockwise.
    """
    settings = VicpSettings()
    pose = lay_on(probe, reference)
    moved = [StrokeLine(pose(line.points), line.radius * pose.scale) for line in vectorise(probe).lines]
    whole = iou(sweep(moved, side=SIDE), _area(reference))
    local, parts = _stroke_similarity(moved, vectorise(reference), settings)
    grade = settings.whole * whole + (1.0 - settings.whole) * local
    return Raw(
        float(np.clip(grade, 0.0, 1.0)),
        {
            "whole": whole,
            "strokes": local,
            **parts,
            "residual": pose.residual / SIDE,
            "size": -float(np.log(pose.scale)),
            "lean": -pose.angle,
        },
    )


@lru_cache(maxsize=32)
def _area(reference: Cell) -> BoolArray:
    return sweep(vectorise(reference).lines, side=SIDE)


PARTS = ("position", "length", "direction", "shape", "thickness")


def _stroke_similarity(
    moved: Sequence[StrokeLine], model: VectorCharacter, settings: VicpSettings
) -> tuple[float, dict[str, float]]:
    """Mean similarity of the strokes by length, 0 where a stroke has no partner, and its parts."""
    copy_lines, lines = cut_alike(moved, model.lines, width=model.width)
    copy, reference = (
        curves_of([StrokeLine(line.points / SIDE, line.radius / SIDE) for line in some])
        for some in (copy_lines, lines)
    )
    parts = local_similarities(copy, reference, settings=settings)
    worth = parts.mean(axis=0)
    pairs = pair_lines(worth, reference, copy)
    if not pairs:
        return 0.0, dict.fromkeys((*PARTS, "paired"), 0.0)
    i, j = np.array(pairs).T
    alone = np.setdiff1d(np.arange(len(copy.length)), j)
    total = float(reference.length.sum() + copy.length[alone].sum())
    weight = reference.length[i]
    held = float(weight.sum())
    means = {name: float(weight @ part[i, j]) / held for name, part in zip(PARTS, parts, strict=True)}
    return float(weight @ worth[i, j]) / total, means | {"paired": held / total}


def local_similarities(copy: Curves, reference: Curves, *, settings: VicpSettings) -> FloatArray:
    """(5, n, m) in [0, 1]: the PARTS of the similarity of reference line i and copy line j.

    Shape is how far the curves lie apart when the copy's is sheared so that their ends meet.
    """
    points, radius = orient(copy, reference)
    gaps = reference.points[:, None] - points
    share = np.linspace(0.0, 1.0, gaps.shape[2])[:, None]
    bent = gaps - (1.0 - share) * gaps[:, :, :1] - share * gaps[:, :, -1:]
    short, long = (pick(reference.length[:, None], copy.length[None]) for pick in (np.minimum, np.maximum))
    thickness = np.abs(reference.radius[:, None] - radius).mean(axis=-1)
    thickness = thickness / np.maximum(reference.radius.mean(axis=1), 1e-9)[:, None]
    return np.stack(
        [
            np.exp(-middles_apart(reference, copy) / settings.position),
            short / np.maximum(long, 1e-9),
            np.maximum(0.0, 1.0 - directions_apart(reference, copy) / settings.askew),
            np.exp(-np.linalg.norm(bent, axis=-1).mean(axis=-1) / settings.shape),
            np.maximum(0.0, 1.0 - thickness),
        ]
    )
