"""The mesh picture: the relief stands up, near things hide far ones, and the height is told true."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rumu.report.mesh_picture import MeshView, mesh_picture
from rumu.report.pictures import PAPER


def test_size_and_ground(master_surface):
    picture, _ = mesh_picture(master_surface, view=MeshView(width=300))
    assert picture.shape[1] == 300 and picture.dtype == np.uint8
    assert picture[0, 0].tolist() == list(PAPER)


def test_ink_is_seen(master_surface):
    blank = replace(
        master_surface,
        height=np.zeros_like(master_surface.height),
        mask=np.zeros_like(master_surface.mask),
    )
    with_ink, without = (mesh_picture(s)[0].min(axis=2) for s in (master_surface, blank))
    assert (with_ink < 100).mean() > 0.03
    assert (without < 100).mean() < 0.001


def test_a_flat_relief_is_raised_and_a_steep_one_left(master_surface):
    low = replace(master_surface, height=0.01 * master_surface.height)
    high = replace(master_surface, height=10 * master_surface.height)
    assert mesh_picture(low)[1] > 50
    assert mesh_picture(high)[1] == 1.0


def test_the_unit_does_not_change_the_picture(master_surface):
    """The same sheet told in millimetres is the same form."""
    metric = replace(
        master_surface, height=(master_surface.height * 0.1).astype(np.float32), spacing=0.1, unit="mm"
    )
    first, raised = mesh_picture(master_surface)
    second, raised_metric = mesh_picture(metric)
    assert raised == pytest.approx(raised_metric, rel=1e-4)
    assert np.abs(first.astype(int) - second.astype(int)).max() <= 8


def test_higher_ground_hides_what_lies_behind(master_surface):
    """A wall across the sheet hides the ink behind it."""
    ink = np.zeros((60, 60), dtype=bool)
    ink[18:24] = True  # far: upper rows
    height = np.zeros((60, 60), dtype=np.float32)
    wall = np.where((np.arange(60) > 30) & (np.arange(60) < 40), 40.0, 0.0)[:, None].astype(np.float32)
    normals = np.zeros((60, 60, 3), dtype=np.float32)
    normals[..., 2] = 1
    flat = replace(
        master_surface,
        height=height,
        mask=ink,
        normals_from=normals,
        albedo_from=np.ones_like(height),
        confidence=np.ones_like(height),
    )
    walled = replace(flat, height=height + wall)
    view = MeshView(azimuth=0.0, elevation=25.0, margin=1.0)

    def bluish(surface):
        picture = mesh_picture(surface, view=view)[0].astype(int)
        return ((picture[..., 2] - picture[..., 0]) > 15).mean()

    assert bluish(flat) > 0.02
    assert bluish(walled) < 0.002


@pytest.mark.parametrize("shape", [(2, 2), (2, 40), (30, 200)])
def test_odd_shapes(master_surface, shape):
    normals = np.zeros((*shape, 3), dtype=np.float32)
    normals[..., 2] = 1
    surface = replace(
        master_surface,
        height=np.zeros(shape, np.float32),
        normals_from=normals,
        albedo_from=np.ones(shape, np.float32),
        mask=np.ones(shape, bool),
        confidence=np.ones(shape, np.float32),
    )
    assert mesh_picture(surface, view=MeshView(width=120))[0].shape[1] == 120


def test_a_photometric_surface_is_drawn_where_it_was_measured(master_surface):
    """What lies outside of the mask neither shows nor pulls the edge down."""
    height = np.where(master_surface.mask, 30.0, -500.0).astype(np.float32)
    measured = replace(master_surface, source="photometric", height=height, albedo_from=np.ones_like(height))
    picture, raised = mesh_picture(measured)
    level, _ = mesh_picture(replace(measured, height=np.full_like(height, 30.0)))
    np.testing.assert_array_equal(picture, level)
    assert raised == 1.0 and 0.1 < (picture == PAPER).all(axis=2).mean() < 0.9


def test_a_photometric_surface_wears_its_albedo(master_surface):
    red = np.zeros((*master_surface.height.shape, 3), dtype=np.float32)
    red[..., 0] = 0.8
    picture, _ = mesh_picture(replace(master_surface, source="photometric", albedo_from=red))
    middle = picture[picture.shape[0] // 2, picture.shape[1] // 2].astype(int)
    assert middle[0] > middle[2] + 40
