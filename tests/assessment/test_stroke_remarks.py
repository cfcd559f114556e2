"""What is said of each fault, word for word, in Chinese and in English."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from rumu.assessment.ink_measures import FilledWhite, InkMeasures, InkPatch, StickingOut
from rumu.assessment.ink_remarks import find_ink_faults
from rumu.assessment.named_strokes import name_all
from rumu.assessment.stroke_remarks import find_stroke_faults
from rumu.assessment.thresholds import RemarkThresholds
from rumu.assessment.whole_remarks import PoseSeen, find_whole_faults
from rumu.strokes.correspondence import BluntTips, CopyStrokes, match_strokes
from rumu.strokes.ink_differences import UNSEEN
from rumu.strokes.openings import Opening
from rumu.strokes.pose import CharacterPose

LIMITS = RemarkThresholds()
HEAVY, THIN = ({"width": width, "written_width": width} for width in (1.5, 0.6))
SQUARE = np.array([[0.1, 0.1], [0.2, 0.1], [0.2, 0.2], [0.1, 0.2], [0.1, 0.1]])
NO_FAULT = InkMeasures((), 0.0, 0.0, 0.0, 1.0, 0.0, None, (), (), (), True, 0.0, 1.0)


@pytest.fixture(scope="module")
def itself(measured, mask):
    """A master's strokes matched with themselves, and the registration."""
    m = measured(mask("regular-shui"), mask("regular-shui"))
    return match_strokes(CopyStrokes(m.copy, m.registration, m.master.stroke_model)), m.registration


def named(match, registration, *, framed=False):
    """The strokes of a match, whose parts explain nothing."""
    return name_all(PoseSeen(match, registration, framed), LIMITS, explained=np.zeros_like(match.places))


def faults_of_first(match, registration, *, framed=False):
    """What is said of the longest stroke."""
    strokes = named(match, registration, framed=framed)
    return [f for f in find_stroke_faults(strokes, match, LIMITS) if f.cause == "stroke 0"]


def moved_in_cell(match, by):
    """The same with the longest stroke elsewhere in the cell, by rms radii, x right and y down."""
    own = match.master.points.owner == 0
    return replace(match, in_cell=match.in_cell + np.where(own[:, None], by, 0.0))


def words(findings, kind):
    (said,) = [(f.remark.zh, f.remark.en) for f in findings if f.remark.kind == kind]
    return said


@pytest.mark.parametrize(
    ("change", "kind", "zh", "en"),
    [
        ({"torn": 2.0}, "rough", "墨邊毛糙破碎，不光潔。", "The edges are frayed and torn."),
        ({"torn": 2.0, "torn_at": np.array([0.1, 0.9])}, "rough",
         "墨邊毛糙破碎，不光潔，左下部最明顯。",
         "The edges are frayed and torn, most of all at the bottom left."),
        ({"tremor": 0.01, "rough": 1.4, "torn": 0.3}, "rough", "筆畫邊緣抖動，比範本多 40%。",
         "The edges tremble, 40% more than the master's."),
        ({"bare": 0.1}, "dry", "枯筆露白，筆畫裡約有 10% 沒有墨。",
         "The brush ran dry: about 10% of the strokes is bare."),
        ({"darkness": 0.6}, "pale", "墨色淡了 40%，不如範本沉著。", "The ink is 40% too pale."),
        ({"paleness": 0.2}, "pale", "墨色淡了 20%，不如範本沉著。", "The ink is 20% too pale."),
        ({"filled": (FilledWhite(0.9, SQUARE),)}, "filled", "左上部的留白糊住了。",
         "The white at the top left has run shut."),
        ({"filled": (FilledWhite(0.9, SQUARE), FilledWhite(0.8, SQUARE + 0.5))}, "filled",
         "有 2 處留白糊住了，左上部最甚。",
         "The white has run shut in 2 places, most of all at the top left."),
        ({"opened": (Opening(1.3, 0.5, np.array([0.4, 0.6]), SQUARE[0], SQUARE[2], SQUARE),)}, "open",
         "左上部的框，右下角沒有封口，缺口約 10% 格。",
         "The box at the top left is not closed: its lower right has a gap of 10% of the cell."),
        ({"patches": (InkPatch(0.05, 1.2, 2.0, True, False, SQUARE),)}, "blot", "左上部有一團墨漬。",
         "There is a blot at the top left."),
        ({"patches": (InkPatch(0.05, 1.2, 2.0, False, False, SQUARE),)}, "blot", "左上部濺了一滴墨。",
         "A drop of ink fell on the paper at the top left."),
        ({"patches": (InkPatch(0.05, 5.0, 2.0, False, False, SQUARE),)}, "extra",
         "左上部多出一筆，約佔全字墨跡的 5%。",
         "There is a stroke too many at the top left, about 5% of the ink."),
    ],
)  # fmt: skip
def test_of_the_ink(*, itself, change, kind, zh, en):
    match, registration = itself
    strokes = named(match, registration)
    found = list(find_ink_faults(replace(NO_FAULT, **change), strokes, match, LIMITS))
    assert words(found, kind) == (zh, en)


