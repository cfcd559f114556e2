"""Which stroke is which, measured on faults whose size and stroke are known."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.assessment.ink_measures import measure_ink
from rumu.strokes.centre_lines import doubled_directions
from rumu.strokes.correspondence import CopyStrokes, match_strokes
from rumu.strokes.pose import find_pose
from rumu_lab.simulation.glyph import Glyph

WORK = "regular-shui"


@pytest.fixture(scope="session")
def found(measured):
    """The strokes of one ink mask in another."""

    def find(copy, master):
        m = measured(copy, master)
        return match_strokes(CopyStrokes(m.copy, m.registration, m.master.stroke_model))

    return find


def struck(strokes, glyph: Glyph, k: int):
    """The stroke found that lies along the glyph's stroke k."""
    path = glyph.strokes[k].points[:, ::-1] / np.array(glyph.mask.shape)

    def away(stroke) -> float:
        reach = np.linalg.norm(stroke.outline[:, None] - path[None], axis=2)
        return float(reach.min(axis=1).mean() + reach.min(axis=0).mean())

    return min(strokes.strokes, key=away)


def test_of_a_perfect_copy_every_stroke_is_the_master_s(found, mask):
    strokes = found(mask(WORK), mask(WORK))
    assert strokes.pose.angle == 0.0 and strokes.pose.scale == 1.0 and strokes.squeeze is None
    for stroke in strokes.strokes:
        assert stroke.present and stroke.coverage > 0.95
        np.testing.assert_allclose(stroke.shift, 0.0, atol=0.01)
        assert stroke.turn == pytest.approx(0.0, abs=0.7)
        assert stroke.length == pytest.approx(1.0, abs=0.03)
        assert stroke.width == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_turned_stroke_turns_by_what_was_done_and_the_others_stay(*, found, fault, mask, seed):
    done = fault(WORK, "angle", 3, seed)
    strokes = found(done.mask, mask(WORK))
    turned = struck(strokes, Glyph(mask(WORK)), done.strokes[0])
    assert turned.turn == pytest.approx(done.size, rel=0.55), "positive is clockwise"
    others = [s.turn for s in strokes.strokes if s is not turned and s.weight > 0.1]
    assert max(abs(turn) for turn in others) < 2.5


@pytest.mark.parametrize("work", ["clerical-shui", "cursive-shu", "regular-shu", "seal-tian"])
def test_a_horizontal_that_leans_is_not_drawn_back_by_its_neighbours(*, found, fault, mask, work):
    done = fault(work, "horizontal", 3, 2)
    strokes = found(done.mask, mask(work))
    turned = struck(strokes, Glyph(mask(work)), done.strokes[0])
    assert turned.turn == pytest.approx(done.size, abs=1.8)


@pytest.fixture
def ren():
    """Points of two long strokes, which stroke each is of, and their doubled directions."""
    along = np.linspace(0.0, 1.0, 40)[:, None]
    first = np.array([0.2, -1.2]) + along * np.array([-1.3, 2.2])
    second = np.array([-0.1, -0.4]) + along * np.array([1.2, 1.3])
    double = doubled_directions(first), doubled_directions(second)
    return np.concatenate([first, second]), np.repeat([0, 1], 40), np.concatenate(double)


def test_one_of_two_strokes_that_was_pushed_is_no_pose(ren):
    points, owner, double = ren
    pushed = points + np.where(owner[:, None] == 0, [0.09, 0.03], 0.0)
    pose = find_pose(points, pushed, owner=owner, double=double)
    np.testing.assert_array_equal(pose.linear, np.eye(2))
    np.testing.assert_array_equal(pose.shift, 0.0)


def test_a_stroke_that_only_slid_along_itself_is_in_its_place(ren):
    points, owner, double = ren
    along = np.where(owner == 1, 1.0, 0.0)[:, None] * np.array([1.2, 1.3]) / np.hypot(1.2, 1.3)
    pushed = points + np.where(owner[:, None] == 0, [-0.12, -0.05], 0.0) - 0.07 * along
    pose = find_pose(points, pushed, owner=owner, double=double)
    np.testing.assert_array_equal(pose.shift, 0.0)


def test_two_strokes_that_lean_together_are_a_pose(ren):
    points, owner, double = ren
    c, s = np.cos(np.radians(6.0)), np.sin(np.radians(6.0))
    pose = find_pose(points, points @ np.array([[c, s], [-s, c]]), owner=owner, double=double)
    assert pose.angle == pytest.approx(6.0, abs=0.3)


@pytest.mark.parametrize("seed", [1, 3])
def test_a_pushed_stroke_has_moved_by_what_was_done(*, found, fault, mask, seed):
    glyph = Glyph(mask(WORK))
    done = fault(WORK, "shift", 4, seed)
    strokes = found(done.mask, mask(WORK))
    rows, columns = np.nonzero(glyph.mask)
    radius = np.hypot(rows.std(), columns.std())
    moved = struck(strokes, glyph, done.strokes[0])
    assert np.hypot(*moved.shift) * radius == pytest.approx(20.0, abs=7.0)
    assert strokes.pose.angle == 0.0
    assert strokes.squeeze is None


