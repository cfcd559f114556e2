"""The five scripts of Chinese calligraphy."""

from __future__ import annotations

from typing import Literal, get_args

from rumu.errors import CalibrationError

Script = Literal["seal", "clerical", "regular", "running", "cursive"]
SCRIPTS: tuple[Script, ...] = get_args(Script)

NAMES_ZH: dict[Script, str] = {
    "seal": "篆書",
    "clerical": "隸書",
    "regular": "楷書",
    "running": "行書",
    "cursive": "草書",
}


def check_script(script: str | None, *, name: str = "script") -> Script | None:
    """The script, or None where it is not known. Raises CalibrationError that names the five."""
    for known in SCRIPTS:
        if script == known:
            return known
    if script is None:
        return None
    raise CalibrationError(f"{name}: expected one of {', '.join(SCRIPTS)}, got {script!r}")
