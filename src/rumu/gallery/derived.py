"""Derived files of a work: pictures, maps and meshes, computed when first requested and then stored.

A derived file lies under the digest of what it was computed from, so it is never out of date and can be
deleted at any time. It is written completely or not at all, and computed once if several threads request it
together. Together they take no more room than RUMU_MAX_DERIVED_MB: the least recently used go first.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from cachetools import LRUCache, cached

from rumu.errors import GalleryError, RumuError
from rumu.gallery import renderers
from rumu.gallery.assets import VERSION, Assets, assets_of, derived_folder
from rumu.gallery.catalog import work
from rumu.gallery.store import Gallery, Store

MESHES = ("glb", "stl", "ply")
EXAGGERATIONS = (
    0.1,
    0.25,
    0.5,
    0.75,
    1.0,
    1.25,
    1.5,
    2.0,
    2.5,
    3.0,
    4.0,
    5.0,
    6.0,
    8.0,
    10.0,
    15.0,
    25.0,
    50.0,
    100.0,
)
"""Steps of which GLB and PLY take the nearest, so that they can be kept; an STL takes any."""
MAX_DERIVED_VARIABLE = "RUMU_MAX_DERIVED_MB"
"""The environment variable with the most megabytes that derived files may take together."""

_VERSIONS = {"glb": 1, "stl": 1, "ply": 1, "facts": 1, "heights": 1}
"""Of kinds that have come out differently since VERSION; increase one's when it would do so again."""
_DEFAULT_MAX_MB = 10_000
_MB = 10**6
_COUNTED_AGAIN = 20  # parts of the room; once one of them has been written, all files are counted again
_LEFT = 0.9  # of the room, that is still full when files have been deleted


@dataclass(frozen=True, slots=True)
class MeshShape:
    """Shape of a mesh. exaggeration: of its height, 0.01 to 100.

    width, base: of an STL, in millimetres: from its left to its right side (None: as large as the sheet), and
    the thickness below its lowest point.
    """

    exaggeration: float = 1.0
    width: float | None = None
    base: float = 2.0


PLAIN = MeshShape()
"""The shape of a mesh when nothing is said about it, and of every other kind of file."""


@dataclass(frozen=True, slots=True)
class DerivedFile:
    """A file as it is sent. media_type: e.g. 'image/webp'. etag: of the content, unquoted."""

    data: bytes
    media_type: str
    etag: str


@dataclass(frozen=True, slots=True)
class FileKind:
    """A kind of derived file. render: computes it from assets; of a mesh with its shape, too."""

    render: Callable[..., bytes]
    media_type: str
    suffix: str


def _webp(render: Callable[..., bytes], **options: Any) -> FileKind:
    return FileKind(partial(render, **options), "image/webp", ".webp")


KINDS = {
    "thumb": _webp(renderers.render_picture, longest=renderers.THUMB, quality=82),
    "thumb-normals": _webp(renderers.render_normals, longest=renderers.THUMB_NORMALS),
    "picture": _webp(renderers.render_picture, longest=renderers.SHOWN, quality=90),
    "albedo": _webp(renderers.render_albedo, longest=renderers.MAP, quality=90),
    "cover": _webp(renderers.render_albedo, longest=renderers.COVER, quality=80),
    "cover-normals": _webp(renderers.render_normals, longest=renderers.COVER_NORMALS),
    "normals": _webp(renderers.render_normals, longest=renderers.MAP),
    "normals-16": FileKind(renderers.render_normals_16, "image/png", ".png"),
    "height16": FileKind(renderers.render_height_16, "image/png", ".png"),
    "heights": FileKind(renderers.render_heights, "application/octet-stream", ".f32"),
    "mask": FileKind(renderers.render_mask, "image/png", ".png"),
    "lamp-a": _webp(renderers.render_photograph, number=0),
    "lamp-b": _webp(renderers.render_photograph, number=1),
    "lamp-c": _webp(renderers.render_photograph, number=2),
    "glb": FileKind(renderers.render_glb, "model/gltf-binary", ".glb"),
    "stl": FileKind(renderers.render_stl, "model/stl", ".stl"),
    "ply": FileKind(renderers.render_ply, "application/octet-stream", ".ply"),
    "facts": FileKind(renderers.render_facts, "application/json", ".json"),
}


