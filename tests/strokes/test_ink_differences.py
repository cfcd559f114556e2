"""How a stroke's ink differs, where what was done to it is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rumu.strokes.correspondence import CopyStrokes, match_strokes
from rumu.strokes.ink_differences import UNSEEN, cut_strips


def cross() -> np.ndarray:
    """A lying bar above a standing one and a short one beside it, which do not touch."""
    mask = np.zeros((128, 128), bool)
    mask[30:38, 20:108] = True
    mask[48:110, 40:48] = True
    mask[60:68, 66:104] = True
    return mask


@pytest.fixture(scope="module")
def differences(measured):
    """What is said of the ink of each line of a copy, by (x, y) of the line's middle in the frame."""

    def find(copy: np.ndarray):
        m = measured(copy, cross())
        match = match_strokes(CopyStrokes(m.copy, m.registration, m.master.stroke_model))
        upper = min(match.strokes, key=lambda stroke: stroke.line.points[:, 1].mean())
        return upper.ink, [stroke.ink for stroke in match.strokes if stroke is not upper]

    return find


def test_the_same_ink_is_not_unlike(differences):
    upper, others = differences(cross())
    for ink in (upper, *others):
        assert max(ink.unlike, ink.moved, ink.entry, ink.exit) < 0.05
        assert abs(ink.fuller) < 0.05 and abs(ink.lacking) < 0.03


def test_a_moved_stroke_is_unlike_until_it_is_put_back(differences):
    copy = cross()
    copy[30:38, 20:108] = False
    copy[25:33, 20:108] = True
    upper, others = differences(copy)
    assert upper.unlike > 0.4 and upper.moved < 0.5 * upper.unlike
    assert max(ink.unlike for ink in others) < 0.4 * upper.unlike


def test_a_stroke_cut_short_lacks_ink_at_its_end(differences):
    copy = cross()
    copy[30:38, 88:108] = False  # 20 of 88 pixels
    upper, others = differences(copy)
    assert upper.lacking == pytest.approx(20 / 88, abs=0.08)
    assert upper.exit > 0.5 > upper.entry
    assert max(ink.lacking for ink in others) < 0.1


@pytest.mark.parametrize(("rows", "fuller"), [(slice(32, 36), -0.5), (slice(28, 40), 0.5)])
def test_a_thin_stroke_holds_less_ink_and_a_thick_one_more(*, differences, rows, fuller):
    copy = cross()
    copy[30:38, 20:108] = False
    copy[rows, 20:108] = True
    upper, _ = differences(copy)
    assert upper.fuller == pytest.approx(fuller, abs=0.15)


def test_a_line_of_one_point_has_no_strip(measured):
    model = measured(cross(), cross()).master.stroke_model
    points = model.lines.points
    last = points.owner == points.owner.max()
    kept = ~last | (np.cumsum(last) == 1)
    short = replace(
        points, xy=points.xy[kept], double=points.double[kept], radius=points.radius[kept],
        owner=points.owner[kept], clear=points.clear[kept],
    )  # fmt: skip
    strips = cut_strips(replace(model.lines, points=short), model.framed)
    assert strips.steps[-1] == 0.0 and points.owner.max() not in strips.owner
    assert UNSEEN.unlike == float("inf")