@pytest.mark.parametrize("stroke", [0, 1, 2])
def test_a_stroke_left_out_is_not_present_and_all_else_is(found, mask, stroke):
    glyph = Glyph(mask(WORK))
    strokes = found(glyph.without(stroke), glyph.mask)
    assert not struck(strokes, glyph, stroke).present
    assert sum(not s.present for s in strokes.strokes) == 1
    assert strokes.pose.scale == pytest.approx(1.0, abs=0.02)


def test_a_thick_stroke_is_thick_and_the_whole_is_not(found, fault, mask):
    done = fault(WORK, "stroke_thick", 4)
    strokes = found(done.mask, mask(WORK))
    assert strokes.width == pytest.approx(1.0, abs=0.06)
    assert struck(strokes, Glyph(mask(WORK)), done.strokes[0]).width > 1.25


def test_a_heavy_entry_is_seen_at_the_entry_alone(found, fault, mask):
    done = fault("clerical-tian", "entry", 4)
    stroke = struck(found(done.mask, mask("clerical-tian")), Glyph(mask("clerical-tian")), done.strokes[0])
    assert 0.3 < stroke.entry < 1.0
    assert stroke.width == pytest.approx(1.0, abs=0.06)
    assert not stroke.exit >= 0.08  # NaN where it joins another


def test_a_dot_s_heavy_entry_is_seen_though_thinning_draws_its_line_short(found, fault, mask):
    done = fault("regular-shui", "entry", 3, 2)
    stroke = struck(found(done.mask, mask("regular-shui")), Glyph(mask("regular-shui")), done.strokes[0])
    assert stroke.entry > 0.15


def test_strokes_heavy_all_along_have_no_heavy_ends(found, fault, mask):
    strokes = found(fault("regular-shui", "thick", 3).mask, mask("regular-shui"))
    assert strokes.width > 1.3
    ends = [abs(end) for s in strokes.strokes for end in (s.entry, s.exit) if np.isfinite(end)]
    assert np.median(ends) < 0.08


def test_blunt_tips_have_lost_the_taper_that_was_taken_and_a_perfect_copy_none(found, fault, mask):
    tips = found(fault("regular-shui", "blunt", 4).mask, mask("regular-shui")).tips
    assert tips is not None and 0.3 < tips.lost < 1.0 and tips.blunted > 0.7
    perfect = found(mask("regular-shui"), mask("regular-shui")).tips
    assert perfect is not None and perfect.lost == 0.0


@pytest.mark.parametrize("fault_of_width", ["thin", "thick"])
def test_strokes_thinner_or_heavier_all_along_have_lost_little_of_their_tips(
    found, fault, mask, fault_of_width
):
    tips = found(fault("regular-shui", fault_of_width, 3).mask, mask("regular-shui")).tips
    assert tips is not None and tips.lost < 0.25


def test_even_strokes_have_no_taper_to_lose(found, mask):
    assert found(mask("seal-tian"), mask("seal-tian")).tips is None


def test_a_squeezed_character_is_squeezed_and_its_strokes_are_in_place(found, fault, mask):
    strokes = found(fault(WORK, "squeeze", 3).mask, mask(WORK))
    squeeze = strokes.squeeze
    assert squeeze is not None and squeeze.axis == "across"
    assert squeeze.first > 1.1 and squeeze.second < 0.9
    assert max(np.hypot(*s.shift) for s in strokes.strokes if s.weight > 0.1) < 0.08


def test_a_lean_is_the_whole_s_and_no_stroke_s(found, moved, mask):
    strokes = found(moved(WORK, lean=7.0, scale=0.85), mask(WORK))
    assert strokes.pose.angle == pytest.approx(7.0, abs=0.6)
    assert strokes.pose.scale == pytest.approx(0.85, abs=0.015)
    assert max(abs(s.turn) for s in strokes.strokes if s.weight > 0.1) < 1.5


def test_outlines_lie_on_the_ink_of_the_copy_as_it_was_written(found, moved, mask):
    copy = moved(WORK, lean=-10.0, scale=0.8, shift=(30, -20))
    for stroke in found(copy, mask(WORK)).strokes:
        columns, rows = (stroke.outline * 512).astype(int).T
        assert copy[rows, columns].mean() > 0.9


def test_ink_that_belongs_to_no_stroke_is_a_patch(measured, mask):
    copy = mask(WORK).copy()
    copy[60:100, 60:90] = True
    m = measured(copy, mask(WORK))
    strokes = match_strokes(CopyStrokes(m.copy, m.registration, m.master.stroke_model))
    ink = measure_ink(strokes, m.copy, m.master.stroke_model, m.registration)
    assert len(ink.patches) == 1
    assert ink.patches[0].share == pytest.approx(1200 / copy.sum(), rel=0.25)
    assert not ink.patches[0].attached
    assert ink.bare == pytest.approx(0.0, abs=0.01)
