"""Disk B-splines fit the skeleton and sweep the ink again."""

from __future__ import annotations

import numpy as np
import pytest

from rumu_lab.baselines.cell import SIDE
from rumu_lab.baselines.disk_spline import SplineSettings, fit_disk_spline, sweep
from rumu_lab.baselines.lines import StrokeLine, lines_of, skeleton_of


def wave(n: int = 160) -> StrokeLine:
    x = np.linspace(20, 180, n)
    return StrokeLine(np.column_stack([x, 100 + 25 * np.sin(x / 18)]), 6 + 2 * np.sin(x / 40))


def test_centre_and_half_width_are_followed():
    line = wave()
    spline = fit_disk_spline(line, width=12.0)
    assert spline.rms < 0.5
    fitted = spline.line(step=0.5)
    gaps = np.linalg.norm(line.points[:, None] - fitted.points[None], axis=-1)
    assert gaps.min(axis=1).max() < 1.5
    nearest = gaps.argmin(axis=1)
    assert np.abs(fitted.radius[nearest] - line.radius).max() < 0.5
    assert spline.at(np.array([0.0, 1.0]))[:, :2] == pytest.approx(line.points[[0, -1]], abs=1.0)


def test_control_points_are_added_until_the_fit_is_accepted():
    few = fit_disk_spline(wave(), width=60.0, settings=SplineSettings(accepted=1e9))
    more = fit_disk_spline(wave(), width=60.0)
    assert len(few.control) == 4 and len(more.control) > 8
    assert more.rms < 0.5 < few.rms


def test_knots_are_clamped_and_rise():
    spline = fit_disk_spline(wave(), width=12.0)
    assert len(spline.knots) == len(spline.control) + 4
    assert (np.diff(spline.knots) >= 0).all()
    assert (spline.knots[:4] == 0).all() and (spline.knots[-4:] == 1).all()


@pytest.mark.parametrize("n", [2, 3, 5])
def test_the_shortest_lines_can_be_fitted(n):
    points = np.linspace((10.0, 10.0), (13.0, 12.0), n)
    spline = fit_disk_spline(StrokeLine(points, np.full(n, 2.0)), width=8.0)
    assert spline.rms < 0.1 and np.isfinite(spline.control).all()


@pytest.mark.parametrize("work", ["regular-shu", "regular-tian", "clerical-tian"])
def test_the_swept_disks_are_the_ink_again(cell, work):
    master = cell(work)
    width = skeleton_of(master).width
    area = sweep([fit_disk_spline(line, width=width).line() for line in lines_of(master)], side=SIDE)
    assert np.count_nonzero(area & master.ink) > 0.8 * np.count_nonzero(area | master.ink)


def test_a_disk_is_a_disk():
    area = sweep([StrokeLine(np.array([[100.0, 50.0], [100.0, 50.0]]), np.full(2, 10.0))], side=128)
    rows, columns = np.nonzero(area)
    assert rows.mean() == pytest.approx(50.0, abs=0.1) and columns.mean() == pytest.approx(100.0, abs=0.1)
    assert len(rows) == pytest.approx(np.pi * 100, rel=0.1)
