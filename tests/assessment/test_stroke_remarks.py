"""What is said of each fault, word for word, in Chinese and in English."""

from __future__ import annotations

from dataclasses import replace

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
from rumu.strokes.pose import CharacterPose

LIMITS = RemarkThresholds()
SQUARE = np.array([[0.1, 0.1], [0.2, 0.1], [0.2, 0.2], [0.1, 0.2], [0.1, 0.1]])
NO_FAULT = InkMeasures((), 0.0, 0.0, 0.0, 1.0, 0.0, None, (), (), True, 0.0, 1.0)


@pytest.fixture(scope="module")
def itself(measured, mask):
    """A master's strokes matched with themselves, and the registration."""
    m = measured(mask("regular-shui"), mask("regular-shui"))
    return match_strokes(CopyStrokes(m.copy, m.registration, m.master.stroke_model)), m.registration


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
        ({"tremor": 0.01, "rough": 1.4}, "rough", "筆畫邊緣抖動，比範本多 40%。",
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
    strokes = name_all(match, registration, LIMITS, explained=np.zeros_like(match.places))
    found = list(find_ink_faults(replace(NO_FAULT, **change), strokes, match, LIMITS))
    assert words(found, kind) == (zh, en)


@pytest.mark.parametrize(
    ("patch", "unfound"),
    [
        (InkPatch(0.05, 5.0, 0.6, True, False, SQUARE), 0.0),  # a heavy end's edge
        (InkPatch(0.05, 5.0, 2.0, True, True, SQUARE), 0.0),  # the brush was not lifted
        (InkPatch(0.05, 5.0, 2.0, True, False, SQUARE), 0.06),  # a stroke that stands elsewhere
    ],
)
def test_ink_that_strokes_account_for_is_no_stroke_too_many(itself, patch, unfound):
    match, registration = itself
    strokes = name_all(match, registration, LIMITS, explained=np.zeros_like(match.places))
    ink = replace(NO_FAULT, patches=(patch,), unfound=unfound)
    assert [f.remark.kind for f in find_ink_faults(ink, strokes, match, LIMITS)] == []


@pytest.mark.parametrize("change", [{"bare": 0.1}, {"darkness": 0.5}, {"paleness": 0.4}])
def test_a_picture_of_black_and_white_only_is_not_called_dry_or_pale(itself, change):
    match, registration = itself
    strokes = name_all(match, registration, LIMITS, explained=np.zeros_like(match.places))
    ink = replace(NO_FAULT, has_shades=False, **change)
    assert [f.remark.kind for f in find_ink_faults(ink, strokes, match, LIMITS)] == []


def test_what_a_photograph_s_exposure_may_do_is_not_called_pale(itself):
    match, registration = itself
    strokes = name_all(match, registration, LIMITS, explained=np.zeros_like(match.places))
    assert list(find_ink_faults(replace(NO_FAULT, darkness=0.75), strokes, match, LIMITS)) == []


def test_of_an_end_that_sticks_out(itself):
    match, registration = itself
    strokes = name_all(match, registration, LIMITS, explained=np.zeros_like(match.places))
    foot = match.moved[np.flatnonzero(match.master.points.owner == 0)[-1]]

    def said_of_ink_at(tip):
        ink = replace(NO_FAULT, sticking_out=(StickingOut(0.1 / strokes[0].cell, tip, foot, SQUARE),))
        return [f for f in find_ink_faults(ink, strokes, match, LIMITS) if f.remark.kind == "sticks_out"]

    zh, en = words(said_of_ink_at(foot + np.array([0.0, 0.2])), "sticks_out")
    assert not said_of_ink_at(foot + np.array([0.2, 0.0]))  # beside the foot: a stroke out of its place
    assert not said_of_ink_at(foot - np.array([0.0, 0.2]))
    assert zh == f"{strokes[0].name.zh}下端出頭約 10% 格。"
    assert en == f"{strokes[0].en} sticks out at its foot by about 10% of the cell."


@pytest.mark.parametrize(
    ("change", "kind", "zh", "en"),
    [
        ({"shift": np.array([0.25, 0.0])}, "displaced", "偏右約 #% 格。",
         "stands too far right, by about #% of the cell."),
        ({"turn": 9.0}, "stroke_angle", "斜了 #°，下端偏左。", "is off by #°: its foot is too far left."),
        ({"length": 1.3}, "stroke_long", "長了 #%。", "is #% too long."),
        ({"length": 0.7}, "stroke_short", "短了 #%。", "is #% too short."),
        ({"width": 1.5}, "stroke_heavy", "比別的筆畫粗 #%。", "is #% heavier than the others."),
        ({"width": 0.6}, "stroke_thin", "比別的筆畫細 #%。", "is #% thinner than the others."),
        ({"entry": 0.5}, "entry_heavy", "起筆太重。", "begins too heavily."),
        ({"entry": -0.5}, "entry_light", "起筆太輕。", "begins too lightly."),
        ({"exit": 0.5}, "exit_blunt", "收筆禿鈍，鋒沒有收住。", "ends bluntly."),
    ],
)  # fmt: skip
def test_of_one_stroke(*, itself, change, kind, zh, en):
    match, registration = itself
    good = replace(match.strokes[0], entry=0.0, exit=0.0, ink=UNSEEN)
    changed = replace(match, strokes=(replace(good, **change), *match.strokes[1:]), tips=None)
    strokes = name_all(changed, registration, LIMITS, explained=np.zeros_like(match.places))
    found = [f for f in find_stroke_faults(strokes, changed, LIMITS) if f.cause == "stroke 0"]
    said_zh, said_en = words(found, kind)
    assert _no_digits(said_zh) == f"{_no_digits(strokes[0].name.zh)}{zh}"
    assert _no_digits(said_en) == f"{_no_digits(strokes[0].en)} {en}"


@pytest.mark.parametrize(("edge", "kinds"), [(0.2, {"stroke_short", "exit_blunt"}), (0.0, set())])
def test_a_stroke_that_the_picture_cuts_off_is_neither_short_nor_blunt(itself, edge, kinds):
    match, registration = itself
    outline = match.strokes[0].outline.copy()
    outline[:, 0] += edge - outline[:, 0].min()
    said = set()
    for change in ({"length": 0.7}, {"exit": 0.5}):
        good = replace(match.strokes[0], entry=0.0, exit=0.0, ink=UNSEEN, outline=outline)
        changed = replace(match, strokes=(replace(good, **change), *match.strokes[1:]), tips=None)
        strokes = name_all(changed, registration, LIMITS, explained=np.zeros_like(match.places))
        said |= {f.remark.kind for f in find_stroke_faults(strokes, changed, LIMITS) if f.cause == "stroke 0"}
    assert said == kinds


@pytest.mark.parametrize(
    "change",
    [{"shift": np.array([0.25, 0.0])}, {"turn": 9.0}, {"length": 0.7}, {"width": 1.5}, {"entry": 0.5}],
)
def test_what_the_ink_does_not_show_is_not_told(itself, change):
    match, registration = itself
    changed = replace(match, strokes=(replace(match.strokes[0], **change), *match.strokes[1:]), tips=None)
    strokes = name_all(changed, registration, LIMITS, explained=np.zeros_like(match.places))
    assert [f for f in find_stroke_faults(strokes, changed, LIMITS) if f.cause == "stroke 0"] == []


def test_a_stroke_that_put_back_is_no_more_like_is_not_out_of_place(itself):
    match, registration = itself
    ink = replace(UNSEEN, unlike=0.8, moved=0.8)
    pushed = replace(match.strokes[0], shift=np.array([0.25, 0.0]), ink=ink)
    changed = replace(match, strokes=(pushed, *match.strokes[1:]), tips=None)
    strokes = name_all(changed, registration, LIMITS, explained=np.zeros_like(match.places))
    assert "displaced" not in [f.remark.kind for f in find_stroke_faults(strokes, changed, LIMITS)]


@pytest.mark.parametrize(
    ("width", "fuller", "told"), [(0.35, -0.6, True), (0.35, -0.1, False), (0.6, 0.0, True)]
)
def test_a_great_change_of_width_is_believed_where_the_ink_shows_it(itself, width, fuller, told):
    match, registration = itself
    thin = replace(match.strokes[0], width=width, ink=replace(UNSEEN, fuller=fuller))
    changed = replace(match, strokes=(thin, *match.strokes[1:]), tips=None)
    strokes = name_all(changed, registration, LIMITS, explained=np.zeros_like(match.places))
    kinds = [f.remark.kind for f in find_stroke_faults(strokes, changed, LIMITS)]
    assert ("stroke_thin" in kinds) == told


@pytest.mark.parametrize(
    ("length", "lacking", "moved", "change"),
    [
        (0.8, 0.3, 0.4, -0.3),
        (0.95, 0.3, 0.4, -0.1),
        (0.95, 0.3, 0.8, -0.05),
        (1.0, 0.3, 0.4, 0.0),
        (0.7, 0.1, 0.4, -0.3),
    ],
)
def test_ink_that_is_lacking_at_the_ends_shows_a_short_stroke(itself, length, lacking, moved, change):
    match, registration = itself
    short = replace(match.strokes[0], length=length, ink=replace(UNSEEN, lacking=lacking, moved=moved))
    changed = replace(match, strokes=(short, *match.strokes[1:]))
    strokes = name_all(changed, registration, LIMITS, explained=np.zeros_like(match.places))
    assert strokes[0].length_change == pytest.approx(change)


def test_size_and_place_are_what_strokes_and_edges_both_say(itself):
    """A pose that the edges of the writing contradict is not told, one that they exceed is told as it is."""
    match, registration = itself
    posed = replace(match, pose=CharacterPose(1.25 * np.eye(2), np.array([0.0, -0.5])))
    assert PoseSeen(posed, registration, True).size == 0.0  # the edges stand where the master's do
    assert np.all(PoseSeen(posed, registration, True).offset == 0.0)
    wider = replace(posed, in_cell=match.in_cell * 1.1 + np.array([0.0, -0.9]))
    assert PoseSeen(wider, registration, True).size == pytest.approx(0.1, abs=0.02)


def test_a_line_that_leads_over_bare_paper_is_not_spoken_of(itself):
    match, registration = itself
    kinds = {}
    for inked in (1.0, 0.5):
        long = replace(match.strokes[0], length=1.4, turn=12.0, inked=inked, ink=UNSEEN)
        changed = replace(match, strokes=(long, *match.strokes[1:]), tips=None)
        strokes = name_all(changed, registration, LIMITS, explained=np.zeros_like(match.places))
        kinds[inked] = {f.remark.kind for f in find_stroke_faults(strokes, changed, LIMITS)}
    assert {"stroke_long", "stroke_angle"} <= kinds[1.0]
    assert not {"stroke_long", "stroke_angle"} & kinds[0.5]


def _no_digits(text: str) -> str:
    return "".join("#" if c.isdigit() else c for c in text).replace("##", "#")


def test_of_most_tips(itself):
    match, registration = itself
    unseen = tuple(replace(stroke, ink=UNSEEN) for stroke in match.strokes)
    tips = BluntTips(0.8, 0.9, ((0, 1), (1, 1), (2, 0)))
    assert not [
        f
        for f in find_stroke_faults(
            name_all(match, registration, LIMITS, explained=np.zeros_like(match.places)),
            replace(match, tips=tips),
            LIMITS,
        )
        if f.remark.kind == "exit_blunt"
    ], "the ink of its tips is the master's"
    changed = replace(match, strokes=unseen, tips=tips)
    strokes = name_all(changed, registration, LIMITS, explained=np.zeros_like(match.places))
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
