"""What is refused, and why; above all, what is not. `benchmarks/refusal.py` asks the same of all the data."""

from __future__ import annotations

import csv
from dataclasses import replace
from functools import lru_cache

import cv2
import numpy as np
import pytest
from PIL import Image

import rumu
from rumu.assessment.refusal import RefusalLimits, check_copy, fill_outlines, parts_of
from rumu.assessment.refusal_reasons import refusal_of, turned_refusal
from rumu.capture.image import read_image
from rumu.gallery.starter import find_work, starter_works
from rumu.pipeline import Measurement, PreparedMaster, measure
from rumu.values import Surface
from rumu_lab.simulation import faults
from rumu_lab.simulation.impostors import impostor, picture_of

WORKS = ("regular-shu", "regular-shui", "clerical-tian", "seal-yue", "running-ri", "cursive-shu")


@lru_cache(maxsize=64)
def mask(work: str) -> np.ndarray:
    return np.asarray(Image.open(find_work(work).path)) < 128


@lru_cache(maxsize=64)
def master(work: str) -> Surface:
    return rumu.relief(picture_of(mask(work)))


@lru_cache(maxsize=64)
def prepared(work: str) -> PreparedMaster:
    """The same, made ready once for all of its copies."""
    return PreparedMaster(master(work))


def against(page: np.ndarray, master_page: np.ndarray, **options) -> Measurement:
    return measure(rumu.relief(page), PreparedMaster(rumu.relief(master_page)), **options)


def code(page: np.ndarray, work: str, **options) -> str | None:
    found = measure(rumu.relief(page), prepared(work), **options).refusal
    return found.code if found else None


def box(ink: np.ndarray) -> np.ndarray:
    return ink[np.ix_(ink.any(axis=1), ink.any(axis=0))]


