"""Options that several commands share, and the checks that need more than a type."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

from rumu.errors import CalibrationError, GalleryError, ImageError
from rumu.inputs import read_json

AsJson = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on stdout and nothing else there.")
]


def finite(value: float) -> float:
    """For angles and lengths: 'nan' and 'inf' parse as numbers, but mean nothing here."""
    if not math.isfinite(value):
        raise typer.BadParameter(f"expected a number, got {value}")
    return value


def known_script_name(value: str | None) -> str | None:
    """One of the five scripts, or None."""
    from rumu.values import SCRIPTS  # not at the top: the command line starts without numpy

    if value is not None and value not in SCRIPTS:
        raise typer.BadParameter(f"{value!r} is not one of {', '.join(map(repr, SCRIPTS))}.")
    return value


def not_an_input(output: Path | None, *inputs: Path | str | None) -> None:
    """Refuse to write over what is read: a slip of the hand would lose the original."""
    if output is None:
        return
    for path in inputs:
        if path is not None and output.resolve() == Path(path).resolve():
            raise typer.BadParameter(f"{output} is an input and would be written over")


class _OnlyCheckingError(Exception):
    pass


def check_writable(writing: AbstractContextManager[Path]) -> None:
    """Enter `whole_file` or `whole_folder` and leave everything as it was.

    Raises OutputError now, when it cannot be written, rather than after minutes of work.
    """
    with contextlib.suppress(_OnlyCheckingError), writing:
        raise _OnlyCheckingError


def find_copy(name: str, *, root: Path) -> Path:
    """The file of a copy that a table names, relative to `root`.

    A name that stands there in composed or decomposed, traditional or simplified characters, in other case or
    with backslashes is found.
    """
    path = root / name
    if path.exists():
        return path
    from rumu.containment import FolderFiles
    from rumu.gallery.vocabulary import file_in_other_characters

    return FolderFiles(root).find(name) or file_in_other_characters(root, name) or path


class FoundMaster(NamedTuple):
    """The file or folder of a master; its script and what is written, where they are known."""

    path: Path
    script: str | None = None
    character: str | None = None


def find_master(master: str, *, root: Path | None = None) -> FoundMaster:
    """The file or folder of a master, and what is known of it.

    master: its path (relative to `root`), or the id of a starter work, which knows its script and character.
    Raises ImageError when it is neither.
    """
    path = Path(master) if root is None else find_copy(master, root=root)
    if path.exists():
        return FoundMaster(path)
    from rumu.gallery.starter import find_work

    try:
        work = find_work(master)
    except GalleryError as error:
        if Path(master).name != master or Path(master).suffix:
            raise ImageError(f"{path}: there is no such file") from error
        raise ImageError(f"{path}: there is no such file, and {error}") from error
    return FoundMaster(work.path, work.script, work.character)


def part_weights(text: str) -> Mapping[str, float]:
    """Weights of the parts: 'brushwork=50,structure=50,ink=0', or a JSON file of the same.

    Raises CalibrationError that says what was expected.
    """
    from rumu.assessment.calibration import check_weights

    if Path(text).suffix.lower() == ".json":
        return check_weights(_json_object(Path(text), of="weights"), name=text)
    pairs = [part.partition("=") for part in text.split(",")]
    if not all(sign for _, sign, _ in pairs) or len({name.strip() for name, _, _ in pairs}) < len(pairs):
        raise CalibrationError(
            f"weights {text!r}: expected brushwork=50,structure=50,ink=0 or the like, or a .json file"
        )
    return check_weights({name.strip(): value for name, _, value in pairs}, name="weights")


def level_cuts(name: str) -> Mapping[str, float]:
    """Cut-offs by the name of a set, or from a JSON file: {"excellent": 80, "good": 65, "medium": 50}.

    Raises CalibrationError that names the known sets, or what is wrong with the file.
    """
    from rumu.assessment.calibration import CUT_OFFS, check_cuts

    path = Path(name)
    if name not in CUT_OFFS and path.suffix.lower() != ".json":
        raise CalibrationError(f"levels {name!r}: expected one of {', '.join(CUT_OFFS)}, or a .json file")
    cuts = CUT_OFFS[name] if name in CUT_OFFS else check_cuts(_json_object(path, of="levels"), name=name)
    return {str(level): low for level, low in cuts.items()}


def _json_object(path: Path, *, of: str) -> Mapping[str, Any]:
    if not path.exists():
        raise CalibrationError(f"{path}: there is no such file")
    held = read_json(path, error_type=CalibrationError, expected=f"a JSON object of {of}")
    if not isinstance(held, dict):
        raise CalibrationError(f"{path}: expected a JSON object of {of}, got {type(held).__name__}")
    return held
