"""Tiles of a map of a work for deep zoom: a tile set of the IIIF Image API 3, level 0, in one zip.

Its files are named as the Image API asks for them, `0,0,1024,1024/512,512/0/default.jpg`, and info.json
lacks only its id; unpacked into a folder of a web server it is what IIIF viewers zoom into. They are stored
without compression, so that a tile is read from the zip without the rest of it. A set is written in one
pass over the rows of its map, which need never be in memory together.
"""

from __future__ import annotations

import io
import json
import os
import zipfile
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any, BinaryIO, Literal

import numpy as np
import numpy.typing as npt
from cachetools import LRUCache, cached

from rumu.errors import GalleryError
from rumu.gallery.store import Store

Bytes = npt.NDArray[np.uint8]
Kind = Literal["light", "normals", "heights"]

TILE = 512
"""Side of a tile, in pixels."""
INFO = "info.json"
MEDIA_TYPES = {"jpg": "image/jpeg", "png": "image/png"}
_QUALITY = 90  # of JPEG
_STRIP = 128  # rows that are halved at a time; even
_DIRECTORIES = 32  # of zips that stay in memory
_HEADER = 30  # bytes before the name of a file in a zip
_LEVELS = 65535


@dataclass(frozen=True, slots=True)
class TileMap:
    """A map as rows from its top.

    width, height: pixels. bands: yields (rows, width) or (rows, width, 3) uint8, RGB. kind: 'light' of
    values in sRGB, which become JPEG; 'normals' of n = value / 127.5 - 1, which become PNG, since a JPEG
    of quality 95 turns those at an outline by up to 12 degrees (`benchmarks/deep_zoom.py --errors`);
    'heights' of (256 * red + green) in levels, PNG as well. more: what info.json says besides.
    """

    width: int
    height: int
    bands: Callable[[], Iterator[Bytes]]
    kind: Kind
    more: Mapping[str, Any] = field(default_factory=dict)

    @property
    def suffix(self) -> str:
        return "jpg" if self.kind == "light" else "png"


def scale_factors(width: int, height: int) -> list[int]:
    """1, 2, 4... until the whole map is one tile."""
    factors = [1]
    while max(width, height) > TILE * factors[-1]:
        factors.append(2 * factors[-1])
    return factors


def tile_name(column: int, row: int, *, scale: int, width: int, height: int, suffix: str) -> str:
    """The name of a tile of a map, as the Image API asks for it.

    column, row: counted from the top left. scale: pixels of the map for one of the tile.
    """
    x, y = column * TILE * scale, row * TILE * scale
    w, h = min(TILE * scale, width - x), min(TILE * scale, height - y)
    return f"{x},{y},{w},{h}/{-(-w // scale)},{-(-h // scale)}/0/default.{suffix}"


