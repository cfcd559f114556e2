"""Two surfaces -> the registration and what a mark is made of."""

from __future__ import annotations

from functools import lru_cache

from rumu.assessment.edges import describe
from rumu.assessment.features import Features, measure
from rumu.errors import RefusedImage, RegistrationError, SurfaceError
from rumu.registration.icp import register_points
from rumu.registration.points import canvas_ink, sample_points
from rumu.values import FloatArray, PointSet, Registration, Surface


def compare(copy: Surface, master: Surface) -> tuple[Registration, Features]:
    """Copy laid on master, and what a mark is made of.

    Raises RefusedImage for a copy with too little ink or no relief, RegistrationError or SurfaceError for
    such a master.
    """
    try:
        reference, edge = _described(master)
    except RefusedImage as refusal:
        raise RegistrationError(f"the master cannot be compared with: {refusal}") from refusal
    try:
        probe = sample_points(copy)
    except RegistrationError as error:
        raise RefusedImage(str(error), reason="too small") from error
    except SurfaceError as error:
        raise RefusedImage(f"{error}; mark the ink of one image instead", reason="flat") from error
    registration = register_points(probe, reference)
    return registration, measure(
        registration, edges=describe(canvas_ink(copy), lean=registration.angle) - edge
    )


@lru_cache(maxsize=2)  # many copies of one master come in a row
def _described(master: Surface) -> tuple[PointSet, FloatArray]:
    return sample_points(master), describe(canvas_ink(master))
