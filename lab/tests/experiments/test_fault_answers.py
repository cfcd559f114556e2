"""What counts as naming a simulated fault, and which faults are large enough to be seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rumu.values import Remark
from rumu_lab.experiments.fault_answers import ANSWERS, find_position, is_seen, speaks_of
from rumu_lab.simulation.faults import FAULTS, apply
from rumu_lab.simulation.glyph import Glyph


@pytest.fixture(scope="module")
def cross() -> Glyph:
    """A lying stroke over a standing one."""
    mask = np.zeros((128, 128), bool)
    mask[40:52, 16:112] = True
    mask[20:116, 60:72] = True
    return Glyph(mask)


@pytest.fixture(scope="module")
def turned(cross):
    """Its lying stroke, turned."""
    return apply(cross.mask, "horizontal", severity=5, seed=1)


def along(glyph: Glyph, k: int, kind="stroke_angle") -> Remark:
    """A remark on one stroke of a glyph."""
    points = glyph.strokes[k].points[:, ::-1] / np.array(glyph.mask.shape)
    line = tuple((float(x), float(y)) for x, y in points)
    return Remark(kind, 1.0, "degrees", 3.0, None, "橫", "A horizontal.", (line,))


def test_every_fault_of_the_simulation_has_its_answer():
    assert set(ANSWERS) == set(FAULTS)


def test_a_remark_must_speak_of_the_stroke_that_was_struck(cross, turned):
    (struck,) = turned.strokes
    other = next(k for k in range(len(cross.strokes)) if k != struck)
    assert speaks_of(along(cross, struck), turned, cross)
    assert not speaks_of(along(cross, other), turned, cross)


def test_a_remark_on_the_whole_speaks_of_no_struck_stroke(cross, turned):
    whole = Remark("lean", 6.0, "degrees", 3.0, None, "歪", "It leans.")
    assert not speaks_of(whole, turned, cross)
    assert speaks_of(whole, apply(cross.mask, "lean", severity=2), cross)


def test_an_extra_stroke_is_told_where_it_is(cross):
    extra = apply(cross.mask, "extra", severity=1, seed=2)
    x0, y0, _, y1 = extra.region
    there = Remark("extra", 0.1, "of the ink", 3.0, extra.region, "多", "One too many.")
    # a box that ends where the region begins
    elsewhere = Remark("extra", 0.1, "of the ink", 3.0, (x0 - 0.1, y0, x0, y1), "多", "One too many.")
    assert speaks_of(there, extra, cross)
    assert not speaks_of(elsewhere, extra, cross)


def test_a_heavy_entry_must_be_told_at_that_end(cross):
    heavy = apply(cross.mask, "entry", severity=4, seed=1)
    (struck,) = heavy.strokes
    _, _, x1, y1 = heavy.region
    line = along(cross, struck, "entry_heavy")
    assert speaks_of(replace(line, region=heavy.region), heavy, cross)
    assert not speaks_of(replace(line, region=(x1 + 0.1, y1 + 0.1, x1 + 0.3, y1 + 0.3)), heavy, cross)


@pytest.fixture(scope="module")
def man() -> Glyph:
    """人, whose strokes taper."""
    from rumu.gallery.starter import find_work
    from rumu.pipeline import surface_of

    return Glyph(surface_of(find_work("regular-ren").path).mask)


@pytest.fixture(scope="module")
def blunt(man):
    """The same with blunt tips."""
    return apply(man.mask, "blunt", severity=4)


def test_what_strikes_many_strokes_may_be_told_of_all_at_once(man, blunt):
    assert len(blunt.strokes) > 1
    lines = tuple(along(man, k).outline[0] for k in blunt.strokes)
    assert speaks_of(replace(along(man, 0, "exit_blunt"), outline=lines), blunt, man)


def test_a_blunt_tip_is_a_heavy_beginning_only_where_ink_was_added(man, blunt):
    x0, y0, *_ = blunt.region
    told = along(man, blunt.strokes[0], "entry_heavy")
    assert speaks_of(replace(told, region=blunt.region), blunt, man)
    assert not speaks_of(replace(told, region=(0.0, 0.0, x0 - 0.02, y0 - 0.02)), blunt, man)


def test_beside_a_stroke_that_is_most_of_the_character_the_others_stand_off():
    mask = np.zeros((128, 128), bool)
    mask[20:30, 10:118] = True
    mask[90:100, 50:78] = True
    glyph = Glyph(mask)
    assert glyph.strokes[0].length > 0.6 * sum(stroke.length for stroke in glyph.strokes)
    pushed = [apply(mask, "shift", severity=3, seed=seed) for seed in range(20)]
    long, short = (next(copy for copy in pushed if copy.strokes == (k,)) for k in (0, 1))
    assert speaks_of(along(glyph, 1, "displaced"), long, glyph)
    assert not speaks_of(along(glyph, 0, "displaced"), short, glyph)


def test_the_second_half_of_a_remark_names_a_fault_too(cross):
    short = apply(cross.mask, "short", severity=3, seed=1)
    (struck,) = short.strokes
    line = along(cross, struck, "displaced")
    told = replace(line, zh="第一筆「橫」偏下約 3% 格，又短了 24%。行筆到位。", master_outline=line.outline)
    other = replace(told, kind="stroke_short", zh="第一筆「橫」短了 24%。行筆到位。")
    assert find_position((told,), (other,), short, cross) == 0
    assert find_position((told,), (replace(other, zh="第一筆「橫」短了 12%。"),), short, cross) is None
    assert find_position((told,), (replace(other, master_outline=()),), short, cross) is None
    assert find_position((replace(told, zh="第一筆「橫」偏下約 3% 格。"),), (other,), short, cross) is None


def test_a_slight_turn_is_not_seen_and_a_strong_one_is(cross):
    copies = [apply(cross.mask, "horizontal", severity=s, seed=1) for s in (0.2, 5.0)]
    assert [is_seen(copy, cross) for copy in copies] == [False, True]


def test_uneven_spaces_are_seen_from_where_one_stroke_stands_off(cross):
    copies = [apply(cross.mask, "uneven", severity=s, seed=3) for s in (1.0, 5.0)]
    assert copies[1].apart == pytest.approx(5.0 * copies[0].apart)
    assert [is_seen(copy, cross) for copy in copies] == [False, True]
    assert is_seen(apply(cross.mask, "lean", severity=0.1), cross)
