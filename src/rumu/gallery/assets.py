"""The files of a work that everything else is computed from: its picture, photographs and surface.

They lie in the store under pictures/, captures/ and surfaces/, each under the digest of its content, so that
equal content is stored once. What is computed from them lies under derived/ and can be computed again.
Decoded pictures and surfaces stay in memory, in one cache for the whole process.
"""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import math
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cachetools import LRUCache, cached
from sqlalchemy import or_, select

from rumu.database.tables import Work
from rumu.errors import GalleryError, RefusedImage, SurfaceError
from rumu.gallery.store import PART_SUFFIX, Gallery, Store
from rumu.values import Bilingual
from rumu.workspaces import temporary_folder

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    from PIL.Image import Image as Picture

    from rumu.surface.surface_bands import SurfaceBands
    from rumu.values import Capture, Surface

VERSION = 5
"""Increase it when the derived files of the same assets would come out differently."""

MAX_PIXELS = 2400 * 2400  # a larger picture is reduced before its relief is computed
DAY = 86_400.0  # seconds
_DELETED_AT_ONCE = 500  # works whose files are looked for in one query, which reads the whole table
_FOLDERS = ("pictures", "captures", "surfaces")
_MAX_MEMORY = 512 * 2**20  # bytes of the cache
_WHOLE = Bilingual("這件作品的整個表面", "the whole surface of this work")
_WHOLE_BYTES = 60  # of one pixel while a surface is read: its arrays, and one of them as it is unpacked
_SURFACE_BYTES = 25  # of one pixel: height, normals, albedo and confidence of 32 bits, and a mask


@dataclass(frozen=True, slots=True, kw_only=True)
class Assets:
    """Functions that read what derived files are computed from.

    digest: of all that they depend on. picture_file: lends the picture as it was uploaded. surface: of a
    capture the reconstructed one, else the relief of the picture. capture: the photographs; None where there
    are none. measured: of a capture, its surface, to be read some rows at a time. The functions raise
    GalleryError when a file is missing, ImageError or RefusedImage when the picture cannot be used,
    SurfaceError for a whole surface that does not fit into memory.
    """

    digest: str
    picture_file: Callable[[], contextlib.AbstractContextManager[Path]]
    surface: Callable[[], Surface]
    capture: Callable[[], Capture] | None = None
    measured: Callable[[], contextlib.AbstractContextManager[SurfaceBands]] | None = None

    def overview(self) -> Surface:
        """The surface, at no more pixels than can be seen at once where a measured one has more."""
        return (
            self.surface() if self.measured is None else _overview(self.digest, self.measured, self.surface)
        )


def assets_of(store: Store, work: Work) -> Assets:
    """The assets of a work."""
    if work.surface is None or work.capture is None:
        return picture_assets(store, work.picture, method=work.height_source, spacing=work.spacing)
    return Assets(
        digest=_digest(work.picture, work.surface, work.capture),
        picture_file=partial(_stored_file, store, work.picture),
        surface=partial(_measured_surface, store, work.surface, work.capture),
        capture=partial(_read_capture, store, work.capture),
        measured=partial(_measured_bands, store, work.surface, work.capture),
    )


def picture_assets(
    store: Store, key: str, *, method: str = "inflation", spacing: float | None = None
) -> Assets:
    """The assets of a single picture in the store, such as a learner's copy.

    method: how its height is computed, 'inflation' or 'density'. spacing: mm per pixel, None if unknown.
    """
    return Assets(
        digest=_digest(key, method, spacing),
        picture_file=partial(_stored_file, store, key),
        surface=partial(_relief, store, key, method, spacing),
    )


def _digest(*parts: Any) -> str:
    return hashlib.sha256("\0".join(map(str, parts)).encode()).hexdigest()[:40]


def picture_key(data: bytes, *, suffix: str) -> str:
    """The key of a picture with this content. suffix: such as '.png', lower case."""
    digest = hashlib.sha256(data).hexdigest()
    return f"pictures/{digest[:2]}/{digest}{suffix}"


def capture_key(digest: str) -> str:
    """The key of the folder of a capture. digest: as `folder_digest` gives it."""
    return f"captures/{digest[:2]}/{digest}"


def surface_key(capture_digest: str, *, solver: str = "robust", rectify: str = "none") -> str:
    """The key of the folder of the surface that is reconstructed from a capture in this way."""
    digest = hashlib.sha256(f"{capture_digest} {solver} {rectify}".encode()).hexdigest()
    return f"surfaces/{digest[:2]}/{digest}"


