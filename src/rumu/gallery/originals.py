"""What a work's pictures, maps and meshes are made of: its picture, its surface, its photographs.

Keys of the store that rumu writes for works: pictures/, captures/ and surfaces/, each named by the digest of
what it holds, so that the same content is one file, and derived/, which can be made again.
"""

from __future__ import annotations

import dataclasses
import hashlib
import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sqlalchemy import or_, select

from rumu.database.tables import Work
from rumu.errors import GalleryError
from rumu.gallery.gallery import Gallery
from rumu.gallery.store import Store

if TYPE_CHECKING:
    from rumu.values import Capture, Surface

VERSION = 1
"""Rises when the derived files of the same original would come out differently."""

MAX_SIDE = 2400  # pixels: a larger picture is reduced before its relief is computed
_IN_MEMORY = 24_000_000  # pixels of the surfaces that are kept in memory


@dataclass(frozen=True, slots=True, kw_only=True)
class Original:
    """What derived files are made of, and nothing is read before it is asked for.

    digest: names all that they depend on. picture: the bytes as they came. surface: of a
    capture the reconstructed one from the store, else the relief of the picture.
    capture: the photographs, None where there are none.
    """

    digest: str
    picture: Callable[[], bytes]
    surface: Callable[[], Surface]
    capture: Callable[[], Capture] | None = None


def picture_original(
    store: Store, key: str, *, method: str = "inflation", spacing: float | None = None
) -> Original:
    """The original of one picture of the store, such as a learner's copy.

    method: 'inflation' or 'density', how its height is computed. spacing: millimetres per pixel, None
    unknown.
    """
    digest = _named(key, method, spacing)
    return Original(
        digest=digest,
        picture=partial(store.read, key),
        surface=partial(_remembered, store, digest, partial(_relief, store, key, method, spacing)),
    )


def original_of(store: Store, row: Work) -> Original:
    """The original of a work.

    Its functions raise GalleryError when a file is missing, ImageError or RefusedImage when the picture
    cannot be used.
    """
    if row.surface is None or row.capture is None:
        return picture_original(store, row.picture, method=row.height_source, spacing=row.spacing)
    digest = _named(row.picture, row.surface, row.capture)
    return Original(
        digest=digest,
        picture=partial(store.read, row.picture),
        surface=partial(_remembered, store, digest, partial(_kept_surface, store, row.surface)),
        capture=partial(_kept_capture, store, row.capture),
    )


def picture_key(data: bytes, *, suffix: str) -> str:
    """Where a picture of this content lies; suffix: '.png' and the like, lower case."""
    digest = hashlib.sha256(data).hexdigest()
    return f"pictures/{digest[:2]}/{digest}{suffix}"


def derived_folder(digest: str) -> str:
    """The key of the folder of an original's derived files."""
    return f"derived/{digest[:2]}/{digest}"


def forget_files(gallery: Gallery, gone: Work) -> None:
    """Delete the files of a work that is no longer in the catalogue, but for those that another work
    shares."""
    keys = [key for key in (gone.picture, gone.surface, gone.capture) if key]
    with gallery.database.reading() as session:
        used = {
            key
            for row in session.execute(
                select(Work.picture, Work.surface, Work.capture).where(
                    or_(Work.picture.in_(keys), Work.surface.in_(keys), Work.capture.in_(keys))
                )
            )
            for key in row
        }
    if gone.picture not in used:
        gallery.store.delete(derived_folder(original_of(gallery.store, gone).digest))
    for key in keys:
        if key not in used:
            gallery.store.delete(key)


def _named(*parts: Any) -> str:
    return hashlib.sha256("\0".join(map(str, parts)).encode()).hexdigest()[:40]


# --- surfaces --------------------------------------------------------------------------------------

_recent: OrderedDict[tuple[str, str], Surface] = OrderedDict()
_changing = threading.Lock()
_making = tuple(threading.Lock() for _ in range(16))


def _remembered(store: Store, digest: str, make: Callable[[], Surface]) -> Surface:
    """A surface made once, however many threads ask for it; the last ones asked for stay in memory."""
    name = (store.root, digest)
    with _making[int(digest[:8], 16) % len(_making)]:
        with _changing:
            if name in _recent:
                _recent.move_to_end(name)
                return _recent[name]
        surface = make()
        with _changing:
            _recent[name] = surface
            while len(_recent) > 1 and sum(s.height.size for s in _recent.values()) > _IN_MEMORY:
                _recent.popitem(last=False)
        return surface


def _relief(store: Store, key: str, method: str, spacing: float | None) -> Surface:
    import cv2
    import numpy as np

    from rumu.capture.image import read_image
    from rumu.errors import RefusedImage
    from rumu.surface.relief import relief

    with store.local(key) as path:
        if not path.is_file():
            raise GalleryError(f"{key}: expected a picture in the store, there is none")
        image = read_image(path)
    shrink = min(1.0, MAX_SIDE / max(image.shape[:2]))
    if shrink < 1.0:
        size = (max(8, round(image.shape[1] * shrink)), max(8, round(image.shape[0] * shrink)))
        image = np.clip(cv2.resize(image, size, interpolation=cv2.INTER_AREA), 0.0, 1.0)
    try:
        surface = relief(image, method=method)  # type: ignore[arg-type]
    except RefusedImage as error:
        raise RefusedImage(f"{Path(key).name}: {error}", reason=error.reason) from None
    return surface if spacing is None else _in_millimetres(surface, spacing / shrink)


def _in_millimetres(surface: Surface, spacing: float) -> Surface:
    import numpy as np

    height = surface.height * np.float32(spacing)
    return dataclasses.replace(surface, height=height, spacing=spacing, unit="mm")


def _kept_surface(store: Store, key: str) -> Surface:
    from rumu.surface.folder import read_surface

    with store.local(key) as folder:
        return read_surface(folder)


def _kept_capture(store: Store, key: str) -> Capture:
    from rumu.capture.folder import read_capture

    with store.local(key) as folder:
        return read_capture(folder)
