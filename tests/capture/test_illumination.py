"""Uneven light: the paper's bands and SVD split, and the fit to blank paper."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rumu.capture.flatfield import fit_flatfield
from rumu.capture.illumination import (
    band_levels,
    band_ratio,
    find_bands,
    gain,
    inverse_square_ratio,
    lamp_distance,
    rectify,
    rectify_capture,
    svd_ratio,
    svd_split,
)
from rumu.capture.lights import direction
from rumu.errors import CaptureError
from rumu.values import Capture

PAPER, INK = 0.85, 0.06


def page(shape: tuple[int, int] = (240, 200), *, into_far_band: bool = False, seed: int = 3) -> np.ndarray:
    """Albedo of a page: slanted strokes of ink on paper; at will one more that runs out at the right edge."""
    rng = np.random.default_rng(seed)
    rows, columns = np.mgrid[: shape[0], : shape[1]].astype(float)
    ink = np.zeros(shape, bool)
    for _ in range(14):
        r0, c0 = rng.uniform(0.2, 0.8, 2) * shape
        angle, length, width = rng.uniform(0, np.pi), rng.uniform(20, 60), rng.uniform(3, 7)
        along = (columns - c0) * np.cos(angle) + (rows - r0) * np.sin(angle)
        across = -(columns - c0) * np.sin(angle) + (rows - r0) * np.cos(angle)
        ink |= (np.abs(along) < length / 2) & (np.abs(across) < width)
    if into_far_band:
        ink |= (rows > 60) & (rows < 155) & (columns > 150)
    return np.where(ink, INK, PAPER)


def near_lamp(shape: tuple[int, int], *, distance: float, tilt: float, slant: float = 45) -> np.ndarray:
    """The true law of a small lamp over a plane, h / (rho^2 + h^2)^(3/2); distance in longer sides."""
    height, width = shape
    rows, columns = np.mgrid[:height, :width] / max(shape)
    x, y = columns - columns.mean(), -(rows - rows.mean())
    lamp = distance * direction(tilt=tilt, slant=slant)
    light = lamp[2] / ((x - lamp[0]) ** 2 + (y - lamp[1]) ** 2 + lamp[2] ** 2) ** 1.5
    return np.asarray(light / light.max())


def one_dimensional(shape: tuple[int, int], *, ratio: float, tilt: float) -> np.ndarray:
    """The paper's law: light that falls as 1 / gain along the tilt, K' = ratio from band to band."""
    bands = find_bands(shape, tilt=tilt)
    return 1 / gain(bands.position, ratio=ratio, distance=bands.distance)


def photograph(albedo: np.ndarray, light: np.ndarray, *, noise: float = 0.004) -> np.ndarray:
    grain = np.random.default_rng(5).normal(0, noise, albedo.shape)
    return (albedo * light + grain).clip(0, 1).astype(np.float32)


def relative_rms(values: np.ndarray) -> float:
    return float(values.std() / values.mean())


# --- identities ------------------------------------------------------------------------------------


@given(distance=st.floats(0.01, 1e4), step=st.floats(1e-3, 1e3))
def test_lamp_distance_solves_the_inverse_square_law(distance: float, step: float) -> None:
    ratio = inverse_square_ratio(distance, step=step)
    if ratio < 1 - 1e-9:
        assert lamp_distance(ratio, step=step) == pytest.approx(distance, rel=1e-6)
    assert inverse_square_ratio(lamp_distance(0.37, step=step), step=step) == pytest.approx(0.37)


def test_without_radicals_it_would_not_solve_it() -> None:
    assert inverse_square_ratio(2.0 * 0.37 / (1 - 0.37), step=2.0) != pytest.approx(0.37, abs=0.05)


@given(ratio=st.floats(0.01, 1), distance=st.floats(1, 1e4))
def test_gain_at_the_bands(ratio: float, distance: float) -> None:
    ends = gain(np.array([0.0, distance]), ratio=ratio, distance=distance)
    np.testing.assert_allclose(ends, [1, 1 / ratio], rtol=1e-9)


def test_gain_is_the_inverse_square_law_between_the_bands() -> None:
    steps = np.linspace(0, 50, 11)
    lamp = lamp_distance(0.4, step=50)
    expected = [1 / inverse_square_ratio(lamp, step=s) for s in steps]
    np.testing.assert_allclose(gain(steps, ratio=0.4, distance=50), expected)


def test_even_light_means_a_lamp_at_infinity() -> None:
    assert math.isinf(lamp_distance(1.0, step=3)) and inverse_square_ratio(math.inf, step=3) == 1
    np.testing.assert_array_equal(gain(np.arange(5.0), ratio=1.0, distance=4), np.ones(5))


@pytest.mark.parametrize("ratio", [0.0, -1.0, 1.2, math.nan])
def test_ratio_outside_its_range(ratio: float) -> None:
    with pytest.raises(CaptureError, match=r"expected a ratio in \(0, 1\]"):
        lamp_distance(ratio, step=1)


# --- bands -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("tilt", "near", "far", "distance"),
    [
        (0, np.s_[:, -7:], np.s_[:, :7], 43),
        (90, np.s_[:7], np.s_[-7:], 33),
        (180, np.s_[:, :7], np.s_[:, -7:], 43),
        (270, np.s_[-7:], np.s_[:7], 33),
    ],
)
def test_bands_lie_at_the_lamps_edge(tilt: float, near: tuple, far: tuple, distance: float) -> None:
    bands = find_bands((40, 50), tilt=tilt, n=7)
    expected_near, expected_far = np.zeros((2, 40, 50), bool)
    expected_near[near], expected_far[far] = True, True
    np.testing.assert_array_equal(bands.near, expected_near)
    np.testing.assert_array_equal(bands.far, expected_far)
    assert bands.distance == pytest.approx(distance)
    assert bands.position[bands.near].mean() == pytest.approx(0, abs=1e-4)
    assert bands.position[bands.far].mean() == pytest.approx(distance, abs=1e-4)


def test_bands_of_a_lamp_at_the_top_right_are_corners() -> None:
    bands = find_bands((40, 40), tilt=45)
    assert bands.near[0, -1] and bands.far[-1, 0] and not bands.near[0, 0] and not bands.far[-1, -1]


def test_bands_that_meet() -> None:
    with pytest.raises(CaptureError, match="expected bands of 1 to 19 pixels, got n = 30"):
        find_bands((40, 50), tilt=0, n=30)


@pytest.mark.parametrize("n", [5, 7, 11])
def test_a_stroke_in_the_far_band_fools_the_mean_and_not_us(n: int) -> None:
    albedo = page(into_far_band=True)
    light = one_dimensional(albedo.shape, ratio=0.55, tilt=180)
    image = photograph(albedo, light)
    bands = find_bands(image.shape, tilt=180, n=n)
    mean_ratio = image[bands.far].mean() / image[bands.near].mean()
    assert mean_ratio < 0.40
    paper = fit_flatfield(image).paper
    ours = band_ratio(*band_levels(image, bands, paper=paper))
    assert ours == pytest.approx(light[bands.far].mean() / light[bands.near].mean(), abs=0.01)


def test_no_paper_in_a_band() -> None:
    image = np.full((40, 40), 0.5, np.float32)
    with pytest.raises(CaptureError, match="expected blank paper in the far band, found none"):
        paper = np.ones((40, 40), bool)
        paper[:, 20:] = False
        band_levels(image, find_bands((40, 40), tilt=180), paper=paper)


# --- the SVD split ---------------------------------------------------------------------------------


def test_split_adds_up() -> None:
    image = photograph(page(), near_lamp((240, 200), distance=2, tilt=0))
    light, rest = svd_split(image, k=7)
    np.testing.assert_allclose(light + rest, image, atol=1e-6)
    u, w, vt = np.linalg.svd(image.astype(np.float64), full_matrices=False)
    np.testing.assert_allclose(light, (u[:, :7] * w[:7]) @ vt[:7], atol=1e-5)


def test_multiplicative_split_multiplies_up() -> None:
    image = photograph(page(), near_lamp((240, 200), distance=2, tilt=0)).clip(1e-3, 1)
    light, rest = svd_split(image, k=7, kind="multiplicative")
    np.testing.assert_allclose(light * rest, image, rtol=1e-4)
    assert light.min() > 0


@pytest.mark.parametrize("k", range(1, 21))
def test_ratio_is_right_for_every_number_of_components(k: int) -> None:
    albedo = page()
    light = one_dimensional(albedo.shape, ratio=0.55, tilt=0)
    image = photograph(albedo, light)
    bands = find_bands(image.shape, tilt=0)
    found = svd_ratio(image, bands, paper=fit_flatfield(image).paper, k=k)
    assert found == pytest.approx(light[bands.far].mean() / light[bands.near].mean(), abs=0.003)


@pytest.mark.parametrize(("k", "error"), [(7, 0.05), (16, 0.01)])
def test_multiplicative_ratio_leaks_ink_when_the_components_are_few(k: int, error: float) -> None:
    albedo = page()
    light = one_dimensional(albedo.shape, ratio=0.55, tilt=0)
    image = photograph(albedo, light)
    bands = find_bands(image.shape, tilt=0)
    found = svd_ratio(image, bands, paper=fit_flatfield(image).paper, k=k, kind="multiplicative")
    assert 0.55 - 0.002 < found < 0.55 + error


def test_leading_components_are_ink_more_than_light() -> None:
    albedo = np.full((240, 240), PAPER)
    for line in range(30, 220, 40):
        albedo[line : line + 14, 40:200] = INK
        albedo[40:200, line : line + 10] = INK
    light = near_lamp((240, 240), distance=3, tilt=0)
    leading, _ = svd_split(photograph(albedo, light), k=7)
    with_ink = np.corrcoef(leading.ravel(), (albedo == PAPER).ravel())[0, 1]
    with_light = np.corrcoef(leading.ravel(), light.ravel())[0, 1]
    assert with_ink > 0.7 > with_light


def test_split_settings() -> None:
    with pytest.raises(CaptureError, match="expected 1 to 20 singular values, got k = 0"):
        svd_split(np.ones((20, 30), np.float32), k=0)
    with pytest.raises(CaptureError, match="expected kind 'additive' or 'multiplicative'"):
        svd_split(np.ones((20, 30), np.float32), kind="log")  # type: ignore[arg-type]


# --- the fit to blank paper ------------------------------------------------------------------------


@pytest.mark.parametrize("tilt", [0, 90, 217])
@pytest.mark.parametrize("distance", [1.2, 2.0, 4.0])
def test_fit_recovers_a_near_lamp(tilt: float, distance: float) -> None:
    albedo, light = page(), near_lamp((240, 200), distance=distance, tilt=tilt)
    fit = fit_flatfield(photograph(albedo, light))
    assert relative_rms(fit.level / light) < 1e-3
    assert (albedo[fit.paper] == PAPER).all() and fit.paper.mean() > 0.4


def test_fit_recovers_smooth_light() -> None:
    albedo = page()
    rows, columns = np.mgrid[:240, :200] / 120 - 1
    light = np.exp(-0.4 * columns + 0.1 * rows - 0.15 * columns**2 - 0.2 * rows**2)
    light /= light.max()
    fit = fit_flatfield(photograph(albedo, light))
    assert fit.law == "smooth"
    assert relative_rms(fit.level / light) < 1e-3


def test_fit_of_a_large_image_and_a_mask() -> None:
    albedo = np.kron(page(), np.ones((4, 4)))
    light = near_lamp(albedo.shape, distance=1.5, tilt=180)
    image = photograph(albedo, light)
    mask = np.zeros(albedo.shape, bool)
    mask[100:860, 80:720] = True
    image[~mask] = 0.02  # a dark table around the sheet
    fit = fit_flatfield(image, mask=mask)
    assert relative_rms((fit.level / light)[mask]) < 2e-3
    assert not fit.paper[~mask].any() and fit.paper.mean() > 0.3


def test_black_image_has_no_paper() -> None:
    with pytest.raises(CaptureError, match="expected"):
        rectify(
            np.where(np.random.default_rng(0).random((64, 64)) > 0.5, 1.0, 1e-4).astype(np.float32), tilt=0
        )


# --- rectification ---------------------------------------------------------------------------------


@pytest.mark.parametrize(("method", "limit"), [("masked", 1e-3), ("bands", 0.04), ("svd", 0.04)])
@pytest.mark.parametrize("tilt", [0, 90, 180, 270, 60])
def test_paper_comes_out_even(method: str, limit: float, tilt: float) -> None:
    albedo, light = page(), near_lamp((240, 200), distance=2, tilt=tilt)
    done = rectify(photograph(albedo, light), tilt=tilt, method=method)  # type: ignore[arg-type]
    assert not done.swapped and done.warning is None
    assert relative_rms(done.gain * light) < limit < relative_rms(light)
    assert done.spread[1] < done.spread[0]
    bands = find_bands(light.shape, tilt=tilt)
    assert done.gain[bands.near].mean() == pytest.approx(1, abs=0.02)
    true_ratio = light[bands.far].mean() / light[bands.near].mean()
    assert abs(done.K - true_ratio) < 0.02


@pytest.mark.parametrize("method", ["masked", "bands", "svd"])
def test_lamp_on_the_other_side_is_swapped_and_said(method: str) -> None:
    light = one_dimensional((240, 200), ratio=0.6, tilt=180)
    done = rectify(photograph(page(), light), tilt=0, method=method)  # type: ignore[arg-type]
    assert done.swapped and abs(done.K - 0.6) < 0.01
    assert done.warning is not None and "labelled tilt 0 stands on the other side" in done.warning
    assert relative_rms(done.gain * light) < 0.01
    right = rectify(photograph(page(), light), tilt=180, method=method)  # type: ignore[arg-type]
    np.testing.assert_allclose(done.gain, right.gain, rtol=1e-3)


@pytest.mark.parametrize("method", ["masked", "bands", "svd"])
def test_even_light_is_left_alone(method: str) -> None:
    done = rectify(photograph(page(), np.ones((240, 200))), tilt=0, method=method)  # type: ignore[arg-type]
    assert not done.swapped
    np.testing.assert_allclose(done.gain, 1, atol=0.01)


def test_colours_share_one_gain() -> None:
    light = near_lamp((240, 200), distance=2, tilt=0)
    gray = photograph(page(), light, noise=0)
    colour = gray[:, :, None] * np.array([1.0, 0.8, 0.6], np.float32)
    done = rectify(colour, tilt=0)
    assert done.image.shape == (240, 200, 3) and done.image.dtype == np.float32
    np.testing.assert_allclose(done.image[..., 2] / done.image[..., 0], 0.6, rtol=1e-5)


def test_unknown_method() -> None:
    with pytest.raises(CaptureError, match="expected a method among masked, bands, svd, got 'magic'"):
        rectify(np.ones((64, 64), np.float32), tilt=0, method="magic")  # type: ignore[arg-type]


# --- a whole capture -------------------------------------------------------------------------------


def flat_capture(tilts: tuple[float, ...] = (0, 90, 180)) -> Capture:
    """A flat page under near lamps of different strengths; the true result is three equal images."""
    strengths = (1.0, 0.7, 0.85)
    images = [
        photograph(page(), near_lamp((240, 200), distance=2, tilt=t) * s)
        for t, s in zip((0, 90, 180), strengths, strict=True)
    ]
    return Capture(
        images=np.stack(images),
        lights=np.array([direction(tilt=t, slant=45) for t in tilts]),
        mask=np.ones((240, 200), bool),
        names=("a.png", "b.png", "c.png"),
    )


def test_flat_capture_becomes_equal_images() -> None:
    done = rectify_capture(flat_capture())
    paper = page() == PAPER
    a, b, c = done.images[:, paper]
    # With a = b = c there is no slope, as it must be for flat paper; before, the slopes were large.
    slope = np.abs((c - a) / (a + c)).mean()
    raw_a, _, raw_c = flat_capture().images[:, paper]
    assert np.abs((raw_c - raw_a) / (raw_a + raw_c)).mean() > 0.1
    assert slope < 0.006
    assert np.median(b) == pytest.approx(np.median(a), rel=2e-3)
    assert done.images.min() >= 0 and done.images.max() <= 1
    assert done.strengths is not None and (done.strengths == 1).all()
    assert done.names == ("a.png", "b.png", "c.png")


def test_capture_with_a_wrong_label_warns_and_names_the_image() -> None:
    with pytest.warns(UserWarning, match=r"c\.png: the lamp labelled tilt 300 stands on the other side"):
        rectify_capture(flat_capture(tilts=(0, 90, 300)))
