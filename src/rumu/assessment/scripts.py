"""The five scripts, and how far the interval of a mark can be trusted in each."""

from __future__ import annotations

from typing import Literal, NamedTuple, get_args

from rumu.errors import CalibrationError

Script = Literal["seal", "clerical", "regular", "running", "cursive"]
SCRIPTS: tuple[Script, ...] = get_args(Script)

WIDENED = 1.5
"""The interval of a script that no human marks cover, over that of regular script: a declared convention,
since there is nothing to measure it on."""

_NAMES: dict[Script, str] = {
    "seal": "篆書",
    "clerical": "隸書",
    "regular": "楷書",
    "running": "行書",
    "cursive": "草書",
}


class Note(NamedTuple):
    """One sentence or more in both languages."""

    en: str
    zh: str


def checked_script(script: str | None, *, name: str = "script") -> Script | None:
    """The script, or None where it is not known. Raises CalibrationError that names the five."""
    for known in SCRIPTS:
        if script == known:
            return known
    if script is None:
        return None
    raise CalibrationError(f"{name}: expected one of {', '.join(SCRIPTS)}, got {script!r}")


def widening(script: Script | None) -> float:
    """By how much the panel's interval is widened for a script."""
    return 1.0 if script in (None, "regular") else WIDENED


def interval_note(script: Script | None) -> Note | None:
    """What must be said of the panel's interval for a script; None where it was measured on that script."""
    if script == "regular":
        return None
    if script is None:
        return Note(
            "The interval was measured on regular script; for other scripts it is too narrow.",
            "區間由楷書臨作測得；其他書體的區間應更寬。",
        )
    return Note(
        f"No human marks cover {script} script: the interval is that of regular script, widened {WIDENED:g} "
        "times by convention.",
        f"{_NAMES[script]}沒有真人評分：區間取自楷書，並按約定放寬為 {WIDENED:g} 倍。",
    )