def store_files(store: Store, key: str, files: Iterable[Path]) -> None:
    """Write files into a folder of the store, in this order; those that it has, as of another work, stay."""
    for file in files:
        if not store.exists(f"{key}/{file.name}"):
            with file.open("rb") as stream:
                store.write(f"{key}/{file.name}", stream)


def store_surface(store: Store, key: str, surface: Surface) -> None:
    """Write what `read_surface` needs into the store; pictures and meshes are derived when requested."""
    from rumu.surface.folder import FLOATS, MARKER, write_surface

    with temporary_folder() as temporary, store.whole_folder(key):
        write_surface(surface, temporary / "surface", files=FLOATS)
        # the description last, by which readers know that the others are there
        files = sorted((temporary / "surface").iterdir(), key=lambda path: path.name == MARKER)
        store_files(store, key, files)


def surface_files(store: Store, work: Work) -> list[str]:
    """The keys of the files of a reconstructed surface; none where relief is computed from the picture."""
    if work.surface is None or work.capture is None:
        return []
    _ensure_measured(store, work.surface, work.capture)
    return list(store.keys(work.surface))


def folder_digest(files: Mapping[str, Path]) -> str:
    """The digest of the files of a folder: of their names, by which they are given, and of their contents."""
    digest = hashlib.sha256()
    for name, path in sorted(files.items()):
        with path.open("rb") as stream:
            content = hashlib.file_digest(stream, "sha256")
        digest.update(name.encode() + b"\0" + content.digest())
    return digest.hexdigest()


def derived_folder(digest: str) -> str:
    """The key of the folder with the derived files of assets."""
    return f"derived/{digest[:2]}/{digest}"


# --- deletion --------------------------------------------------------------------------------------


def delete_files(gallery: Gallery, deleted: Sequence[Work]) -> None:
    """Delete the files of works whose rows are deleted, except those that another work shares."""
    for first in range(0, len(deleted), _DELETED_AT_ONCE):
        works = deleted[first : first + _DELETED_AT_ONCE]
        keys = [key for work in works for key in (work.picture, work.surface, work.capture) if key]
        shares_one = or_(Work.picture.in_(keys), Work.surface.in_(keys), Work.capture.in_(keys))
        with gallery.database.reading() as session:
            rows = session.execute(select(Work.picture, Work.surface, Work.capture).where(shares_one))
            used = {key for row in rows for key in row}
        for work in works:
            if work.picture not in used:
                gallery.store.delete(derived_folder(assets_of(gallery.store, work).digest))
        for key in keys:
            if key not in used:
                gallery.store.delete(key)


def delete_orphans(gallery: Gallery, *, older_than: float = DAY) -> int:
    """Delete files that belong to no work and files that were only partly written; their number.

    Such files remain when an import is interrupted. older_than: seconds; younger files may belong to a work
    that another process is adding, because files are written before rows.
    """
    with gallery.database.reading() as session:
        rows = session.execute(select(Work.picture, Work.surface, Work.capture)).all()
    used = {key for row in rows for key in row if key}
    count = 0
    for folder in (*_FOLDERS, "derived"):
        for key in list(gallery.store.keys(folder, older_than=older_than)):
            # a row names a picture by its own key, and files of a capture or surface by their folder
            is_orphan = folder in _FOLDERS and key not in used and key.rpartition("/")[0] not in used
            if is_orphan or key.endswith(PART_SUFFIX):
                gallery.store.delete_file(key)
                count += 1
    return count


# --- reading, and the cache ------------------------------------------------------------------------


def _bytes_in_memory(value: Surface | Picture) -> int:
    from rumu.values import Surface

    if isinstance(value, Surface):
        return int(value.height.size) * _SURFACE_BYTES
    return int(value.width * value.height * len(value.getbands()))


_cache: LRUCache[tuple[Any, ...], Any] = LRUCache(_MAX_MEMORY, getsizeof=_bytes_in_memory)
_cache_changed = threading.Condition()


