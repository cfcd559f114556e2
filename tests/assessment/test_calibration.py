"""From features to a mark: its order, its ends, its levels and what a teacher may set."""

from __future__ import annotations

import json
from dataclasses import asdict, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rumu.assessment.calibration import (
    CUT_OFFS,
    WIDENING,
    Charges,
    MarkingTerms,
    check_cuts,
    check_script,
    check_terms,
    check_weights,
    interval_note,
    level_of,
    load_calibration,
    mark_fields,
    panel,
    read_calibration,
    write_calibration,
)
from rumu.assessment.edges import EDGE_NUMBERS
from rumu.assessment.features import RESIDUALS, SIGNED_FEATURES, Features, Residuals
from rumu.errors import CalibrationError, OutputError, RumuError
from rumu.strokes.omissions import Region
from rumu.values import SCRIPTS

PERFECT = Features(Residuals(), lean=0.0, offset=0.0, size=0.0, weight=0.0)
COMMON = Residuals(0.2, 0.14, 0.18, 0.2, 0.12, 0.18, 0.26, 0.22, 0.28, 0.3, 0.17, 0.12, 0.1, 0.3)
residual = st.floats(0, 3)
all_residuals = st.builds(Residuals, *[residual] * len(RESIDUALS))


def plain() -> dict:
    return json.loads(json.dumps(asdict(panel())))


# the scale


def test_no_residual_can_raise_a_mark():
    calibration = panel()
    for scale in (calibration.scale, *calibration.parts.values()):
        bound = [w for name, w in zip(scale.names, scale.weights, strict=True) if name not in SIGNED_FEATURES]
        assert max(bound) <= 0
        assert min(bound) < 0
        assert min(scale.spread) > 0


@given(all_residuals, st.sampled_from(RESIDUALS), st.floats(0, 2))
def test_a_larger_residual_never_raises_the_score(r, name, more):
    worse = replace(r, **{name: getattr(r, name) + more})
    score = panel().score
    assert score(replace(PERFECT, residuals=worse)) <= score(replace(PERFECT, residuals=r)) + 1e-9


@given(all_residuals, st.lists(st.floats(-9, 9), min_size=EDGE_NUMBERS, max_size=EDGE_NUMBERS))
def test_scores_and_parts_stay_within_0_and_100(r, edges):
    features = replace(PERFECT, residuals=r, edges=tuple(edges))
    parts = panel().part_scores(features)
    assert set(parts) == {"brushwork", "structure", "ink"}
    for value in (panel().score(features), *parts.values()):
        assert 0 <= value <= 100


def test_a_perfect_copy_scores_100_and_is_excellent():
    assert panel().score(PERFECT) == pytest.approx(100.0)
    for cuts in CUT_OFFS.values():
        assert level_of(100.0, cuts=cuts) == "excellent"


def test_anchors_rise():
    for scale in (panel().scale, *panel().parts.values()):
        sums, marks = np.array(scale.anchors).T
        assert (np.diff(sums) > 0).all()
        assert (np.diff(marks) > 0).all()
        assert (marks[0], marks[-1]) == (0.0, 100.0)


def test_the_human_range_is_the_panels_own():
    """In the middle of the range a point of the scale is a point of the panel's mark."""
    from rumu.assessment.fitting import HUMAN_RANGE

    assert [pair for pair in panel().scale.anchors if pair[0] == pair[1]] == [(v, v) for v in HUMAN_RANGE]


def test_a_perfect_copy_has_perfect_parts():
    assert panel().part_scores(PERFECT) == pytest.approx({"brushwork": 100, "structure": 100, "ink": 100})


def test_full_writing_is_marked_up_within_reason():
    """People mark cramped writing down; a copy of twice the size earns no more than one a third larger."""
    r = COMMON
    large, same, small = (panel().score(replace(PERFECT, residuals=r, size=s)) for s in (0.2, 0.0, -0.2))
    assert small < same < large
    assert large - same == pytest.approx(same - small)
    assert large - same < 5
    assert panel().score(replace(PERFECT, residuals=r, size=0.7)) <= panel().score(
        replace(PERFECT, residuals=r, size=0.3)
    )


