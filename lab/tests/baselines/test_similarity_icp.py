"""The closed form of a similarity, and the loop around it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rumu.errors import RegistrationError
from rumu_lab.baselines.similarity_icp import SimilarityIcpSettings, similarity_icp, umeyama

HOOK = np.concatenate(
    [
        np.linspace((0, 0), (100, 10), 120),
        np.linspace((60, -50), (55, 90), 160),
        np.linspace((55, 90), (35, 75), 30),
    ]
)


def turned(points: np.ndarray, degrees: float, scale: float, shift: tuple[float, float]) -> np.ndarray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return scale * points @ np.array([[c, -s], [s, c]]).T + shift


@given(st.floats(-180, 180), st.floats(0.1, 10), st.floats(-500, 500))
@settings(max_examples=50, deadline=None)
def test_the_closed_form_is_exact(degrees, scale, shift):
    pose = umeyama(HOOK, turned(HOOK, degrees, scale, (shift, -shift)))
    assert pose.scale == pytest.approx(scale, rel=1e-9)
    assert np.linalg.det(pose.rotation) == pytest.approx(1.0)
    assert np.cos(np.radians(pose.angle - degrees)) == pytest.approx(1.0)


def test_a_mirror_is_never_the_answer():
    pose = umeyama(HOOK, HOOK * (-1.0, 1.0))
    assert np.linalg.det(pose.rotation) == pytest.approx(1.0)
    assert similarity_icp(HOOK * (-1.0, 1.0), HOOK).residual > 3.0


@pytest.mark.parametrize("degrees", [-50, -20, 0, 35, 50])
@pytest.mark.parametrize("scale", [0.4, 1.0, 1.7])
def test_place_size_and_slant_are_taken_out(degrees, scale):
    probe = turned(HOOK, degrees, scale, (30.0, -80.0))
    pose = similarity_icp(probe, HOOK)
    assert pose.residual < 0.5 and pose.converged
    assert pose.scale == pytest.approx(1 / scale, rel=0.02)
    assert pose.angle == pytest.approx(-degrees, abs=1.0)
    assert pose(probe) == pytest.approx(HOOK, abs=2.0)


def test_a_copy_is_not_shrunk_onto_one_stroke():
    whole = np.concatenate([HOOK, np.linspace((0, 60), (110, 60), 120)])
    pose = similarity_icp(HOOK, whole)
    assert 0.85 < pose.scale < 1.2
    other = similarity_icp(np.random.default_rng(0).random((200, 2)) * 100, HOOK)
    assert 0.3 < other.scale < 2.0


def test_running_out_of_iterations_is_a_field():
    probe = turned(HOOK, 33, 1.3, (5.0, 5.0))
    once = similarity_icp(probe, HOOK, settings=SimilarityIcpSettings(iterations=1, scout=1))
    assert not once.converged and once.iterations == 1


@pytest.mark.parametrize(
    "bad", [np.zeros((2, 2)), np.zeros((9, 2)), np.zeros((9, 3)), np.full((9, 2), np.nan), np.zeros(9)]
)
def test_points_that_cannot_be_laid_are_refused(bad):
    for pair in ((bad, HOOK), (HOOK, bad)):
        with pytest.raises(RegistrationError):
            similarity_icp(*pair)
