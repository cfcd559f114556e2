"""The picture of an Image API service, versions 1 to 3: whole where the server gives it, else from its tiles.

Servers of level 0 give only the sizes and tiles that they list; others give the whole picture smaller than it
is (`maxWidth`). So the whole is asked for first, and what comes is believed only when it has the size that
info.json says; else the picture is put together of tiles.
"""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from rumu.errors import GalleryError, ImageError
from rumu.gallery.assets import decode_picture
from rumu.gallery.iiif_image import BadImageRequest, parse_rotation, region_box, rotate
from rumu.gallery.iiif_reading import CanvasPicture
from rumu.gallery.museum_web import MuseumWeb, NotThere

if TYPE_CHECKING:
    from PIL.Image import Image as Picture

MAX_PIXELS = 40_000_000
"""Pixels of a picture that is brought in, unless told otherwise; a larger one comes at half, a quarter..."""
_TILE = 512  # pixels: side of the parts that are asked for where a server lists no tiles
_MOST_TILES = 4000
_QUALITY = 95  # of the JPEG that tiles become


@dataclass(frozen=True, slots=True)
class ImageService:
    """What info.json says. version: 1, 2 or 3. level: 0, 1 or 2. tile: (width, height), None if none listed.

    factors: by which tiles are reduced. sizes: (width, height) that are served. limit: the most pixels of one
    answer's width, height and area, None where there is none.
    """

    base: str
    version: int
    level: int
    width: int
    height: int
    tile: tuple[int, int] | None
    factors: tuple[int, ...]
    sizes: tuple[tuple[int, int], ...]
    limit: tuple[int | None, int | None, int | None]

    def url(self, region: str, size: tuple[int, int] | None) -> str:
        """The address of a part of the picture. size: (width, height) that it comes in, None for its own."""
        if size is None:
            asked = "max" if self.version == 3 else "full"
        else:
            asked = f"{size[0]},{size[1]}" if self.version == 3 else f"{size[0]},"
        return f"{self.base}/{region}/{asked}/0/{'native' if self.version == 1 else 'default'}.jpg"


@dataclass(frozen=True, slots=True)
class FetchedPicture:
    """A picture as it is stored. urls: that it was made of."""

    data: bytes
    suffix: str
    width: int
    height: int
    urls: tuple[str, ...]


def fetch_picture(
    web: MuseumWeb, canvas: CanvasPicture, *, near: str, max_pixels: int = MAX_PIXELS
) -> FetchedPicture:
    """The picture on a canvas. near: the address of its manifest.

    Raises NotThere where there is none, NotNow where the server cannot be reached now, ImageError for what is
    no picture.
    """
    if canvas.service:
        try:
            service = read_info(web.json_bytes(f"{canvas.service}/info.json", near=near), canvas.service)
        except NotThere:
            if not canvas.picture:
                raise
        else:
            found = _of_service(web, service, canvas, near=near, max_pixels=max_pixels)
            return _shown(_within(found, max_pixels), canvas, (service.width, service.height))
    found = _single(web, canvas.picture, near)
    return _shown(_within(found, max_pixels), canvas, (found.width, found.height))


def read_info(data: bytes, base: str) -> ImageService:
    """An info.json of any version. Raises NotThere for what is none."""
    try:
        facts = json.loads(data.decode("utf-8-sig"))
        width, height = int(facts["width"]), int(facts["height"])
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise NotThere(
            f"{base}/info.json: expected the description of a picture", zh="圖像說明讀不懂。"
        ) from error
    if not (0 < width < 1_000_000 and 0 < height < 1_000_000):
        raise NotThere(f"{base}/info.json: expected a size, got {width} x {height}", zh="圖像尺寸不對。")
    told = f"{facts.get('@context', '')} {facts.get('type', '')} {facts.get('profile', '')}".lower()
    version = 3 if "image/3" in told or "imageservice3" in told else 2 if "image/2" in told else 1
    if version == 1 and ("tiles" in facts or "sizes" in facts):
        version = 2
    level = next((n for n in (2, 1, 0) if f"level{n}" in told), 0)
    tile, factors = _tiles(facts)
    return ImageService(
        base=base,
        version=version,
        level=level,
        width=width,
        height=height,
        tile=tile,
        factors=factors,
        sizes=tuple(sorted(_sizes(facts))),
        limit=_limit(facts),
    )


