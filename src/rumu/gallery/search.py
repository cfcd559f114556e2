"""Which master is this a copy of: every master is described once, a copy is then found among thousands.

The descriptions lie in RUMU_HOME/indices, one file for each set of masters. A master is described anew only
when its content changed; names, sizes and times tell quickly that nothing did.
"""

from __future__ import annotations

import hashlib
import os
import warnings
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rumu.errors import GalleryError, OutputError, RumuError
from rumu.executors import in_order
from rumu.gallery.gallery import user_home
from rumu.gallery.masters import Master, Places, read_masters
from rumu.registration.descriptor import (
    VERSION,
    DescriptorSettings,
    describe,
    from_bytes,
    likeness,
    to_bytes,
)
from rumu.registration.points import sample_points

if TYPE_CHECKING:
    from rumu.pipeline import SurfaceLike

Progress = Callable[[int, int], None]

_LENGTH = DescriptorSettings().length
_FEW = 50  # described before another process would have started


@dataclass(frozen=True, slots=True)
class Match:
    """One master that may be the one.

    likeness: up to 1 for the same outline, about 0 for any two characters.
    """

    master: Master
    likeness: float


@dataclass(frozen=True, slots=True, eq=False)
class MasterIndex:
    """Masters with their descriptions.

    vectors: (N, L) uint8, one row for each of `masters`. left_out: masters that cannot be described, and why.
    """

    masters: tuple[Master, ...]
    vectors: np.ndarray
    left_out: tuple[tuple[Master, str], ...] = ()

    def __post_init__(self) -> None:
        if self.vectors.shape != (len(self.masters), _LENGTH):
            raise GalleryError(
                f"expected descriptions of ({len(self.masters)}, {_LENGTH}), got {self.vectors.shape}"
            )


def find(
    copy: SurfaceLike, masters: Places | MasterIndex, *, top: int = 10, progress: Progress | None = None
) -> tuple[Match, ...]:
    """The masters that a copy is most like, best first.

    copy: a path, an array or a Surface. masters: a folder of pictures, a labels.csv, several of these, or an
        index from `index_masters`. The first search through a set describes each of its masters, some 25 ms
        each, and keeps that. progress: called with (done, total) meanwhile.
    Likeness is of outlines: the same character by another hand is found, and one that looks alike is near.
    Raises RefusedImage for a copy without writing, GalleryError for masters that are not there.
    """
    if top < 1:
        raise GalleryError(f"top: expected 1 or more, got {top}")
    from rumu.pipeline import surface_of

    vector = describe(sample_points(surface_of(copy)))
    index = masters if isinstance(masters, MasterIndex) else index_masters(masters, progress=progress)
    alike = likeness(vector, from_bytes(index.vectors))
    best = np.argsort(-alike, kind="stable")[:top]
    return tuple(Match(index.masters[k], float(alike[k])) for k in best)


def index_masters(places: Places, *, jobs: int = 1, progress: Progress | None = None) -> MasterIndex:
    """Describe the masters of a place (see `read_masters`), or read what was kept of them.

    jobs: processes; more than one needs a script that can be imported, as multiprocessing does.
    Raises GalleryError when there are none, or none that holds writing. Where RUMU_HOME cannot be written a
    warning says so and nothing is kept.
    """
    masters = read_masters(places)
    paths = [str(master.path.resolve()) for master in masters]
    file = _file_of(paths)
    kept = _Table.read(file)
    stamps = np.array([_stamp(path) for path in paths], dtype=np.int64)
    if kept is None or not kept.holds(paths, stamps):
        kept = _described(paths, stamps, kept=kept, jobs=jobs, progress=progress)
        try:
            kept.write(file)
        except OutputError as error:
            warnings.warn(f"the descriptions of the masters are not kept: {error}", UserWarning, stacklevel=2)
    return _index(masters, kept)


def _index(masters: Sequence[Master], table: _Table) -> MasterIndex:
    fine = np.array([reason == "" for reason in table.reasons], dtype=bool)
    if not fine.any():
        raise GalleryError(f"none of {len(masters)} masters holds writing; the first: {table.reasons[0]}")
    pairs = list(zip(masters, table.reasons, strict=True))
    return MasterIndex(
        masters=tuple(master for master, reason in pairs if reason == ""),
        vectors=table.vectors[fine],
        left_out=tuple((master, str(reason)) for master, reason in pairs if reason != ""),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Table:
    """What is kept of a set of masters, one row each: where, size and time, content, vector or why none."""

    paths: np.ndarray
    stamps: np.ndarray
    digests: np.ndarray
    vectors: np.ndarray
    reasons: np.ndarray

    def holds(self, paths: list[str], stamps: np.ndarray) -> bool:
        """Whether these are the same files, unchanged as far as size and time tell."""
        return len(paths) == len(self.paths) and bool(
            np.array_equal(self.stamps, stamps) and self.paths.tolist() == paths
        )

    @staticmethod
    def read(file: Path) -> _Table | None:
        """What was kept, or None when there is nothing that can be used."""
        try:
            with np.load(file, allow_pickle=False) as kept:
                if int(kept["version"]) != VERSION:
                    return None
                return _Table(*(kept[name] for name in _Table.__slots__))
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
            return None  # not there, of an older rumu, or cut short: it is made anew

    def write(self, file: Path) -> None:
        """Whole or not at all."""
        from rumu.outputs import whole_file

        with whole_file(file) as part, part.open("wb") as stream:
            np.savez(stream, version=VERSION, **{name: getattr(self, name) for name in self.__slots__})


def _file_of(paths: list[str]) -> Path:
    name = hashlib.sha256("\n".join(paths).encode()).hexdigest()[:16]
    return user_home() / "indices" / f"{name}.npz"


def _stamp(path: str) -> tuple[int, int]:
    try:
        found = os.stat(path)  # noqa: PTH116  a Path for each of 10,000 files takes longer than the search
    except OSError:
        return -1, -1
    return found.st_size, found.st_mtime_ns


def _described(
    paths: list[str], stamps: np.ndarray, *, kept: _Table | None, jobs: int, progress: Progress | None
) -> _Table:
    """Every master's row; those whose content is among the kept ones are taken from there."""
    digests = [_digest(path) for path in paths]
    known: dict[str, tuple[Any, str]] = {}
    if kept is not None:
        known = {
            str(d): (v, str(r)) for d, v, r in zip(kept.digests, kept.vectors, kept.reasons, strict=True)
        }
    new = [k for k, digest in enumerate(digests) if digest not in known or not digest]
    processes = jobs if len(new) > _FEW else 1
    rows = [known.get(digest, (np.zeros(_LENGTH, np.uint8), "")) for digest in digests]
    for done, (k, row) in enumerate(
        zip(new, in_order(_row, (paths[k] for k in new), processes=processes), strict=True)
    ):
        rows[k] = row
        if progress is not None:
            progress(done + 1, len(new))
    return _Table(
        paths=np.array(paths),
        stamps=stamps,
        digests=np.array(digests),
        vectors=np.stack([vector for vector, _ in rows]),
        reasons=np.array([reason for _, reason in rows]),
    )


def _digest(path: str) -> str:
    """Of the content; '' for what cannot be read, which is then never taken for known."""
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()
    except OSError:
        return ""


def _row(path: str) -> tuple[np.ndarray, str]:
    """The vector of one master as bytes, and ''; or zeros and the reason why there is none."""
    from rumu.pipeline import surface_of

    try:
        vector = describe(sample_points(surface_of(path)))
    except RumuError as error:
        return np.zeros(_LENGTH, np.uint8), " ".join(str(error).split())
    return to_bytes(vector), ""