@pytest.mark.parametrize(
    ("patch", "unfound"),
    [
        (InkPatch(0.05, 5.0, 0.6, True, False, SQUARE), 0.0),  # a heavy end's edge
        (InkPatch(0.05, 5.0, 2.0, True, True, SQUARE), 0.0),  # the brush was not lifted
        (InkPatch(0.05, 5.0, 2.0, True, False, SQUARE), 0.06),  # a stroke that stands elsewhere
        (InkPatch(0.05, 1.2, 2.0, True, False, SQUARE), 0.06),  # a part of one
    ],
)
def test_ink_that_strokes_account_for_is_no_stroke_too_many_and_no_blot(itself, patch, unfound):
    match, registration = itself
    strokes = named(match, registration)
    ink = replace(NO_FAULT, patches=(patch,), unfound=unfound)
    assert [f.remark.kind for f in find_ink_faults(ink, strokes, match, LIMITS)] == []


@pytest.mark.parametrize("change", [{"bare": 0.1}, {"darkness": 0.5}, {"paleness": 0.4}])
def test_a_picture_of_black_and_white_only_is_not_called_dry_or_pale(itself, change):
    match, registration = itself
    strokes = named(match, registration)
    ink = replace(NO_FAULT, has_shades=False, **change)
    assert [f.remark.kind for f in find_ink_faults(ink, strokes, match, LIMITS)] == []


def test_what_a_photograph_s_exposure_may_do_is_not_called_pale(itself):
    match, registration = itself
    strokes = named(match, registration)
    assert list(find_ink_faults(replace(NO_FAULT, darkness=0.75), strokes, match, LIMITS)) == []


def test_of_an_end_that_sticks_out(itself):
    match, registration = itself
    strokes = named(match, registration)
    foot = match.moved[np.flatnonzero(match.master.points.owner == 0)[-1]]

    def said_of_ink_at(tip):
        ink = replace(NO_FAULT, sticking_out=(StickingOut(0.1 / strokes[0].cell, tip, foot, SQUARE),))
        return [f for f in find_ink_faults(ink, strokes, match, LIMITS) if f.remark.kind == "sticks_out"]

    zh, en = words(said_of_ink_at(foot + np.array([0.0, 0.2])), "sticks_out")
    assert not said_of_ink_at(foot + np.array([0.2, 0.0]))  # beside the foot: a stroke out of its place
    assert not said_of_ink_at(foot - np.array([0.0, 0.2]))
    assert _no_digits(zh) == f"{_no_digits(strokes[0].name.zh)}下端出頭約 #% 格。"
    assert _no_digits(en) == f"{_no_digits(strokes[0].en)} sticks out at its foot by about #% of the cell."


