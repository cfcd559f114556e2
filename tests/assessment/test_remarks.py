"""What is said of known faults: the right thing, at the right place, of the right size, in two languages."""

from __future__ import annotations

import re
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from rumu import pipeline
from rumu.assessment.remarks import write_remarks
from rumu.assessment.thresholds import RemarkThresholds
from rumu.assessment.whole_remarks import find_whole_faults
from rumu.gallery.starter import find_work, starter_samples
from rumu.strokes.correspondence import CopyStrokes
from rumu_lab.experiments.marked_copies import read_copies
from rumu_lab.simulation.faults import FAULTS
from rumu_lab.simulation.glyph import Glyph, region_of

WORK = "regular-shui"


@pytest.fixture(scope="session")
def said(measured):
    """The remarks on one ink mask as a copy of another."""

    def write(copy, master, **options):
        m = measured(copy, master, written=options.pop("written", None))
        options = {"framed": True} | options
        return write_remarks(CopyStrokes(m.copy, m.registration, m.master.stroke_model), **options).remarks

    return write


def the(kind, found):
    chosen = [r for r in found if r.kind == kind]
    assert chosen, f"no {kind!r} among {[r.kind for r in found]}"
    return chosen[0]


def overlap(a, b) -> float:
    """Shared area over the smaller of two boxes (x0, y0, x1, y1)."""
    across = min(a[2], b[2]) - max(a[0], b[0])
    down = min(a[3], b[3]) - max(a[1], b[1])
    areas = [(r[2] - r[0]) * (r[3] - r[1]) for r in (a, b)]
    return max(across, 0.0) * max(down, 0.0) / min(areas)


def test_of_a_perfect_copy_nothing_is_said(said, mask):
    assert said(mask(WORK), mask(WORK)) == ()


@pytest.mark.parametrize("fault_name", FAULTS)
def test_remarks_are_few_ordered_whole_and_bilingual(said, fault, mask, fault_name):
    found = said(fault(WORK, fault_name, 5).mask, mask(WORK))
    assert len(found) <= 3
    severities = [r.severity for r in found]
    assert severities == sorted(severities, reverse=True)
    for remark in found:
        assert remark.severity > 0
        assert np.isfinite(remark.size)
        assert remark.unit
        assert re.search("[一-鿿]", remark.zh), remark.zh
        assert re.fullmatch(r"[ -~°]+\.", remark.en), remark.en
        if remark.region is not None:
            x0, y0, x1, y1 = remark.region
            assert 0 <= x0 < x1 <= 1
            assert 0 <= y0 < y1 <= 1


def test_no_more_is_said_than_asked(said, fault, mask):
    bad = fault(WORK, "uneven", 5, seed=2).mask
    everything = said(bad, mask(WORK))
    assert len(everything) == 3
    assert said(bad, mask(WORK), thresholds=RemarkThresholds(at_most=2)) == everything[:2]


@pytest.mark.parametrize(
    ("lean", "zh", "en"), [(12.0, "向右", " clockwise"), (-9.0, "向左", " anticlockwise")]
)
def test_a_lean_is_named_with_its_side_and_size(*, said, moved, mask, lean, zh, en):
    remark = the("lean", said(moved(WORK, lean=lean), mask(WORK)))
    assert remark.size == pytest.approx(lean, abs=0.4)
    assert remark.unit == "degrees"
    assert remark.region is None
    assert zh in remark.zh and en in remark.en
    assert f"{abs(lean):.0f}°" in remark.zh and f"{abs(lean):.0f}°" in remark.en


@pytest.mark.parametrize(("scale", "zh", "en"), [(0.6, "小", "smaller"), (1.2, "大", "larger")])
def test_size_is_named(*, said, moved, mask, scale, zh, en):
    remark = the("size", said(moved(WORK, scale=scale), mask(WORK)))
    assert remark.size == pytest.approx(scale - 1, abs=0.01)
    assert zh in remark.zh and en in remark.en


