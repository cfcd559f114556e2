"""A capture becomes a surface: normals by the solver that fits the lamps, then height.

A page of flat paper and ink comes out flat here, however black the ink: see `rumu.surface.stereo`.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rumu.capture.lights import PaperLamps, paper_tilts
from rumu.errors import SurfaceError
from rumu.image_stack import Progress, begin
from rumu.surface.beyond_lambert import find_materials
from rumu.surface.frame_check import check_exposure, check_still
from rumu.surface.holes import fill_holes
from rumu.surface.integrate import INTEGRATORS, integrate
from rumu.surface.lamp_check import check_lamps
from rumu.surface.lamp_order import check_order
from rumu.surface.level import check_level, take_level
from rumu.surface.near_lamps import solve_near
from rumu.surface.perspective import check_focal_length
from rumu.surface.reflectance import Material
from rumu.surface.robust import SOLVERS
from rumu.surface.solve import Solution, solve
from rumu.surface.stereo import (
    all_lit,
    channel_albedo,
    gradients_from_normals,
    three_lamps,
)
from rumu.surface.strengths import Photometry, estimate_photometry, flat_sheet, sample
from rumu.values import BoolArray, Capture, FloatArray, Surface

_PAPER_TOLERANCE = 0.25
"""Degrees from the paper's lamps, nearer than any lamp list is exact; beyond, given directions are better."""
_SHEET_SHARE = 0.6
"""Share of the pixels that must be trusted for an unmasked capture to count as a full sheet."""
_BAND = 2_000_000
"""Pixels of the closed form worked on at a time."""
_LOOKED_AT = 1_000_000
"""Pixels of a larger picture whose medians and quantiles are taken of every k-th one, to about this many."""
_BELOW_BLACK = 0.02  # of white, that a camera may have taken too much
_LEAST_TRUST = 0.05
"""Least weight of a slope in integration: an unsure slope is better than none."""
CHECKING, MATERIALS = "Checking the photographs", "Looking for other materials"
CHECKING_LAMPS, INTEGRATING = "Checking the lamps", "Integrating the height"
"""What is told of the steps that are not counted."""


def photometric(
    capture: Capture,
    *,
    solver: str = "robust",
    integrator: str = "auto",
    focal_length: float | None = None,
    level: str = "none",
    progress: Progress | None = None,
) -> Surface:
    """The surface of a capture, source 'photometric'.

    solver: one of `rumu.surface.robust.SOLVERS`. integrator: one of `rumu.surface.integrate.INTEGRATORS`.
    focal_length: of the camera, in pixels; None for one that is far away. level: what is taken off in the
    end, one of `rumu.surface.level.LEVELS`.
    Height is in millimetres when the capture's spacing is known, else in pixels: 0 at the paper when most of
    the sheet faces one way, else at the mean. Pixels that no three lamps reach are filled in from their
    neighbours before integration and have confidence 0; the surface's mask holds those that were measured.
    quality: see `surface_normals`.
    Raises SurfaceError when a name is unknown or nothing was lit, CaptureError when the lamps are clearly not
    those of the photographs.
    """
    if integrator not in INTEGRATORS:
        raise SurfaceError(f"expected an integrator among {', '.join(INTEGRATORS)}, got {integrator!r}")
    check_level(level)
    check_focal_length(focal_length, capture.mask.shape)
    normals, albedo, confidence, quality = surface_normals(capture, solver=solver, progress=progress)
    measured = capture.mask & (confidence > 0)
    if not measured.any():
        raise SurfaceError("expected pixels that three lamps reach, got none: the photographs are all dark")
    domain = _domain(capture.mask, confidence)
    whole = bool(domain.all())
    measured &= domain
    fill_holes(normals, albedo, known=measured, within=domain)
    begin(INTEGRATING, progress)
    height = integrate(
        normals,
        mask=None if whole else domain,
        method=integrator,
        weights=None if whole else np.maximum(confidence, _LEAST_TRUST),
        focal_length=focal_length,
    )
    take_level(height, normals, measured, level=level)
    spacing = 1.0 if capture.spacing is None else capture.spacing
    height -= np.float32(_ground(height, measured))
    height *= np.float32(spacing)
    if not whole:
        height[~domain] = 0.0
    confidence[~measured] = 0.0
    quality["measured_share"] = float(measured.sum() / domain.sum())
    return Surface(
        height=height,
        normals_from=normals,
        albedo_from=albedo,
        mask=measured,
        confidence=confidence,
        spacing=spacing,
        unit="px" if capture.spacing is None else "mm",
        source="photometric",
        quality=quality,
    )