def test_an_end_does_not_stick_out_that_stops_short_in_the_cell(itself):
    """A small character's long stroke may be too long for it and end above the master's foot."""
    match, registration = itself
    foot = match.moved[np.flatnonzero(match.master.points.owner == 0)[-1]]
    shift = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -0.2]])
    higher = replace(match.framed, to_picture=match.framed.to_picture + shift)
    told = {}
    for framed in (False, True):
        strokes = named(replace(match, framed=higher), registration, framed=framed)
        tip = StickingOut(0.1 / strokes[0].cell, foot + np.array([0.0, 0.2]), foot, SQUARE)
        found = find_ink_faults(replace(NO_FAULT, sticking_out=(tip,)), strokes, match, LIMITS)
        told[framed] = "sticks_out" in [f.remark.kind for f in found]
    assert told == {False: True, True: False}


@pytest.mark.parametrize(
    ("change", "kind", "zh", "en"),
    [
        ({"shift": np.array([0.25, 0.0])}, "displaced", "偏右約 #% 格。",
         "stands too far right, by about #% of the cell."),
        ({"turn": 9.0}, "stroke_angle", "斜了 #°，下端偏左。", "is off by #°: its foot is too far left."),
        ({"length": 1.3}, "stroke_long", "長了 #%。", "is #% too long."),
        ({"length": 0.7}, "stroke_short", "短了 #%。", "is #% too short."),
        (HEAVY, "stroke_heavy", "比範本粗 #%。", "is #% heavier than the master's."),
        (THIN, "stroke_thin", "比範本細 #%。", "is #% thinner than the master's."),
        ({"entry": 0.5, "entry_alone": 0.5}, "entry_heavy", "起筆太重。", "begins too heavily."),
        ({"entry": -0.5, "entry_alone": -0.4}, "entry_light", "起筆太輕。", "begins too lightly."),
        ({"exit": 0.5, "exit_alone": 0.4}, "exit_blunt", "收筆禿鈍，鋒沒有收住。", "ends bluntly."),
    ],
)  # fmt: skip
def test_of_one_stroke(*, itself, change, kind, zh, en):
    match, registration = itself
    good = replace(match.strokes[0], entry=0.0, exit=0.0, ink=UNSEEN)
    changed = replace(match, strokes=(replace(good, **change), *match.strokes[1:]), tips=None)
    changed = moved_in_cell(changed, change.get("shift", np.zeros(2)))
    strokes = named(changed, registration)
    found = faults_of_first(changed, registration)
    said_zh, said_en = words(found, kind)
    assert _no_digits(said_zh) == f"{_no_digits(strokes[0].name.zh)}{zh}"
    assert _no_digits(said_en) == f"{_no_digits(strokes[0].en)} {en}"


@pytest.mark.parametrize(("edge", "kinds"), [(0.2, {"stroke_short", "exit_blunt"}), (0.0, set())])
def test_a_stroke_that_the_picture_cuts_off_is_neither_short_nor_blunt(itself, edge, kinds):
    match, registration = itself
    outline = match.strokes[0].outline.copy()
    outline[:, 0] += edge - outline[:, 0].min()
    said = set()
    for change in ({"length": 0.7}, {"exit": 0.5, "exit_alone": 0.5}):
        good = replace(match.strokes[0], entry=0.0, exit=0.0, ink=UNSEEN, outline=outline)
        changed = replace(match, strokes=(replace(good, **change), *match.strokes[1:]), tips=None)
        strokes = named(changed, registration)
        said |= {f.remark.kind for f in find_stroke_faults(strokes, changed, LIMITS) if f.cause == "stroke 0"}
    assert said == kinds


@pytest.mark.parametrize(
    "change",
    [
        {"shift": np.array([0.25, 0.0])},
        {"turn": 9.0},
        {"length": 0.7},
        HEAVY,
        {"entry": 0.5, "entry_alone": 0.5},
    ],
)
def test_what_the_ink_does_not_show_is_not_told(itself, change):
    match, registration = itself
    changed = replace(match, strokes=(replace(match.strokes[0], **change), *match.strokes[1:]), tips=None)
    changed = moved_in_cell(changed, change.get("shift", np.zeros(2)))
    strokes = named(changed, registration)
    assert [f for f in find_stroke_faults(strokes, changed, LIMITS) if f.cause == "stroke 0"] == []


