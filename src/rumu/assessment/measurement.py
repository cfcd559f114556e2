"""Copy and master -> what a mark rests on: their registration, its features, and whether to refuse."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from rumu.assessment.features import Features, describe_edge, measure_features
from rumu.assessment.refusal import (
    Refusal,
    RefusalFigures,
    RefusalLimits,
    RefusalReference,
    check_copy,
)
from rumu.errors import RefusedImage, RegistrationError, SurfaceError
from rumu.registration.icp import register_points
from rumu.registration.points import Canvas, canvas_of, ink_mask, sample_points
from rumu.strokes.correspondence import MasterStrokes
from rumu.strokes.omissions import MasterInk
from rumu.values import FloatArray, PointSet, Registration, Surface


@dataclass(frozen=True, eq=False)
class PreparedMaster:
    """A master with everything that is derived from it, to be made once and used for many copies.

    Each part is computed when it is first needed. A master that cannot be compared with raises
    RegistrationError or SurfaceError then.

    surface: the master itself.
    """

    surface: Surface

    @cached_property
    def canvas(self) -> Canvas:
        """Its ink on the common canvas."""
        return canvas_of(ink_mask(self.surface))

    @cached_property
    def points(self) -> PointSet:
        """Ink points: what copies are registered to."""
        try:
            return sample_points(self.surface, canvas=self.canvas)
        except RefusedImage as refusal:
            raise RegistrationError(f"the master cannot be compared with: {refusal}") from refusal

    @cached_property
    def edges(self) -> FloatArray:
        """(NUMBERS,) description of the edge of its ink, see `describe_edge`."""
        return describe_edge(self.canvas.ink)

    @cached_property
    def outline(self) -> RefusalReference:
        """Its outlines as they are, mirrored and turned, for the refusal of copies."""
        return RefusalReference(self.points, self.surface.quality.get("noise", np.inf))

    @cached_property
    def ink(self) -> MasterInk:
        """Its ink points and their centre lines, to look for missing strokes."""
        return MasterInk(self.points)

    @cached_property
    def stroke_model(self) -> MasterStrokes:
        """Its strokes at full resolution, for remarks."""
        return MasterStrokes(self.surface, self.points)


@dataclass(frozen=True, slots=True, eq=False)
class Measurement:
    """All that is known of a copy laid on its master, before it is marked.

    figures: what the refusal rests on, computed on demand. refusal: why the copy cannot be marked, or None.
    highest: the highest mark, 0-100, that it may get; below 100 when it is hardly like its master.
    """

    copy: Surface
    master: PreparedMaster
    registration: Registration
    features: Features
    figures: RefusalFigures
    refusal: Refusal | None
    highest: float


def measure(copy: Surface, master: PreparedMaster, *, limits: RefusalLimits | None = None) -> Measurement:
    """Lay a copy on its master and measure what a mark is made of.

    Raises RefusedImage for a copy with too little ink or no relief, RegistrationError or SurfaceError for
    such a master.
    """
    reference, edges = master.points, master.edges
    try:
        canvas = canvas_of(ink_mask(copy))
        probe = sample_points(copy, canvas=canvas)
    except RegistrationError as error:
        raise RefusedImage(str(error), reason="too small") from error
    except SurfaceError as error:
        raise RefusedImage(f"{error}; mark the ink of one image instead", reason="flat") from error
    registration = register_points(probe, reference)
    edges = describe_edge(canvas.ink, lean=registration.angle) - edges
    features = measure_features(registration, edges=edges, ink=master.ink)
    figures = RefusalFigures(copy, master.outline, registration)
    refusal, highest = check_copy(figures, limits=limits)
    return Measurement(copy, master, registration, features, figures, refusal, highest)
