"""The IIIF Image API 3, level 2: a work's picture in any region, size, rotation, quality and format."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from rumu.errors import GalleryError
from rumu.gallery.assets import read_picture
from rumu.gallery.catalog import work
from rumu.gallery.store import Gallery

if TYPE_CHECKING:
    from PIL.Image import Image as Picture

FORMATS = {"jpg": "image/jpeg", "png": "image/png", "webp": "image/webp"}
QUALITIES = ("default", "color", "gray", "bitonal")
MAX_SIDE = 4096  # pixels of an answer; a larger picture is served in parts
TILE = 512

_NUMBER = r"(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)"
_THRESHOLD = 128  # gray values from here on are white in 'bitonal'


class BadImageRequest(GalleryError):  # noqa: N818  the name of HTTP status 400
    """An image request that the Image API does not allow."""


@dataclass(frozen=True, slots=True)
class PictureRegion:
    """A region of a picture in pixels, origin top left."""

    x: int
    y: int
    width: int
    height: int


def image_info(gallery: Gallery, work_id: str, *, base: str) -> dict[str, Any]:
    """The info.json of a work's picture.

    base: URL of the image service, e.g. 'https://example.org/iiif/image'. Raises GalleryError when there is
    no such work.
    """
    row = work(gallery, work_id)
    longest = max(row.width, row.height)
    factors = [2**n for n in range(12) if n == 0 or longest / 2**n > TILE / 2]
    fitted = [n for n in factors if longest / n <= MAX_SIDE]
    sizes = [{"width": -(-row.width // n), "height": -(-row.height // n)} for n in reversed(fitted)]
    return {
        "@context": "http://iiif.io/api/image/3/context.json",
        "id": f"{base.rstrip('/')}/{row.id}",
        "type": "ImageService3",
        "protocol": "http://iiif.io/api/image",
        "profile": "level2",
        "width": row.width,
        "height": row.height,
        "maxWidth": MAX_SIDE,
        "maxHeight": MAX_SIDE,
        "sizes": sizes,
        "tiles": [{"width": TILE, "height": TILE, "scaleFactors": factors}],
        "extraFormats": ["webp"],
        "extraQualities": ["color", "gray", "bitonal"],
        "extraFeatures": ["mirroring", "regionSquare", "sizeUpscaling"],
    }


def image_response(  # noqa: PLR0917  in the order of the address
    gallery: Gallery, work_id: str, region: str, size: str, rotation: str, quality: str, format: str
) -> tuple[bytes, str]:
    """The bytes of the image that a request asks for, and their media type.

    region: full, square, 'x,y,w,h' or 'pct:x,y,w,h'. size: max, 'w,', ',h', 'w,h', '!w,h', 'pct:n', each with
        ^ before it to allow enlarging. rotation: 0, 90, 180 or 270, clockwise; with ! before it the picture
        is mirrored first. quality: one of QUALITIES; format: one of FORMATS.
    Raises BadImageRequest for other values, a region outside of the picture, a size above MAX_SIDE, or one
    above the region without ^; GalleryError when there is no such work.
    """
    from PIL import Image

    row = work(gallery, work_id)
    if quality not in QUALITIES or format not in FORMATS:
        raise BadImageRequest(
            f"expected a quality among {', '.join(QUALITIES)} and a format among {', '.join(FORMATS)}, "
            f"got {quality}.{format}"
        )
    box = region_box(region, width=row.width, height=row.height)
    wanted = size_of(size, box)
    mirrored, quarters = parse_rotation(rotation)
    picture = read_picture(gallery.store, row.picture)
    part = picture.crop((box.x, box.y, box.x + box.width, box.y + box.height))
    if part.size != wanted:
        part = part.resize(wanted, Image.Resampling.LANCZOS)
    image = _convert(rotate(part, mirrored, quarters), quality)
    packed = io.BytesIO()
    if format == "jpg":
        image.save(packed, "JPEG", quality=90)
    elif format == "png":
        image.save(packed, "PNG")
    else:
        image.convert("RGB").save(packed, "WEBP", quality=90, method=3)
    return packed.getvalue(), FORMATS[format]


def region_box(region: str, *, width: int, height: int) -> PictureRegion:
    """The region of a picture that a request names. Raises BadImageRequest if invalid or outside."""
    if region == "full":
        return PictureRegion(0, 0, width, height)
    if region == "square":
        side = min(width, height)
        return PictureRegion((width - side) // 2, (height - side) // 2, side, side)
    pixels = re.fullmatch(r"([0-9]{1,9}),([0-9]{1,9}),([0-9]{1,9}),([0-9]{1,9})", region)
    shares = re.fullmatch(rf"pct:({_NUMBER}),({_NUMBER}),({_NUMBER}),({_NUMBER})", region)
    if pixels:
        x, y, w, h = map(int, pixels.groups())
    elif shares:
        values = [float(share) / 100 for share in shares.groups()]
        x, y = round(values[0] * width), round(values[1] * height)
        w, h = round(values[2] * width), round(values[3] * height)
    else:
        raise BadImageRequest(f"expected a region full, square, x,y,w,h or pct:x,y,w,h, got {region!r:.60}")
    if w == 0 or h == 0 or x >= width or y >= height:
        raise BadImageRequest(f"expected a region within {width} x {height} pixels, got {region!r:.60}")
    return PictureRegion(x, y, min(w, width - x), min(h, height - y))


def size_of(size: str, box: PictureRegion) -> tuple[int, int]:
    """(width, height) that a request asks for. Raises BadImageRequest as `image_response`."""
    upscale, asked = size.startswith("^"), size.removeprefix("^")
    wanted = _parse_size(asked, box, upscale=upscale)
    if min(wanted) < 1 or max(wanted) > MAX_SIDE:
        raise BadImageRequest(f"expected a size from 1 to {MAX_SIDE} pixels a side, got {size!r:.60}")
    if not upscale and (wanted[0] > box.width or wanted[1] > box.height):
        raise BadImageRequest(
            f"expected a size of at most {box.width} x {box.height} pixels (^ before it enlarges), "
            f"got {size!r:.60}"
        )
    return wanted


def _parse_size(asked: str, box: PictureRegion, *, upscale: bool) -> tuple[int, int]:
    if asked == "max":
        return _fit(box, MAX_SIDE, MAX_SIDE, upscale=upscale)
    if share := re.fullmatch(rf"pct:({_NUMBER})", asked):
        factor = float(share[1]) / 100
        return max(1, round(box.width * factor)) if factor else 0, max(1, round(box.height * factor))
    if fit := re.fullmatch(r"!([0-9]{1,9}),([0-9]{1,9})", asked):
        width, height = min(int(fit[1]), MAX_SIDE), min(int(fit[2]), MAX_SIDE)
        return _fit(box, width, height, upscale=upscale) if width and height else (0, 0)
    sides = re.fullmatch(r"([0-9]{0,9}),([0-9]{0,9})", asked)
    if sides is None or not (sides[1] or sides[2]):
        raise BadImageRequest(
            f"expected a size max, w,h or w, or ,h or !w,h or pct:n, with or without ^, got {asked!r:.60}"
        )
    width, height = int(sides[1] or 0), int(sides[2] or 0)
    if not sides[2]:
        height = max(1, round(box.height * width / box.width)) if width else 0
    if not sides[1]:
        width = max(1, round(box.width * height / box.height)) if height else 0
    return width, height


def _fit(box: PictureRegion, width: int, height: int, *, upscale: bool) -> tuple[int, int]:
    """The largest size with the region's proportions within these sides."""
    factor = min(width / box.width, height / box.height)
    if not upscale:
        factor = min(factor, 1.0)
    return max(1, int(box.width * factor + 1e-6)), max(1, int(box.height * factor + 1e-6))