def test_a_stroke_that_put_back_is_no_more_like_is_not_out_of_place(itself):
    match, registration = itself
    ink = replace(UNSEEN, unlike=0.8, moved=0.8)
    pushed = replace(match.strokes[0], shift=np.array([0.25, 0.0]), ink=ink)
    changed = replace(match, strokes=(pushed, *match.strokes[1:]), tips=None)
    changed = moved_in_cell(changed, np.array([0.25, 0.0]))
    strokes = named(changed, registration)
    assert "displaced" not in [f.remark.kind for f in find_stroke_faults(strokes, changed, LIMITS)]


@pytest.mark.parametrize(
    ("in_cell", "framed", "told"),
    [
        ((0.25, 0.0), True, "偏右約 #% 格。"),
        ((-0.2, 0.0), True, None),  # it stands on the other side of its place
        ((0.0, 0.0), False, None),  # by its extent the whole says nothing of it
        ((0.25, 0.25), False, "偏右約 #% 格。"),  # that it is low is not said by the pose
    ],
)
def test_a_stroke_is_out_of_place_where_no_reading_says_the_contrary(*, itself, in_cell, framed, told):
    """Beside the other strokes, by the extent of the whole, and in the cell where it is known."""
    match, registration = itself
    stroke = replace(match.strokes[0], shift=np.array([0.25, 0.0]), ink=UNSEEN)
    changed = replace(match, strokes=(stroke, *match.strokes[1:]), tips=None)
    changed = moved_in_cell(changed, np.array(in_cell))
    said = [f for f in faults_of_first(changed, registration, framed=framed) if f.remark.kind == "displaced"]
    name = named(changed, registration)[0].name.zh
    assert [_no_digits(f.remark.zh) for f in said] == ([] if told is None else [f"{_no_digits(name)}{told}"])


@pytest.mark.parametrize(
    ("change", "kind"),
    [
        (HEAVY, "stroke_heavy"),  # all are as heavy
        ({"entry": -0.5, "entry_alone": 0.1}, "entry_light"),  # the stroke is heavy, not its beginning light
        ({"exit": 0.5, "exit_alone": -0.1}, "exit_blunt"),
        ({"exit": 1.2, "exit_alone": 1.2}, "exit_blunt"),  # the end of another stroke
        ({"length": 0.7, "ink": replace(UNSEEN, lacking=-0.2)}, "stroke_short"),
        ({"length": 1.3, "ink": replace(UNSEEN, lacking=0.1)}, "stroke_long"),
        ({"turn": 9.0, "ink": replace(UNSEEN, unlike=0.4, moved=0.9)}, "stroke_angle"),  # laid on other ink
    ],
)
def test_a_fault_of_one_stroke_is_not_told_where_two_readings_differ(itself, change, kind):
    match, registration = itself
    good = replace(match.strokes[0], entry=0.0, exit=0.0, ink=UNSEEN)
    width = 1.5 if "width" in change else match.width
    changed = replace(match, strokes=(replace(good, **change), *match.strokes[1:]), width=width, tips=None)
    assert kind not in [f.remark.kind for f in faults_of_first(changed, registration)]


def test_a_vertical_that_stands_more_upright_than_a_slanting_master_is_not_told_to_stand_straight(itself):
    match, registration = itself
    stroke = match.strokes[0]
    aside = np.linspace(0.0, 0.7, len(stroke.line.points))[:, None] * np.array([1.0, 0.0])
    line = replace(stroke.line, points=stroke.line.points + aside)  # its foot lies to the right
    advice = {}
    for more in (True, False):  # slants more than the master, or less
        turned = replace(stroke, turn=-8.0 if more else 8.0, line=line, ink=UNSEEN)
        changed = replace(match, strokes=(turned, *match.strokes[1:]), tips=None)
        (said,) = [f for f in faults_of_first(changed, registration) if f.remark.kind == "stroke_angle"]
        advice[more] = said.advice[0].zh
    assert "直下" in advice[True] and "直下" not in advice[False]