def _tiles(facts: dict[str, Any]) -> tuple[tuple[int, int] | None, tuple[int, ...]]:
    tiles = facts.get("tiles")
    if isinstance(tiles, list) and tiles and isinstance(tiles[0], dict):
        width = _number(tiles[0].get("width"))
        height = _number(tiles[0].get("height")) or width
        factors = tiles[0].get("scaleFactors")
    else:  # version 1
        width, factors = _number(facts.get("tile_width")), facts.get("scale_factors")
        height = _number(facts.get("tile_height")) or width
    known = sorted({n for n in factors if _number(n)}) if isinstance(factors, list) else []
    return ((width, height) if width and height else None), tuple(known or [1])


def _sizes(facts: dict[str, Any]) -> Iterator[tuple[int, int]]:
    sizes = facts.get("sizes")
    for one in sizes if isinstance(sizes, list) else ():
        if isinstance(one, dict) and _number(one.get("width")) and _number(one.get("height")):
            yield one["width"], one["height"]


def _limit(facts: dict[str, Any]) -> tuple[int | None, int | None, int | None]:
    profile = facts.get("profile")
    told_apart = profile if isinstance(profile, list) else []
    places = [facts, *(one for one in told_apart if isinstance(one, dict))]
    told = {
        name: number
        for place in places
        for name in ("maxWidth", "maxHeight", "maxArea")
        if (number := _number(place.get(name)))
    }
    width = told.get("maxWidth")
    return width, told.get("maxHeight", width), told.get("maxArea")


def _number(value: Any) -> int:
    return value if isinstance(value, int) and not isinstance(value, bool) and 0 < value < 10**9 else 0


# --- fetching --------------------------------------------------------------------------------------


def _of_service(
    web: MuseumWeb, service: ImageService, canvas: CanvasPicture, *, near: str, max_pixels: int
) -> FetchedPicture:
    factor = _reduction(service.width, service.height, max_pixels)
    if factor == 1 and not _is_limited(service):
        try:
            whole = _single(web, service.url("full", None), near)
        except (NotThere, ImageError):
            pass
        else:
            if (whole.width, whole.height) == (service.width, service.height):
                return whole
    try:
        return _of_tiles(web, service, factor, near)
    except (NotThere, ImageError):
        return _smaller(web, service, canvas, near=near, max_pixels=max_pixels)