def tile_info(width: int, height: int, *, suffix: str) -> dict[str, Any]:
    """The info.json of a tile set, without its id."""
    factors = scale_factors(width, height)
    whole = {"width": -(-width // factors[-1]), "height": -(-height // factors[-1])}
    return {
        "@context": "http://iiif.io/api/image/3/context.json",
        "type": "ImageService3",
        "protocol": "http://iiif.io/api/image",
        "profile": "level0",
        "width": width,
        "height": height,
        "maxWidth": TILE,
        "maxHeight": TILE,
        "sizes": [whole],
        "tiles": [{"width": TILE, "height": TILE, "scaleFactors": factors}],
        "preferredFormats": [suffix],
    }


# --- writing ---------------------------------------------------------------------------------------


def write_tiles(tiled: TileMap, stream: BinaryIO) -> None:
    """Write the tile set of a map.

    Raises GalleryError when the bands are not rows of the map, or not all of them.
    """
    with zipfile.ZipFile(stream, "w") as archive, ThreadPoolExecutor(os.cpu_count()) as pool:
        info = tile_info(tiled.width, tiled.height, suffix=tiled.suffix) | dict(tiled.more)
        archive.writestr(zipfile.ZipInfo(INFO), json.dumps(info))
        finest = _Level(tiled, 1, archive, pool)
        rows = 0
        for band in tiled.bands():
            if band.shape[1] != tiled.width or band.dtype != np.uint8:
                raise GalleryError(
                    f"expected rows of {tiled.width} pixels of uint8, got {band.dtype} {band.shape}"
                )
            rows += len(band)
            finest.push(band)
        if rows != tiled.height:
            raise GalleryError(f"expected {tiled.height} rows, got {rows}")
        finest.end()


@dataclass(slots=True)
class _Level:
    """One level while it is written: it takes rows, writes tiles, and passes the rows on at half the size."""

    tiled: TileMap
    scale: int
    archive: zipfile.ZipFile
    pool: Executor
    waiting: list[Bytes] = field(default_factory=list)
    written: int = 0
    coarser: _Level | None = None

    def push(self, rows: Bytes) -> None:
        self.waiting.append(rows)
        while sum(map(len, self.waiting)) >= TILE:
            together = np.concatenate(self.waiting) if len(self.waiting) > 1 else self.waiting[0]
            self._write(together[:TILE])
            self.waiting = [together[TILE:]] if len(together) > TILE else []

    def end(self) -> None:
        if self.waiting:
            self._write(np.concatenate(self.waiting))
        if self.coarser is not None:
            self.coarser.end()

    def _write(self, rows: Bytes) -> None:
        """Write one row of tiles."""
        columns = range(-(-rows.shape[1] // TILE))
        parts = (rows[:, TILE * k : TILE * (k + 1)] for k in columns)
        width, height, suffix = self.tiled.width, self.tiled.height, self.tiled.suffix
        for column, data in zip(columns, self.pool.map(self._encode, parts), strict=True):
            name = tile_name(
                column, self.written, scale=self.scale, width=width, height=height, suffix=suffix
            )
            self.archive.writestr(zipfile.ZipInfo(name), data)
        self.written += 1
        if self.scale < scale_factors(self.tiled.width, self.tiled.height)[-1]:
            if self.coarser is None:
                self.coarser = _Level(self.tiled, 2 * self.scale, self.archive, self.pool)
            self.coarser.push(_halve(rows, self.tiled.kind, self.pool))

    def _encode(self, part: Bytes) -> bytes:
        return encode_jpeg(part) if self.tiled.kind == "light" else _encode_png(part)


def encode_jpeg(part: Bytes) -> bytes:
    """An array (H, W) or (H, W, 3), RGB, as a JPEG."""
    from PIL import Image

    packed = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(part)).save(packed, "JPEG", quality=_QUALITY)
    return packed.getvalue()


def _encode_png(part: Bytes) -> bytes:
    """As a PNG, with the quickest setting that still packs."""
    import cv2

    settings = [cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_RLE, cv2.IMWRITE_PNG_COMPRESSION, 1]
    settings += [cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_SUB]
    _, packed = cv2.imencode(".png", np.ascontiguousarray(part[..., ::-1]), settings)
    return packed.tobytes()


def _halve(rows: Bytes, kind: Kind, pool: Executor) -> Bytes:
    """Rows at half the size, rounded up: means of 2 x 2, of linear light, unit vectors or heights."""
    half = _HALVES[kind]
    strips = [rows[top : top + _STRIP] for top in range(0, len(rows), _STRIP)]
    return np.concatenate(list(pool.map(half, strips)))


def _half_of_light(strip: Bytes) -> Bytes:
    import cv2

    linear, curved = _tables()
    mean = _mean_of_fours(cv2.LUT(strip, linear))
    return np.asarray(curved[(mean * np.float32(_LEVELS) + np.float32(0.5)).astype(np.uint16)])


def _half_of_normals(strip: Bytes) -> Bytes:
    mean = _mean_of_fours(strip.astype(np.float32) / np.float32(127.5) - np.float32(1))
    mean /= np.maximum(np.linalg.norm(mean, axis=2, keepdims=True), np.float32(1e-6))
    return np.asarray(np.round(mean * np.float32(127.5) + np.float32(127.5)), dtype=np.uint8)


def _half_of_heights(strip: Bytes) -> Bytes:
    return packed_levels(np.rint(_mean_of_fours(strip[..., 0] * np.float32(256) + strip[..., 1])))


def packed_levels(levels: npt.NDArray[np.floating[Any]]) -> Bytes:
    """Whole numbers of 16 bits as red, their upper byte, and green, their lower one."""
    whole = levels.clip(0, _LEVELS).astype(np.uint16)
    return np.dstack([whole >> 8, whole & 255, np.zeros_like(whole)]).astype(np.uint8)


_HALVES: dict[Kind, Callable[[Bytes], Bytes]] = {
    "light": _half_of_light,
    "normals": _half_of_normals,
    "heights": _half_of_heights,
}


def _mean_of_fours(values: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """Means of 2 x 2; an odd last row or column counts twice."""
    import cv2

    height, width = values.shape[:2]
    if height % 2 or width % 2:
        values = cv2.copyMakeBorder(values, 0, height % 2, 0, width % 2, cv2.BORDER_REPLICATE)
    size = (values.shape[1] // 2, values.shape[0] // 2)
    return np.asarray(cv2.resize(values, size, interpolation=cv2.INTER_AREA))


@cached({})
def _tables() -> tuple[npt.NDArray[np.float32], Bytes]:
    """(256,) linear light of an sRGB value; (65536,) the sRGB value of linear light in 16 bits."""
    from rumu.capture.image import to_linear
    from rumu.surface.mesh import albedo_srgb

    linear = to_linear(np.arange(256, dtype=np.float32) / np.float32(255))
    curved = albedo_srgb((np.arange(_LEVELS + 1, dtype=np.float32) / np.float32(_LEVELS))[None, :])
    return np.asarray(linear, dtype=np.float32), np.ascontiguousarray(curved.reshape(_LEVELS + 1, -1)[:, 0])


# --- reading ---------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True, eq=False)
class TileSet:
    """A tile set in a store. places: first byte and size of each of its files."""

    store: Store
    key: str
    places: dict[str, tuple[int, int]]

    def read(self, name: str) -> bytes | None:
        """A file of the set; None if there is none of this name.

        Raises GalleryError when the set was deleted meanwhile.
        """
        if name not in self.places:
            return None
        first, size = self.places[name]
        return self.store.read_part(self.key, first, size)

    @property
    def info(self) -> dict[str, Any]:
        """The info.json, without its id."""
        facts: dict[str, Any] = json.loads(self.read(INFO) or b"{}")
        return facts


def open_tiles(store: Store, key: str) -> TileSet | None:
    """The tile set under a key of the store; None if there is none."""
    state = store.state(key)
    return None if state is None else TileSet(store, key, _places(store, key, state))


@cached(LRUCache(_DIRECTORIES), key=lambda store, key, state: (store.root, key, state))
def _places(store: Store, key: str, state: object) -> dict[str, tuple[int, int]]:
    """Where the files of a zip lie in it. state: of the zip, which tells it from one that is made again."""
    with store.open_file(key) as stream, zipfile.ZipFile(stream) as archive:
        return {
            entry.filename: (entry.header_offset + _HEADER + len(entry.filename), entry.file_size)
            for entry in archive.infolist()
        }
