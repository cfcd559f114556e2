"""How a sheet leans and is bowed is taken off, and what lies on it stays."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.errors import SurfaceError
from rumu.surface.level import take_level
from rumu_lab.simulation.lamps import from_slopes

SIZE = (90, 130)


def sheet(*, bow):
    """A sheet with a carved rim, its lean and perhaps its bow: height and normals, with and without them."""
    h, w = SIZE
    y, x = (h - 1) / 2 - np.mgrid[:h, :w][0], np.mgrid[:h, :w][1] - (w - 1) / 2
    carved = np.where((np.abs(x) < 20) & (np.abs(y) < 12), -3.0 * np.cos(x * np.pi / 40) ** 2, 0.0)
    p = np.where((np.abs(x) < 20) & (np.abs(y) < 12), 3.0 * np.pi / 40 * np.sin(x * np.pi / 20), 0.0)
    k = 0.001 if bow else 0.0
    height = carved + 0.1 * x - 0.05 * y + 4.0 + k * (x * x - 0.6 * x * y + 0.5 * y * y)
    px, qy = 0.1 + k * (2 * x - 0.6 * y), -0.05 + k * (y - 0.6 * x)
    return (
        height.astype(np.float32),
        from_slopes(p + px, np.zeros(SIZE) + qy).astype(np.float32),
        carved,
        from_slopes(p, np.zeros(SIZE)),
    )


@pytest.mark.parametrize(("level", "bow"), [("plane", False), ("bow", False), ("bow", True)])
def test_what_is_carved_stays_and_the_sheet_is_level(level, bow):
    height, normals, carved, flat_normals = sheet(bow=bow)
    take_level(height, normals, np.ones(SIZE, bool), level=level)
    assert np.abs(height - carved).max() < 0.05
    np.testing.assert_allclose(normals, flat_normals, atol=2e-3)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=2), 1.0, atol=1e-5)


def test_a_plane_leaves_the_bow():
    height, normals, carved, _ = sheet(bow=True)
    take_level(height, normals, np.ones(SIZE, bool), level="plane")
    assert np.ptp(height - carved) > 2.0


def test_only_what_was_measured_is_fitted():
    height, normals, carved, _ = sheet(bow=False)
    measured = np.zeros(SIZE, bool)
    measured[:, :60] = True
    height[:, 60:] += 50.0
    take_level(height, normals, measured, level="plane")
    assert np.abs(height - carved)[measured].max() < 0.05


def test_none_changes_nothing_and_an_unknown_one_is_refused():
    height, normals, _, _ = sheet(bow=True)
    before = height.copy(), normals.copy()
    take_level(height, normals, np.ones(SIZE, bool), level="none")
    assert np.array_equal(height, before[0]) and np.array_equal(normals, before[1])
    with pytest.raises(SurfaceError, match=r"level among none, plane, bow.*'tilt'"):
        take_level(height, normals, np.ones(SIZE, bool), level="tilt")