def test_strange_edges_count_only_so_far():
    """Beyond three standard deviations no mark has been seen."""
    far, farther = (
        panel().scale.weighted_sum(replace(PERFECT, edges=(e,) * EDGE_NUMBERS).vector())
        for e in (50.0, 500.0)
    )
    assert far == pytest.approx(farther)


# what registration repaired


@pytest.mark.parametrize(
    ("pose", "points"),
    [
        ({"lean": 10.0}, 0),
        ({"lean": 12.0}, 4),
        ({"lean": -12.0}, 4),
        ({"lean": 170.0}, 40),
        ({"offset": 0.15}, 0),
        ({"offset": 0.25}, 10),
        ({"offset": 0.9}, 40),
        ({"size": 0.5}, 0),
        ({"size": -0.3}, 0),
        ({"size": 0.7}, 8),
        ({"size": -0.5}, 8),
        ({"size": np.log(0.2)}, 40),
        ({"lean": 12.0, "offset": 0.25, "size": -0.5}, 22),
    ],
)
def test_pose_is_charged_apart_beyond_a_tolerance_up_to_a_cap(pose, points):
    features = replace(PERFECT, **pose)
    assert sum(Charges().pose_points(features).values()) == pytest.approx(points)
    score, uncharged = panel().score(features), panel().scale.read(features)
    assert score == pytest.approx(max(uncharged - points, 0.0))
    told = mark_fields(features, terms=MarkingTerms())["deductions"]
    assert sum(told.values()) == pytest.approx(points) and all(told.values()) and set(told) <= set(pose)


def faulty(strokes, *, kind="missing"):
    return replace(PERFECT, regions=(Region(kind, np.zeros((3, 2)), 0.1, strokes),))


def test_a_stroke_too_few_is_bad_and_less_of_it_smoothly_better():
    marks = [panel().score(faulty(strokes)) for strokes in np.linspace(0.0, 4.0, 41)]
    assert marks[0] == 100 and marks[-1] < 10
    assert (np.diff(marks[:31]) < 0).all() and (np.diff(marks) <= 0).all()
    assert panel().score(faulty(0.1)) == pytest.approx(75)
    assert panel().score(faulty(1.0)) < panel().score(faulty(0.5)) < CUT_OFFS["panel"]["medium"]


def test_a_stroke_too_many_costs_as_much_as_half_of_one_too_few_and_parts_of_it_in_small_steps():
    assert panel().score(faulty(1.0, kind="extra")) == pytest.approx(panel().score(faulty(0.5)))
    marks = [panel().score(faulty(strokes, kind="extra")) for strokes in np.linspace(0.0, 1.0, 11)]
    assert marks[5] == pytest.approx(60.3, abs=0.1)
    np.testing.assert_allclose(np.diff(marks)[3:], -35 / 7.5)  # below 72, where common copies are
    np.testing.assert_allclose(np.diff(marks)[:2], -11.2)
    assert panel().score(faulty(4.0, kind="extra")) < 20.0


def test_ink_too_much_does_not_make_up_for_a_missing_stroke():
    both = replace(PERFECT, regions=faulty(0.5).regions + faulty(0.2, kind="extra").regions)
    assert panel().score(both) == panel().score(faulty(0.5))


def test_a_bad_copy_pays_for_a_stroke_though_no_ceiling_is_near():
    bad = replace(PERFECT, residuals=replace(COMMON, bent=0.2, warped=0.16, directions=0.5))
    lacking = replace(bad, regions=(Region("missing", np.zeros((3, 2)), 0.01, 0.1),))
    assert panel().score(bad) < 60
    assert panel().score(lacking) == pytest.approx(panel().score(bad) - 1.5)


