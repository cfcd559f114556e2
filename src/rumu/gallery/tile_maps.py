"""The maps of a work that are tiled for deep zoom, and their tile sets in the store.

A tile set is a derived file: it lies under the digest of what it was computed from, takes part of the same
room, and is made again when it is gone. Works of more than LARGE pixels get theirs when they are added,
others when they are first looked at.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import threading
from collections.abc import Callable, Iterator
from functools import partial
from typing import Literal

import numpy as np
from cachetools import LRUCache, cached

from rumu.database.tables import Work
from rumu.errors import GalleryError, RumuError
from rumu.gallery.assets import VERSION, Assets, assets_of, derived_folder, samples_of
from rumu.gallery.catalog import work
from rumu.gallery.derived import derived_file, limit_room
from rumu.gallery.renderers import MAP, height_levels, lamp_photograph
from rumu.gallery.store import Gallery, Store
from rumu.gallery.tiles import TileMap, TileSet, open_tiles, packed_levels, write_tiles
from rumu.workspaces import temporary_folder

MapName = Literal["albedo", "normals", "heights", "picture", "lamp-a", "lamp-b", "lamp-c"]
MAPS: tuple[MapName, ...] = ("albedo", "normals")
"""The maps that every work has, by which it is lit."""
LAMPS: tuple[MapName, ...] = ("lamp-a", "lamp-b", "lamp-c")
"""The photographs of a work under the paper's three lamps."""
LARGE = 12_600_000
"""Pixels above which the tiles of a work are made when it is added, since they take long."""

SLOW = 3_000_000
"""Pixels above which the first visitor of a work would wait longer than a second for its maps."""

_FIRST_SEEN = ("thumb", "thumb-normals", "facts", "heights", "albedo", "normals", "picture", "mask")
_TILES_VERSION = 1  # increase it when the tiles of the same map would come out differently
_ROWS = 128  # converted at a time


def has_tiles(row: Work) -> bool:
    """Whether a work is larger than the maps that are sent whole."""
    return max(row.width, row.height) > MAP


def tiles_etag(assets: Assets, name: MapName) -> str:
    """The ETag of a tile set, which is known before it is made."""
    return hashlib.sha256(_key(assets, name).encode()).hexdigest()[:20]


def stored_tiles(store: Store, assets: Assets, name: MapName) -> TileSet | None:
    """The tile set of a map if it has been made, else None."""
    key = _key(assets, name)
    tiles = open_tiles(store, key)
    if tiles is not None:
        store.mark_as_used(key)
    return tiles


def make_tiles(gallery: Gallery, work_id: str, name: MapName) -> None:
    """Make the tile set of a map of a work, unless there is one.

    Raises GalleryError for an unknown work, ImageError or RefusedImage when its picture cannot be used.
    """
    row = work(gallery, work_id)
    _make(gallery.store, assets_of(gallery.store, row), name)


def make_large_tiles(gallery: Gallery, work_id: str, *, maps_above: int | None = None) -> None:
    """Make the tile sets of a work that is large, and the maps that its page begins with.

    maps_above: pixels above which these maps are made; LARGE unless given. What cannot be made, as the
    normals of a blank leaf, is left out.
    """
    row = work(gallery, work_id)
    pixels = row.width * row.height
    if pixels > (LARGE if maps_above is None else maps_above):
        with contextlib.suppress(RumuError):
            for kind in _FIRST_SEEN:
                derived_file(gallery, work_id, kind)
    if pixels <= LARGE:
        return
    names: list[MapName] = [*MAPS, "heights"] if row.capture is None else [*MAPS, "heights", "picture"]
    with contextlib.suppress(RumuError):
        if json.loads(derived_file(gallery, work_id, "facts").data)["three_lamps"] is not None:
            names += LAMPS
            for name in LAMPS:
                derived_file(gallery, work_id, name)
    for name in names:
        with contextlib.suppress(RumuError):
            make_tiles(gallery, work_id, name)


