"""Mirror spheres: found where there are some, refused where there are none, and true about the lamps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rumu.capture.folder import read_capture
from rumu.capture.image import read_mask, read_photograph
from rumu.capture.lights import direction
from rumu.capture.sphere_capture import read_sphere_capture
from rumu.capture.spheres import Sphere, find_spheres, lamps_of_spheres
from rumu.errors import CaptureError
from rumu.image_stack import ImageStack

LIGHTS = np.array([direction(tilt=40 * i, slant=20 + 4 * i) for i in range(8)])
TWO = (Sphere(150.3, 120.6, 61.5), Sphere(420.0, 260.4, 44.2))


def degrees_between(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.degrees(np.arccos(np.clip((one * other).sum(axis=-1), -1, 1)))


def scene(spheres: tuple[Sphere, ...], *, dark: tuple[int, ...] = (), noise: float = 0.004) -> ImageStack:
    """Photographs of a pale sheet with mirror balls on it; those numbered in `dark` show no highlight."""
    rng = np.random.default_rng(3)
    rows, columns = np.mgrid[:380, :560]
    paper = 0.5 + 0.1 * rng.random((48, 70)).repeat(8, 0).repeat(8, 1)[:380, :560]
    images = []
    for number, light in enumerate(LIGHTS):
        image = paper * light[2]
        for one in spheres:
            x, y = (columns - one.x) / one.radius, -(rows - one.y) / one.radius
            z = np.sqrt(np.clip(1 - x * x - y * y, 0, 1))
            mirrored = np.stack([2 * z * x, 2 * z * y, 2 * z * z - 1], axis=-1)
            highlight = 0.0 if number in dark else np.exp(-((1 - mirrored @ light) / 0.004))
            image = np.where(x * x + y * y < 1, 0.03 + highlight, image)
        images.append((image + rng.normal(0, noise, image.shape)).clip(0, 1).astype(np.float32))
    return ImageStack.of_arrays(images)


@pytest.mark.parametrize("count", [1, 2])
def test_spheres_are_found_and_tell_the_lamps(count: int) -> None:
    stack = scene(TWO[:count])
    found = find_spheres(stack)
    assert len(found) == count
    for one, wanted in zip(found, TWO, strict=False):
        assert np.hypot(one.x - wanted.x, one.y - wanted.y) < 0.6
        assert abs(one.radius - wanted.radius) < 0.6
    lamps = lamps_of_spheres(stack, found)
    assert degrees_between(lamps.lights, LIGHTS).max() < 1.5
    assert (lamps.apart == 0).all() if count == 1 else 0 < lamps.apart.max() < 3


def test_a_small_sphere_tells_the_lamps_between_pixels() -> None:
    """Its highlight covers a few pixels, of which a whole one would be a lamp 4 degrees away."""
    stack = scene((Sphere(70.0, 330.0, 28.0),))
    lamps = lamps_of_spheres(stack, find_spheres(stack))
    assert degrees_between(lamps.lights, LIGHTS).max() < 0.8


def test_photographs_without_a_highlight_have_no_lamp() -> None:
    stack = scene(TWO[:1], dark=(2, 5))
    lamps = lamps_of_spheres(stack, find_spheres(stack))
    assert np.flatnonzero(np.isnan(lamps.lights).all(axis=1)).tolist() == [2, 5]
    kept = np.isfinite(lamps.lights[:, 0])
    assert degrees_between(lamps.lights[kept], LIGHTS[kept]).max() < 1.5


def test_a_sheet_without_a_sphere_and_spheres_that_cannot_be_used() -> None:
    stack = scene(())
    expected = r"a mirror sphere of a radius of 12 pixels or more, found none .* --sphere x,y,r"
    with pytest.raises(CaptureError, match=expected) as none:
        find_spheres(stack)
    assert none.value.zh is not None
    with pytest.raises(CaptureError, match="a radius of 12 pixels or more within 560 x 380"):
        lamps_of_spheres(stack, [Sphere(100, 100, 5)])
    with pytest.raises(CaptureError, match="got centre 700"):
        lamps_of_spheres(stack, [Sphere(700, 100, 50)])
    with pytest.raises(CaptureError, match="no highlight in any photograph"):
        lamps_of_spheres(scene(TWO[:1], dark=tuple(range(8))), [TWO[0]])


def test_real_spheres_found_without_help_agree_with_hand_measured_lamps(data: Path) -> None:
    errors = []
    for probe in ("probe1", "probe2"):
        folder = data / "photometric" / "psbox-cat" / probe
        photographs = [read_photograph(path)[0] for path in sorted(folder.glob("Image_*.JPG"))]
        stack = ImageStack(photographs)
        spheres = find_spheres(stack)
        assert len(spheres) == 1
        wanted = np.loadtxt(folder / "light_directions.txt").T
        errors.append(degrees_between(lamps_of_spheres(stack, spheres).lights, wanted))
    assert np.mean(errors) < 0.8 and np.max(errors) < 1.8


def test_a_real_sphere_before_a_dark_ground_is_found_and_a_dull_one_is_not(data: Path) -> None:
    chrome = data / "photometric" / "uw-psm" / "chrome"
    paths = [path for path in sorted(chrome.glob("chrome.*.png")) if "mask" not in path.name]
    (found,) = find_spheres(ImageStack([read_photograph(path)[0] for path in paths]))
    rows, columns = np.nonzero(read_mask(chrome / "chrome.mask.png"))
    assert abs(found.x - (columns.min() + columns.max()) / 2) < 3
    assert abs(found.y - (rows.min() + rows.max()) / 2) < 3
    assert abs(found.radius - (np.ptp(rows) + 1) / 2) < 3
    for name in ("uw-psm/gray", "uw-psm/horse", "uw-psm/owl", "bunny/bunny_lambert", "psbox-cat"):
        with pytest.raises(CaptureError, match="expected a mirror sphere"):
            find_spheres(read_capture(data / "photometric" / name).photographs)


def test_a_real_folder_with_a_sphere_is_a_capture_without_any_file(data: Path) -> None:
    """The photographs of a probe alone: lamps as measured by hand, the ball outside the mask."""
    folder = data / "photometric" / "psbox-cat" / "probe1"
    capture = read_sphere_capture(folder)
    wanted = np.loadtxt(folder / "light_directions.txt").T
    assert len(capture.lights) == len(wanted) == len(capture.names)
    assert degrees_between(capture.lights, wanted).mean() < 0.8
    assert not capture.mask.all() and capture.mask.mean() > 0.1