def placed(*works: str, rows: int, columns: int, side: int = 512) -> np.ndarray:
    """Works side by side and one above the other, each in a cell of its own."""
    page = np.zeros((side, side), np.float32)
    height, width = side // rows, side // columns
    for k, work in enumerate(works):
        ink = box(mask(work)).astype(np.float32)
        scale = 0.75 * min(height / ink.shape[0], width / ink.shape[1])
        ink = cv2.resize(ink, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        y = (k // columns) * height + (height - ink.shape[0]) // 2
        x = (k % columns) * width + (width - ink.shape[1]) // 2
        page[y : y + ink.shape[0], x : x + ink.shape[1]] = ink
    return picture_of(page)


# what must not be refused


@pytest.mark.parametrize("work", [w.id for w in starter_works()])
def test_a_master_is_a_copy_of_itself(work):
    assert code(picture_of(mask(work)), work) is None


@pytest.mark.parametrize("fault", faults.FAULTS)
@pytest.mark.parametrize("work", ["regular-shui", "cursive-ren"])
def test_no_gross_fault_is_refused(fault, work):
    if fault == "horizontal" and work == "cursive-ren":
        pytest.skip("there is no horizontal stroke in it")
    assert code(picture_of(faults.apply(mask(work), fault, severity=5, seed=2).ink), work) is None


def strokes(*ends: tuple[tuple[int, int], tuple[int, int]]) -> np.ndarray:
    page = np.zeros((400, 400), np.uint8)
    for a, b in ends:
        cv2.line(page, a, b, 1, 22)
    return page > 0


APART = {
    "八": strokes(((170, 110), (80, 300)), ((230, 110), (330, 300))),
    "小": strokes(((200, 70), (200, 330)), ((120, 160), (70, 260)), ((280, 160), (330, 260))),
    "川": strokes(((90, 80), (70, 320)), ((200, 90), (200, 310)), ((310, 70), (310, 330))),
    "三": strokes(((100, 90), (300, 90)), ((120, 200), (280, 200)), ((70, 320), (330, 320))),
}


SYMMETRIC = {
    "口": strokes(
        ((110, 120), (110, 290)), ((110, 120), (290, 120)), ((290, 120), (290, 290)), ((110, 285), (290, 285))
    ),
    "田": strokes(
        ((100, 100), (100, 300)),
        ((100, 100), (300, 100)),
        ((300, 100), (300, 300)),
        ((100, 300), (300, 300)),
        ((200, 100), (200, 300)),
        ((100, 200), (300, 200)),
    ),
    "日": strokes(
        ((130, 90), (130, 310)),
        ((130, 90), (270, 90)),
        ((270, 90), (270, 310)),
        ((130, 200), (270, 200)),
        ((130, 310), (270, 310)),
    ),
    "十": strokes(((200, 80), (200, 330)), ((80, 190), (320, 190))),
    "一": strokes(
        ((70, 210), (330, 195)),
    ),
    "丨": strokes(
        ((200, 60), (203, 340)),
    ),
}


@pytest.mark.parametrize("name", APART)
def test_one_character_of_several_parts_is_one(name):
    own = picture_of(APART[name])
    rng = np.random.default_rng(3)
    for lean in rng.uniform(-9, 9, 3):
        M = cv2.getRotationMatrix2D((200, 200), lean, 0.85)
        M[:, 2] += rng.uniform(-15, 15, 2)
        copy = picture_of(cv2.warpAffine(APART[name].astype(np.float32), M, (400, 400)))
        assert against(copy, own).refusal is None


def test_learners_copies_are_not_refused(data):
    with (data / "e3c" / "scores.csv").open(encoding="utf-8-sig") as stream:
        rows = list(csv.DictReader(stream))
    worst = sorted(rows, key=lambda row: float(row["mean_score"]))[:30]
    refused = {}
    for row in [*worst, *rows[::25]]:
        mark = rumu.assess(
            data / "e3c" / row["image"], template(data / "e3c" / row["template"]), remarks=False
        )
        if mark.refused:
            refused[row["image"]] = mark.refused
    assert refused == {}


@lru_cache(maxsize=32)
def template(path) -> PreparedMaster:
    return PreparedMaster(rumu.relief(path))


# what must be


@pytest.mark.parametrize("work", WORKS)
@pytest.mark.parametrize(("kind", "why"), [("mirrored", "mirrored"), ("upside_down", "upside down")])
def test_a_reversed_character_is_told(work, kind, why):
    """But for characters that are much the same reversed."""
    if work in {"clerical-tian", "regular-shui"} and kind == "mirrored":
        assert code(impostor(mask(work), kind), work) in (None, why)
        return
    if work == "running-ri" and kind == "upside_down":
        assert code(impostor(mask(work), kind), work) in (None, why)
        return
    assert code(impostor(mask(work), kind), work) == why


@pytest.mark.parametrize(
    ("degrees", "name"), [(90, "turned left"), (180, "upside down"), (270, "turned right")]
)
@pytest.mark.parametrize(
    "work", ["regular-shui", "regular-shu", "regular-ren", "clerical-shu", "cursive-shui"]
)
def test_a_photograph_on_its_side_says_how_to_turn_it(work, degrees, name):
    page = picture_of(faults.apply(mask(work), "uneven", severity=2, seed=4).ink)
    turned = np.ascontiguousarray(np.rot90(page, degrees // 90))  # anticlockwise: to be turned back clockwise
    answer = rumu.assess(turned, prepared(work), remarks=False)
    assert (answer.refused, answer.turned_by) == (f"{name}: {turned_refusal(degrees).en}", degrees)
    upright = rumu.assess(
        np.ascontiguousarray(np.rot90(turned, -degrees // 90)), prepared(work), remarks=False
    )
    assert upright.refused is None and upright.turned_by is None


@pytest.mark.parametrize("quarters", range(4))
@pytest.mark.parametrize("name", ["口", "田", "日", "十", "一", "丨"])
def test_a_character_that_is_much_the_same_turned_is_not_refused_upright(name, quarters):
    """Learners' copies of it, leaning and out of proportion, of a master that is nearly its own turn."""
    own, rng = picture_of(SYMMETRIC[name]), np.random.default_rng(quarters)
    lean, wide = rng.uniform(-8, 8), rng.uniform(0.8, 1.2)
    M = np.array([[wide, 0.0, 0.0], [0.0, 1.0, 0.0]])
    M[:, 2] = 200 - M[:, :2] @ (200, 200)
    M = cv2.getRotationMatrix2D((200, 200), lean, 0.9) @ np.vstack([M, [0, 0, 1]])
    copy = picture_of(cv2.warpAffine(SYMMETRIC[name].astype(np.float32), M, (400, 400)))
    assert against(copy, own).refusal is None


def test_a_turned_photograph_whose_border_cuts_it_is_told_to_be_turned(data):
    """Laid wrongly, the master reaches beyond a border; the true reason is that the copy is turned."""
    page = read_image(data / "e3c" / "copies" / "003503.png")
    own = template(data / "e3c" / "templates" / "22.png")
    answer = rumu.assess(np.ascontiguousarray(np.rot90(page)), own, remarks=False)
    assert answer.turned_by == 90


def test_no_learners_copy_is_taken_for_a_turned_one_and_turned_ones_are(data):
    with (data / "e3c" / "scores.csv").open(encoding="utf-8-sig") as stream:
        rows = list(csv.DictReader(stream))[7::13]
    told = 0
    for row in rows:
        own, page = template(data / "e3c" / row["template"]), read_image(data / "e3c" / row["image"])
        assert rumu.assess(page, own, remarks=False).turned_by is None
        told += rumu.assess(np.ascontiguousarray(np.rot90(page, 3)), own, remarks=False).turned_by == 270
    assert told >= 0.95 * len(rows)


@pytest.mark.parametrize("work", ["regular-shu", "clerical-tian", "running-ri", "cursive-shu"])
def test_an_outline_is_told_and_a_thin_pen_is_not_one(work):
    assert code(impostor(mask(work), "outline", seed=2), work) == "outline only"
    assert code(picture_of(faults.apply(mask(work), "thin", severity=5, seed=1).ink), work) is None


@pytest.mark.parametrize("kind", ["blobs", "scribble", "filled_square"])
@pytest.mark.parametrize("work", WORKS)
def test_what_is_no_character_is_refused_or_worth_little(kind, work):
    found = code(impostor(mask(work), kind, seed=5), work)
    assert found in ("another character", "several characters", "mirrored", "upside down", None)
    mark = rumu.assess(impostor(mask(work), kind, seed=5), prepared(work), remarks=False)
    assert mark.refused or mark.score < 40


@pytest.mark.parametrize(
    ("rows", "columns", "others"),
    [
        (1, 2, ("regular-ri",)),
        (2, 1, ("regular-ri",)),
        (1, 3, ("regular-ri", "regular-ren")),
        (2, 2, ("regular-ri", "regular-ren", "regular-yue")),
        (1, 2, ("regular-shu",)),
    ],
)
def test_several_characters_are_told(rows, columns, others):
    page = placed("regular-shu", *others, rows=rows, columns=columns)
    assert code(page, "regular-shu") == "several characters"


@pytest.mark.parametrize(
    ("work", "quarters"), [*(("regular-shu", k) for k in range(4)), *(("regular-tian", k) for k in range(3))]
)
def test_a_character_cut_by_the_edge_is_told(work, quarters):
    own = np.rot90(mask(work), quarters).copy()
    lost = np.cumsum(own.sum(axis=0)) / own.sum()
    cut = own[:, int(np.searchsorted(lost, 0.2)) :]
    assert against(picture_of(cut), picture_of(own)).refusal.code == "cut off"


def test_an_outline_of_a_learners_own_writing_is_told():
    """It lies not where the master's edges are: what tells is that filled it is a character."""
    written = faults.apply(
        faults.apply(mask("regular-shu"), "uneven", severity=5, seed=1).mask, "shift", severity=5
    )
    assert code(impostor(written.mask, "outline", seed=2), "regular-shu") == "outline only"


def test_a_square_drawn_with_a_pen_is_no_outline():
    square = np.zeros((400, 400), np.uint8)
    cv2.rectangle(square, (90, 90), (310, 310), 1, 40)
    pen = np.zeros((400, 400), np.uint8)
    cv2.rectangle(pen, (90, 90), (310, 310), 1, 10)
    found = against(picture_of(pen > 0), picture_of(square > 0))
    assert found.figures.relative_height < RefusalLimits().outline_height
    assert found.refusal is None


def test_what_is_within_closed_lines_is_filled():
    page = np.zeros((120, 120), np.uint8)
    cv2.rectangle(page, (10, 10), (110, 110), 1, 3)
    cv2.rectangle(page, (40, 40), (80, 80), 1, 3)
    full = fill_outlines(page > 0)
    assert full[20, 20] and full[100, 60] and full[10, 10]
    assert not full[60, 60] and not full[3, 3]


def test_strays_of_a_neighbour_at_the_border_are_no_cut():
    ink = mask("regular-shu").copy()
    ink[200:330, :9] = True
    ink[:14, 300:380] = True
    assert code(picture_of(ink), "regular-shu") is None


def test_tiny_writing_is_too_small():
    ink = mask("regular-shu").astype(np.float32)
    M = np.array([[0.15, 0, 220.0], [0, 0.15, 220.0]])
    tiny = cv2.warpAffine(cv2.GaussianBlur(ink, (0, 0), 2.5), M, (512, 512))
    assert code(picture_of(tiny), "regular-shu") == "too small"


def test_a_single_stroke_in_its_place_is_marked_and_low():
    page = impostor(mask("regular-shu"), "one_stroke", seed=1)
    mark = rumu.assess(page, master("regular-shu"), remarks=False)
    assert mark.refused is None
    assert mark.score < 40


def test_another_character_is_refused_mostly():
    """Of the pairs of starter works of one script; what is let through is worth little."""
    works = starter_works()
    pairs = [(a, b) for a in works for b in works if a.script == b.script and a.character != b.character]
    refused = 0
    for copy, own in pairs[::5]:
        mark = rumu.assess(master(copy.id), prepared(own.id), remarks=False)
        refused += mark.refused is not None
        assert mark.refused or mark.score < 40, (copy.id, own.id, mark.score)
    assert refused / len(pairs[::5]) > 0.7


def test_where_the_ink_is_not_clean_another_character_is_not_refused():
    copy, own = rumu.relief(picture_of(mask("regular-ri"))), PreparedMaster(master("regular-shu"))
    silk = replace(copy, quality={**copy.quality, "noise": 9.0})
    assert measure(copy, own).refusal.code == "another character"
    assert measure(silk, own).refusal is None


def test_what_may_be_another_character_gets_no_more_than_a_bad_mark_and_a_copy_may_get_all():
    copy = rumu.relief(picture_of(mask("regular-ri")))
    figures = measure(copy, PreparedMaster(master("regular-shu"))).figures
    strange = figures.strangeness
    between = RefusalLimits(
        refuse_strangeness=strange + 0.1, cap_strangeness=strange - 0.1, zero_strangeness=strange + 0.1
    )
    assert check_copy(figures, limits=between) == (
        None,
        pytest.approx(between.cap_highest / 2),  # half-way from the cap to nothing
    )
    stranger = replace(between, cap_strangeness=strange - 0.2, zero_strangeness=strange)
    assert check_copy(figures, limits=stranger) == (None, 0.0)
    beyond = RefusalLimits(refuse_strangeness=strange + 0.2, cap_strangeness=strange + 0.1)
    assert check_copy(figures, limits=beyond) == (None, 100.0)
    near = replace(between, cap_residual=9.0)
    assert check_copy(figures, limits=near) == (None, 100.0)
    itself = measure(copy, PreparedMaster(copy), limits=RefusalLimits(cap_strangeness=-9.0))
    assert (itself.refusal, itself.highest) == (None, 100.0)


def test_the_mark_keeps_below_what_the_copy_may_get(monkeypatch):
    from rumu import pipeline

    monkeypatch.setattr(pipeline, "check_copy", lambda *_, **__: (None, 39.0))
    assert rumu.assess(master("regular-shu"), master("regular-shu")).score == 39.0


# the figures


def test_the_limits_are_what_decides():
    page = impostor(mask("regular-shu"), "mirrored")
    assert code(page, "regular-shu") == "mirrored"
    assert code(page, "regular-shu", limits=RefusalLimits(reversed_gain=9.0)) is None
    strict = RefusalLimits(reversed_gain=9.0, refuse_strangeness=-1.2)
    assert code(page, "regular-shu", limits=strict) == "another character"


def test_figures_of_a_copy_and_itself():
    own = master("regular-shu")
    figures = measure(own, PreparedMaster(own)).figures
    assert figures.plane_residual == pytest.approx(0.0, abs=1e-6)
    assert figures.upright_likeness == pytest.approx(1.0, abs=1e-5)
    assert max(figures.mirrored_likeness, *figures.turned_likenesses.values()) < 0.7
    assert figures.share_in_place == 1.0
    assert figures.relative_height == pytest.approx(1.0)
    assert figures.hollowness == pytest.approx(0.0)
    assert figures.share_beyond_border == 0.0
    assert figures.strangeness < -1.0


def test_parts_stand_clear_of_each_other():
    ink = np.zeros((100, 100), bool)
    ink[10:40, 10:40] = ink[10:40, 60:90] = ink[60:90, 10:40] = ink[60:90, 60:90] = True
    sizes = sorted(int(part.sum()) for part in parts_of(ink))
    assert sizes == [900] * 4 + [1800] * 4  # two columns, two rows, four cells
    ink[:, 45:55] = True
    assert [int(p.sum()) for p in parts_of(ink) if p[:, 45:55].any()] == [1000]
    assert parts_of(ink[:, 56:]) != []
    assert parts_of(np.ones((20, 20), bool)) == []


# the words


@pytest.mark.parametrize(
    "known",
    [
        *("blank", "black", "noise", "flat", "too small", "cut off", "several characters", "mirrored"),
        *(
            "too thin",
            "uneven light",
            "upside down",
            "turned left",
            "turned right",
            "outline only",
            "another character",
        ),
    ],
)
def test_every_reason_has_a_sentence_in_both_languages(known):
    found = refusal_of(known)
    assert found.code == known
    assert any("\u4e00" <= letter <= "\u9fff" for letter in found.zh) and found.zh.endswith("。")
    assert found.en and found.en[0].islower() and found.en.isascii()


def test_both_sentences_reach_the_assessment():
    mark = rumu.assess(impostor(mask("regular-shu"), "mirrored"), master("regular-shu"))
    assert mark.refused == f"mirrored: {refusal_of('mirrored').en}"
    assert mark.refused_zh == refusal_of("mirrored").zh
    blank = rumu.assess(impostor(mask("regular-shu"), "blank"), master("regular-shu"))
    assert blank.refused.startswith("blank: ") and blank.refused_zh == refusal_of("blank").zh
    assert rumu.assess(master("regular-shu"), master("regular-shu")).refused_zh is None