def _key(assets: Assets, name: MapName) -> str:
    if name not in _MAKERS:
        raise GalleryError(f"expected a map among {', '.join(_MAKERS)}, got {name!r}")
    return f"{derived_folder(assets.digest)}/v{VERSION}.{_TILES_VERSION}-{name}-tiles.zip"


# As of other derived files, the cache holds nothing: it makes threads wait for the one that makes a set.
@cached(
    LRUCache(0),
    key=lambda store, assets, name: (store.root, _key(assets, name)),
    condition=threading.Condition(),
)
def _make(store: Store, assets: Assets, name: MapName) -> None:
    if stored_tiles(store, assets, name) is not None:
        return
    with temporary_folder() as folder:
        path = folder / "tiles.zip"
        with path.open("wb") as stream, _MAKERS[name](assets) as tiled:
            write_tiles(tiled, stream)
        with path.open("rb") as stream:
            store.write(_key(assets, name), stream)
        limit_room(store, path.stat().st_size)


# --- the maps --------------------------------------------------------------------------------------


@contextlib.contextmanager
def _albedo(assets: Assets) -> Iterator[TileMap]:
    """The albedo: of a work from one picture the picture itself."""
    from rumu.surface.mesh import albedo_srgb

    if assets.measured is None:
        yield _picture_map(assets)
        return
    with assets.measured() as surface:
        height, width = surface.shape
        yield TileMap(width, height, lambda: (albedo_srgb(band) for band in surface.rows("albedo")), "light")


@contextlib.contextmanager
def _picture(assets: Assets) -> Iterator[TileMap]:
    """The picture that a measured work is shown by where it is not lit."""
    if assets.measured is None:
        raise GalleryError("expected a work from photographs, this one's picture is its albedo")
    yield _picture_map(assets)


def _picture_map(assets: Assets) -> TileMap:
    with assets.picture_file() as path:
        picture = samples_of(path)
    height, width = picture.shape[:2]
    parts = range(0, height, _ROWS)
    return TileMap(
        width,
        height,
        lambda: (np.ascontiguousarray(picture[top : top + _ROWS]) for top in parts),
        "light",
    )


@contextlib.contextmanager
def _normals(assets: Assets) -> Iterator[TileMap]:
    """The normals: measured ones as they are, those of ink at the sharpness of its picture."""
    from rumu.surface.fine_normals import eight_bit_normals, fine_normals, prepare_ink

    if assets.measured is not None:
        with assets.measured() as surface:
            height, width = surface.shape
            yield TileMap(width, height, lambda: map(eight_bit_normals, surface.rows("normals")), "normals")
        return
    with assets.picture_file() as path:
        ink = prepare_ink(samples_of(path), assets.surface())
    height, width = ink.dark.shape
    yield TileMap(width, height, lambda: fine_normals(ink), "normals")


@contextlib.contextmanager
def _heights(assets: Assets) -> Iterator[TileMap]:
    """The heights of which a surface seen from nearby is made: levels, as info.json says in `heights`."""
    levels = height_levels(assets)
    height, width = levels.shape
    told = {"heights": {"scale": levels.scale, "offset": levels.offset}}
    yield TileMap(width, height, lambda: map(packed_levels, levels.bands()), "heights", told)


@contextlib.contextmanager
def _photograph(assets: Assets, *, number: int) -> Iterator[TileMap]:
    """A photograph under one of the paper's three lamps."""
    from rumu.surface.mesh import albedo_srgb

    photographs, at = lamp_photograph(assets, number)
    height, width = photographs.shape[1:3]
    only = photographs.chosen([at])
    bands = range(0, height, _ROWS)
    yield TileMap(
        width,
        height,
        lambda: (albedo_srgb(np.clip(only.rows(top, min(top + _ROWS, height))[0], 0, 1)) for top in bands),
        "light",
    )


_MAKERS: dict[MapName, Callable[[Assets], contextlib.AbstractContextManager[TileMap]]] = {
    "albedo": _albedo,
    "normals": _normals,
    "heights": _heights,
    "picture": _picture,
    **{name: partial(_photograph, number=number) for number, name in enumerate(LAMPS)},
}
