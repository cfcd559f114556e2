"""Solvers against shadow, gloss and unknown lamps: known surfaces first, then real photographs."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.capture.folder import read_capture
from rumu.errors import CaptureError, SurfaceError
from rumu.surface import solve as solving
from rumu.surface.photometric import photometric, surface_normals
from rumu.surface.robust import SOLVERS
from rumu.surface.solve import solve
from rumu.surface.strengths import estimate_photometry
from rumu.values import Capture
from rumu_lab.simulation.lamps import Gloss, Sensor, photographs
from rumu_lab.simulation.shapes import bump, ridges

RING = tuple(np.arange(12) * 30.0)
TWO_SLANTS = (30.0, 50.0) * 6


def degrees_off(normals, wanted, mask=None):
    """Mean angle between two fields of normals."""
    mask = np.ones(wanted.shape[:2], dtype=bool) if mask is None else mask
    cosine = (normals[mask] * wanted[mask]).sum(axis=1) / np.linalg.norm(wanted[mask], axis=1)
    return float(np.degrees(np.arccos(np.clip(cosine, -1, 1))).mean())


def capture_of(shape, *, albedo=0.7, tilts=RING, slant=TWO_SLANTS, known=None, spacing=None, **options):
    images, lights = photographs(
        shape.height, albedo, tilts=tilts, slant=slant, normals=shape.normals, **options
    )
    mask = np.ones(shape.height.shape, dtype=bool)
    return Capture(images=images, lights=lights, mask=mask, strengths=known, spacing=spacing)


@pytest.mark.parametrize("solver", SOLVERS)
def test_every_solver_is_exact_without_shadow_or_gloss(solver):
    shape = bump((48, 56), peak=4.0, sigma=12.0)
    capture = capture_of(shape, slant=25.0, cast_shadows=False)
    solution = solve(capture.images, capture.lights, solver=solver)
    assert degrees_off(solution.normals, shape.normals) < 0.02
    assert np.abs(solution.albedo - 0.7).max() < 1e-3
    assert solution.confidence.min() > 0.95 and solution.confidence.max() <= 1.0 + 1e-6


def test_robust_survives_cast_shadow_and_gloss():
    shape = ridges((90, 90), width=24.0, pitch=60.0, angle=25.0)
    capture = capture_of(shape, gloss=Gloss(strength=0.3, exponent=40.0), sensor=Sensor(noise=0.002))
    off = {s: degrees_off(surface_normals(capture, solver=s)[0], shape.normals) for s in SOLVERS}
    assert off["robust"] < 0.6 * off["least_squares"]
    assert off["robust"] < 1.1 * min(off.values())


def test_confidence_tells_where_the_normals_are_wrong():
    shape = ridges((90, 90), width=24.0, pitch=60.0, angle=25.0)
    capture = capture_of(shape, sensor=Sensor(noise=0.002))
    normals, _, confidence, _ = surface_normals(capture)
    wrong = np.degrees(np.arccos(np.clip((normals * shape.normals).sum(axis=2), -1, 1)))
    sure = confidence > np.median(confidence)
    assert wrong[sure].mean() < 0.3 * wrong[~sure].mean()


def test_unequal_lamps_are_told_apart_and_equal_ones_left_alone():
    shape = bump((100, 100), peak=12.0, sigma=16.0)
    strengths = np.random.default_rng(4).uniform(0.6, 1.0, 12)
    capture = capture_of(shape, strengths=strengths, sensor=Sensor(noise=0.002))
    found = estimate_photometry(capture.images, capture.lights, mask=capture.mask)
    assert np.abs(found.strengths - strengths / strengths.mean()).max() < 0.005
    assert degrees_off(surface_normals(capture)[0], shape.normals) < 0.4
    assert degrees_off(surface_normals(capture, solver="least_squares")[0], shape.normals) > 2.0
    equal = capture_of(shape, sensor=Sensor(noise=0.002))
    left = estimate_photometry(equal.images, equal.lights, mask=equal.mask)
    assert (left.strengths == 1.0).all() and left.black_level == 0.0


def test_strengths_that_are_known_are_used():
    shape = bump((60, 60), peak=5.0, sigma=12.0)
    strengths = np.linspace(0.6, 1.0, 12)
    capture = capture_of(shape, strengths=strengths, known=strengths / strengths.mean(), cast_shadows=False)
    for solver in ("least_squares", "robust"):
        normals, _, _, quality = surface_normals(capture, solver=solver)
        assert degrees_off(normals, shape.normals) < 0.2
        assert quality["strength_spread"] == pytest.approx(1 / 0.6, rel=1e-6)


def test_stray_light_is_found_when_the_lamps_allow_it():
    shape = bump((100, 100), peak=8.0, sigma=16.0)
    capture = capture_of(shape, veil=0.05, sensor=Sensor(noise=0.002))
    found = estimate_photometry(capture.images, capture.lights, mask=capture.mask)
    assert found.black_level == pytest.approx(0.05, abs=0.002)
    assert (found.strengths == 1.0).all()


@pytest.mark.parametrize("solver", SOLVERS)
def test_tiles_do_not_show(solver):
    shape = ridges((40, 50), width=14.0, pitch=30.0)
    colour = np.stack([np.full((40, 50), v) for v in (0.8, 0.5, 0.2)], axis=-1)
    capture = capture_of(shape, albedo=colour, sensor=Sensor(noise=0.004))
    whole = solve(capture.images, capture.lights, solver=solver)
    tiled = solve(capture.images, capture.lights, solver=solver, tile=12 * 37)
    for name in ("normals", "albedo", "confidence"):
        assert np.allclose(getattr(whole, name), getattr(tiled, name), atol=2e-4)
    assert whole.residual == pytest.approx(tiled.residual, abs=1e-3)
    assert whole.shadow_share == pytest.approx(tiled.shadow_share)


def test_few_of_many_residuals_tell_their_median(monkeypatch):
    """Of a large photograph not all are kept, and those that are come from all over it."""
    shape = ridges((60, 80), width=14.0, pitch=30.0)
    capture = capture_of(shape, albedo=0.6, sensor=Sensor(noise=0.01))
    images = capture.images.copy()
    images[:, 30:] += np.random.default_rng(5).normal(0, 0.04, images[:, 30:].shape)  # worse below
    options = {"solver": "least_squares", "tile": 12 * 50}
    whole = solve(images, capture.lights, **options)
    upper = solve(images[:, :30], capture.lights, **options)
    monkeypatch.setattr(solving, "_RESIDUALS", 4000)
    kept, median = [], np.median
    monkeypatch.setattr(solving.np, "median", lambda values: kept.append(values.size) or median(values))
    few = solve(images, capture.lights, **options)
    assert kept[-1] <= 4000
    assert few.residual == pytest.approx(whole.residual, rel=0.1) and whole.residual > 1.5 * upper.residual
    assert few.shadow_share == whole.shadow_share


def test_colour_and_mask():
    shape = bump((40, 50), peak=3.0, sigma=9.0)
    colour = np.stack([np.full((40, 50), v) for v in (0.8, 0.5, 0.2)], axis=-1)
    capture = capture_of(shape, albedo=colour, slant=30.0, cast_shadows=False)
    mask = np.zeros((40, 50), dtype=bool)
    mask[10:30, 10:40] = True
    solution = solve(capture.images, capture.lights, mask=mask)
    assert np.allclose(solution.albedo[mask], (0.8, 0.5, 0.2), atol=2e-3)
    assert (solution.confidence[~mask] == 0).all()
    assert (solution.normals[~mask] == (0, 0, 1)).all()


def test_three_lamps_of_the_papers_kind_in_any_order():
    shape = bump((60, 60), peak=3.0, sigma=12.0)
    for tilts in ((0.0, 90.0, 180.0), (180.0, 0.0, 90.0), (270.0, 90.0, 0.0, 180.0)):
        capture = capture_of(shape, tilts=tilts, slant=45.0, cast_shadows=False)
        normals, albedo, confidence, quality = surface_normals(capture)
        assert degrees_off(normals, shape.normals) < 0.01
        assert np.allclose(albedo, 0.7, atol=1e-3) and (confidence > 0).all()
        assert ("fourth_lamp" in quality) == (len(tilts) == 4)
        assert quality["residual"] < 1e-5 and abs(quality["paper_p"]) < 0.01


def test_bands_of_the_closed_form_do_not_show(monkeypatch):
    colour = np.stack([np.full((50, 40), v) for v in (0.8, 0.5, 0.2)], axis=-1)
    shape = bump((50, 40), peak=3.0, sigma=9.0)
    capture = capture_of(
        shape, albedo=colour, tilts=(0, 90, 180, 270), slant=45.0, sensor=Sensor(noise=0.004)
    )
    whole = surface_normals(capture)
    monkeypatch.setattr("rumu.surface.photometric._BAND", 40 * 7)
    banded = surface_normals(capture)
    for one, other in zip(whole[:3], banded[:3], strict=True):
        assert np.array_equal(one, other)
    assert banded[3] == pytest.approx(whole[3], rel=0.2)
    assert np.allclose(whole[1].mean(axis=(0, 1)), (0.8, 0.5, 0.2), atol=0.02)


@pytest.mark.parametrize("tilts", [(0.0, 90.0, 180.0), (0.0, 90.0, 180.0, 270.0), RING])
def test_a_flat_inked_page_stays_flat_under_unequal_lamps(tilts):
    rng = np.random.default_rng(9)
    ink = rng.random((16, 16)).repeat(8, 0).repeat(8, 1) > 0.8
    flat = bump(ink.shape, peak=0.0, sigma=9.0)
    capture = capture_of(
        flat,
        albedo=np.where(ink, 0.06, 0.85),
        tilts=tilts,
        slant=45.0,
        strengths=rng.uniform(0.7, 1.0, len(tilts)),
        sensor=Sensor(noise=0.004, seed=2),
    )
    surface = photometric(capture)
    assert abs(np.corrcoef(surface.height.ravel(), ink.ravel())[0, 1]) < 0.1
    assert np.ptp(surface.height) < 1.0
    assert surface.albedo[ink].mean() < 0.12 < surface.albedo[~ink].mean()


def test_photometric_gives_millimetres_and_fills_what_no_lamp_reaches():
    shape = bump((80, 100), peak=8.0, sigma=14.0)
    capture = capture_of(shape, spacing=0.05, cast_shadows=False, slant=35.0)
    images = capture.images.copy()
    images[:, 30:36, 40:46] = 0.0
    dark = photometric(Capture(images=images, lights=capture.lights, mask=capture.mask, spacing=0.05))
    hole = ~dark.mask
    assert hole[30:36, 40:46].all() and hole.sum() == 36
    assert (dark.confidence[hole] == 0).all()
    assert np.allclose(dark.albedo, 0.7, atol=0.01)
    assert dark.unit == "mm" and dark.spacing == 0.05 and dark.source == "photometric"
    wanted = shape.height * 0.05
    assert np.abs((dark.height - dark.height[0, 0]) - (wanted - wanted[0, 0])).max() < 0.03 * np.ptp(wanted)
    assert dark.quality["measured_share"] == pytest.approx(1 - 36 / 8000)


def test_an_object_before_a_dark_background_needs_no_mask():
    shape = bump((100, 100), peak=16.0, sigma=20.0)
    r, c = np.ogrid[:100, :100]
    thing = (r - 50) ** 2 + (c - 50) ** 2 < 30**2
    capture = capture_of(shape, albedo=np.where(thing, 0.8, 0.008), sensor=Sensor(noise=0.004))
    surface = photometric(capture)
    assert (surface.mask ^ thing).sum() < 0.05 * thing.sum()
    fit = surface.height[thing] - shape.height[thing]
    assert (fit - fit.mean()).std() < 0.02 * np.ptp(shape.height[thing])


def test_bad_names_and_darkness_are_refused():
    shape = bump((20, 20), peak=1.0, sigma=5.0)
    capture = capture_of(shape)
    with pytest.raises(SurfaceError, match=r"solver among .*robust, got 'best'"):
        photometric(capture, solver="best")
    with pytest.raises(SurfaceError, match=r"integrator among .*dct.*, got 'fft'"):
        photometric(capture, integrator="fft")
    black = Capture(images=np.zeros_like(capture.images), lights=capture.lights, mask=capture.mask)
    with pytest.raises(CaptureError, match="black, no lamp lit the sheet"):
        photometric(black)


# --- real and rendered photographs -----------------------------------------------------------------


def bunny(data, name):
    folder = data / "photometric" / "bunny"
    capture = read_capture(folder / name)
    return capture, np.load(folder / "normals_gt.npy")


@pytest.mark.parametrize(
    ("name", "solver", "wanted", "within"),
    [
        ("bunny_lambert", "least_squares", 4.16, 0.1),
        ("bunny_lambert", "trimmed", 2.62, 0.1),
        ("bunny_lambert_noshadow", "least_squares", 1.01, 0.1),
        ("bunny_lambert_noshadow", "trimmed", 0.14, 0.05),
        ("bunny_lambert", "robust", 0.20, 0.05),
        ("bunny_lambert_noshadow", "robust", 0.14, 0.05),
    ],
)
def test_bunny(data, name, solver, wanted, within):
    capture, truth = bunny(data, name)
    normals, *_ = surface_normals(capture, solver=solver)
    assert degrees_off(normals, truth, capture.mask) == pytest.approx(wanted, abs=within)


def test_the_gray_sphere(data):
    """Its normals are those of the circle of its mask, taken up to 66 degrees from the camera."""
    capture = read_capture(data / "photometric" / "uw-psm" / "gray")
    rows, columns = np.nonzero(capture.mask)
    cx, cy = (columns.min() + columns.max()) / 2, (rows.min() + rows.max()) / 2
    radius = (np.ptp(columns) + np.ptp(rows) + 2) / 4
    r, c = np.indices(capture.mask.shape)
    x, y = (c - cx) / radius, (cy - r) / radius
    z = np.sqrt(np.clip(1 - x * x - y * y, 0, None))
    facing = capture.mask & (z > 0.4)
    truth = np.dstack([x, y, z])
    plain, *_ = surface_normals(capture, solver="least_squares")
    assert degrees_off(plain, truth, facing) == pytest.approx(4.80, abs=0.1)
    robust, *_, quality = surface_normals(capture)
    assert degrees_off(robust, truth, facing) < 4.1
    assert quality["strength_spread"] == 1.0 and quality["black_level"] == 0.0


def test_the_cat_of_unknown_lamps(data):
    capture = read_capture(data / "photometric" / "psbox-cat")
    plain = surface_normals(capture, solver="least_squares")[3]
    robust = surface_normals(capture)[3]
    assert plain["residual"] > 0.1 and robust["residual"] < 0.02
    assert robust["strength_spread"] == pytest.approx(2.3, abs=0.2)


def test_a_glossy_relief_is_no_worse_than_by_least_squares(data):
    from PIL import Image

    folder = data / "photometric" / "synthrti-relief" / "train49"
    capture = read_capture(folder)
    truth = np.asarray(Image.open(folder / "normals.png").convert("RGB")) / 127.5 - 1.0
    off = {s: degrees_off(surface_normals(capture, solver=s)[0], truth, capture.mask) for s in SOLVERS}
    assert off["robust"] < off["least_squares"] < 20.5


def test_the_bunny_bulges_toward_the_camera(data):
    capture, _ = bunny(data, "bunny_lambert")
    surface = photometric(capture)
    rim = surface.mask & ~np.roll(surface.mask, 6, axis=0) | surface.mask & ~np.roll(surface.mask, -6, axis=1)
    inner = surface.mask[150:180, 130:180]
    assert inner.all()
    assert surface.height[150:180, 130:180].mean() > surface.height[rim].mean() + 10.0
