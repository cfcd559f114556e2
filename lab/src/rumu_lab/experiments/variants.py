"""One copy graded by every variant of the comparison: height, direction, one way or both, density."""

from __future__ import annotations

from typing import Literal

import numpy as np

from rumu.values import Registration, Surface
from rumu_lab.experiments.grading import Grades, GradingTask, residual_grade
from rumu_lab.experiments.measuring import master_at
from rumu_lab.experiments.protocol import declared

FORWARD, BACKWARD = "copy to master only", "master to copy only"
DENSITY = "ink density as height"
HeightMethod = Literal["inflation", "density"]
HEIGHT_METHODS: tuple[HeightMethod, ...] = ("inflation", "density")


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


def grade_by_variants(task: GradingTask) -> Grades:
    """One copy by every variant; density is NaN where the picture has but one tone of ink."""
    from rumu import pipeline
    from rumu.errors import RumuError

    try:
        copy, master = pipeline.surface_of(task.copy.picture()), master_at(task.master).surface
        found = {pair: _register(copy, master, *pair) for pair in weights()}
    except RumuError as error:
        return Grades(task.key, task.cluster, refused=str(error))
    raw = {variant(*pair): residual_grade(registration) for pair, registration in found.items()}
    base = found[base_weights()]
    raw[FORWARD], raw[BACKWARD] = (1.0 - float(np.percentile(w, 75)) for w in (base.forward, base.backward))
    try:
        raw[DENSITY] = _grade_by_height(task, "density")
    except RumuError:
        raw[DENSITY] = float("nan")
    return Grades(task.key, task.cluster, raw)


def grade_by_heights(task: GradingTask) -> Grades:
    """One copy by the 5-D residual, once with each kind of height; 0 where there is no relief to compare."""
    from rumu.errors import RefusedImage, RumuError

    grades: dict[str, float] = {}
    for method in HEIGHT_METHODS:
        try:
            grades[method] = _grade_by_height(task, method)
        except RefusedImage as refusal:
            return Grades(task.key, task.cluster, refused=str(refusal))
        except RumuError:
            grades[method] = 0.0
    return Grades(task.key, task.cluster, grades)


def _grade_by_height(task: GradingTask, method: HeightMethod) -> float:
    from rumu.surface.relief import relief

    copy, master = (relief(picture, method=method) for picture in (task.copy.picture(), task.master))
    return residual_grade(_register(copy, master, *base_weights()))


def _register(copy: Surface, master: Surface, height: float, direction: float) -> Registration:
    from rumu.registration.icp import IcpSettings, register_points
    from rumu.registration.points import Sampling, sample_points

    points = [sample_points(s, settings=Sampling(height_weight=height)) for s in (copy, master)]
    return register_points(*points, settings=IcpSettings(direction_weight=direction))
