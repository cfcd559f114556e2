"""The overlay: master and copy in one frame, loud where they part."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rumu.report.overlay import MISSING, OverlaySettings, overlay_picture, uncovered_share
from rumu.report.pictures import RESIDUAL_STOPS


def near(picture: np.ndarray, colour: tuple[int, int, int], *, by: int = 12) -> np.ndarray:
    return np.abs(picture.astype(int) - colour).max(axis=2) <= by


def test_the_same_character_is_quiet(assessment, master_surface):
    registration = replace(assessment.registration, probe=assessment.registration.reference)
    picture = overlay_picture(registration, master=master_surface)
    assert near(picture, RESIDUAL_STOPS[0]).mean() > 0.05
    assert not near(picture, MISSING).any() and not near(picture, RESIDUAL_STOPS[-1]).any()
    assert uncovered_share(registration) == 0


def test_the_master_s_ink_lies_under_its_points(assessment, master_surface):
    """Points of the master, drawn as the copy, fall on the master's silhouette to within a pixel or two."""
    from rumu.report.overlay import _master_ink
    from rumu.report.pictures import PAPER

    reference = assessment.registration.reference
    settings = OverlaySettings()
    canvas = _master_ink(master_surface.mask, reference, settings, 200.0)
    at = np.round(settings.side + reference.xyz[:, :2] * [200.0, -200.0]).astype(int)
    assert not near(canvas[at[:, 1], at[:, 0]][None], PAPER, by=3).any()


def test_a_missing_stroke_is_ringed_on_both_sides(assessment, master_surface):
    picture = overlay_picture(assessment.registration, master=master_surface)
    ringed = near(picture, MISSING)
    half = picture.shape[1] // 2
    assert ringed[:, : half // 2].any() and ringed[:, -half // 2 :].any()
    assert uncovered_share(assessment.registration) > 0.2


def test_up_is_up(assessment, master_surface):
    """Points above and to the right of the centre, off the master, are drawn there in the loudest colour."""
    registration = assessment.registration
    xyz = np.vstack([registration.reference.xyz, [[0.9, 1.2, 0], [0.92, 1.2, 0], [0.9, 1.22, 0]]])
    probe = replace(registration.probe, xyz=xyz, direction=np.zeros((len(xyz), 2)))
    picture = overlay_picture(replace(registration, probe=probe), master=master_surface)
    rows, columns = np.nonzero(near(picture, RESIDUAL_STOPS[-1]))
    half = OverlaySettings().side / 2
    assert rows.mean() < 0.6 * half and columns.mean() > 1.2 * half


def test_the_pose_is_applied(assessment, master_surface):
    moved = np.eye(4)
    moved[:2, 3] = (0.5, 0.0)
    registration = replace(assessment.registration, T_reference_probe=moved)
    straight, shifted = (
        np.nonzero(near(overlay_picture(r, master=master_surface), RESIDUAL_STOPS[0]))[1].mean()
        for r in (assessment.registration, registration)
    )
    assert shifted > straight + 30


@pytest.mark.parametrize("side", [200, 500])
def test_the_size_is_a_setting(assessment, master_surface, side):
    settings = OverlaySettings(side=side)
    assert overlay_picture(assessment.registration, master=master_surface, settings=settings).shape == (
        side,
        side,
        3,
    )
