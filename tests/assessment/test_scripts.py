"""The names of the five scripts."""

from __future__ import annotations

import pytest

from rumu.assessment.scripts import SCRIPTS, check_script
from rumu.errors import CalibrationError


@pytest.mark.parametrize("script", ["Regular", "kai", "", 3])
def test_another_script_is_refused(script):
    with pytest.raises(CalibrationError, match="mine: expected one of seal, clerical, regular, running, cur"):
        check_script(script, name="mine")
    assert [check_script(known) for known in (*SCRIPTS, None)] == [*SCRIPTS, None]