@pytest.mark.parametrize(
    ("width", "unlike", "fuller", "told"),
    [
        (0.35, np.inf, -0.6, True),
        (0.35, np.inf, -0.1, False),
        (0.6, np.inf, 0.0, True),  # no strip of ink was seen
        (0.6, 0.5, -0.2, True),
        (0.6, 0.5, 0.0, False),
    ],
)
def test_a_change_of_width_is_believed_where_the_ink_shows_it(itself, width, unlike, fuller, told):
    match, registration = itself
    ink = replace(UNSEEN, unlike=unlike, fuller=fuller)
    thin = replace(match.strokes[0], width=width, written_width=width, ink=ink)
    changed = replace(match, strokes=(thin, *match.strokes[1:]), tips=None)
    strokes = named(changed, registration)
    kinds = [f.remark.kind for f in find_stroke_faults(strokes, changed, LIMITS)]
    assert ("stroke_thin" in kinds) == told


@pytest.mark.parametrize(
    ("length", "lacking", "moved", "change"),
    [
        (0.8, 0.3, 0.4, -0.3),
        (0.95, 0.3, 0.4, -0.125),
        (0.95, 0.3, 0.8, -0.05),
        (1.0, 0.3, 0.4, 0.0),
        (0.7, 0.1, 0.4, -0.3),
    ],
)
def test_ink_that_is_lacking_at_the_ends_shows_a_short_stroke(itself, length, lacking, moved, change):
    match, registration = itself
    short = replace(match.strokes[0], length=length, ink=replace(UNSEEN, lacking=lacking, moved=moved))
    changed = replace(match, strokes=(short, *match.strokes[1:]))
    strokes = named(changed, registration)
    assert strokes[0].length_change == pytest.approx(change)


@pytest.mark.parametrize(("length", "lacking", "told"), [(0.8, 0.4, 0.3), (0.7, 0.0, 0.15)])
def test_how_short_a_stroke_is_lies_between_what_its_line_and_its_ink_lack(itself, length, lacking, told):
    match, registration = itself
    short = replace(match.strokes[0], length=length, ink=replace(UNSEEN, lacking=lacking))
    changed = replace(match, strokes=(short, *match.strokes[1:]), tips=None)
    (said,) = [f for f in faults_of_first(changed, registration) if f.remark.kind == "stroke_short"]
    assert said.remark.size == pytest.approx(-told)


@pytest.mark.parametrize(
    ("pose", "extent", "spread", "told"),
    [(1.3, 1.1, 1.2, 0.15), (1.1, 1.0, 1.1, 0.05), (1.0, 0.9, 0.88, -0.1), (1.2, 0.9, 1.1, 0.0)],
)
def test_how_large_the_whole_is_lies_between_its_strokes_and_its_extent(pose, extent, spread, told):
    match = SimpleNamespace(
        pose=SimpleNamespace(scale=pose), extent=(extent, np.zeros(2)), spread=(spread, np.zeros(2))
    )
    assert PoseSeen(match, None, True).size == pytest.approx(told)


def test_size_and_place_are_what_strokes_and_edges_both_say(itself):
    """A pose that the edges of the writing contradict is not told, one that they exceed is told as it is."""
    match, registration = itself
    posed = replace(match, pose=CharacterPose(1.25 * np.eye(2), np.array([0.0, -0.5])))
    assert PoseSeen(posed, registration, True).size == pytest.approx(
        0.0, abs=1e-9
    )  # the edges stand where the master's do
    assert PoseSeen(posed, registration, True).offset == pytest.approx(0.0, abs=1e-9)
    wider = replace(posed, in_cell=match.in_cell * 1.1 + np.array([0.0, -0.9]))
    assert PoseSeen(wider, registration, True).size == pytest.approx(0.1, abs=0.02)