def derived_file(gallery: Gallery, work_id: str, kind: str, *, shape: MeshShape = PLAIN) -> DerivedFile:
    """A derived file of a work.

    kind: one of KINDS: 'thumb' (at most 256 px), 'thumb-normals' (128 px), 'picture' (for showing, at most
        2048 px), 'albedo' and 'normals' (at most 1024 px; n = value / 127.5 - 1, y up), 'cover' and
        'cover-normals' (the same for the home page, at most 900 and 450 px), 'normals-16', 'height16' (16-bit
        PNG; 'facts' gives its scale), 'heights' (float32, little endian, row by row, as many as of 512x512),
        'mask', 'lamp-a' to 'lamp-c' (photographs of a three-lamp work), 'glb', 'stl', 'ply', 'facts' (JSON).
    shape: of a mesh.
    Raises GalleryError for an unknown kind, one that this work does not have, or an unknown work; ImageError
    or RefusedImage when its picture cannot be used.
    """
    assets = assets_of(gallery.store, work(gallery, work_id))
    return derived_of(gallery.store, assets, kind, shape=shape)


def derived_of(store: Store, assets: Assets, kind: str, *, shape: MeshShape = PLAIN) -> DerivedFile:
    """A derived file of assets; see `derived_file`."""
    tag = etag(assets, kind, shape=shape)
    if kind == "picture":
        with assets.picture_file() as path:
            media_type = renderers.browser_media_type(path)
            if media_type is not None:
                return DerivedFile(path.read_bytes(), media_type, tag)
    return DerivedFile(_read_or_render(store, assets, kind, shape), KINDS[kind].media_type, tag)


def stored_file(store: Store, assets: Assets, kind: str, *, shape: MeshShape = PLAIN) -> DerivedFile | None:
    """A derived file of assets if it is in the store, else None."""
    key = _key(assets, kind, shape)
    if not store.exists(key):
        return None
    try:
        data = store.read(key)
    except GalleryError:  # it was deleted this very moment
        return None
    store.mark_as_used(key)
    return DerivedFile(data, KINDS[kind].media_type, etag(assets, kind, shape=shape))


def etag(assets: Assets, kind: str, *, shape: MeshShape = PLAIN) -> str:
    """The ETag of a derived file, which is known before the file is computed."""
    return hashlib.sha256(_key(assets, kind, shape).encode()).hexdigest()[:20]


def viewer_facts(
    gallery: Gallery, work_id: str, *, url: Callable[[str, str], str] | None = None
) -> dict[str, Any]:
    """What the viewer needs to show a work.

    url: makes the address of a kind of derived file with its ETag; by default of the service's own files.
    Returns pixels ([width, height] of albedo and normals), aspect, unit, spacing (of those pixels), source,
    source_text, height {url, width, height, min, max}, normals, albedo, picture, mask, glb, and three_lamps
    {a, b, c, slant} or None. Raises as `derived_file`.
    """
    return viewer_facts_of(
        gallery.store,
        assets_of(gallery.store, work(gallery, work_id)),
        url=url or (lambda kind, tag: f"/api/works/{work_id}/files/{kind}?v={tag}"),
    )


def viewer_facts_of(store: Store, assets: Assets, *, url: Callable[[str, str], str]) -> dict[str, Any]:
    """What the viewer needs to show a work or another picture; see `viewer_facts`."""
    facts: dict[str, Any] = json.loads(derived_of(store, assets, "facts").data)

    def address(kind: str) -> str:
        return url(kind, etag(assets, kind))

    lamps, heights, _ = (facts.pop(name) for name in ("three_lamps", "heights", "height16"))
    return facts | {
        "height": {"url": address("heights"), **heights},
        "three_lamps": lamps and {name: address(f"lamp-{name}") for name in "abc"} | lamps,
        **{name: address(name) for name in ("normals", "albedo", "picture", "mask", "glb")},
    }


