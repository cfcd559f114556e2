"""Directional responses of bars whose direction is known, and claims that do not cover everything twice."""

from __future__ import annotations

import numpy as np
import pytest

from rumu_lab.baselines.gabor import GaborSettings, reconstruct, responses

SETTINGS = GaborSettings()
WIDTH = 7.0


def bar(angle: float, *, side: int = 128, length: float = 80.0, width: float = WIDTH) -> np.ndarray:
    """A bar through the middle, at `angle` degrees counter-clockwise from +x."""
    y, x = np.mgrid[(side - 1) / 2 : -(side + 1) / 2 : -1, -(side - 1) / 2 : (side + 1) / 2]
    a = np.radians(angle)
    along, across = x * np.cos(a) + y * np.sin(a), y * np.cos(a) - x * np.sin(a)
    return (np.abs(along) <= length / 2) & (np.abs(across) <= width / 2)


def found(ink: np.ndarray) -> np.ndarray:
    return responses(ink.astype(np.float32), width=WIDTH, settings=SETTINGS)


@pytest.mark.parametrize("number", range(SETTINGS.directions))
def test_a_bar_answers_in_its_own_direction(number: int) -> None:
    ink = bar(180.0 * number / SETTINGS.directions)
    answer = found(ink)
    assert answer.shape == (SETTINGS.directions, 128, 128)
    assert (answer.min(), answer.max()) == (0.0, 1.0)
    assert answer[:, 54:74, 54:74].sum(axis=(1, 2)).argmax() == number


def test_an_even_sheet_answers_at_its_edges_alone() -> None:
    answer = found(np.ones((128, 128), bool))
    assert answer.max() == 1.0
    assert answer[:, 44:84, 44:84].max() < 0.02


def test_nothing_wraps_round_the_picture() -> None:
    ink = np.zeros((128, 128), bool)
    ink[:, 2:9] = True
    assert found(ink)[:, :, 90:].max() < 1e-3


def test_a_cross_is_told_apart_and_its_middle_is_claimed_twice() -> None:
    ink = bar(0.0) | bar(90.0)
    claims, error = reconstruct(found(ink), ink, width=WIDTH, settings=SETTINGS)
    assert error < 0.25
    assert claims[0, 63, 64]
    assert claims[4, 63, 64]
    assert claims[0, 64, 30:50].all()
    assert not claims[4, 64, 30:50].any()
    assert claims[4, 30:50, 64].all()
    assert not claims[0, 30:50, 64].any()


def test_thresholds_leave_less_error_than_the_two_ends_of_the_grid() -> None:
    ink = bar(0.0) | bar(90.0) | bar(45.0, length=110.0)
    answer = found(ink)
    _, error = reconstruct(answer, ink, width=WIDTH, settings=SETTINGS)
    _, coarse = reconstruct(answer, ink, width=WIDTH, settings=GaborSettings(grid=2))
    assert error < coarse
    assert error < 1.0  # of thresholds at which nothing is claimed
