"""Canonical strokes on a master, and which of them a copy lacks."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

import rumu
from rumu.assessment.thresholds import RemarkThresholds
from rumu.characters.stroke_data import find_character
from rumu.gallery.starter import starter_works
from rumu.pipeline import PreparedMaster, measure, prepare_master
from rumu.strokes.canonical import lay_character
from rumu.strokes.correspondence import CopyStrokes, StrokeMatch, match_strokes
from rumu.strokes.dots import find_lone_stroke
from rumu.strokes.naming import HORIZONTAL, name_strokes, stroke_title
from rumu.strokes.placement import stroke_numbers
from rumu.values import FloatArray, Surface

SIDE = 360


def printed(
    character: str,
    *,
    without: tuple[int, ...] = (),
    moved: dict[int, tuple[int, int]] | None = None,
    shrunk: dict[int, float] | None = None,
    join: tuple[int, int] | None = None,
) -> Surface:
    """A character as copybooks print it; strokes, from 1, left out, moved by pixels, shrunk, or joined."""
    known = find_character(character)
    assert known is not None
    page = np.full((SIDE, SIDE), 255, np.uint8)
    for number, stroke in enumerate(known.strokes, start=1):
        if number not in without:
            shift = np.array((moved or {}).get(number, (0, 0)))
            outline = 40 + stroke.polygon() * (SIDE - 80) + shift
            middle = outline.mean(axis=0)
            outline = middle + (outline - middle) * (shrunk or {}).get(number, 1.0)
            cv2.fillPoly(page, [np.round(outline).astype(np.int32)], 0)
    if join:
        ends = [known.strokes[n - 1].centre_line[k] for n, k in zip(join, (-1, 0), strict=True)]
        a, b = (tuple(int(v) for v in np.round(40 + end * (SIDE - 80))) for end in ends)
        cv2.line(page, a, b, 0, 6)
    return rumu.relief(page / np.float32(255))


def matched(copy: Surface, master: PreparedMaster) -> StrokeMatch:
    return match_strokes(CopyStrokes(copy, measure(copy, master).registration, master.stroke_model))


def share_missing_for_the_mark(copy: Surface, master: PreparedMaster) -> float:
    return sum(r.share for r in measure(copy, master).features.regions if r.kind == "missing")


@pytest.mark.parametrize("character", "永書水天方寧德語")
def test_each_stroke_lies_on_its_own_ink(character: str) -> None:
    known = find_character(character)
    assert known is not None
    master = PreparedMaster(printed(character), character)
    laid = master.stroke_model.laid
    assert laid is not None and laid.confidence.min() > 0.6
    assert {line.number for line in laid.lines.lines} - {0} == set(range(1, len(known.strokes) + 1))
    ink = master.stroke_model.framed
    for number, stroke in enumerate(known.strokes, start=1):
        at = [ink.on_picture(line.points) for line in laid.lines.lines if line.number == number]
        want = (40 + stroke.centre_line * (SIDE - 80)) / SIDE
        off = np.linalg.norm(want[:, None] - np.concatenate(at), axis=2).min(axis=1)
        assert off.mean() < 0.03, number


def test_works_of_the_starter_gallery_are_named() -> None:
    works = [work for work in starter_works(script="regular") if find_character(work.character)]
    laid = [prepare_master(work.path, character=work.character).stroke_model.laid for work in works]
    assert len(works) > 5 and np.mean([one is not None for one in laid]) > 0.9


@pytest.mark.parametrize(("character", "numbers"), [("德", (10, 11)), ("書", (3, 4, 6))])
def test_two_strokes_on_the_same_ink_are_not_sure(character: str, numbers: tuple[int, ...]) -> None:
    """A master without the horizontal in 德's middle: its neighbour's ink is not told under two names."""
    master = PreparedMaster(printed(character, without=numbers[:1]), character)
    laid = master.stroke_model.laid
    whole = PreparedMaster(printed(character), character).stroke_model.laid
    assert laid is not None and whole is not None
    least, before = (min(one.confidence[number - 1] for number in numbers) for one in (laid, whole))
    assert least <= RemarkThresholds().confident < before


@pytest.mark.parametrize(("written", "claimed"), [("書", "水"), ("天", "永"), ("合", "令")])
def test_another_character_is_not_named(written: str, claimed: str) -> None:
    known = find_character(claimed)
    assert known is not None
    master = PreparedMaster(printed(written), claimed)
    assert not lay_character(known, master.stroke_model.framed).is_confident
    assert master.stroke_model.laid is None


def test_other_scripts_and_unknown_characters_have_no_names() -> None:
    surface = printed("水")
    assert prepare_master(surface, character="水", script="seal").canonical is None
    assert prepare_master(surface, character="水", script="running").canonical is not None
    assert prepare_master(surface, character="A").canonical is None
    lines = prepare_master(surface).stroke_model.lines.lines
    assert all(
        "的一筆" in name.zh and name.en.startswith("the stroke at") for name in name_strokes(lines, None)
    )


def test_names_tell_number_kind_and_part() -> None:
    master = PreparedMaster(printed("永"), "永")
    names = name_strokes(master.stroke_model.lines.lines, master.canonical)
    assert names[0] == ("第一筆「點」", "the first stroke (dot)")
    assert (
        "第二筆「橫折鉤」的鉤",
        "the hook of the second stroke (horizontal with a bend and a hook)",
    ) in names
    assert any(name.zh == "第二筆「橫折鉤」的豎段" for name in names)
    assert ("第五筆「捺」", "the fifth stroke (right-falling stroke)") in names


@pytest.mark.parametrize(
    ("character", "number"),
    [
        ("天", 1),
        ("天", 2),
        ("永", 1),
        ("方", 2),
        ("語", 2),
        ("語", 9),
        ("德", 11),
        ("書", 5),
        ("水", 4),
    ],
)
def test_a_stroke_that_was_left_out_is_told(character: str, number: int) -> None:
    master = PreparedMaster(printed(character), character)
    copy = printed(character, without=(number,))
    match = matched(copy, master)
    assert match.missing == (number,)
    # the mark rests on the same answer
    points, own = match.master.points, stroke_numbers(match.master) == number
    share = float(points.radius[own].sum() / points.radius.sum())
    assert share_missing_for_the_mark(copy, master) == pytest.approx(share)
    whole, mark = (rumu.assess(one, master, remarks=False).score for one in (printed(character), copy))
    assert whole is not None and mark is not None and mark < whole - 20


@pytest.mark.parametrize("character", "天永方語德書")
def test_nothing_is_missing_from_the_master_itself(character: str) -> None:
    assert matched(printed(character), PreparedMaster(printed(character), character)).missing == ()


@pytest.mark.parametrize(
    ("character", "moved"),
    [("天", {2: (0, 26)}), ("永", {1: (22, -10)}), ("語", {9: (0, 14)}), ("方", {1: (30, 0)})],
)
def test_a_stroke_that_stands_elsewhere_is_not_missing(
    character: str, moved: dict[int, tuple[int, int]]
) -> None:
    master = PreparedMaster(printed(character), character)
    copy = printed(character, moved=moved)
    assert matched(copy, master).missing == ()
    assert share_missing_for_the_mark(copy, master) == 0.0


@pytest.mark.parametrize(
    ("character", "join"), [("天", (1, 2)), ("三", (1, 2)), ("德", (14, 15)), ("水", (3, 4))]
)
def test_joined_strokes_are_neither_missing_nor_too_many(character: str, join: tuple[int, int]) -> None:
    master = PreparedMaster(printed(character), character)
    joined = printed(character, join=join)
    assert matched(joined, master).missing == ()
    kinds = {remark.kind for remark in rumu.assess(joined, master).remarks}
    assert not kinds & {"missing", "extra"}


def test_a_remark_names_the_missing_stroke_in_both_languages() -> None:
    master = PreparedMaster(printed("天"), "天")
    mark = rumu.assess(printed("天", without=(1,)), master)
    remark = next(remark for remark in mark.remarks if remark.kind == "missing")
    assert remark.stroke == 1 and remark.master_outline
    assert "漏寫了第一筆「橫」" in remark.zh and "The first stroke (horizontal) is missing" in remark.en


@pytest.mark.parametrize(("shrunk", "told"), [(1.0, False), (0.8, False), (0.5, True)])
def test_a_dot_that_stands_alone_is_too_small_where_half_of_its_ink_is_there(shrunk, told) -> None:
    master = PreparedMaster(printed("玉"), "玉")
    copy = printed("玉", shrunk={5: shrunk})
    match = matched(copy, master)
    alone = find_lone_stroke(match, position_of(5, match))
    assert alone is not None and alone.area == pytest.approx(shrunk**2, abs=0.08)
    mark = rumu.assess(copy, master)
    said = [r for r in (*mark.remarks, *mark.untold) if "太小" in r.zh]
    assert bool(said) == told
    if told:
        assert "第五筆「點」太小" in said[0].zh and "The fifth stroke (dot) is too small" in said[0].en


def test_a_dot_that_joins_another_stroke_does_not_stand_alone() -> None:
    match = matched(printed("太"), PreparedMaster(printed("太"), "太"))
    assert find_lone_stroke(match, position_of(4, match)) is None


def position_of(number: int, match: StrokeMatch) -> int:
    return next(k for k, line in enumerate(match.master.lines) if line.number == number)


# --- learners' copies ---------------------------------------------------------------------------------

WHOLE = ("003078", "007350", "004319", "000625", "006900", "004471", "002524")
"""Copies of which a stroke was once said to be missing, though all of them are there."""


def copy_and_master(data: Path, image: str) -> tuple[Path, PreparedMaster]:
    import csv

    with (data / "e3c" / "scores.csv").open(encoding="utf-8", newline="") as stream:
        row = next(row for row in csv.DictReader(stream) if row["image"].endswith(f"{image}.png"))
    master = prepare_master(data / "e3c" / row["template"], character=row["character"])
    return data / "e3c" / row["image"], master


def match_of(data: Path, image: str) -> StrokeMatch:
    copy, master = copy_and_master(data, image)
    return matched(rumu.relief(copy), master)


def without_stroke(page: FloatArray, match: StrokeMatch, number: int) -> FloatArray:
    """The page, (H, W) gray, with the ink about a stroke taken off, but for what lies about the others."""
    size = np.array(page.shape[::-1])
    at = match.framed.on_picture(match.moved) * size - 0.5
    scale = np.sqrt(abs(np.linalg.det(match.framed.to_picture[:, :2] * size[:, None])))
    masks = []
    own = stroke_numbers(match.master) == number
    for which, reach in ((own, 1.6), (~own, 1.0)):
        mask = np.zeros(page.shape, np.uint8)
        for (x, y), radius in zip(at[which], match.radius[which], strict=True):
            cv2.circle(mask, (round(x), round(y)), round(reach * radius * scale), 1, -1)
        masks.append(mask > 0)
    return np.where(masks[0] & ~masks[1], 255, page).astype(np.uint8)


@pytest.mark.parametrize("image", WHOLE)
def test_whole_copies_lack_nothing(data: Path, image: str) -> None:
    assert match_of(data, image).missing == ()


@pytest.mark.parametrize(
    ("image", "number"),
    [
        ("003110", 6),
        ("003952", 7),
        ("000139", 3),
        ("003864", 1),
        ("004313", 11),
        ("008957", 9),
    ],
)
def test_a_stroke_erased_from_a_learners_copy_is_told(data: Path, image: str, number: int) -> None:
    copy, master = copy_and_master(data, image)
    page = cv2.imread(str(copy), cv2.IMREAD_GRAYSCALE)
    match = matched(rumu.relief(copy), master)
    assert number not in match.missing
    left = without_stroke(page, match, number)
    assert matched(rumu.relief(left / np.float32(255)), master).missing == (number,)


@pytest.mark.parametrize("image", ["004105", "004108", "004309"])
def test_copies_without_a_horizontal_are_told_so(data: Path, image: str) -> None:
    assert match_of(data, image).missing == (11,)


@pytest.mark.parametrize(
    ("number", "zh", "en"),
    [
        (3, "三", "third"),
        (10, "十", "tenth"),
        (12, "十二", "12th"),
        (20, "二十", "20th"),
        (22, "二十二", "22nd"),
        (31, "三十一", "31st"),
    ],
)
def test_numbers_of_strokes_in_words(number: int, zh: str, en: str) -> None:
    assert stroke_title(number, HORIZONTAL) == (f"第{zh}筆「橫」", f"the {en} stroke (horizontal)")


def test_two_horizontals_that_found_each_others_ink_are_exchanged(data: Path) -> None:
    """The long horizontal of 丁 in 寧, the 13th stroke, lies below that of 皿."""
    master = PreparedMaster(rumu.relief(data / "e3c" / "templates" / "14.png"), "寧")
    laid = master.stroke_model.laid
    assert laid is not None
    down = {line.number: float(line.points[:, 1].mean()) for line in laid.lines.lines}
    assert down[12] < down[13] - master.stroke_model.lines.width
    assert laid.confidence[[11, 12]].min() > 0.8