@pytest.mark.parametrize(
    ("across", "down", "zh", "en"), [(0.8, 1.0, "窄", "narrow"), (1.0, 0.8, "寬", "wide")]
)
def test_a_shape_is_named_once_and_no_stroke_is_blamed_for_it(*, said, mask, across, down, zh, en):
    height, width = mask(WORK).shape
    shape = np.array([[across, 0, (1 - across) * width / 2], [0, down, (1 - down) * height / 2]])
    copy = cv2.warpAffine(mask(WORK).astype(np.float32), shape, (width, height)) > 0.5
    remarks = said(copy, mask(WORK))
    remark = the("aspect", remarks)
    assert remark.size == pytest.approx(across / down - 1, abs=0.03)
    assert f"字形太{zh}" in remark.zh and f"too {en} for its height" in remark.en
    assert {r.kind for r in remarks} == {"aspect"}


def test_a_stroke_that_is_too_long_makes_no_character_wide(said, mask):
    wide = mask("regular-tian").copy()
    rows = np.flatnonzero(wide.any(axis=1))
    lower = slice(int(rows.min() + 0.3 * np.ptp(rows)), int(rows.min() + 0.45 * np.ptp(rows)))
    long = np.roll(wide[lower], 40, axis=1) | np.roll(wide[lower], -40, axis=1)
    wide[lower] |= long
    assert "aspect" not in {r.kind for r in said(wide, mask("regular-tian"))}


@pytest.mark.parametrize(
    ("shift", "zh", "en"),
    [((60, 0), "偏右", "too far right"), ((-60, 0), "偏左", "too far left"), ((0, 60), "偏上", "too high"),
     ((50, -50), "偏右下", "too low and too far right")],
)  # fmt: skip
def test_an_offset_is_named_with_its_direction(*, said, moved, mask, shift, zh, en):
    remark = the("offset", said(moved(WORK, shift=shift), mask(WORK)))
    assert remark.size == pytest.approx(np.hypot(*shift) / 512, abs=0.003)
    assert zh in remark.zh and en in remark.en


@pytest.mark.parametrize(("name", "kind", "sign"), [("thick", "heavy", 1), ("thin", "thin", -1)])
def test_weight_is_named(*, said, fault, mask, name, kind, sign):
    remark = the(kind, said(fault(WORK, name, 4).mask, mask(WORK)))
    assert remark.size * sign > 0.15


@pytest.mark.parametrize(
    ("weights", "told"),
    [
        ((1.68, 1.16), 0.16),  # strokes that lie on other ink seem far too heavy
        ((0.55, 0.80), -0.20),  # and too thin
        ((1.30, 1.60), 0.30),
        ((1.40, 1.01), None),  # where the ink says nothing, nothing is told
        ((1.02, 1.30), 0.30),  # where the strokes do not, it may explain a low mark of the ink
        ((1.02, 1.30, 1.25), 0.25),  # in its cell the middle one of three
        ((1.04, 1.25, 0.85), None),  # a small character written with a thin brush is heavy for its size alone
    ],
)
def test_of_the_measures_of_weight_that_is_told_which_none_contradicts(weights, told):
    match = SimpleNamespace(width_error=lambda points: 0.0, master=SimpleNamespace(points=None))
    pose = SimpleNamespace(match=match, weights=tuple(np.log(weights)), framed=False, aspect=0.0)
    found = [fault.remark.size for fault in find_whole_faults(pose, RemarkThresholds())]
    assert [size for size in found if abs(size) >= 0.14] == ([] if told is None else [pytest.approx(told)])


def test_small_faults_are_left_unsaid(said, moved, mask):
    assert said(moved(WORK, lean=2.0, scale=0.95, shift=(10, 5)), mask(WORK)) == ()


@pytest.mark.parametrize(
    ("work", "written"),
    [
        ("regular-shui", "水"),
        ("regular-shui", None),
        ("clerical-tian", None),
        ("seal-shui", None),
    ],
)
def test_a_dropped_stroke_is_missed_where_it_was(said, mask, work, written):
    glyph = Glyph(mask(work))
    stroke = len(glyph.strokes) // 2
    gone = glyph.mask & ~glyph.without(stroke)
    remark = the("missing", said(glyph.without(stroke), mask(work), written=written))
    assert overlap(remark.region, region_of(gone)) > 0.5
    assert remark.size == pytest.approx(gone.sum() / glyph.mask.sum(), rel=0.6)
    assert remark.unit == "of the ink"