def _reduction(width: int, height: int, max_pixels: int) -> int:
    """By which power of 2 the sides of a picture are reduced, for it to have no more pixels than that."""
    factor = 1
    while -(-width // factor) * -(-height // factor) > max_pixels:
        factor *= 2
    return factor


def _is_limited(service: ImageService) -> bool:
    """Whether the whole picture is larger than the server gives at once."""
    width, height, area = service.limit
    return (
        (width is not None and service.width > width)
        or (height is not None and service.height > height)
        or (area is not None and service.width * service.height > area)
    )


def _of_tiles(web: MuseumWeb, service: ImageService, factor: int, near: str) -> FetchedPicture:
    """The picture put together of tiles, each side reduced by at least `factor`."""
    from PIL import Image

    if service.tile is None and service.level < 1:
        raise NotThere(f"{service.base}: lists no tiles", zh="伺服器沒有列出圖塊。")
    tile = service.tile or (_TILE, _TILE)
    if service.level == 0 or service.tile is not None:
        factor = next((n for n in service.factors if n >= factor), service.factors[-1])
    width, height = -(-service.width // factor), -(-service.height // factor)
    columns, rows = -(-width // tile[0]), -(-height // tile[1])
    if columns * rows > _MOST_TILES:
        raise NotThere(f"{service.base}: {columns * rows} tiles are too many", zh="圖塊太多。")
    whole = Image.new("RGB", (width, height))
    urls = []
    for row in range(rows):
        for column in range(columns):
            url, (x, y) = _tile_url(service, factor, tile, (column, row)), (column * tile[0], row * tile[1])
            part = _decoded(web.picture_bytes(url, near=near), url).convert("RGB")
            expected = min(tile[0], width - x), min(tile[1], height - y)
            if max(abs(part.width - expected[0]), abs(part.height - expected[1])) > 1:
                raise NotThere(
                    f"{url}: expected a tile of {expected[0]} x {expected[1]}, "
                    f"got {part.width} x {part.height}",
                    zh="圖塊的尺寸不對。",
                )
            whole.paste(part, (x, y))
            urls.append(url)
    return FetchedPicture(_packed(whole), ".jpg", width, height, tuple(urls))


def _tile_url(service: ImageService, factor: int, tile: tuple[int, int], at: tuple[int, int]) -> str:
    """The canonical address of a tile: what a server of level 0 has as a file."""
    x, y = at[0] * tile[0] * factor, at[1] * tile[1] * factor
    wide, high = min(tile[0] * factor, service.width - x), min(tile[1] * factor, service.height - y)
    listed = service.tile is not None  # else the server computes: it may have given the whole smaller
    whole = listed and (wide, high) == (service.width, service.height)
    region = "full" if whole else f"{x},{y},{wide},{high}"
    size = None if whole and factor == 1 else (-(-wide // factor), -(-high // factor))
    return service.url(region, size)


def _smaller(
    web: MuseumWeb, service: ImageService, canvas: CanvasPicture, *, near: str, max_pixels: int
) -> FetchedPicture:
    """The largest listed size, else whatever the server gives as the whole."""
    fitting = [one for one in service.sizes if one[0] * one[1] <= max_pixels]
    urls = [service.url("full", size) for size in (*reversed(fitting), None)]
    last: GalleryError | ImageError | None = None
    for url in dict.fromkeys(filter(None, (*urls, canvas.picture))):
        try:
            return _single(web, url, near)
        except (NotThere, ImageError) as error:
            last = error
    raise last or NotThere(f"{service.base}: gives no picture", zh="伺服器不給圖。")


def _single(web: MuseumWeb, url: str, near: str) -> FetchedPicture:
    """A picture as the server gives it. Raises ImageError when it cannot be read."""
    data = web.picture_bytes(url, near=near)
    picture = _decoded(data, url)
    return FetchedPicture(data, _suffix(data), picture.width, picture.height, (url,))


def _decoded(data: bytes, url: str) -> Picture:
    """The picture that came from an address; an error names that, not the file in between."""
    try:
        return decode_picture(data)
    except ImageError as error:
        raise ImageError(error.en, name=url, zh=error.zh) from error


def _within(found: FetchedPicture, max_pixels: int) -> FetchedPicture:
    """The picture, reduced where a server gives only one that is too large."""
    factor = _reduction(found.width, found.height, max_pixels)
    if factor == 1:
        return found
    small = decode_picture(found.data).convert("RGB").reduce(factor)
    return replace(found, data=_packed(small), suffix=".jpg", width=small.width, height=small.height)


def _shown(found: FetchedPicture, canvas: CanvasPicture, whole: tuple[int, int]) -> FetchedPicture:
    """The part of a picture that a canvas shows, turned as there. whole: size of the picture, unreduced."""
    if (canvas.region, canvas.rotation) == ("full", "0"):
        return found
    try:
        box = region_box(canvas.region, width=whole[0], height=whole[1])
        mirrored, quarters = parse_rotation(canvas.rotation)
    except BadImageRequest as error:
        raise NotThere(f"{canvas.id}: {error}", zh="畫布所示的部分讀不懂。") from error
    edges = (box.x, box.y, box.x + box.width, box.y + box.height)
    left, top, right, bottom = (round(edge * found.width / whole[0]) for edge in edges)
    part = decode_picture(found.data).crop((left, top, max(right, left + 1), max(bottom, top + 1)))
    part = rotate(part, mirrored, quarters)
    return replace(found, data=_packed(part), suffix=".jpg", width=part.width, height=part.height)


def _packed(picture: Picture) -> bytes:
    packed = io.BytesIO()
    picture.save(packed, "JPEG", quality=_QUALITY, subsampling=0)
    return packed.getvalue()


def _suffix(data: bytes) -> str:
    heads = {
        b"\xff\xd8": ".jpg",
        b"\x89P": ".png",
        b"RI": ".webp",
        b"GI": ".gif",
        b"II": ".tif",
        b"MM": ".tif",
    }
    return heads.get(data[:2], ".image")
