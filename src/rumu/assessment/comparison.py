"""Two surfaces -> the registration and what a mark is made of."""

from __future__ import annotations

from functools import lru_cache

from rumu.assessment.features import Features, Residuals, measure, residuals
from rumu.errors import RefusedImage, RegistrationError, SurfaceError
from rumu.registration.icp import register_in_place, register_points
from rumu.registration.points import Sampling, ink_canvas, sample_points
from rumu.values import PointSet, Registration, Surface


def compare(copy: Surface, master: Surface, *, seed: int = 0) -> tuple[Registration, Features]:
    """Copy laid on master, and what a mark is made of.

    seed: of the sampling of the copy. Raises RefusedImage for a copy with too little ink or no relief,
    RegistrationError or SurfaceError for such a master.
    """
    try:
        reference, floor = _prepared(master)
    except RefusedImage as refusal:
        raise RegistrationError(f"the master cannot be compared with: {refusal}") from refusal
    try:
        probe = sample_points(copy, settings=Sampling(seed=seed))
    except RegistrationError as error:
        raise RefusedImage(str(error), reason="too small") from error
    except SurfaceError as error:
        raise RefusedImage(f"{error}; mark the ink of one image instead", reason="flat") from error
    registration = register_points(probe, reference)
    return registration, measure(registration, floor=floor)


@lru_cache(maxsize=2)  # many copies of one master come in a row
def _prepared(master: Surface) -> tuple[PointSet, Residuals]:
    """A master's points, and what registration leaves between it and itself sampled anew."""
    canvas = ink_canvas(master)
    once, again = (sample_points(canvas, settings=Sampling(seed=seed)) for seed in (0, 1))
    return once, residuals(register_in_place(again, once))
