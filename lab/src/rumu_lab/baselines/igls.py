"""IGLS-based grader (our reconstruction), after Han, Chou and Wu 2008.

Known from the abstract: characters are cut out of paper printed with a red mesh; three quantised features,
the centre, the size and the projections of a character, go into a fuzzy inference system that gives the
grade; the learner is told how to improve. Our reconstruction: every formula, membership function and rule
below, that the features are taken against a reference, and that the grade is brought to [0, 1]; the
instructions to the learner are left out. The red mesh is removed when a picture is
read, for all methods alike.

What we decided. The size is a feature of its own, so the projections are compared after it is taken out;
their score reaches 0 where most masters of other characters lie (their median is 0.027 cells, three in
four below 0.037). Low projections never give more than medium; the weights of the rules see to that. The
centroid of the best set is 94.6 and of the worst 20.4, so the grade is stretched to [0, 1] for `raw`. The
centroid of cut sets is not quite monotone: a better feature may lower the grade by up to 2.2 points of 100
where the others are bad. Features are quantised to twentieths: fifths leave 16 different grades, so that
most copies tie. A centre or a size that is middling costs nothing while the rest is high: 7 of 8 is
excellent.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product

import numpy as np

from rumu.values import IntArray
from rumu_lab.baselines.cell import SIDE, Cell, Raw
from rumu_lab.baselines.mamdani import Corners, FuzzySystem

BAD, MEDIUM, GOOD, EXCELLENT = range(4)
LEVELS: tuple[Corners, ...] = ((0.0, 0.0, 0.35, 0.6), (0.4, 0.65, 0.65, 0.85), (0.7, 0.9, 1.0, 1.0))
GRADES: tuple[Corners, ...] = (
    (0.0, 0.0, 30.0, 50.0),
    (40.0, 60.0, 60.0, 75.0),
    (65.0, 78.0, 78.0, 90.0),
    (85.0, 95.0, 100.0, 100.0),
)


@dataclass(frozen=True, slots=True)
class IglsSettings:
    """Differences that score 0, and how features are quantised.

    off_centre: distance of the centroids, in cells, that scores 0. size: ratio of a side of the boxes that
    does. projection: mean earth mover's distance of the projections, in cells, that does. bins: of one.
    steps: how many a feature is quantised to; 0 for none.
    """

    off_centre: float = 0.15
    size: float = 1.6
    projection: float = 0.04
    bins: int = 64
    steps: int = 20


def raw(probe: Cell, reference: Cell) -> Raw:
    """The fuzzy grade, stretched to [0, 1].

    features: 'centre', 'size', 'projections', each in [0, 1] before it is quantised; 'grade', what the rules
    conclude, in points of 100 (20.4 to 94.6).
    """
    settings = IglsSettings()
    scores = measure(probe, reference, settings=settings)
    system = FuzzySystem(LEVELS, GRADES, rules())
    grade = system.infer(tuple(quantise(score, steps=settings.steps) for score in scores.values()))
    low, high = system.infer((0.0, 0.0, 0.0)), system.infer((1.0, 1.0, 1.0))
    return Raw(min(max((grade - low) / (high - low), 0.0), 1.0), scores | {"grade": grade})


def measure(probe: Cell, reference: Cell, *, settings: IglsSettings) -> dict[str, float]:
    """How well centre, size and projections agree, each in [0, 1], not quantised."""
    own, there = (np.array(np.nonzero(cell.ink)[::-1]) for cell in (probe, reference))  # x and y of the ink
    axes = list(zip(own, there, strict=True))
    off = float(np.linalg.norm(own.mean(axis=1) - there.mean(axis=1))) / SIDE
    ratio = max(abs(math.log((int(np.ptp(a)) + 1) / (int(np.ptp(b)) + 1))) for a, b in axes)
    moved = float(np.mean([_projections_apart(a, b, bins=settings.bins) for a, b in axes]))
    return {
        "centre": max(0.0, 1.0 - off / settings.off_centre),
        "size": max(0.0, 1.0 - ratio / math.log(settings.size)),
        "projections": max(0.0, 1.0 - moved / settings.projection),
    }


def _projections_apart(own: IntArray, there: IntArray, *, bins: int) -> float:
    """Earth mover's distance, in cells, of two projections brought to one centre and size.

    own, there: (N,) places of the ink along one axis, in pixels. What lies beyond the cell
    is in the last bin.
    """
    a, b = ((places - places.mean()) / SIDE for places in (own, there))
    a = a * (b.std() / max(float(a.std()), 1e-9))
    one, two = (
        np.histogram(np.clip(places, -0.5, 0.5), bins=bins, range=(-0.5, 0.5))[0] / len(places)
        for places in (a, b)
    )
    return float(np.abs(np.cumsum(one - two)).mean())


def quantise(score: float, *, steps: int) -> float:
    """The nearest of steps + 1 equidistant values in [0, 1]; the score itself for no steps."""
    return round(score * steps) / steps if steps else score


def rules() -> dict[tuple[int, ...], int]:
    """Levels of (centre, size, projections), 0 low to 2 high -> grade, BAD to EXCELLENT; all 27.

    The projections weigh as much as the other two together.
    """
    table = {}
    for levels in product(range(3), repeat=3):
        centre, size, projections = levels
        weight = centre + size + 2 * projections
        table[levels] = BAD if weight <= 2 else MEDIUM if weight <= 4 else GOOD if weight <= 6 else EXCELLENT
    return table
