"""Photographs that cannot be used are refused for the true reason, by name and in both languages."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy import ndimage

from rumu.capture.folder import read_capture
from rumu.errors import CaptureError
from rumu.surface.frame_check import check_exposure, check_still, exposure_notes
from rumu.surface.photometric import photometric
from rumu.values import Capture
from rumu_lab.simulation.lamps import Sensor, photographs
from rumu_lab.simulation.shapes import bump, ridges

REAL = (
    *(f"uw-psm/{name}" for name in ("buddha", "cat", "chrome", "gray", "horse", "owl", "rock")),
    "bunny/bunny_lambert", "psbox-cat", "synthrti-relief/train49", "synthrti-relief/test20", "lion-rti",
)  # fmt: skip
SIZE = (160, 200)
NAMES = tuple(f"p{i}.png" for i in range(6))


def capture_of(*, noise: float = 0.003, lamps: int = 6, **options: object) -> Capture:
    """A low bump on inked paper under six lamps, or as many."""
    strokes = sum(ridges(SIZE, width=7, pitch=60, angle=angle).height for angle in (0, 80, 45))
    images, lights = photographs(
        bump(SIZE, peak=6, sigma=30).height, 0.06 + 0.8 * np.exp(-np.asarray(strokes)),
        tilts=np.arange(lamps) * 360 / lamps, slant=45, sensor=Sensor(noise=noise), **options,
    )  # fmt: skip
    return Capture(images=images, lights=lights, mask=np.ones(SIZE, bool), names=NAMES if lamps == 6 else ())


def refused(capture: Capture) -> CaptureError:
    with pytest.raises(CaptureError) as error:
        photometric(capture)
    assert error.value.zh
    return error.value


@pytest.mark.parametrize("name", REAL)
def test_real_captures_pass(data: Path, name: str) -> None:
    capture = read_capture(data / "photometric" / name)
    check_exposure(capture)
    check_still(capture)


def test_a_good_capture_passes() -> None:
    assert photometric(capture_of()).source == "photometric"


def test_black_frames_are_named() -> None:
    images = capture_of().images.copy()
    images[[1, 4]] = 0.001
    error = refused(replace(capture_of(), images=images))
    assert str(error).startswith("p1.png, p4.png: black, no lamp lit") and "p1.png、p4.png：全黑" in str(
        error.zh
    )


def test_all_black() -> None:
    capture = capture_of()
    error = refused(replace(capture, images=capture.images * np.float32(0.001)))
    assert str(error).startswith("p0.png, p1.png") and "black" in str(error)


def test_photographs_without_shades_are_told_as_such() -> None:
    error = refused(replace(capture_of(), images=(capture_of().images > 0.4).astype(np.float32)))
    assert "black and white alone" in str(error)


def test_overexposed_frames_are_named() -> None:
    images = capture_of().images.copy()
    images[2] = 1.0
    error = refused(replace(capture_of(), images=images))
    assert str(error).startswith("p2.png: overexposed, 100%") and "p2.png：曝光過度" in str(error.zh)


def test_the_case_of_white_frames(cases: Path) -> None:
    error = refused(read_capture(cases / "ps-white"))
    assert str(error).startswith("p0.jpg, p1.jpg, p2.jpg, p3.jpg, p4.jpg, p5.jpg: overexposed")


@pytest.mark.parametrize("seed", range(3))
def test_a_frame_that_moved_is_named(seed: int) -> None:
    capture = capture_of()
    images = capture.images.copy()
    dy, dx = np.random.default_rng(seed).uniform(3, 6, 2)
    images[3] = ndimage.shift(images[3], (dy, -dx), order=1, mode="nearest")
    error = refused(replace(capture, images=images))
    assert "p3.png" in str(error) and f"by about {np.hypot(dy, dx):.0f} pixels" in str(error)
    assert "錯開了" in str(error.zh)


def test_relief_alone_is_no_movement() -> None:
    """Shading moves with the lamp; a sheet that is all relief must not be taken for one that moved."""
    rough = ndimage.gaussian_filter(np.random.default_rng(0).normal(size=SIZE), 4)
    images, lights = photographs(
        rough / rough.std(), 0.7, tilts=range(0, 360, 45), slant=50, sensor=Sensor(noise=0.003)
    )
    check_still(Capture(images=images, lights=lights, mask=np.ones(SIZE, bool)))


# --- on the disk ------------------------------------------------------------------------------------


def write(folder: Path, images: np.ndarray) -> Path:
    capture = capture_of()
    for name, image in zip(NAMES, images, strict=True):
        Image.fromarray((np.clip(image, 0, 1) * 65535).astype(np.uint16)).save(folder / name)
    rows = [f"{name} {x} {y} {z}" for name, (x, y, z) in zip(NAMES, capture.lights, strict=True)]
    (folder / "lights.lp").write_text("\n".join(["6", *rows]))
    return folder


def test_one_picture_under_two_names(tmp_path: Path) -> None:
    images = capture_of().images
    with pytest.raises(CaptureError, match=r"p4\.png: the same picture as p1\.png") as same:
        read_capture(write(tmp_path, images[[0, 1, 2, 3, 1, 5]]))
    assert "與 p1.png 完全相同" in str(same.value.zh)


def test_one_picture_under_all_names(tmp_path: Path) -> None:
    with pytest.raises(CaptureError, match=r"p1\.png: the same picture as p0\.png"):
        read_capture(write(tmp_path, capture_of().images[[0] * 6]))


def test_an_ambient_frame_that_is_brighter_than_a_lamp(tmp_path: Path) -> None:
    images = capture_of().images.copy()
    images[2] *= 0.2  # its lamp failed
    write(tmp_path, images + 0.2)
    Image.fromarray((np.clip(images[0] * 0.5 + 0.2, 0, 1) * 65535).astype(np.uint16)).save(
        tmp_path / "ambient.png"
    )
    with pytest.raises(CaptureError, match=r"p2\.png: darker than ambient\.png") as darker:
        read_capture(tmp_path)
    assert "比 ambient.png 還暗" in str(darker.value.zh)


@pytest.mark.parametrize("kind", ["each its own way", "drifting", "of many"])
@pytest.mark.parametrize("pixels", [2, 6])
def test_frames_that_all_moved(kind: str, pixels: int) -> None:
    lamps = 26 if kind == "of many" else 6
    capture = capture_of(lamps=lamps)
    rng = np.random.default_rng(1)
    moves = rng.normal(size=(lamps, 2))
    moves *= pixels / np.hypot(*moves.T)[:, None]
    if kind == "drifting":
        moves = np.array([(0.0, pixels * k) for k in range(6)])
    images = np.stack(
        [ndimage.shift(i, m, order=1, mode="nearest") for i, m in zip(capture.images, moves, strict=True)]
    )
    error = refused(replace(capture, images=images))
    assert "moved against the other photographs" in str(error) and "錯開了約" in str(error.zh)


def test_frames_of_different_exposure_are_noted_and_give_the_same_surface() -> None:
    capture = capture_of()
    exposed = replace(capture, images=capture.images * np.float32([1, 1, 0.5, 1, 0.7, 1])[:, None, None])
    even, uneven = photometric(capture), photometric(exposed)
    assert exposure_notes(capture, even) == ()
    (note,) = exposure_notes(exposed, uneven)
    assert "differ in brightness by up to 2 times" in note.en and "相差到 2 倍" in note.zh
    turned = (even.normals * uneven.normals).sum(axis=2).clip(-1, 1)
    assert np.degrees(np.arccos(turned)).mean() < 1.0
    assert exposure_notes(replace(exposed, strengths=np.ones(6)), uneven) == ()
