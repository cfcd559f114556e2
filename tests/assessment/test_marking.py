"""From features to the fields of a mark, on a teacher's terms."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rumu.assessment.calibration import panel, write_calibration
from rumu.assessment.features import Features, Residuals
from rumu.assessment.marking import Terms, checked_terms, mark_fields
from rumu.errors import CalibrationError

COPY = Features(
    Residuals(0.2, 0.14, 0.18, 0.2, 0.12, 0.18, 0.26, 0.22, 0.28, 0.3), lean=0, offset=0, size=0, weight=0.1
)


def test_without_terms_it_is_the_panel_s_mark():
    mark = mark_fields(COPY, terms=Terms())
    assert mark["score"] == panel().score(COPY)
    assert mark["interval"] == panel().interval_of(mark["score"])
    assert (mark["weights"], mark["calibration"], mark["script"]) == (None, None, None)
    assert mark["interval_note"] and mark["interval_note_zh"]


def test_regular_script_needs_no_note():
    mark = mark_fields(COPY, terms=Terms(script="regular"))
    assert (mark["interval_note"], mark["interval_note_zh"]) == (None, None)


def test_a_teacher_s_calibration_has_its_own_interval_whatever_the_script(tmp_path):
    """Its errors were measured on that teacher's marks, so the panel's want of other scripts is not its."""
    own = replace(panel(), interval=(-3.0, 4.0), provenance="mine")
    write_calibration(own, tmp_path / "own.json")
    for given in (own, tmp_path / "own.json", str(tmp_path / "own.json")):
        mark = mark_fields(COPY, terms=checked_terms(calibration=given, script="seal"))
        assert mark["interval"] == pytest.approx((mark["score"] - 3, mark["score"] + 4))
        assert mark["calibration"] == "mine" and "seal" not in mark["interval_note"]


@pytest.mark.parametrize(
    "terms",
    [{"script": "printed"}, {"weights": {"ink": 1}}, {"levels": {}}, {"calibration": "gone.json"}],
    ids=lambda terms: next(iter(terms)),
)
def test_wrong_terms_are_refused(terms):
    with pytest.raises(CalibrationError, match=r"expected|no such file"):
        checked_terms(**terms)
