"""Find the master that a copy was written after, among thousands.

Each master is described once by a vector of its outline. The descriptions lie in RUMU_HOME/indices, one file
for each set of masters. A master is described again only when its content has changed; paths, sizes and times
of the files tell quickly that nothing has.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import warnings
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rumu.errors import GalleryError, ImageError, OutputError, RumuError
from rumu.executors import in_order
from rumu.gallery.masters import Master, MasterPaths, read_masters
from rumu.homes import user_home
from rumu.inputs import read_file
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
_FEW = 50  # masters that one process describes before another has started


@dataclass(frozen=True, slots=True)
class SearchResult:
    """A master that the copy may have been written after.

    likeness: up to 1 for the same outline, about 0 for two unrelated characters.
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
    copy: SurfaceLike, masters: MasterPaths | MasterIndex, *, top: int = 10, progress: Progress | None = None
) -> tuple[SearchResult, ...]:
    """Find the masters that a copy is most like.

    Parameters
    ----------
    copy
        A path, an (H, W) or (H, W, 3) array of an image in [0, 1], or a Surface.
    masters
        A folder of pictures, a labels.csv, several of these, or an index from
        `rumu.gallery.search.index_masters`.
    top
        The number of masters to return at most, 1 or more.
    progress
        Called with (done, total) while masters are described.

    Returns
    -------
    tuple of SearchResult
        The masters with their likeness, up to 1, the most alike first.

    Raises
    ------
    RefusedImage
        When the copy holds no writing.
    GalleryError
        When there are no such masters, none of them holds writing, or `top` is below 1.

    Notes
    -----
    The first search describes each master, which takes about 25 ms, and stores the descriptions in
    RUMU_HOME/indices. Outlines are compared, see `rumu.registration.descriptor`: the same character by
    another hand is found, and a character that looks similar is near.
    """
    if top < 1:
        raise GalleryError(f"top: expected 1 or more, got {top}")
    from rumu.pipeline import surface_of

    vector = describe(sample_points(surface_of(copy)))
    index = masters if isinstance(masters, MasterIndex) else index_masters(masters, progress=progress)
    alike = likeness(vector, from_bytes(index.vectors))
    best = np.argsort(-alike, kind="stable")[:top]
    return tuple(SearchResult(index.masters[k], float(alike[k])) for k in best)


def index_masters(paths: MasterPaths, *, jobs: int = 1, progress: Progress | None = None) -> MasterIndex:
    """Describe masters (see `read_masters` for their paths), or read the descriptions that are stored.

    jobs: processes; more than one needs a script that can be imported, as multiprocessing does.
    Raises GalleryError when there are none, or none that holds writing. Where RUMU_HOME cannot be written a
    warning says so and nothing is stored.
    """
    masters = read_masters(paths)
    files = [str(master.path.resolve()) for master in masters]
    name = hashlib.sha256("\n".join(files).encode()).hexdigest()[:16]
    table = None
    with contextlib.suppress(OutputError):  # said below
        table = _IndexTable.read(user_home() / "indices" / f"{name}.npz")
    stats = np.array([_size_and_time(file) for file in files], dtype=np.int64)
    if table is None or not table.matches(files, stats):
        table = _describe_masters(files, stats, stored=table, jobs=jobs, progress=progress)
        try:
            table.write(user_home() / "indices" / f"{name}.npz")
        except OutputError as error:
            warnings.warn(f"the descriptions of the masters are not kept: {error}", UserWarning, stacklevel=2)
    return _index(masters, table)


def _index(masters: Sequence[Master], table: _IndexTable) -> MasterIndex:
    described = np.array([reason == "" for reason in table.reasons], dtype=bool)
    if not described.any():
        raise GalleryError(f"none of {len(masters)} masters holds writing; the first: {table.reasons[0]}")
    pairs = list(zip(masters, table.reasons, strict=True))
    return MasterIndex(
        masters=tuple(master for master, reason in pairs if reason == ""),
        vectors=table.vectors[described],
        left_out=tuple((master, str(reason)) for master, reason in pairs if reason != ""),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _IndexTable:
    """The file of an index, one row for each master.

    paths: of the pictures. stamps: their sizes and times. digests: of their content. vectors: the
    descriptions. reasons: why a master has none, else ''.
    """

    paths: np.ndarray
    stamps: np.ndarray
    digests: np.ndarray
    vectors: np.ndarray
    reasons: np.ndarray

    def matches(self, paths: list[str], stats: np.ndarray) -> bool:
        """Whether these are the same files, unchanged as far as size and time tell."""
        return len(paths) == len(self.paths) and bool(
            np.array_equal(self.stamps, stats) and self.paths.tolist() == paths
        )

    @staticmethod
    def read(file: Path) -> _IndexTable | None:
        """The stored table, or None when there is none that can be used."""
        try:
            with np.load(file, allow_pickle=False) as stored:
                if int(stored["version"]) != VERSION:
                    return None
                return _IndexTable(*(stored[name] for name in _IndexTable.__slots__))
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
            return None  # missing, of an older version, or truncated: it is computed again

    def write(self, file: Path) -> None:
        """Write the file completely or not at all."""
        from rumu.outputs import whole_file

        with whole_file(file) as part, part.open("wb") as stream:
            np.savez(stream, version=VERSION, **{name: getattr(self, name) for name in self.__slots__})


def _size_and_time(path: str) -> tuple[int, int]:
    try:
        stat = os.stat(path)  # noqa: PTH116  a Path for each of 10,000 files takes longer than the search
    except OSError:
        return -1, -1
    return stat.st_size, stat.st_mtime_ns


def _describe_masters(
    paths: list[str],
    stats: np.ndarray,
    *,
    stored: _IndexTable | None,
    jobs: int,
    progress: Progress | None,
) -> _IndexTable:
    """The rows of all masters; those whose content is in the stored table are taken from there."""
    digests = [_content_digest(path) for path in paths]
    known: dict[str, tuple[Any, str]] = {}
    if stored is not None:
        columns = zip(stored.digests, stored.vectors, stored.reasons, strict=True)
        known = {str(digest): (vector, str(reason)) for digest, vector, reason in columns}
    new = [k for k, digest in enumerate(digests) if digest not in known or not digest]
    processes = jobs if len(new) > _FEW else 1
    rows = [known.get(digest, (np.zeros(_LENGTH, np.uint8), "")) for digest in digests]
    described = in_order(_describe_master, (paths[k] for k in new), processes=processes)
    for done, (k, row) in enumerate(zip(new, described, strict=True), start=1):
        rows[k] = row
        if progress is not None:
            progress(done, len(new))
    return _IndexTable(
        paths=np.array(paths),
        stamps=stats,
        digests=np.array(digests),
        vectors=np.stack([vector for vector, _ in rows]),
        reasons=np.array([reason for _, reason in rows]),
    )


def _content_digest(path: str) -> str:
    """SHA-256 of a file; '' if it cannot be read, which never counts as known."""
    try:
        return hashlib.sha256(read_file(path, error_type=ImageError)).hexdigest()
    except ImageError:
        return ""


def _describe_master(path: str) -> tuple[np.ndarray, str]:
    """The vector of a master as bytes and '', or zeros and the reason why there is none."""
    from rumu.pipeline import surface_of

    try:
        vector = describe(sample_points(surface_of(path)))
    except RumuError as error:
        return np.zeros(_LENGTH, np.uint8), " ".join(str(error).split())
    return to_bytes(vector), ""