@pytest.mark.parametrize(
    ("corner", "kinds", "zh", "en"),
    [((40, 40), ("blot",), "左上", "top left"), ((420, 410), ("blot", "extra"), "右下", "bottom right")],
    ids=["by itself", "at the edge of a stroke"],
)
def test_added_ink_is_pointed_at(*, said, mask, corner, kinds, zh, en):
    row, column = corner
    copy = mask("regular-ren").copy()
    copy[row : row + 45, column : column + 45] = True
    added = np.zeros_like(copy)
    added[row : row + 45, column : column + 45] = True
    found = said(copy, mask("regular-ren"))
    remark = next(r for r in found if r.kind in kinds)
    assert overlap(remark.region, region_of(added)) > 0.6
    assert zh in remark.zh and en in remark.en


def test_a_stroke_in_the_wrong_place_is_displaced_and_not_missing(said, mask):
    glyph = Glyph(mask("regular-shui"))
    stroke = max(range(len(glyph.strokes)), key=lambda k: glyph.strokes[k].points[:, 1].mean())
    alone = glyph.mask & ~glyph.without(stroke)
    copy = glyph.without(stroke) | np.roll(alone, (0, 45), axis=(0, 1))
    found = said(copy, glyph.mask)
    remark = the("displaced", found)
    assert "missing" not in [r.kind for r in found]
    assert "右" in remark.zh and "right" in remark.en
    assert remark.size == pytest.approx(45 / 512, abs=0.05)


@pytest.mark.parametrize("stroke", [0, 1, 2])
def test_of_a_missing_stroke_it_is_not_said_that_all_is_small(said, mask, stroke):
    glyph = Glyph(mask("regular-shui"))
    found = said(glyph.without(stroke), glyph.mask)
    assert "size" not in [r.kind for r in found], found


def test_a_blot_does_not_make_the_character_large(said, mask):
    copy = mask("regular-shui").copy()
    copy[40:90, 40:90] = True
    assert "size" not in [r.kind for r in said(copy, mask("regular-shui"))]


def test_what_the_few_remarks_leave_unsaid_is_kept_apart():
    (sample,) = [s for s in starter_samples() if s.work == WORK and s.degree == "bad"]
    mark = pipeline.assess(sample.path, find_work(WORK).path)
    assert mark.untold
    assert not set(mark.untold) & set(mark.remarks)
    severities = [r.severity for r in mark.untold]
    assert severities == sorted(severities, reverse=True)
    assert pipeline.assess(sample.path, find_work(WORK).path, remarks=False).untold == ()


# --- learners' copies, as a teacher saw them ------------------------------------------------------------


@pytest.mark.parametrize(
    ("image", "said_zh", "unsaid_zh"),
    [
        (
            "003888",
            "第二、三、九筆比範本粗",
            "抖動",
        ),  # three heavy strokes are seen first, a little tremor not
        ("004132", "整字比範本大 14%，又在格中偏右", "抖動"),
        (
            "007294",
            "整字比範本大 25%，又在格中偏",
            "一團墨",
        ),  # the lump is the right end of the eighth stroke
        ("000645", "", "墨漬"),  # the foot of the right-falling stroke
        ("005031", "", "沒有鉤出"),  # the fold of 日 is no hook
        ("001880", "太平", "起筆太重"),
        ("003374", "第四筆「點」太小", "墨漬"),
    ],
)
def test_what_a_teacher_says_of_a_learners_copy(data, image, said_zh, unsaid_zh):
    row = next(row for row in read_copies(data) if row.image.stem == image)
    master = pipeline.prepare_master(row.template, character=row.character)
    mark = pipeline.assess(row.image, master, framed=True)
    told = "".join(remark.zh for remark in mark.remarks)
    assert said_zh in told and unsaid_zh not in told
    assert not any(unsaid_zh in remark.zh for remark in mark.untold if remark.kind in ("blot", "no_hook"))
