"""Which of many faults are told: few, the worst first, each once, and low parts of the mark explained."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from rumu.assessment.advice import STROKES, WHOLE, for_stroke
from rumu.assessment.findings import PARTS_OF_KINDS, Finding, choose_remarks
from rumu.assessment.thresholds import RemarkThresholds, severity
from rumu.report.wording import kind_name
from rumu.values import Bilingual, Remark

LIMITS = RemarkThresholds()
SAID = Bilingual("看清範本。", "Look at the master.")
OTHER = Bilingual("慢些寫。", "Write more slowly.")


def fault(kind, severe, *, excess=2.0, cause="", advice=(SAID, OTHER), predicate=None) -> Finding:
    remark = Remark(kind, 1.0, "degrees", severe, None, f"{kind}。", f"{kind}.")
    return Finding(remark, excess, advice, cause or kind, predicate)


def choose(*found, **parts):
    return choose_remarks(found, parts=parts, limits=LIMITS)[0]


def kinds(remarks):
    return [remark.kind for remark in remarks]


def test_the_three_worst_are_told_and_the_others_kept():
    found = [fault(f"k{n}", 5.0 + n, excess=2.0) for n in range(5)]
    told, untold = choose_remarks(found, parts={}, limits=LIMITS)
    assert kinds(told) == ["k4", "k3", "k2"]
    assert kinds(untold) == ["k1", "k0"]


def test_a_trifle_is_never_told():
    assert choose(fault("displaced", 9.0, excess=0.99)) == ()


def test_what_is_slight_beside_the_worst_is_left_out():
    assert kinds(choose(fault("rough", 10.0), fault("entry_heavy", 3.9))) == ["rough"]


def test_one_cause_is_told_once_and_its_two_faults_in_one_sentence():
    worst = fault("displaced", 9.0, cause="stroke 3", predicate=Bilingual("偏左", "stands too far left"))
    second = fault("stroke_angle", 5.0, cause="stroke 3", predicate=Bilingual("斜了 9°", "is off by 9°"))
    (told,) = choose(worst, second)
    assert told.zh.startswith("displaced，又斜了 9°。")
    assert told.en.startswith("displaced, and is off by 9°.")


def test_of_one_stroke_a_fault_is_not_told_twice_in_other_words():
    long = fault("stroke_long", 9.0, cause="stroke 3", predicate=Bilingual("長了", "is too long"))
    out = fault("sticks_out", 5.0, cause="stroke 3", predicate=Bilingual("出頭", "sticks out"))
    (told,) = choose(long, out)
    assert "出頭" not in told.zh


@pytest.mark.parametrize("second", ["displaced", "entry_heavy"])
def test_where_a_turned_stroke_stands_and_how_it_begins_is_not_told_with_its_turn(second):
    turned = fault("stroke_angle", 9.0, cause="stroke 3", predicate=Bilingual("斜了 9°", "is off by 9°"))
    other = fault(second, 5.0, excess=4.0, cause="stroke 3", predicate=Bilingual("偏左", "too far left"))
    (told,) = choose(turned, other)
    assert "偏左" not in told.zh


def test_what_a_remark_tells_of_together_is_not_told_by_itself():
    single = [fault("stroke_heavy", 9.0 - n, cause=f"stroke {n}") for n in range(3)]
    covers = tuple((f.cause, "stroke_heavy") for f in single[:2])
    together = replace(fault("stroke_heavy", 8.0, cause="weight"), covers=covers)
    told, untold = choose_remarks([*single, together], parts={}, limits=LIMITS)
    assert [remark.severity for remark in told] == [8.0, 7.0]
    assert [remark.severity for remark in untold] == [9.0, 8.0]


def test_the_same_advice_does_not_end_two_remarks():
    told = choose(*(fault(f"k{n}", 9.0 - n) for n in range(3)))
    assert [remark.zh for remark in told] == ["k0。看清範本。", "k1。慢些寫。", "k2。"]


def test_size_place_and_lean_do_not_come_first_and_only_one_of_them_is_told():
    told = choose(fault("size", 20.0), fault("offset", 15.0), fault("displaced", 8.5))
    assert kinds(told) == ["displaced", "size"]
    assert told[0].severity > told[1].severity
    assert kinds(choose(fault("size", 20.0))) == ["size"]


@pytest.mark.parametrize(
    ("part", "kind"), [("ink", "heavy"), ("brushwork", "rough"), ("structure", "spacing")]
)
def test_a_low_part_is_explained_even_by_a_small_fault(part, kind):
    found = [fault("size", 12.0), *(fault("blank", 11.0 - n, cause=f"c{n}") for n in range(3))]
    small = fault(kind, 2.0, excess=0.6)
    assert kind not in kinds(choose(*found, small))
    told = choose(*found, small, **{part: 40.0})
    assert kind in kinds(told) and len(told) == 3


def test_one_remark_may_explain_two_low_parts():
    told = choose(fault("heavy", 6.0), fault("rough", 5.0), fault("size", 9.0), ink=20.0, brushwork=30.0)
    assert "heavy" in kinds(told)


def test_a_fault_twice_as_large_is_graver_but_not_twice():
    small, large = (severity("angle", size, 3.0) for size in (3.0, 6.0))
    assert small < large < 2 * small


def test_every_kind_that_explains_a_part_has_a_name_for_readers():
    for kind in itertools.chain(*PARTS_OF_KINDS.values()):
        assert kind_name(kind).en != kind, kind


def all_advice():
    for advice in itertools.chain(WHOLE.values(), *(kinds.values() for kinds in STROKES.values())):
        yield from advice


def test_advice_is_a_sentence_in_both_languages_and_no_two_are_the_same():
    every = list(all_advice())
    assert len({words.zh for words in every}) == len(every)
    for zh, en in every:
        assert zh.endswith("。") and not any(c.isascii() for c in zh), zh
        assert en.endswith(".") and en.isascii() and en[0].isupper(), en


def test_advice_speaks_the_words_of_teaching_books():
    text = "".join(words.zh for words in all_advice())
    for word in ("藏鋒", "露鋒", "中鋒", "提按", "頓筆", "回鋒", "鋪毫", "逆"):
        assert word in text, word


def test_advice_depends_on_the_kind_of_stroke_and_the_way_it_turned():
    down, up = (for_stroke("stroke_angle", f"橫 {way}")[0] for way in ("clockwise", "anticlockwise"))
    assert down != up
    assert for_stroke("exit_blunt", "撇")[0] != for_stroke("exit_blunt", "橫")[0]
    assert for_stroke("stroke_long", "橫折鉤")[0] == for_stroke("stroke_long", "橫")[0]
    assert all(for_stroke(kind, "曲筆") for kind in STROKES)


def test_thresholds_are_what_the_eye_notices():
    assert (LIMITS.lean, LIMITS.turn) == (3.0, 3.0)
    assert (LIMITS.size, LIMITS.length) == (0.08, 0.08)
    assert LIMITS.at_most == 3
    assert np.isclose(LIMITS.offset, 0.04)
