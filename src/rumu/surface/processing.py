"""What a surface was made of, and how: so that it can be made again, and told whether it came out the same.

The record lies in surface.json under "processing": who made it, with which settings and which version, the
SHA-256 of every file that was read, and that of the arrays that came out.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from rumu.capture.lamp_files import LAMP_SUFFIXES
from rumu.errors import SurfaceError
from rumu.inputs import open_file, read_json
from rumu.surface.array_files import ARRAYS
from rumu.surface.folder import MARKER, Processing, read_surface
from rumu.values import Surface

_BLOCK = 2**20


@dataclass(frozen=True, slots=True)
class ResultComparison:
    """Two results of one processing.

    same: to the last bit. differs: the arrays that do not agree. largest: the largest difference of each of
    them, where both are there to be compared. versions: of rumu, then and now.
    """

    same: bool
    differs: tuple[str, ...]
    largest: Mapping[str, float]
    versions: tuple[str, str]


def record_processing(
    surface: Surface,
    *,
    settings: Mapping[str, Any],
    inputs: Mapping[str, str],
    made_by: str | None = None,
    lamps: Mapping[str, Any] | None = None,
    photographs: Mapping[str, Mapping[str, Any]] | None = None,
) -> Processing:
    """The record of a surface that was just made. inputs: see `digest_files`; the rest: see `Processing`."""
    made = datetime.now(UTC).isoformat(timespec="seconds")
    return Processing(
        dict(settings),
        dict(inputs),
        digest_surface(surface),
        version("rumu"),
        made,
        made_by,
        dict(lamps or {}),
        dict(photographs or {}),
    )


def digest_files(paths: Iterable[Path]) -> dict[str, str]:
    """The SHA-256 of files, by their absolute paths. Raises SurfaceError for one that cannot be read."""
    chosen = sorted({one.resolve() for one in paths})
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return dict(zip(map(str, chosen), pool.map(_digest_file, chosen), strict=True))


def _digest_file(path: Path) -> str:
    digest = hashlib.sha256()
    with open_file(path, error_type=SurfaceError) as file:
        while block := file.read(_BLOCK):
            digest.update(block)
    return digest.hexdigest()


def digest_surface(surface: Surface) -> dict[str, str]:
    """The SHA-256 of each array of a surface, by its name, of its bytes in little-endian order."""
    arrays = {name: np.ascontiguousarray(getattr(surface, name), "<f4") for name in ARRAYS}
    arrays["mask"] = np.ascontiguousarray(surface.mask).view(np.uint8)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        digests = pool.map(lambda one: hashlib.sha256(one.data).hexdigest(), arrays.values())
        return dict(zip(arrays, digests, strict=True))


def read_processing(path: str | Path) -> Processing:
    """The record in a surface.json, or in that of a folder.

    Raises SurfaceError when there is none, as in folders of earlier versions.
    """
    path = Path(path)
    file = path / MARKER if path.is_dir() else path
    content = read_json(file, error_type=SurfaceError, expected=f"a {MARKER}")
    record = content.get("processing") if isinstance(content, dict) else None
    try:
        told = dict(record or {})
        texts = [{str(k): str(v) for k, v in dict(told[name]).items()} for name in ("inputs", "result")]
        settings = {str(name): value for name, value in dict(told["settings"]).items()}
        inputs, result = texts
        version_then, made = str(told["version"]), str(told["made"])
        more = [dict(told.get(name) or {}) for name in ("lamps", "photographs")]
        return Processing(settings, inputs, result, version_then, made, told.get("made_by"), *more)
    except (KeyError, TypeError, ValueError) as error:
        raise SurfaceError(
            'expected a record of its "processing", which reconstruct writes, found none or a part of one',
            name=file,
        ) from error


def moved_record(record: Processing, *, place: Path) -> Processing:
    """The record of a capture that lies elsewhere by now.

    place: its folder, or its file of lamps. What was read from beside its earlier place is looked for beside
    this one, and left where it was when it is not there. Raises SurfaceError for a record without a capture.
    """
    told = record.settings.get("capture")
    if not isinstance(told, str):
        raise SurfaceError("expected a record that tells its capture, got one that does not")
    there, here = Path(told), place.resolve()
    by_file = place.is_file() or there.suffix.lower() in LAMP_SUFFIXES
    if by_file:
        here = here if here.is_file() else here / there.name
        there, folder = there.parent, here.parent
    else:
        folder = here

    def now(path: str) -> str:
        found = Path(os.path.normpath(folder / os.path.relpath(path, there)))
        return path if Path(path).exists() and not found.exists() else str(found)

    settings = {**record.settings, "capture": str(here)}
    if isinstance(settings.get("flat_field"), str):
        settings["flat_field"] = now(settings["flat_field"])
    return replace(record, settings=settings, inputs={now(path): sha for path, sha in record.inputs.items()})


def check_inputs(record: Processing) -> None:
    """Raise SurfaceError, naming them, where files that were read are gone or are other ones now."""
    gone = [path for path in record.inputs if not Path(path).is_file()]
    there = digest_files(Path(path) for path in record.inputs if path not in gone)
    other = [path for path, digest in record.inputs.items() if there.get(path, digest) != digest]
    moved = "; if the capture was moved, give its folder: rumu reconstruct FOLDER --again surface.json"
    faults = (("are not there any more", gone, moved), ("are not what they were", other, ""))
    for words, paths, hint in faults:
        if paths:
            names = ", ".join(Path(path).name for path in paths[:4]) + ("..." if len(paths) > 4 else "")
            raise SurfaceError(f"{len(paths)} of {len(record.inputs)} files {words}: {names}{hint}")


def compare_results(record: Processing, surface: Surface, *, earlier: Path) -> ResultComparison:
    """The surface beside the result that a record tells.

    earlier: the folder of that result, whose arrays are compared where they are still there as they were.
    """
    now = digest_surface(surface)
    differs = tuple(name for name, digest in now.items() if record.result.get(name) != digest)
    largest: dict[str, float] = {}
    if differs and (earlier / MARKER).is_file():
        old = read_surface(earlier)
        for name in differs:
            before, after = (np.asarray(getattr(one, name), np.float64) for one in (old, surface))
            if before.shape == after.shape:
                largest[name] = float(np.abs(before - after).max())
    return ResultComparison(not differs, differs, largest, (record.version, version("rumu")))
