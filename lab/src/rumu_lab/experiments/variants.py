"""One copy by every variant of the comparison: weights of height and direction, one way or both, density.

Apart from what is made of it, so that a new word in a table measures nothing anew.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from rumu.values import Registration, Surface
from rumu_lab.experiments.measuring import GradingTask, Measured, drawn, residual_grade
from rumu_lab.experiments.protocol import declared

FORWARD, BACKWARD = "copy to master only", "master to copy only"
DENSITY = "ink density as height"


def variant(height: float, direction: float) -> str:
    """The name of a variant by its weights."""
    flat = "x, y" if height == 0 else f"x, y, height x {height:g}"
    return f"{flat}, direction x {direction:g}" if direction else flat


def base_weights() -> tuple[float, float]:
    """Weights of height and direction as the mark uses them."""
    from rumu.registration.icp import IcpSettings
    from rumu.registration.points import Sampling

    return Sampling().height_weight, IcpSettings().direction_weight


def base_variant() -> str:
    """The variant that the mark uses."""
    return variant(*base_weights())


def weights() -> list[tuple[float, float]]:
    """All pairs of weights of height and direction: the declared ones, and those the mark uses."""
    plain = declared().plain["ablation"]
    pairs = [(h, d) for d in plain["direction_weights"] for h in plain["height_weights"]]
    return list(dict.fromkeys([*pairs, base_weights(), (0.0, base_weights()[1])]))


def measure_variants(task: GradingTask, *, pictures: Path | None = None) -> Measured:
    """One copy by every variant; density is NaN (kept as None) where the picture has but one tone of ink."""
    from rumu import pipeline
    from rumu.errors import RumuError

    try:
        copy, master = (pipeline.surface_of(p) for p in (drawn(task.copy, pictures), task.master))
        found = {pair: _registered(copy, master, *pair) for pair in weights()}
    except RumuError as error:
        return Measured(task.key, task.cluster, refused=str(error))
    raw = {variant(*pair): residual_grade(registration) for pair, registration in found.items()}
    base = found[base_weights()]
    raw[FORWARD], raw[BACKWARD] = (1.0 - float(np.percentile(w, 75)) for w in (base.forward, base.backward))
    raw[DENSITY] = _by_density(task)
    return Measured(task.key, task.cluster, raw)


def _registered(copy: Surface, master: Surface, height: float, direction: float) -> Registration:
    from rumu.registration.icp import IcpSettings, register_points
    from rumu.registration.points import Sampling, sample_points

    points = [sample_points(s, settings=Sampling(height_weight=height)) for s in (copy, master)]
    return register_points(*points, settings=IcpSettings(direction_weight=direction))


def _by_density(task: GradingTask) -> float:
    """The base variant on heights from the darkness of the ink; NaN where there is no such relief."""
    from rumu.errors import RumuError
    from rumu.surface.relief import relief

    try:
        copy, master = (relief(p, method="density") for p in (task.copy.picture(), task.master))
        return residual_grade(_registered(copy, master, *base_weights()))
    except RumuError:
        return float("nan")
