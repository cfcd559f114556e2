"""What a capture does not say about itself: how strong each lamp was, and what the camera calls black.

Our own, not the paper's. Both are found from the photographs alone, because Lambert's law leaves N - 3
contradictions in every pixel and the lamps are the same for all pixels. A correction is made only when it
removes most of what contradicts the law: a capture with equal lamps is left exactly as it is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from rumu.image_stack import ImageStack, pixels_of
from rumu.surface.compiled import l1_solver
from rumu.surface.robust import (
    RobustSettings,
    brightness_rows,
    law,
    pixel_scale,
    relative_residuals,
    subtract_black,
)
from rumu.surface.stereo import SHADOW_FLOOR
from rumu.values import BoolArray, FloatArray


@dataclass(frozen=True, slots=True)
class PhotometrySettings:
    """How much must be gained before a capture is corrected.

    residual_ratio: the residual must fall to this share of what it was. least_residual: share of a pixel's
        brightness below which nothing is corrected. least_lamps: lamps needed.
    sheet_share: of the pixels, that must face one way for the capture to be a flat sheet. sheet_tolerance:
        how far their brightness may be off, as a share. near_best: a simpler correction is taken when its
        residual is at most this many times the best one's.
    pixels: most pixels looked at. iterations: most steps of a refinement; it ends below the step `converged`.
    """

    residual_ratio: float = 0.4
    least_residual: float = 0.004
    least_lamps: int = 4
    sheet_share: float = 0.5
    sheet_tolerance: float = 0.06
    near_best: float = 1.3
    pixels: int = 2000
    iterations: int = 12
    converged: float = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class Photometry:
    """strengths: (N,) float64, mean 1, of each lamp. black_level: brightness the camera gives to no light.

    sheet: True when most pixels face one way, as flat paper does, and the strengths were taken from it.
    """

    strengths: FloatArray
    black_level: float = 0.0
    sheet: bool = False


def estimate_photometry(
    images: FloatArray | ImageStack,
    lights: FloatArray,
    *,
    mask: BoolArray,
    strengths: FloatArray | None = None,
    settings: PhotometrySettings | None = None,
) -> Photometry:
    """Lamp strengths, unless they are given, and black level of a capture of N lamps.

    images: (N, H, W) or (N, H, W, 3), linear; lights: (N, 3), unit length; mask: (H, W).
    One of the two is corrected first and then the other, each kept only if it explains enough. Three lamps
    leave no contradiction to learn from, four none for the black level.
    """
    settings = settings or PhotometrySettings()
    n = len(lights)
    photometry = Photometry(np.ones(n) if strengths is None else strengths / strengths.mean())
    rows = sample(images, mask=mask, most=min(settings.pixels, max(300, 150_000 // n)))
    if n < settings.least_lamps or len(rows) < n:
        return photometry
    now = _Guess(rows, lights, photometry)
    trials: list[Callable[[], _Guess | None]] = []
    if n > 4:
        trials += [lambda: _refine(now, settings, of_strengths=False)]
    if strengths is None:
        trials += [
            lambda: _from_sheet(rows, lights, settings),
            lambda: _refine(_from_singular_vectors(now), settings, of_strengths=True),
        ]
    best = _best_trial(now, trials, settings)
    if best is now or strengths is not None or n == 4:
        return best.photometry
    of_strengths = best.photometry.black_level != 0.0  # what was not corrected yet
    again = [lambda: _refine(best, settings, of_strengths=of_strengths)]
    return _best_trial(best, again, settings).photometry


class _Guess:
    """Some pixels, solved under what a capture may be like.

    rows: (P, N) their brightness, less the black level in `cleaned`. lamps: (N, 3), times strength.
    scaled: (P, 3) albedo times normal by least absolute residuals.
    """

    def __init__(self, rows: FloatArray, lights: FloatArray, photometry: Photometry) -> None:
        self.rows, self.lights, self.photometry = rows, lights, photometry
        self.cleaned = subtract_black(rows, photometry.black_level)
        self.lamps = lights * photometry.strengths[:, None]
        self.scaled = l1_solver()(self.cleaned, self.lamps, RobustSettings())

    def changed(self, **changes: Any) -> _Guess:
        """The same pixels under another photometry."""
        return _Guess(self.rows, self.lights, replace(self.photometry, **changes))

    @cached_property
    def residual(self) -> float:
        """Sixty-percent quantile of what contradicts Lambert's law, in shares of the pixel's brightness."""
        dark = RobustSettings().dark
        off, lit = relative_residuals(self.cleaned, self.lamps, self.scaled, dark=dark)
        return float(np.quantile(off[lit], 0.6)) if lit.any() else 0.0


def sample(images: FloatArray | ImageStack, *, mask: BoolArray, most: int) -> FloatArray:
    """(P <= most, N) float64 gray brightness of the brighter four fifths of the pixels in the mask."""
    images = images if isinstance(images, ImageStack) else ImageStack.of_arrays(images)
    rows: FloatArray = brightness_rows(images.at(pixels_of(mask, about=4 * most)))
    rows = np.asarray(rows[rows.max(axis=1) > SHADOW_FLOOR])
    if len(rows) == 0:
        return rows
    scale = pixel_scale(rows)[:, 0]
    bright = rows[scale >= np.quantile(scale, 0.2)]
    return np.asarray(bright[:: max(1, -(-len(bright) // most))])


def flat_sheet(rows: FloatArray, *, settings: PhotometrySettings | None = None) -> FloatArray | None:
    """(N,) median brightness of the pixels that face as most do; None when most do not face one way.

    rows: (P, N), lit in every lamp for a pixel to count. Ink and paper that face one way have brightness in
    the same ratios, whatever their albedo, so the ratios are compared and not the values.
    """
    settings = settings or PhotometrySettings()
    needed = settings.sheet_share * len(rows)
    lit = rows.min(axis=1) > SHADOW_FLOOR
    if np.count_nonzero(lit) < max(50, needed):
        return None
    ratios = rows[lit] / rows[lit].mean(axis=1, keepdims=True)
    for _ in range(3):
        usual = np.median(ratios, axis=0)
        near = np.abs(ratios / usual - 1.0).max(axis=1) < settings.sheet_tolerance
        if np.count_nonzero(near) < needed:
            return None
        ratios = ratios[near] if np.count_nonzero(near) < len(ratios) else ratios
    return np.asarray(np.median(ratios, axis=0))


def _from_sheet(rows: FloatArray, lights: FloatArray, settings: PhotometrySettings) -> _Guess | None:
    """Strengths that make the sheet face the camera."""
    usual = flat_sheet(rows, settings=settings)
    if usual is None or not (lights[:, 2] > 0.05).all():
        return None
    given = usual / lights[:, 2]
    return _Guess(rows, lights, Photometry(given / given.mean(), sheet=True))


def _best_trial(
    now: _Guess, trials: Sequence[Callable[[], _Guess | None]], settings: PhotometrySettings
) -> _Guess:
    """The simplest of the good trials if it explains enough, else what is there now; simplest first.

    A flat sheet comes before free strengths: it separates strength from tilt by facing the camera, which the
    law alone leaves open.
    """
    if now.residual < settings.least_residual:
        return now
    found: list[_Guess] = []
    for attempt in trials:
        trial = attempt()
        if trial is not None:
            found.append(trial)
            if trial.residual < min(settings.least_residual, settings.residual_ratio * now.residual):
                break  # nothing is left to explain
    good = settings.near_best * min((one.residual for one in found), default=0.0)
    simplest = next((one for one in found if one.residual <= good), now)
    return simplest if simplest.residual < settings.residual_ratio * now.residual else now


def _from_singular_vectors(equal: _Guess) -> _Guess:
    """Strengths from the three directions in which the brightness of fully lit pixels varies.

    The law says brightness = S L B with S diagonal, so S L = V A for the three leading singular vectors V:
    one null vector holds both A and S.
    """
    rows, lights, n = equal.rows, equal.lights, len(equal.lights)
    lit = rows[rows.min(axis=1) > 0.05 * pixel_scale(rows)[:, 0]]
    if len(lit) < max(3 * n, 0.1 * len(rows)):
        return equal
    unit = lit / np.linalg.norm(lit, axis=1, keepdims=True)
    V = np.linalg.svd(unit, full_matrices=False)[2][:3].T
    system = np.zeros((3 * n, 9 + n))
    for lamp in range(n):
        for axis in range(3):
            system[3 * lamp + axis, 3 * axis : 3 * axis + 3] = V[lamp]
            system[3 * lamp + axis, 9 + lamp] = -lights[lamp, axis]
    strengths = np.linalg.svd(system)[2][-1][9:]
    strengths = strengths * np.sign(strengths.sum())
    if strengths.min() <= 0.02 * strengths.max():
        return equal
    return equal.changed(strengths=strengths / strengths.mean())


def _refine(start: _Guess, settings: PhotometrySettings, *, of_strengths: bool) -> _Guess:
    """Gauss-Newton on the sum of absolute residuals, over all strengths or over the black level.

    The normals are eliminated pixel by pixel (variable projection), so each step solves one small system;
    directions that the capture leaves open, such as the common scale, are not moved along.
    """
    now = start
    for _ in range(settings.iterations):
        step = _gauss_newton_step(now, of_strengths=of_strengths)
        if of_strengths:
            strengths = np.maximum(now.photometry.strengths + step, 0.02)
            now = now.changed(strengths=strengths / strengths.mean(), sheet=False)
        else:
            now = now.changed(black_level=now.photometry.black_level + float(step[0]))
        if np.abs(step).max() < settings.converged:
            break
    return now


def _gauss_newton_step(now: _Guess, *, of_strengths: bool) -> FloatArray:
    """What to add to the strengths, (N,), or to the black level, (1,)."""
    lamps, cleaned = now.lamps, now.cleaned
    scale = pixel_scale(cleaned)
    left = cleaned - law(now.scaled, lamps)
    trust = np.where(cleaned > 0.05 * scale, 1.0 / np.sqrt((left / scale) ** 2 + 1e-6), 0.0) / scale**2
    # What one unit of an unknown adds to a value: the light itself, or one unit of black.
    effect = np.maximum(law(now.scaled, now.lights), 0.0) if of_strengths else np.ones_like(left)
    pairs = (lamps[:, :, None] * lamps[:, None, :]).reshape(len(lamps), 9)
    A = (trust @ pairs).reshape(-1, 3, 3)
    A += (1e-9 * np.trace(A, axis1=1, axis2=2)[:, None, None] + 1e-12) * np.eye(3)
    if of_strengths:
        across = lamps.T[None] * (trust * effect)[:, None, :]
        diagonal, pull = (trust * effect**2).sum(axis=0), (effect * trust * left).sum(axis=0)
    else:  # one black level for all lamps
        across = (trust @ lamps)[:, :, None]
        diagonal, pull = trust.sum()[None], (trust * left).sum()[None]
    k = len(diagonal)
    solved = _inverse(A) @ across
    H = np.diag(diagonal) - across.reshape(-1, k).T @ solved.reshape(-1, k)
    g = pull - ((trust * left) @ lamps).reshape(-1) @ solved.reshape(-1, k)
    size, axes = np.linalg.eigh(H)
    determined = size > 1e-4 * diagonal.sum() / k
    return np.asarray(axes[:, determined] @ ((axes[:, determined].T @ g) / size[determined]))


def _inverse(symmetric: FloatArray) -> FloatArray:
    """Of (P, 3, 3) symmetric matrices, by cofactors, which LAPACK takes several times as long for."""
    xx, xy, xz = symmetric[:, 0].T
    yy, yz, zz = symmetric[:, 1, 1], symmetric[:, 1, 2], symmetric[:, 2, 2]
    rows = (
        (yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy),
        (xz * yz - xy * zz, xx * zz - xz * xz, xy * xz - xx * yz),
        (xy * yz - xz * yy, xy * xz - xx * yz, xx * yy - xy * xy),
    )
    determinant = xx * rows[0][0] + xy * rows[0][1] + xz * rows[0][2]
    return np.moveaxis(np.array(rows) / determinant, 2, 0)
