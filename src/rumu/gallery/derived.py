"""Pictures, maps and meshes of a work: made when they are first asked for, then kept in the store.

A derived file lies under the digest of what it was made of, so it is never out of date and can always be
thrown away. It is written whole or not at all, and made once however many threads ask for it.
"""

from __future__ import annotations

import hashlib
import json
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rumu.errors import GalleryError
from rumu.gallery.catalog import work
from rumu.gallery.gallery import Gallery
from rumu.gallery.originals import VERSION, Original, derived_folder, original_of
from rumu.gallery.store import Store

MESHES = ("glb", "stl", "ply")
_making = tuple(threading.Lock() for _ in range(32))


@dataclass(frozen=True, slots=True)
class Derived:
    """A file as it is sent. media_type: e.g. 'image/webp'. etag: changes when the bytes do, without
    quotes."""

    data: bytes
    media_type: str
    etag: str


@dataclass(frozen=True, slots=True)
class Kind:
    """How one kind of file is made: its module function, the type, and the end of its name."""

    make: str
    media_type: str
    suffix: str


KINDS = {
    "thumb": Kind("thumb", "image/webp", ".webp"),
    "thumb-normals": Kind("thumb_normals", "image/webp", ".webp"),
    "picture": Kind("picture", "image/webp", ".webp"),
    "albedo": Kind("albedo", "image/webp", ".webp"),
    "normals": Kind("normals", "image/webp", ".webp"),
    "normals-16": Kind("normals_16", "image/png", ".png"),
    "height16": Kind("height_16", "image/png", ".png"),
    "heights": Kind("heights", "application/octet-stream", ".f32"),
    "mask": Kind("mask", "image/png", ".png"),
    "lamp-a": Kind("lamp_a", "image/webp", ".webp"),
    "lamp-b": Kind("lamp_b", "image/webp", ".webp"),
    "lamp-c": Kind("lamp_c", "image/webp", ".webp"),
    "glb": Kind("glb", "model/gltf-binary", ".glb"),
    "stl": Kind("stl", "model/stl", ".stl"),
    "ply": Kind("ply", "application/octet-stream", ".ply"),
    "facts": Kind("facts", "application/json", ".json"),
}


def derived(gallery: Gallery, work_id: str, kind: str, *, exaggeration: float = 1.0) -> Derived:
    """One derived file of a work.

    kind: one of KINDS: 'thumb' (at most 256 px), 'thumb-normals' (128 px), 'picture' (as shown, at most 2048
        px), 'albedo' and 'normals' (at most 1024 px; n = value / 127.5 - 1, y up), 'normals-16', 'height16'
        (16-bit PNG; 'facts' says its scale), 'heights' (float32, little endian, row by row, at most 512 px),
        'mask', 'lamp-a' to 'lamp-c' (the photographs of a three-lamp work), 'glb', 'stl', 'ply', 'facts'
    (JSON). exaggeration: of a mesh's height, 0.01 to 100.
    Raises GalleryError for another kind, one that this work does not have, or a work that is not there;
    ImageError or RefusedImage when its picture cannot be used.
    """
    original = original_of(gallery.store, work(gallery, work_id))
    return derived_of(gallery.store, original, kind, exaggeration=exaggeration)


def derived_of(store: Store, original: Original, kind: str, *, exaggeration: float = 1.0) -> Derived:
    """One derived file of an original; see `derived`."""
    key = _key(original, kind, exaggeration)
    if kind == "picture":
        shown = _as_it_came(original)
        if shown is not None:
            return Derived(shown[0], shown[1], etag(original, kind))
    data = _kept(store, key)
    if data is None:
        with _making[hash(key) % len(_making)]:
            data = _kept(store, key)  # another thread may have made it meanwhile
            if data is None:
                data = _made(original, kind, exaggeration)
                store.write(key, data)
    return Derived(data, KINDS[kind].media_type, etag(original, kind, exaggeration=exaggeration))


def kept(store: Store, original: Original, kind: str, *, exaggeration: float = 1.0) -> Derived | None:
    """The same where it is there without being made, else None."""
    data = _kept(store, _key(original, kind, exaggeration))
    if data is None:
        return None
    return Derived(data, KINDS[kind].media_type, etag(original, kind, exaggeration=exaggeration))


def etag(original: Original, kind: str, *, exaggeration: float = 1.0) -> str:
    """What names the content of a derived file, known before it is made."""
    return hashlib.sha256(_key(original, kind, exaggeration).encode()).hexdigest()[:20]


def viewer_facts(
    gallery: Gallery, work_id: str, *, url: Callable[[str, str], str] | None = None
) -> dict[str, Any]:
    """What the viewer needs to show a work.

    url: makes the address of a kind of derived file with its etag; by default of the service's own files.
    Returns pixels ([width, height] of albedo and normals), aspect, unit, spacing (of those pixels), source,
    source_text, height {url, width, height, min, max}, normals, albedo, picture, mask, glb, and three_lamps
    {a, b, c, slant} or None. Raises as `derived`.
    """
    return viewer_facts_of(
        gallery.store,
        original_of(gallery.store, work(gallery, work_id)),
        url=url or (lambda kind, tag: f"/api/works/{work_id}/files/{kind}?v={tag}"),
    )


def viewer_facts_of(store: Store, original: Original, *, url: Callable[[str, str], str]) -> dict[str, Any]:
    """The same of any original; see `viewer_facts`."""
    facts: dict[str, Any] = json.loads(derived_of(store, original, "facts").data)

    def address(kind: str) -> str:
        return url(kind, etag(original, kind))

    lamps, heights, _ = (facts.pop(name) for name in ("three_lamps", "heights", "height16"))
    return facts | {
        "height": {"url": address("heights"), **heights},
        "three_lamps": lamps and {name: address(f"lamp-{name}") for name in "abc"} | lamps,
        **{name: address(name) for name in ("normals", "albedo", "picture", "mask", "glb")},
    }


def _key(original: Original, kind: str, exaggeration: float) -> str:
    if kind not in KINDS:
        raise GalleryError(f"expected a kind of file among {', '.join(KINDS)}, got {kind!r}")
    if not 0.01 <= exaggeration <= 100:
        raise GalleryError(f"expected an exaggeration from 0.01 to 100, got {exaggeration}")
    if exaggeration != 1.0 and kind not in MESHES:
        raise GalleryError(f"expected an exaggeration of a mesh ({', '.join(MESHES)}), got it of {kind}")
    more = "" if exaggeration == 1.0 else f"-x{exaggeration:g}"
    return f"{derived_folder(original.digest)}/v{VERSION}-{kind}{more}{KINDS[kind].suffix}"


def _kept(store: Store, key: str) -> bytes | None:
    return store.read(key) if store.exists(key) else None


def _made(original: Original, kind: str, exaggeration: float) -> bytes:
    from rumu.gallery import making

    make = getattr(making, KINDS[kind].make)
    return bytes(make(original, exaggeration=exaggeration) if kind in MESHES else make(original))


def _as_it_came(original: Original) -> tuple[bytes, str] | None:
    """The picture itself, where a browser shows it and it is not too large."""
    from rumu.gallery.making import shown_as_it_is

    data = original.picture()
    media_type = shown_as_it_is(data)
    return None if media_type is None else (data, media_type)
