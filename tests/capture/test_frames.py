"""Odd but honest captures, as they come from a digitisation: read rightly, or refused for the true reason."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import tifffile
from PIL import Image

from rumu.capture.flat_frames import unused_flat_notes
from rumu.capture.folder import read_capture
from rumu.capture.lights import direction
from rumu.errors import CaptureError, ImageError
from rumu.values import Capture

LIGHTS = np.array([direction(tilt=90 * i, slant=40) for i in range(4)])
SIZE = (24, 20)


def photographs(folder: Path, *, suffix: str = ".png", dark_around: bool = False) -> Path:
    """Four photographs of a bright patch and their lamps."""
    for i in range(4):
        levels = np.full(SIZE, 60 + 30 * i, np.uint8)
        levels[0, i] = 7
        if dark_around:
            levels[:, :8] = 1
        Image.fromarray(levels).save(folder / f"p{i}{suffix}")
    write_lamps(folder / "lights.lp", suffix)
    return folder


def write_lamps(path: Path, suffix: str = ".png") -> None:
    rows = [f"p{i}{suffix} {x:.6f} {y:.6f} {z:.6f}" for i, (x, y, z) in enumerate(LIGHTS)]
    path.write_text("\n".join(["4", *rows]))


def notes(capture: Capture) -> str:
    return "\n".join(note.en for note in capture.notes)


def test_a_list_on_which_windows_hung_txt(tmp_path: Path) -> None:
    photographs(tmp_path)
    (tmp_path / "lights.lp").rename(tmp_path / "lights.lp.txt")
    np.testing.assert_allclose(read_capture(tmp_path).lights, LIGHTS, atol=1e-6)
    np.testing.assert_allclose(read_capture(tmp_path / "lights.lp.txt").lights, LIGHTS, atol=1e-6)


def test_workbooks_are_named(tmp_path: Path) -> None:
    photographs(tmp_path)
    (tmp_path / "lights.lp").unlink()
    (tmp_path / "lamps.xlsx").write_bytes(b"PK\x03\x04" + bytes(40))
    with pytest.raises(CaptureError, match=r"found lamps\.xlsx, a workbook: save it as CSV"):
        read_capture(tmp_path)
    (tmp_path / "lamps.xlsx").rename(tmp_path / "lamps.csv")
    with pytest.raises(CaptureError, match=r"lamps\.csv: expected a text file, found the workbook"):
        read_capture(tmp_path)


def test_a_flat_field_frame_is_no_photograph(tmp_path: Path) -> None:
    photographs(tmp_path)
    (tmp_path / "lights.lp").unlink()
    np.savetxt(tmp_path / "light_directions.txt", LIGHTS)
    Image.new("L", SIZE[::-1], 200).save(tmp_path / "Flat-Field.png")
    assert read_capture(tmp_path).names == ("p0.png", "p1.png", "p2.png", "p3.png")
    (note,) = unused_flat_notes(tmp_path)
    assert f"--flat-field {tmp_path / 'Flat-Field.png'} divides" in note.en


def test_raw_files_are_not_looked_for_in_other_captures(tmp_path: Path) -> None:
    (tmp_path / "one").mkdir()
    photographs(tmp_path / "one")
    (tmp_path / "other").mkdir()
    write_lamps(tmp_path / "other" / "lights.lp")
    for i in range(4):
        (tmp_path / "other" / f"p{i}.CR2").write_bytes(b"II*\0")
    with pytest.raises(CaptureError, match=r"lights\.lp line 2: p0\.CR2 is a raw file of a camera"):
        read_capture(tmp_path / "other")


def test_a_mask_that_is_inverted(tmp_path: Path) -> None:
    photographs(tmp_path, dark_around=True)
    mask = np.zeros(SIZE, np.uint8)
    mask[:, 8:] = 255
    Image.fromarray(mask).save(tmp_path / "mask.png")
    assert read_capture(tmp_path).mask.sum() == mask.sum() / 255
    Image.fromarray(255 - mask).save(tmp_path / "mask.png")
    with pytest.raises(CaptureError, match=r"mask\.png: seems to be inverted"):
        read_capture(tmp_path)


def test_transparent_places_are_outside_the_mask(tmp_path: Path) -> None:
    photographs(tmp_path)
    for i in range(4):
        levels = np.repeat(np.full(SIZE, 60 + 30 * i, np.uint16)[..., None] * 257, 4, axis=2)
        levels[0, i, :3] = 7
        levels[..., 3] = 65535
        levels[:, : 4 + i, 3] = 0
        tifffile.imwrite(tmp_path / f"p{i}.tif", levels, photometric="rgb", extrasamples=["unassalpha"])
        (tmp_path / f"p{i}.png").unlink()
    write_lamps(tmp_path / "lights.lp", ".tif")
    capture = read_capture(tmp_path)
    assert capture.mask[:, 7:].all() and not capture.mask[:, :7].any()
    assert "4 photographs (p0.tif...) are transparent in places (35%)" in notes(capture)
    np.testing.assert_allclose(capture.images[2][:, 8:], 120 / 255, rtol=1e-6)
    levels[..., 3] = 100
    tifffile.imwrite(tmp_path / "p0.tif", levels, photometric="rgb", extrasamples=["unassalpha"])
    with pytest.raises(CaptureError, match="no place is opaque in all photographs"):
        read_capture(tmp_path)


def test_photographs_of_two_kinds(tmp_path: Path) -> None:
    photographs(tmp_path)
    Image.open(tmp_path / "p1.png").save(tmp_path / "p1.jpg")
    (tmp_path / "p1.png").unlink()
    assert "not of one kind: 1 (p1.jpg...)" in notes(read_capture(tmp_path))
    assert "not of one kind" not in notes(read_capture(tmp_path, encoding="srgb"))


def test_errors_tell_no_folder_and_quote_names(tmp_path: Path) -> None:
    photographs(tmp_path)
    (tmp_path / "p2.png").write_bytes(b"")
    with pytest.raises(ImageError, match=r"^p2\.png: expected an image .*, the file is empty"):
        read_capture(tmp_path)
    (tmp_path / "p2.png").unlink()
    (tmp_path / "lights.lp").write_text((tmp_path / "lights.lp").read_text().replace("p2", "p 2"))
    with pytest.raises(CaptureError, match=r'--leave-out "p 2\.png" does without it'):
        read_capture(tmp_path)