def near_step(shape: MeshShape, kind: str) -> MeshShape:
    """The shape that a mesh of this kind is made in: GLB and PLY at the nearest of EXAGGERATIONS."""
    if kind == "stl" or shape.exaggeration <= 0:
        return shape
    nearest = min(EXAGGERATIONS, key=lambda step: abs(math.log(step / shape.exaggeration)))
    return replace(shape, exaggeration=nearest)


def _key(assets: Assets, kind: str, shape: MeshShape) -> str:
    if kind not in KINDS:
        raise GalleryError(f"expected a kind of file among {', '.join(KINDS)}, got {kind!r}")
    if not 0.01 <= shape.exaggeration <= 100:
        raise GalleryError(f"expected an exaggeration from 0.01 to 100, got {shape.exaggeration}")
    if shape.exaggeration != 1.0 and kind not in MESHES:
        raise GalleryError(f"expected an exaggeration of a mesh ({', '.join(MESHES)}), got it of {kind}")
    if (shape.width, shape.base) != (PLAIN.width, PLAIN.base) and kind != "stl":
        raise GalleryError(f"expected a width and a base of an STL, got them of {kind}")
    shape = near_step(shape, kind)
    more = "" if shape.exaggeration == 1.0 else f"-x{shape.exaggeration:g}"
    more += "" if shape.width is None else f"-w{shape.width:g}"
    more += "" if shape.base == PLAIN.base else f"-b{shape.base:g}"
    version = f"{VERSION}.{_VERSIONS[kind]}" if kind in _VERSIONS else VERSION
    return f"{derived_folder(assets.digest)}/v{version}-{kind}{more}{KINDS[kind].suffix}"


# The cache holds nothing, because the file is in the store: it makes threads that request a file wait for the
# one that renders it.
@cached(
    LRUCache(0),
    key=lambda store, assets, kind, shape: (store.root, _key(assets, kind, shape)),
    condition=threading.Condition(),
)
def _read_or_render(store: Store, assets: Assets, kind: str, shape: MeshShape) -> bytes:
    stored = stored_file(store, assets, kind, shape=shape)
    if stored is not None:
        return stored.data
    shape = near_step(shape, kind)
    options: dict[str, float | None] = {}
    if kind in MESHES:
        options = {"exaggeration": shape.exaggeration}
    if kind == "stl":
        options |= {"width": shape.width, "base": shape.base}
    data = KINDS[kind].render(assets, **options)
    if shape == PLAIN or kind != "stl":  # anybody may ask for an STL of any shape, and the store would fill
        store.write(_key(assets, kind, shape), data)
        limit_room(store, len(data))
    return data


# --- the room that they take -----------------------------------------------------------------------

_written: dict[str, int] = {}  # by the store: bytes that this process has written since it counted the files
_written_lock = threading.Lock()


def max_derived_bytes() -> int:
    """The most bytes that derived files may take. Raises RumuError when the variable is no number."""
    text = os.environ.get(MAX_DERIVED_VARIABLE) or str(_DEFAULT_MAX_MB)
    if not text.strip().isdecimal() or int(text) == 0:
        raise RumuError(
            f"expected a whole number of megabytes, got {text!r}",
            name=MAX_DERIVED_VARIABLE,
            zh=f"{MAX_DERIVED_VARIABLE} 應是以 MB 計的整數，現在是 {text!r}。",
        )
    return int(text) * _MB


def limit_room(store: Store, written: int) -> None:
    """Count the bytes that have been written, and delete the least recently used files above the limit."""
    most = max_derived_bytes()
    with _written_lock:
        before = _written.get(store.root)
        _written[store.root] = (before or 0) + written
        if before is not None and _written[store.root] < most / _COUNTED_AGAIN:
            return
        _written[store.root] = 0
    delete_least_used(store, most=most)


def delete_least_used(store: Store, *, most: int) -> int:
    """Delete the derived files that were used longest ago, until the rest take nine tenths of `most`.

    most: bytes; nothing is deleted as long as all files together take less. Returns how many were deleted.
    """
    files = sorted(store.files("derived"), key=lambda file: file.written)
    total = sum(file.size for file in files)
    if total <= most:
        return 0
    count = 0
    for file in files:
        if total <= _LEFT * most:
            break
        store.delete_file(file.key)
        total -= file.size
        count += 1
    return count