def surface_normals(
    capture: Capture, *, solver: str = "robust", progress: Progress | None = None
) -> tuple[FloatArray, FloatArray, FloatArray, dict[str, float]]:
    """Normals (H, W, 3), albedo (H, W[, 3]) in [0, 1], confidence (H, W) in [0, 1], and quality.

    Three lamps of the paper's kind, and four, take its closed form whatever the solver. When the capture does
    not know the strengths of its lamps, solver 'robust' and the closed form estimate them, with care.

    quality: 'residual', median |brightness - law| in shares of a pixel's brightness (0 by construction for
    three lamps); 'shadow_share', share of values in shadow; 'paper_p' and 'paper_q', median slopes before any
    strength was estimated, near 0 for a sheet that faced the camera; 'fourth_lamp', median |d - (a + c - b)|
    over brightness, only with four lamps of the paper's kind; 'strength_spread', strongest lamp over weakest
    as used; 'black_level', brightness taken for none; 'measured_share', share of the object measured;
    'brightness', by which the albedo was divided to stay within 1; 'lamps', their number; 'materials', number
    of those found beside Lambert's, see `rumu.surface.beyond_lambert`.
    Raises SurfaceError for an unknown solver; CaptureError when photographs are black, overexposed or moved,
    or when other lamps clearly fit them better, see `rumu.surface.frame_check` and `rumu.surface.lamp_check`.
    """
    if solver not in SOLVERS:
        raise SurfaceError(f"expected a solver among {', '.join(SOLVERS)}, got {solver!r}")
    begin(CHECKING, progress)
    check_exposure(capture)
    lamps = paper_tilts(capture.lights, tolerance=_PAPER_TOLERANCE) if capture.positions is None else None
    trusted = capture.lamps_as_given
    check = None
    with ThreadPoolExecutor(1) as beside:
        checks = [] if trusted else [beside.submit(check_still, capture)]
        photometry = _photometry(capture, lamps, solver)
        if not trusted:
            checks.append(beside.submit(check_order, capture, photometry.strengths))
        materials: tuple[Material, ...] = ()
        if lamps is None and solver == "robust":
            photometry, materials = _materials(capture, photometry, progress)
        if lamps is not None:
            solution, check = _closed_form(capture, lamps, photometry.strengths)
        else:
            solution = _solved(capture, photometry, solver, materials, _unless_refused(checks, progress))
        for one in checks:
            one.result()
    measured = capture.mask & (solution.confidence > 0)
    if not trusted:
        begin(CHECKING_LAMPS, progress)
        check_lamps(capture, solution.normals, solution.albedo, known=measured)
    brightness = _within_one(solution.albedo, measured)
    leaning = solution
    if lamps is not None and photometry.sheet:  # lamps taken for equal show how the sheet leans
        leaning, _ = _closed_form(capture, lamps, np.ones(len(capture.lights)))
    p, q = _median_slopes(leaning.normals, measured)
    quality = {
        "residual": solution.residual,
        "shadow_share": solution.shadow_share,
        "paper_p": p,
        "paper_q": q,
        "strength_spread": float(photometry.strengths.max() / photometry.strengths.min()),
        "black_level": photometry.black_level,
        "measured_share": float(measured.sum() / capture.mask.sum()),
        "brightness": brightness,
        "lamps": float(len(capture.lights)),
        "materials": float(len(solution.materials)),
    }
    if check is not None:
        quality["fourth_lamp"] = check
    return solution.normals, solution.albedo, solution.confidence, quality


