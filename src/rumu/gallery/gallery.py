"""A gallery: a database with what is known of its works, and a store with their files."""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rumu.database.engine import Database
    from rumu.gallery.store import Store


@dataclass(frozen=True, slots=True)
class Gallery:
    """database: what is known of the works. store: their files."""

    database: Database
    store: Store


def user_home() -> Path:
    """The folder for a person's data: RUMU_HOME, or the platform's folder for application data.

    It need not exist yet.
    """
    chosen = os.environ.get("RUMU_HOME")
    if chosen:
        return Path(chosen)
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local")) / "rumu"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Application Support" / "rumu"
    return Path(os.environ.get("XDG_DATA_HOME", Path.home() / ".local" / "share")) / "rumu"