def test_ink_is_100_at_the_masters_weight_and_halves_by_quarters():
    ink = [
        panel().part_scores(replace(PERFECT, weight=w))["ink"]
        for w in (0.0, np.log(1.25), -np.log(1.25), 9.0)
    ]
    assert ink == pytest.approx([100, 50, 50, 0], abs=0.01)


# a teacher's own weights


EQUAL = {"brushwork": 1.0, "structure": 1.0, "ink": 1.0}


def test_own_weights_make_the_mean_of_the_parts():
    copy = replace(PERFECT, residuals=COMMON, weight=np.log(1.25))
    parts = panel().part_scores(copy)
    assert panel().score(copy, weights=EQUAL) == pytest.approx(np.mean(list(parts.values())))
    for name, part in parts.items():
        alone = dict.fromkeys(EQUAL, 0.0) | {name: 3.0}
        assert panel().score(copy, weights=alone) == pytest.approx(part)


def test_own_weights_stand_under_the_same_charges_and_ceiling():
    leaning = replace(PERFECT, lean=Charges().lean_free + 3.0)
    lacking = faulty(0.5)
    assert panel().score(leaning, weights=EQUAL) == pytest.approx(94.0)
    assert panel().score(lacking, weights=EQUAL) == pytest.approx(37.0)
    assert panel().score(PERFECT, weights=EQUAL) == pytest.approx(100.0)


@pytest.mark.parametrize(
    "weights",
    [
        {},
        {"brushwork": 1, "structure": 1},
        EQUAL | {"taste": 1},
        EQUAL | {"ink": -1},
        dict.fromkeys(EQUAL, 0),
        EQUAL | {"ink": "much"},
        EQUAL | {"ink": float("nan")},
        EQUAL | {"structure": float("inf")},
    ],
)
def test_other_weights_are_refused_by_name(weights):
    with pytest.raises(CalibrationError, match=r"^mine: expected weights of brushwork, structure, ink, each"):
        check_weights(weights, name="mine")


# interval and levels


@pytest.mark.parametrize("score", [0.0, 3.0, 50.0, 97.0, 100.0])
def test_the_interval_holds_the_score_and_stays_on_the_scale(score):
    low, high = panel().interval_of(score)
    assert 0 <= low <= score <= high <= 100
    assert high - low > 10


def test_an_interval_is_widened_about_the_score():
    low, high = panel().interval
    assert panel().interval_of(50.0, widened=1.5) == pytest.approx((50 + 1.5 * low, 50 + 1.5 * high))
    assert panel().interval_of(98.0, widened=1.5)[1] == 100.0


def test_a_copy_stands_somewhere_among_learners_copies():
    standing = panel().standing
    assert panel().percentile_of(standing[0] - 1) == 0 and panel().percentile_of(standing[-1] + 1) == 100
    assert panel().percentile_of(float(np.median(standing))) == pytest.approx(50, abs=3)
    shares = [panel().percentile_of(cut) for cut in CUT_OFFS["panel"].values()]
    assert shares == pytest.approx([88, 59, 25], abs=6)  # an eighth is excellent, a quarter bad
    for terms in (MarkingTerms(weights=EQUAL), MarkingTerms(calibration=replace(panel(), standing=()))):
        assert mark_fields(COPY, terms=terms)["percentile"] is None
    mark = mark_fields(COPY, terms=MarkingTerms())
    assert mark["percentile"] == panel().percentile_of(mark["score"])


def test_levels_by_name():
    for cuts in CUT_OFFS.values():
        assert list(cuts) == ["excellent", "good", "medium"]
        for level, lowest in cuts.items():
            assert level_of(lowest, cuts=cuts) == level
            assert level_of(lowest - 1e-6, cuts=cuts) != level
        assert level_of(0.0, cuts=cuts) == "bad"
    assert CUT_OFFS["rubric"] == {"excellent": 87.5, "good": 72.5, "medium": 52.5}
    assert [level_of(s, cuts=CUT_OFFS["rubric"]) for s in (90, 80, 60, 50)] == [
        "excellent",
        "good",
        "medium",
        "bad",
    ]


