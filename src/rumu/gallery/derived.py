"""Derived files of a work: pictures, maps and meshes, computed when first requested and then stored.

A derived file lies under the digest of what it was computed from, so it is never out of date and can be
deleted at any time. It is written completely or not at all, and computed once if several threads request it
together.
"""

from __future__ import annotations

import hashlib
import json
import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from cachetools import LRUCache, cached

from rumu.errors import GalleryError
from rumu.gallery import renderers
from rumu.gallery.assets import VERSION, Assets, assets_of, derived_folder
from rumu.gallery.catalog import work
from rumu.gallery.store import Gallery, Store

MESHES = ("glb", "stl", "ply")


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
    "albedo": _webp(renderers.render_albedo),
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
        2048 px), 'albedo' and 'normals' (at most 1024 px; n = value / 127.5 - 1, y up), 'normals-16',
        'height16' (16-bit PNG; 'facts' gives its scale), 'heights' (float32, little endian, row by row, at
        most 512 px), 'mask', 'lamp-a' to 'lamp-c' (the photographs of a three-lamp work), 'glb', 'stl',
        'ply', 'facts' (JSON). shape: of a mesh.
    Raises GalleryError for an unknown kind, one that this work does not have, or an unknown work; ImageError
    or RefusedImage when its picture cannot be used.
    """
    assets = assets_of(gallery.store, work(gallery, work_id))
    return derived_of(gallery.store, assets, kind, shape=shape)


def derived_of(store: Store, assets: Assets, kind: str, *, shape: MeshShape = PLAIN) -> DerivedFile:
    """A derived file of assets; see `derived_file`."""
    tag = etag(assets, kind, shape=shape)
    if kind == "picture":
        data = assets.picture()
        media_type = renderers.browser_media_type(data)
        if media_type is not None:
            return DerivedFile(data, media_type, tag)
    return DerivedFile(_read_or_render(store, assets, kind, shape), KINDS[kind].media_type, tag)


def stored_file(store: Store, assets: Assets, kind: str, *, shape: MeshShape = PLAIN) -> DerivedFile | None:
    """A derived file of assets if it is in the store, else None."""
    key = _key(assets, kind, shape)
    if not store.exists(key):
        return None
    tag = etag(assets, kind, shape=shape)
    return DerivedFile(store.read(key), KINDS[kind].media_type, tag)


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


def _key(assets: Assets, kind: str, shape: MeshShape) -> str:
    if kind not in KINDS:
        raise GalleryError(f"expected a kind of file among {', '.join(KINDS)}, got {kind!r}")
    if not 0.01 <= shape.exaggeration <= 100:
        raise GalleryError(f"expected an exaggeration from 0.01 to 100, got {shape.exaggeration}")
    if shape.exaggeration != 1.0 and kind not in MESHES:
        raise GalleryError(f"expected an exaggeration of a mesh ({', '.join(MESHES)}), got it of {kind}")
    if (shape.width, shape.base) != (PLAIN.width, PLAIN.base) and kind != "stl":
        raise GalleryError(f"expected a width and a base of an STL, got them of {kind}")
    more = "" if shape.exaggeration == 1.0 else f"-x{shape.exaggeration:g}"
    more += "" if shape.width is None else f"-w{shape.width:g}"
    more += "" if shape.base == PLAIN.base else f"-b{shape.base:g}"
    return f"{derived_folder(assets.digest)}/v{VERSION}-{kind}{more}{KINDS[kind].suffix}"


# The cache holds nothing, because the file is in the store: it makes threads that request a file wait for the
# one that renders it.
@cached(
    LRUCache(0),
    key=lambda store, assets, kind, shape: (store.root, _key(assets, kind, shape)),
    condition=threading.Condition(),
)
def _read_or_render(store: Store, assets: Assets, kind: str, shape: MeshShape) -> bytes:
    key = _key(assets, kind, shape)
    if store.exists(key):
        return store.read(key)
    options: dict[str, float | None] = {}
    if kind in MESHES:
        options = {"exaggeration": shape.exaggeration}
    if kind == "stl":
        options |= {"width": shape.width, "base": shape.base}
    data = KINDS[kind].render(assets, **options)
    if shape == PLAIN:  # anybody may ask for any shape, and the store would fill
        store.write(key, data)
    return data
