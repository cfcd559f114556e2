"""Where what rumu keeps for a person lies: RUMU_HOME, or the platform's folder for application data."""

from __future__ import annotations

import os
import sys
from pathlib import Path


def user_home() -> Path:
    """The folder; it need not exist yet."""
    chosen = os.environ.get("RUMU_HOME")
    if chosen:
        return Path(chosen)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local")) / "rumu"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Application Support" / "rumu"
    return Path(os.environ.get("XDG_DATA_HOME", Path.home() / ".local" / "share")) / "rumu"