@cached(_cache, condition=_cache_changed)
def _relief(store: Store, key: str, method: str, spacing: float | None) -> Surface:
    import numpy as np

    from rumu.capture.decoded_size import Reduction
    from rumu.capture.formats import decode
    from rumu.capture.image import image_of
    from rumu.surface.relief import relief

    with _stored_file(store, key) as path:
        stored = decode(path, reduction=Reduction(pixels=MAX_PIXELS))
        image = image_of(stored, name=path)
    try:
        surface = relief(image, method=method)  # type: ignore[arg-type]
    except RefusedImage as error:
        raise RefusedImage(error.en, reason=error.reason, name=Path(key).name, zh=error.zh) from None
    if spacing is None:
        return surface
    spacing *= max(stored.whole) / max(image.shape[:2])
    height = surface.height * np.float32(spacing)
    return dataclasses.replace(surface, height=height, spacing=spacing, unit="mm")


@cached(_cache, condition=_cache_changed)
def _measured_surface(store: Store, key: str, capture: str) -> Surface:
    """The whole surface with this key. Raises SurfaceError where it does not fit into memory."""
    from rumu.capture.memory_plan import check_memory
    from rumu.surface.folder import read_surface

    with _measured_bands(store, key, capture) as bands:
        height, width = bands.shape
        check_memory(height * width * _WHOLE_BYTES, what=_WHOLE, error_type=SurfaceError)
        return read_surface(bands.folder)


@contextlib.contextmanager
def _measured_bands(store: Store, key: str, capture: str) -> Iterator[SurfaceBands]:
    """The surface with this key, to be read some rows at a time."""
    from rumu.surface.surface_bands import SurfaceBands

    _ensure_measured(store, key, capture)
    with store.local(key) as folder:
        yield SurfaceBands(folder)


def _ensure_measured(store: Store, key: str, capture: str) -> None:
    """Reconstruct a surface from its photographs, and store it, when it is first needed."""
    from rumu.pipeline import reconstruct
    from rumu.surface.folder import MARKER

    if not store.exists(f"{key}/{MARKER}"):
        store_surface(store, key, reconstruct(_read_capture(store, capture)))


@cached(_cache, key=lambda digest, measured, whole: ("overview", digest), condition=_cache_changed)
def _overview(
    digest: str,
    measured: Callable[[], contextlib.AbstractContextManager[SurfaceBands]],
    whole: Callable[[], Surface],
) -> Surface:
    from rumu.surface.reduction import SHOWN

    with measured() as bands:
        height, width = bands.shape
        if height * width > SHOWN:
            return bands.reduced()
    return whole()


def _read_capture(store: Store, key: str) -> Capture:
    from rumu.capture.description import DESCRIPTION, read_description
    from rumu.capture.folder import read_capture

    with store.local(key) as folder:
        # Before captures said which way round they are, photographs were always turned as EXIF says.
        told = read_description(folder / DESCRIPTION).orientation
        return read_capture(folder, orientation="auto" if told else "exif", within=folder)


@cached(_cache, condition=_cache_changed)
def read_picture(store: Store, key: str) -> Picture:
    """A picture of the store, see `picture_of`; several parts of one are often requested in a row."""
    with _stored_file(store, key) as path:
        return picture_of(path)


@contextlib.contextmanager
def _stored_file(store: Store, key: str) -> Iterator[Path]:
    """A picture of the store as a file. Raises GalleryError when there is none."""
    with store.local(key) as path:
        if not path.is_file():
            raise GalleryError(f"{key}: expected a picture in the store, there is none")
        yield path


def decode_picture(data: bytes, *, longest: float = math.inf) -> Picture:
    """The picture that data are, see `picture_of`."""
    with picture_file(data) as path:
        return picture_of(path, longest=longest)


def picture_of(path: Path, *, longest: float = math.inf) -> Picture:
    """The picture of a file upright, with 8 bits, gray ('L') or RGB, transparent pixels white.

    longest: pixels of its longest side at most. Raises ImageError when the file is no picture.
    """
    from PIL import Image

    return Image.fromarray(samples_of(path, longest=longest))


def samples_of(path: Path, *, longest: float = math.inf) -> npt.NDArray[np.uint8]:
    """The samples of a picture, (H, W) or (H, W, 3) uint8; otherwise as `picture_of`."""
    import numpy as np

    from rumu.capture.decoded_size import Reduction
    from rumu.capture.formats import decode
    from rumu.capture.stored import eight_bits, over_white

    stored = decode(path, reduction=Reduction(side=longest), floats=False)
    return np.ascontiguousarray(over_white(eight_bits(stored.values), stored.alpha))


@contextlib.contextmanager
def picture_file(data: bytes) -> Iterator[Path]:
    """A picture as a temporary file; its name says nothing."""
    with temporary_folder() as folder:
        path = folder / "picture"
        path.write_bytes(data)
        yield path