def parse_rotation(rotation: str) -> tuple[bool, int]:
    """Whether the picture is mirrored, and the number of quarter turns clockwise."""
    degrees = re.fullmatch(rf"(!?)({_NUMBER})", rotation)
    if degrees is None or float(degrees[2]) not in (0, 90, 180, 270, 360):
        raise BadImageRequest(f"expected a rotation of 0, 90, 180 or 270 degrees, got {rotation!r:.60}")
    return bool(degrees[1]), round(float(degrees[2]) / 90) % 4


def rotate(image: Picture, mirrored: bool, quarters: int) -> Picture:
    """The picture mirrored, then turned by quarters clockwise."""
    from PIL import Image

    if mirrored:
        image = image.transpose(Image.Transpose.FLIP_LEFT_RIGHT)
    clockwise = {1: Image.Transpose.ROTATE_270, 2: Image.Transpose.ROTATE_180, 3: Image.Transpose.ROTATE_90}
    return image.transpose(clockwise[quarters]) if quarters else image


def _convert(image: Picture, quality: str) -> Picture:
    if quality == "default":
        return image
    if quality == "color":
        return image.convert("RGB")
    gray = image.convert("L")
    return gray if quality == "gray" else gray.point(lambda value: 255 if value >= _THRESHOLD else 0)