def test_all_four_levels_are_in_use_on_human_marks(data):
    from rumu_lab.experiments.marked_copies import read_copies
    from rumu_lab.experiments.protocol import declared

    levels = [level_of(copy.mark, cuts=declared().cut_offs) for copy in read_copies(data)]
    shares = {level: levels.count(level) / len(levels) for level in (*CUT_OFFS["panel"], "bad")}
    assert min(shares.values()) > 0.08, shares
    assert max(shares.values()) < 0.5, shares


def test_a_teachers_levels_are_taken():
    cuts = check_cuts({"good": "60", "excellent": 80, "medium": 40}, name="mine")
    assert cuts == {"excellent": 80.0, "good": 60.0, "medium": 40.0}
    assert level_of(79, cuts=cuts) == "good"


@pytest.mark.parametrize(
    "cuts",
    [
        {},
        {"excellent": 80, "good": 60},
        {"excellent": 80, "good": 60, "medium": 40, "bad": 0},
        {"excellent": 60, "good": 80, "medium": 40},
        {"excellent": 80, "good": 80, "medium": 40},
        {"excellent": 101, "good": 60, "medium": 40},
        {"excellent": 80, "good": 60, "medium": -1},
        {"excellent": "high", "good": 60, "medium": 40},
        {"excellent": float("nan"), "good": 60, "medium": 40},
        {"excellent": None, "good": 60, "medium": 40},
    ],
)
def test_other_levels_are_refused_by_name(cuts):
    with pytest.raises(
        CalibrationError, match=r"^mine: expected cut-offs 100 >= excellent > good > medium >= 0, got "
    ):
        check_cuts(cuts, name="mine")


# reading and writing


def test_a_calibration_comes_back_from_its_file(tmp_path):
    write_calibration(panel(), tmp_path / "mine.json")
    again = read_calibration(json.loads((tmp_path / "mine.json").read_text("utf-8")))
    assert again == panel()


def test_it_says_what_it_was_fitted_on():
    for word in ("810", "E3C", "2023", "mean times ten"):
        assert word in panel().provenance


@pytest.mark.parametrize("lost", ["scale", "parts", "interval", "provenance"])
def test_a_calibration_that_is_not_whole_is_refused(lost):
    cut = plain()
    del cut[lost]
    with pytest.raises(CalibrationError, match=f"expected a calibration with scale, .*{lost}"):
        read_calibration(cut)


@pytest.mark.parametrize(
    ("key", "value"),
    [("interval", ["low", "high"]), ("parts", {"structure": {}}), ("scale", {})],
)
def test_a_calibration_of_wrong_things_is_refused(key, value):
    with pytest.raises(RumuError, match="expected a calibration with"):
        read_calibration(plain() | {key: value})


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"names": ["position", "taste"]}, "taste"),
        ({"weights": [-1.0]}, "inhomogeneous|one finite"),
        ({"spread": [1.0, 0.0]}, "spreads above 0"),
        ({"mean": float("nan")}, "one finite"),
        ({"anchors": [[0, 0], [50, 60], [40, 100]]}, "anchors that rise"),
        ({"anchors": [[0, 0]]}, "anchors that rise"),
    ],
)
def test_a_scale_that_cannot_be_read_off_is_refused(change, words):
    scale = {
        "names": ["position", "whole"],
        "centre": [-1.5, -1.2],
        "spread": [0.3, 0.3],
        "weights": [-2.0, -3.0],
        "mean": 50.0,
        "anchors": [[0, 0], [100, 100]],
    }
    read_calibration(plain() | {"scale": scale})
    with pytest.raises(CalibrationError, match=words):
        read_calibration(plain() | {"scale": scale | change})
    with pytest.raises(CalibrationError, match="expected low <= 0 <= high"):
        read_calibration(plain() | {"interval": [5, 9]})


