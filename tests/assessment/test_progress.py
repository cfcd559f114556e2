"""Two attempts at one master: only what is larger than the error of measuring is told."""

from __future__ import annotations

from dataclasses import dataclass, replace

import pytest

from rumu.assessment.progress import FaultPrecision, ProgressSettings, compare_attempts
from rumu.values import Remark

SETTINGS = ProgressSettings(
    mark=6.0, parts={"ink": 8.0}, faults={"length": FaultPrecision(error=0.05, least=0.08)}
)
ACROSS = (((0.2, 0.3), (0.8, 0.3)),)
DOWN = (((0.5, 0.1), (0.5, 0.9)),)


@dataclass(frozen=True)
class Mark:
    remarks: tuple[Remark, ...] = ()
    untold: tuple[Remark, ...] | None = ()
    score: float | None = 50.0
    parts: dict[str, float] = None  # type: ignore[assignment]

    def __post_init__(self):
        object.__setattr__(self, "parts", self.parts or {"structure": 50.0, "ink": 40.0})


def short(size=0.2, **more) -> Remark:
    fields = {"kind": "stroke_short", "unit": "of the master", "severity": 3.0, "region": None, "zh": "短"}
    fields |= {"en": "Short.", "outline": ACROSS, "master_outline": ACROSS, "size": -size}
    return Remark(**(fields | more))


def told(before: Mark, after: Mark):
    """Status of each fault."""
    progress = compare_attempts(before, after, framed=True, settings=SETTINGS)
    return [(fault.status, fault.remark.kind) for fault in progress.faults]


@pytest.mark.parametrize(
    ("after", "change"), [(50.0, "same"), (55.9, "same"), (44.1, "same"), (56.1, "better"), (43.9, "worse")]
)
def test_a_mark_changes_only_by_more_than_its_error(after, change):
    progress = compare_attempts(Mark(), Mark(score=after), framed=True, settings=SETTINGS)
    assert progress.mark.change == change
    parts = Mark(parts={"structure": 57.0, "ink": 47.0})
    found = compare_attempts(Mark(), parts, framed=True, settings=SETTINGS).parts
    assert {name: part.change for name, part in found.items()} == {"structure": "better", "ink": "same"}


def test_nothing_is_compared_with_a_copy_that_was_refused():
    assert compare_attempts(Mark(score=None), Mark(), framed=True) is None
    assert compare_attempts(Mark(), Mark(score=None), framed=True) is None


@pytest.mark.parametrize(
    ("before", "after", "status"),
    [(0.2, 0.14, "smaller"), (0.2, 0.16, "same"), (0.2, 0.24, "same"), (0.2, 0.26, "larger")],
)
def test_a_fault_grows_or_shrinks_only_by_more_than_its_error(before, after, status):
    assert told(Mark((short(before),)), Mark((short(after),))) == [(status, "stroke_short")]
    assert told(Mark((short(before),)), Mark(untold=(short(after),)))[0][0] == status


def test_a_fault_that_is_not_found_again_is_gone_if_it_was_clear():
    assert told(Mark((short(0.2),)), Mark()) == [("gone", "stroke_short")]
    assert told(Mark((short(0.1),)), Mark()) == [], "it may have fallen just below what is told"


def test_a_fault_that_is_only_no_longer_told_is_not_gone():
    assert told(Mark((short(0.2),)), Mark(untold=(short(0.19),))) == [("same", "stroke_short")]
    assert told(Mark((short(0.2),)), Mark(untold=None)) == [], "a mark that did not keep what it left unsaid"


def test_a_new_fault_is_told_if_it_is_clear_and_was_looked_for():
    assert told(Mark(), Mark((short(0.2),))) == [("new", "stroke_short")]
    assert told(Mark(), Mark((short(0.1),))) == []
    assert told(Mark(untold=None), Mark((short(0.2),))) == []
    assert told(Mark(untold=(short(0.18),)), Mark((short(0.2),))) == [], "it was there and did not grow"
    assert told(Mark(untold=(short(0.1),)), Mark((short(0.2),))) == [("larger", "stroke_short")]


def test_too_short_that_becomes_too_long_is_neither_gone_nor_new():
    long = replace(short(0.12), kind="stroke_long", size=0.12)
    assert told(Mark((short(),)), Mark((long,))) == [("turned", "stroke_long")]


def test_strokes_are_told_apart_by_number_or_by_place():
    elsewhere = short(0.2, master_outline=DOWN, outline=DOWN)
    assert told(Mark((short(),)), Mark((elsewhere,))) == [("gone", "stroke_short"), ("new", "stroke_short")]
    near = short(0.2, master_outline=(((0.21, 0.31), (0.5, 0.3), (0.8, 0.3)),))
    assert told(Mark((short(),)), Mark((near,))) == [("same", "stroke_short")]
    first, second = short(stroke=1), short(stroke=2)
    assert told(Mark((first,)), Mark((second,)))[0][0] == "gone"
    assert told(Mark((first,)), Mark((short(stroke=1, master_outline=DOWN),)))[0][0] == "same"


def test_of_a_stroke_that_one_copy_lacks_nothing_else_is_told():
    missing = replace(short(), kind="missing", size=0.1)
    assert told(Mark((short(),)), Mark((missing,))) == [("new", "missing")]
    assert told(Mark((missing,)), Mark((short(),))) == [("gone", "missing")]


def test_place_and_size_are_compared_only_where_the_cell_is_known():
    lean = replace(short(), kind="lean", size=9.0, outline=(), master_outline=())
    assert told(Mark((lean,)), Mark()) == [("gone", "lean")]
    assert not compare_attempts(Mark((lean,)), Mark(), framed=False).faults
    assert not compare_attempts(Mark(), Mark((lean,)), framed=False).faults
    assert compare_attempts(Mark((short(0.3),)), Mark(), framed=False).faults


def test_what_got_better_comes_first():
    lean = replace(short(), kind="lean", size=4.0, outline=(), master_outline=())
    before = Mark((short(0.2), lean))
    after = Mark((replace(lean, size=9.0), short(0.3, outline=DOWN, master_outline=DOWN)))
    assert [status for status, _ in told(before, after)] == ["gone", "larger", "new"]


def test_two_photographs_of_one_copy_differ_in_nothing():
    """The same picture, framed, lit and stored in two ways."""
    import numpy as np
    from PIL import Image

    from rumu import pipeline
    from rumu.gallery.starter import find_work, starter_samples
    from rumu_lab.simulation.photographs import Shade, photograph

    master = pipeline.prepare_master(find_work("regular-shui").path)
    for sample in (s for s in starter_samples(work="regular-shui") if s.degree in ("medium", "bad")):
        ink = 1.0 - np.asarray(Image.open(sample.path).convert("L"), dtype=np.float32) / 255
        one = pipeline.assess(photograph(ink, side=620, fill=0.9, seed=1), master)
        two = pipeline.assess(photograph(ink, side=700, fill=0.9, shade=Shade(0.2, 40), seed=2), master)
        progress = compare_attempts(one, two, framed=False)
        assert progress.mark.change == "same"
        assert {part.change for part in progress.parts.values()} == {"same"}
        assert {fault.status for fault in progress.faults} <= {"same"}