def test_a_line_that_leads_over_bare_paper_is_not_spoken_of(itself):
    match, registration = itself
    kinds = {}
    for inked in (1.0, 0.5):
        long = replace(match.strokes[0], length=1.4, turn=12.0, inked=inked, ink=UNSEEN)
        changed = replace(match, strokes=(long, *match.strokes[1:]), tips=None)
        strokes = named(changed, registration)
        kinds[inked] = {f.remark.kind for f in find_stroke_faults(strokes, changed, LIMITS)}
    assert {"stroke_long", "stroke_angle"} <= kinds[1.0]
    assert not {"stroke_long", "stroke_angle"} & kinds[0.5]


def test_ink_at_the_end_of_a_stroke_was_pressed_there_and_is_no_blot(itself):
    match, registration = itself
    foot = match.framed.on_picture(match.moved)[np.flatnonzero(match.master.points.owner == 0)[-1]]
    patch = InkPatch(0.05, 1.2, 2.0, True, False, SQUARE - SQUARE.mean(axis=0) + foot)
    strokes = named(match, registration)
    found = find_ink_faults(replace(NO_FAULT, patches=(patch,)), strokes, match, LIMITS)
    zh, en = words(found, "blot")
    assert zh == f"{strokes[0].name.zh}下端按得太重，積成一團墨。"
    assert en == f"{strokes[0].en} is pressed so hard at its foot that the ink has run into a lump."


@pytest.mark.parametrize(("rough", "torn", "told"), [(1.4, 0.4, True), (1.4, 0.0, False), (1.1, 0.4, False)])
def test_edges_tremble_where_it_is_seen_and_they_are_frayed_a_little_too(itself, rough, torn, told):
    match, registration = itself
    ink = replace(NO_FAULT, tremor=1.1 * LIMITS.tremor, rough=rough, torn=torn)
    found = find_ink_faults(ink, named(match, registration), match, LIMITS)
    assert ("rough" in [f.remark.kind for f in found if f.excess >= 1.0]) == told


def _no_digits(text: str) -> str:
    return "".join("#" if c.isdigit() else c for c in text).replace("##", "#")


def test_of_most_tips(itself):
    match, registration = itself
    unseen = tuple(replace(stroke, ink=UNSEEN) for stroke in match.strokes)
    tips = BluntTips(0.8, 0.9, ((0, 1), (1, 1), (2, 0)))
    assert not [
        f
        for f in find_stroke_faults(
            named(match, registration),
            replace(match, tips=tips),
            LIMITS,
        )
        if f.remark.kind == "exit_blunt"
    ], "the ink of its tips is the master's"
    changed = replace(match, strokes=unseen, tips=tips)
    strokes = named(changed, registration)
    said = words(find_stroke_faults(strokes, changed, LIMITS), "exit_blunt")
    assert said == ("筆鋒多禿鈍，有 3 處不夠尖。", "The tips are blunt, 3 of them.")


@pytest.mark.parametrize(
    ("size", "degrees", "shift", "kind", "zh", "en"),
    [
        (1.2, 0.0, (0.0, 0.0), "size", "整字比範本大 20%。",
         "The whole character is 20% larger than the master."),
        (1.0, 6.0, (0.0, 0.0), "lean", "整字向右傾斜 6°。", "The whole character leans 6° clockwise."),
        (1.0, 0.0, (0.0, -0.5), "offset", "整字在格中偏上，離範本位置約 #% 格。",
         "The whole character stands too high, by about #% of the cell."),
    ],
)  # fmt: skip
def test_of_the_whole_in_its_cell(*, itself, size, degrees, shift, kind, zh, en):
    match, registration = itself
    a = np.radians(degrees)
    linear = size * np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    in_cell = match.in_cell @ linear.T + np.array(shift)
    posed = replace(match, pose=CharacterPose(linear, np.array(shift)), in_cell=in_cell)
    said_zh, said_en = words(find_whole_faults(PoseSeen(posed, registration, True), LIMITS), kind)
    if "#" in zh:
        said_zh, said_en = _no_digits(said_zh), _no_digits(said_en)
    assert (said_zh, said_en) == (zh, en)
    free = find_whole_faults(PoseSeen(posed, registration, False), LIMITS)
    assert kind not in [f.remark.kind for f in free]