def _unless_refused(checks: Sequence[Future[None]], progress: Progress | None) -> Progress:
    """Progress that is told on, until one of the checks beside it has ended in an error, which it raises."""

    def tell(what: str, done: int, parts: int) -> None:
        for one in checks:
            if one.done():
                one.result()
        if progress is not None:
            progress(what, done, parts)

    return tell


def _materials(
    capture: Capture, photometry: Photometry, progress: Progress | None
) -> tuple[Photometry, tuple[Material, ...]]:
    """Materials beside Lambert's, of lamps that are far away, and the photometry under which they are found.

    A level far below black is what gloss on a flat sheet looks like: it adds the same to all places, dark and
    bright. No camera takes so much away, so where materials explain it they are believed.
    """
    if capture.positions is not None:
        return photometry, ()
    begin(MATERIALS, progress)
    lights = capture.lights * photometry.strengths[:, None]
    if photometry.black_level < -_BELOW_BLACK:
        found = find_materials(capture.photographs, lights, mask=capture.mask)
        if found:
            return replace(photometry, black_level=0.0), found
    level = photometry.black_level
    return photometry, find_materials(capture.photographs, lights, mask=capture.mask, black_level=level)


def _solved(
    capture: Capture,
    photometry: Photometry,
    solver: str,
    materials: Sequence[Material],
    progress: Progress | None,
) -> Solution:
    """The normals under lamps that are far away, or near."""
    lights = capture.lights * photometry.strengths[:, None]
    options: dict[str, Any] = {
        "solver": solver,
        "mask": capture.mask,
        "black_level": photometry.black_level,
        "progress": progress,
    }
    if capture.positions is None:
        return solve(capture.photographs, lights, materials=materials, **options)
    return solve_near(capture.photographs, lights, capture.positions, **options)


def _photometry(capture: Capture, lamps: PaperLamps | None, solver: str) -> Photometry:
    """What to divide the photographs by, and what to take from them first."""
    n = len(capture.lights)
    known = Photometry(
        np.ones(n) if capture.strengths is None else capture.strengths / capture.strengths.mean()
    )
    if n > 3 and (solver == "robust" or lamps is not None):
        found = estimate_photometry(
            capture.photographs, capture.lights, mask=capture.mask, strengths=capture.strengths
        )
        # The closed form has no term for a black level.
        return found if lamps is None else replace(found, black_level=0.0)
    if lamps is None or capture.strengths is not None:
        return known
    # Three equations and three unknowns contradict nothing; only flat paper, which must look alike under
    # every lamp of one slant, shows that their strengths differ.
    usual = flat_sheet(sample(capture.photographs, mask=capture.mask, most=20_000))
    return known if usual is None else Photometry(usual / usual.mean(), sheet=True)


