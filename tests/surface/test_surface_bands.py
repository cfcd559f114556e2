"""A surface that is read some rows at a time: the same rows, and the same means, as of the whole."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
import tifffile
from tests.surface.test_folder import surface

from rumu.errors import SurfaceError
from rumu.surface.array_files import ARRAYS
from rumu.surface.folder import FLOATS, PICTURES, write_surface
from rumu.surface.surface_bands import SurfaceBands


@pytest.mark.parametrize("colour", [False, True])
@pytest.mark.parametrize("size", [(23, 31), (256, 512), (700, 300)])
def test_the_rows_are_those_that_were_written(tmp_path, colour, size):
    made = surface(colour=colour, h=size[0], w=size[1])
    write_surface(made, tmp_path / "s", files=FLOATS)
    bands = SurfaceBands(tmp_path / "s")
    assert bands.shape == size
    for name in ARRAYS:
        parts = list(bands.rows(name))
        assert len(parts) == -(-size[0] // 256)
        assert np.array_equal(np.concatenate(parts), getattr(made, name))
    assert bands.height_range() == (made.height.min(), made.height.max())


def test_a_file_of_strips_and_a_surface_without_floats_are_read_as_well(tmp_path):
    made = surface(h=90, w=70)
    write_surface(made, tmp_path / "s", files=FLOATS)
    tifffile.imwrite(tmp_path / "s" / "height.tif", made.height, rowsperstrip=16)
    assert np.array_equal(np.concatenate(list(SurfaceBands(tmp_path / "s").rows("height"))), made.height)
    write_surface(made, tmp_path / "p", files=PICTURES)
    found = np.concatenate(list(SurfaceBands(tmp_path / "p").rows("normals")))
    assert np.abs(found - made.normals).max() < 1e-3


def test_what_is_reduced_are_means_over_squares(tmp_path):
    made = surface(h=600, w=400)
    write_surface(made, tmp_path / "s", files=FLOATS)
    found = SurfaceBands(tmp_path / "s").reduced(pixels=600 * 400 // 4)
    assert found.height.shape == (300, 200) and found.spacing == pytest.approx(2 * made.spacing)
    for name in ("height", "albedo", "confidence"):
        wanted = cv2.resize(getattr(made, name), (200, 300), interpolation=cv2.INTER_AREA)
        assert np.abs(getattr(found, name) - wanted).max() < 1e-5
    assert np.abs(np.linalg.norm(found.normals, axis=2) - 1).max() < 1e-5
    odd = SurfaceBands(tmp_path / "s").reduced(pixels=30_000)  # squares of three, and a rest
    assert odd.height.shape == (200, 134) and odd.mask.shape == (200, 134)
    assert odd.height[0, 0] == pytest.approx(made.height[:3, :3].mean(), abs=1e-5)


@pytest.mark.parametrize("harm", ["gone", "cut", "other"])
def test_a_damaged_file_is_named(tmp_path, harm):
    write_surface(surface(), tmp_path / "s", files=FLOATS)
    path = tmp_path / "s" / "albedo.tif"
    if harm == "gone":
        path.unlink()
    elif harm == "cut":
        path.write_bytes(path.read_bytes()[:200])
    else:
        tifffile.imwrite(path, np.zeros((23, 30), np.float32))
    with pytest.raises(SurfaceError, match="albedo"):
        list(SurfaceBands(tmp_path / "s").rows("albedo"))


def test_a_whole_surface_is_checked_some_rows_at_a_time(tmp_path):
    made = surface(h=600, w=300)
    write_surface(made, tmp_path / "s", files=FLOATS)
    SurfaceBands(tmp_path / "s").check()
    write_surface(surface(), tmp_path / "p", files=PICTURES)
    SurfaceBands(tmp_path / "p").check()
    bent = made.normals.copy()
    bent[520:, ::2] *= 1.5  # in the last rows
    tifffile.imwrite(tmp_path / "s" / "normals.tif", bent, tile=(256, 256))
    with pytest.raises(SurfaceError, match="unit normals"):
        SurfaceBands(tmp_path / "s").check()
    tifffile.imwrite(tmp_path / "s" / "normals.tif", made.normals[:-1], tile=(256, 256))
    with pytest.raises(SurfaceError, match=r"normals\.tif: expected 600 rows, got 599"):
        SurfaceBands(tmp_path / "s").check()
    tifffile.imwrite(tmp_path / "s" / "normals.tif", made.normals[..., :2], tile=(256, 256))
    with pytest.raises(SurfaceError, match="normals"):
        SurfaceBands(tmp_path / "s").check()
