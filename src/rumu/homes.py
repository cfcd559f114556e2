"""Where a person's data lie: RUMU_HOME, RUMU_DATABASE and RUMU_FILES, or the platform's usual folder."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from rumu.errors import OutputError


def user_home() -> Path:
    """The folder for a person's data: RUMU_HOME, or the platform's folder for application data. Absolute.

    It need not exist yet. Raises OutputError when it cannot be a folder.
    """
    chosen = os.environ.get("RUMU_HOME", "").strip()
    if chosen:
        return _check_folder(expand_path(chosen, name="RUMU_HOME"), name="RUMU_HOME")
    if sys.platform == "win32":
        base = os.environ.get("LOCALAPPDATA") or "~/AppData/Local"
    elif sys.platform == "darwin":
        base = "~/Library/Application Support"
    else:
        base = os.environ.get("XDG_DATA_HOME") or "~/.local/share"
    return _check_folder(expand_path(base, name="the home folder") / "rumu", name="the folder for data")


def database_place(given: str | Path | None = None) -> str:
    """The database: as given, else as RUMU_DATABASE says, else in `user_home`; a URL stays as it is."""
    return _place(given, "RUMU_DATABASE", "rumu.sqlite")


def files_place(given: str | Path | None = None) -> str:
    """The folder or URL of the files: as given, else as RUMU_FILES says, else in `user_home`."""
    return _place(given, "RUMU_FILES", "files")


def expand_path(text: str, *, name: str) -> Path:
    """The absolute path of a text that may begin with ~ or ~somebody. name: of what holds it.

    Raises OutputError when nobody is called so.
    """
    try:
        return Path(os.path.abspath(Path(text).expanduser()))  # noqa: PTH100  keeps links as they are
    except (RuntimeError, ValueError) as error:
        raise OutputError(
            f"{name}={text}: expected a path, it cannot be read as one ({error})",
            zh=f"{name} 的路徑不對（{error}）。",
        ) from error


def _place(given: str | Path | None, variable: str, usual: str) -> str:
    chosen = str(given or os.environ.get(variable, "")).strip()
    if not chosen:
        return str(user_home() / usual)
    return chosen if "://" in chosen else str(expand_path(chosen, name=variable))


def _check_folder(folder: Path, *, name: str) -> Path:
    """The folder, if it is one or can become one: nothing else stands at it or above it."""
    for path in (folder, *folder.parents):
        try:
            if path.is_dir():
                return folder
            if path.exists() or path.is_symlink():
                raise OutputError(
                    f"{name}={folder}: expected a folder, but {path} is none",
                    zh=f"{name} 應該是資料夾，卻不是。",
                )
        except OSError as error:  # a loop of links, or a folder that may not be entered
            raise OutputError(
                f"{name}={folder}: cannot be used ({error.strerror})",
                zh=f"{name} 不能用（{error.strerror}）。",
            ) from error
    return folder