def test_a_calibration_is_loaded_by_name_or_refused_by_name(tmp_path):
    write_calibration(panel(), tmp_path / "mine.json")
    assert load_calibration(tmp_path / "mine.json") == panel()
    (tmp_path / "mine.json").write_text("[]", "utf-8")
    with pytest.raises(CalibrationError, match=r"mine\.json: expected a calibration"):
        load_calibration(tmp_path / "mine.json")


def test_a_calibration_without_standing_is_read_and_one_that_falls_is_not():
    older = plain()
    del older["standing"]
    assert read_calibration(older).percentile_of(50.0) is None
    with pytest.raises(CalibrationError, match="scores that do not fall"):
        read_calibration(plain() | {"standing": [40.0, 30.0]})


def test_a_calibration_needs_a_place(tmp_path):
    (tmp_path / "taken").write_text("a file", "utf-8")
    with pytest.raises(OutputError, match="taken"):
        write_calibration(panel(), tmp_path / "taken" / "mine.json")


# on a teacher's terms


COPY = Features(COMMON, lean=0, offset=0, size=0, weight=0.1)


def test_without_terms_it_is_the_panel_s_mark():
    mark = mark_fields(COPY, terms=MarkingTerms())
    assert mark["score"] == panel().score(COPY)
    assert mark["interval"] == panel().interval_of(mark["score"])
    assert (mark["weights"], mark["calibration"], mark["script"]) == (None, None, None)
    assert mark["interval_note"] and mark["interval_note_zh"]


def test_regular_script_needs_no_note():
    mark = mark_fields(COPY, terms=MarkingTerms(script="regular"))
    assert (mark["interval_note"], mark["interval_note_zh"]) == (None, None)


def test_a_teacher_s_calibration_has_its_own_interval_whatever_the_script(tmp_path):
    """Its errors were measured on that teacher's marks, so the panel's want of other scripts is not its."""
    own = replace(panel(), interval=(-3.0, 4.0), provenance="mine")
    write_calibration(own, tmp_path / "own.json")
    for calibration in (own, tmp_path / "own.json", str(tmp_path / "own.json")):
        mark = mark_fields(COPY, terms=check_terms(calibration=calibration, script="seal"))
        assert mark["interval"] == pytest.approx((mark["score"] - 3, mark["score"] + 4))
        assert mark["calibration"] == "mine" and "seal" not in mark["interval_note"]


@pytest.mark.parametrize(
    "terms",
    [{"script": "printed"}, {"weights": {"ink": 1}}, {"levels": {}}, {"calibration": "gone.json"}],
    ids=lambda terms: next(iter(terms)),
)
def test_wrong_terms_are_refused(terms):
    with pytest.raises(CalibrationError, match=r"expected|no such file"):
        check_terms(**terms)


# the interval by script: only regular script was marked by people


def test_only_regular_script_is_covered():
    width = {}
    for script in (*SCRIPTS, None):
        fields = mark_fields(PERFECT, terms=MarkingTerms(script=script, calibration=None))
        low, _ = fields["interval"]
        width[script] = (fields["score"] - low) / -panel().interval[0]
    expected = {**dict.fromkeys(SCRIPTS, WIDENING), "regular": 1.0, None: 1.0}
    assert width == pytest.approx(expected)
    assert interval_note("regular") is None
    assert "too narrow" in interval_note(None).en


@pytest.mark.parametrize("script", ["Regular", "kai", "", 3])
def test_another_script_is_refused(script):
    with pytest.raises(CalibrationError, match="mine: expected one of seal, clerical, regular, running, cur"):
        check_script(script, name="mine")
    assert [check_script(known) for known in (*SCRIPTS, None)] == [*SCRIPTS, None]


@pytest.mark.parametrize("script", [script for script in SCRIPTS if script != "regular"])
def test_what_is_not_covered_is_said_in_both_languages(script):
    note = interval_note(script)
    assert script in note.en and f"{WIDENING:g} times" in note.en
    assert "沒有真人評分" in note.zh and f"{WIDENING:g} 倍" in note.zh