def _closed_form(capture: Capture, lamps: PaperLamps, strengths: FloatArray) -> tuple[Solution, float | None]:
    """The paper's three lamps, and a fourth, band by band so that memory stays bounded."""
    h, w = capture.mask.shape
    rows = max(1, _BAND // w)
    bands = [_solve_band(capture, lamps, strengths, slice(r, min(r + rows, h))) for r in range(0, h, rows)]
    share = [float(one.mask.sum()) / float(capture.mask.sum()) for one in bands]
    check = None
    if len(lamps.order) == 4:
        check = float(np.dot(share, [one.fourth_lamp for one in bands]))
    solution = Solution(
        np.concatenate([one.normals for one in bands]),
        np.concatenate([one.albedo for one in bands]),
        np.concatenate([one.confidence for one in bands]),
        0.5 * (check or 0.0),
        float(np.dot(share, [one.shadow_share for one in bands])),
    )
    return solution, check


@dataclass(frozen=True, slots=True, eq=False)
class _Band:
    normals: FloatArray
    albedo: FloatArray
    confidence: FloatArray
    mask: BoolArray
    shadow_share: float
    fourth_lamp: float


def _solve_band(capture: Capture, lamps: PaperLamps, strengths: FloatArray, rows: slice) -> _Band:
    """Some rows by the closed form; confidence is the brightness of the darkest lamp beside the mean."""
    order = list(lamps.order)
    images = capture.photographs.rows(rows.start, rows.stop)[order]
    raw = images if images.ndim == 3 else images.mean(axis=3)
    gray = (raw / strengths[order, None, None]).astype(np.float32)
    found = three_lamps(*gray[:3], slant=lamps.slant, d=gray[3] if len(order) == 4 else None)
    mask = capture.mask[rows]
    lit = found.valid & mask & all_lit(raw)
    normals, albedo = found.normals, found.albedo
    if images.ndim == 4:
        lights = capture.lights[order] * strengths[order, None]
        values = images.reshape(len(order), -1, 3)
        ones = np.ones((values.shape[1], len(order)))
        albedo = channel_albedo(values, normals.reshape(-1, 3), lights, weights=ones)
        albedo = np.where(lit[..., None], albedo.reshape(*lit.shape, 3), 0.0).astype(np.float32)
    darkest = gray.min(axis=0) / np.maximum(gray.mean(axis=0), 1e-6)
    confidence = np.where(lit, np.clip(darkest, 1e-3, 1.0), 0.0).astype(np.float32)
    dark = (gray < 0.05 * gray.max(axis=0))[:, mask]
    shadow_share = float(dark.mean()) if dark.size else 0.0
    return _Band(normals, albedo, confidence, mask, shadow_share, found.fourth_lamp or 0.0)


def _some(values: FloatArray, chosen: BoolArray) -> FloatArray:
    """(P, ...) the chosen pixels of (H, W, ...), every k-th of a large picture."""
    step = max(1, chosen.size // _LOOKED_AT)
    flat = values.reshape(chosen.size, *values.shape[2:])[::step]
    return np.asarray(flat[chosen.reshape(-1)[::step]])


def _median_slopes(normals: FloatArray, measured: BoolArray) -> tuple[float, float]:
    """Median slopes of the measured pixels, 0 when there are none."""
    few = _some(normals, measured)
    if not few.size:
        return 0.0, 0.0
    p, q = gradients_from_normals(few[None])
    return float(np.median(p)), float(np.median(q))


def _within_one(albedo: FloatArray, measured: BoolArray) -> float:
    """Bring albedo to [0, 1]; what it was divided by: 1, or its brightest one in a thousand if more."""
    kept = _some(albedo, measured)
    top = max(1.0, float(np.quantile(kept, 0.999))) if kept.size else 1.0
    if top > 1:
        albedo /= np.float32(top)
    np.clip(albedo, 0.0, 1.0, out=albedo)
    return top


def _domain(mask: BoolArray, confidence: FloatArray) -> BoolArray:
    """Where height is integrated: the mask that came with the capture, or what it shows of an object.

    Without a mask, an object before a dark background is recognised by its confidence: the background has
    next to none, and slopes of noise there would bend the object. A full sheet is taken whole.
    """
    trusted = confidence > 0.1 * float(np.quantile(_some(confidence, mask), 0.95))
    if not mask.all() or trusted.mean() > _SHEET_SHARE:
        return mask
    from scipy import ndimage

    parts, count = ndimage.label(ndimage.binary_opening(trusted, iterations=2))
    if count == 0:
        return mask
    sizes = np.bincount(parts.ravel())[1:]
    kept = np.isin(parts, 1 + np.flatnonzero(sizes > 0.05 * sizes.max()))
    closed = ndimage.binary_closing(np.pad(kept, 3), iterations=3)[3:-3, 3:-3]
    return np.asarray(ndimage.binary_fill_holes(closed | kept))


def _ground(height: FloatArray, measured: BoolArray) -> float:
    """Height to call 0: the paper's, if most of the sheet is within a tenth of the relief, else the mean."""
    values = _some(height, measured)
    low, high = np.quantile(values, [0.01, 0.99])
    middle = float(np.median(values))
    near = np.mean(np.abs(values - middle) <= 0.05 * max(high - low, 1e-12))
    return middle if near > 0.5 else float(values.mean())
