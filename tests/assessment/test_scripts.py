"""The interval by script: only regular script was marked by people."""

from __future__ import annotations

import pytest

from rumu.assessment.scripts import SCRIPTS, WIDENED, checked_script, interval_note, widening
from rumu.errors import CalibrationError


def test_only_regular_script_is_covered():
    assert {script: widening(script) for script in (*SCRIPTS, None)} == {
        **dict.fromkeys(SCRIPTS, WIDENED),
        "regular": 1.0,
        None: 1.0,
    }
    assert interval_note("regular") is None
    assert "too narrow" in interval_note(None).en


@pytest.mark.parametrize("script", [script for script in SCRIPTS if script != "regular"])
def test_what_is_not_covered_is_said_in_both_languages(script):
    note = interval_note(script)
    assert script in note.en and f"{WIDENED:g} times" in note.en
    assert "沒有真人評分" in note.zh and f"{WIDENED:g} 倍" in note.zh


@pytest.mark.parametrize("script", ["Regular", "kai", "", 3])
def test_another_script_is_refused(script):
    with pytest.raises(CalibrationError, match="mine: expected one of seal, clerical, regular, running, cur"):
        checked_script(script, name="mine")
    assert [checked_script(known) for known in (*SCRIPTS, None)] == [*SCRIPTS, None]
