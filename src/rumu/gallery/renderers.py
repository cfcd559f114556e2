"""Renderers of derived files: each makes the bytes of one kind of file from the assets of a work."""

from __future__ import annotations

import io
import json
import math
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from rumu.errors import GalleryError, ImageError, SurfaceError
from rumu.gallery.assets import Assets, picture_of
from rumu.gallery.vocabulary import HEIGHT_SOURCES
from rumu.values import FloatArray, Surface

if TYPE_CHECKING:
    from PIL.Image import Image as Picture

    from rumu.image_stack import ImageStack

Bytes = npt.NDArray[np.uint8]

THUMB, THUMB_NORMALS, MAP, SHOWN = 256, 128, 1024, 2048  # longest sides, pixels
HEIGHTS = 512**2  # pixels: a long scroll has as many as a square sheet
COVER, COVER_NORMALS = 900, 450  # of the home page, which a phone is to show within two seconds
GLB_BYTES = 5_000_000
_GLB_VERTICES = 60_000
_FINE_VERTICES = 250_000  # of STL and PLY, which are for printing and measuring
_BROWSER_TYPES = {"PNG": "image/png", "JPEG": "image/jpeg", "WEBP": "image/webp"}
_BROWSER_MODES = ("L", "RGB", "P", "1")
_ORIENTATION = 0x0112  # tag of EXIF; 1 is upright


# --- pictures --------------------------------------------------------------------------------------


def render_picture(assets: Assets, *, longest: int, quality: int) -> bytes:
    """The picture, WebP. longest: pixels of its longest side at most."""
    from PIL import Image

    with assets.picture_file() as path:
        picture = picture_of(path, longest=2 * longest)
    if max(picture.size) > longest:
        picture.thumbnail((longest, longest), Image.Resampling.LANCZOS)
    return _webp(picture, quality=quality)


def browser_media_type(path: Path) -> str | None:
    """The media type of a picture that can be sent to browsers unchanged, else None.

    Such a picture has a format that all browsers know, is upright and at most SHOWN pixels long.
    """
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # nothing is decoded here
            image = Image.open(path)
        with image:
            if image.mode not in _BROWSER_MODES or max(image.size) > SHOWN:
                return None
            return (
                _BROWSER_TYPES.get(str(image.format)) if image.getexif().get(_ORIENTATION, 1) == 1 else None
            )
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        return None


def render_photograph(assets: Assets, *, number: int) -> bytes:
    """The photograph under lamp 0, 1 or 2 of the paper (tilt 0, 90 or 180 degrees), WebP in sRGB."""
    from rumu.surface.mesh import albedo_srgb

    photographs, at = lamp_photograph(assets, number)
    light = _reduce(photographs.reduced(at, _size(photographs.shape[1:3], MAP)), MAP)
    return _webp(_image(albedo_srgb(np.clip(light, 0, 1))), quality=95)


def lamp_photograph(assets: Assets, number: int) -> tuple[ImageStack, int]:
    """The photographs of a work, and which of them is that under lamp 0, 1 or 2 of the paper.

    Raises GalleryError for a work that has none under these lamps.
    """
    from rumu.capture.lights import paper_tilts

    capture = None if assets.capture is None else assets.capture()
    lamps = None if capture is None else paper_tilts(capture.lights)
    if capture is None or lamps is None:
        raise GalleryError(
            "expected a work with photographs under the paper's three lamps, this one has none"
        )
    return capture.photographs, lamps.order[number]


# --- maps ------------------------------------------------------------------------------------------


def render_normals(assets: Assets, *, longest: int) -> bytes:
    """Normals: n = value / 127.5 - 1, y up; lossless WebP."""
    packed = io.BytesIO()
    # Method 2 at quality 50 is within a tenth of the smallest file and several times as fast.
    image = _image(normals_8(assets.overview(), longest))
    image.save(packed, "WEBP", lossless=True, method=2, quality=50)
    return packed.getvalue()


def normals_8(surface: Surface, longest: int) -> Bytes:
    """Normals as (h, w, 3) uint8: n = value / 127.5 - 1."""
    mean = _reduce(surface.normals, longest)
    unit = mean / np.maximum(np.linalg.norm(mean, axis=2, keepdims=True), 1e-6)
    return np.asarray(np.round(unit * 127.5 + 127.5)).clip(0, 255).astype(np.uint8)


def render_normals_16(assets: Assets) -> bytes:
    """Normals: n = value / 32767.5 - 1, y up; all pixels of the surface; 16-bit PNG."""
    bands = (np.round((n.astype(np.float64) + 1.0) * 32767.5)[..., ::-1] for n in _bands(assets, "normals"))
    return _png(_levels_16(bands))


def render_albedo(assets: Assets, *, longest: int, quality: int) -> bytes:
    """Albedo in sRGB, WebP."""
    from rumu.surface.mesh import albedo_srgb

    albedo = _reduce(assets.overview().albedo, longest)
    return _webp(_image(albedo_srgb(np.clip(albedo, 0, 1))), quality=quality)


def render_mask(assets: Assets) -> bytes:
    """White on ink, or where a photometric surface was measured; 8-bit PNG."""
    share = _reduce(assets.overview().mask.astype(np.float32), MAP)
    return _png(np.round(share * 255).astype(np.uint8))


def render_height_16(assets: Assets) -> bytes:
    """All pixels of the height: value * scale + offset, both of which are in 'facts'; 16-bit PNG."""
    return _png(_levels_16(height_levels(assets).bands()))


@dataclass(frozen=True, slots=True)
class HeightLevels:
    """The height in whole numbers from 0 to 65535: value * scale + offset is that of the surface.

    shape: (H, W). bands: yields its rows from the top, (rows, W) float64.
    """

    shape: tuple[int, int]
    scale: float
    offset: float
    bands: Callable[[], Iterator[FloatArray]]


def height_levels(assets: Assets) -> HeightLevels:
    """All pixels of the height in 16 bits."""
    scale, offset = _scale_and_offset(assets)
    return HeightLevels(
        _shape(assets),
        scale,
        offset,
        lambda: (np.round((z.astype(np.float64) - offset) / scale) for z in _bands(assets, "height")),
    )


def render_heights(assets: Assets) -> bytes:
    """Height in the surface's unit, float32, little endian, row by row from the top."""
    return _low_heights(assets.overview()).astype("<f4").tobytes()


def _low_heights(surface: Surface) -> FloatArray:
    """The heights that are drawn, of no more than HEIGHTS pixels but for rounding."""
    height, width = surface.height.shape
    longest = max(height, width) * math.sqrt(HEIGHTS / (height * width))
    return _reduce(surface.height, round(longest))


def render_facts(assets: Assets) -> bytes:
    """What the numbers of the maps mean, as JSON."""
    from rumu.capture.lights import paper_tilts

    surface = assets.overview()
    height, width = _shape(assets)
    low = _low_heights(surface)
    map_size = _size((height, width), MAP)
    scale, offset = _scale_and_offset(assets)
    text = HEIGHT_SOURCES[surface.source]
    lamps = None if assets.capture is None else paper_tilts(assets.capture().lights)
    facts = {
        "pixels": list(map_size),
        "aspect": width / height,
        "unit": surface.unit,
        "spacing": surface.spacing * surface.height.shape[1] / map_size[0],
        "source": surface.source,
        "source_text": {"zh": text.zh, "en": text.en},
        "heights": {
            "width": low.shape[1],
            "height": low.shape[0],
            "min": float(low.min()),
            "max": float(low.max()),
        },
        "height16": {"width": width, "height": height, "scale": scale, "offset": offset},
        "quality": {name: float(value) for name, value in surface.quality.items()},
        "three_lamps": None if lamps is None else {"slant": lamps.slant},
    }
    return json.dumps(facts, ensure_ascii=False).encode()


# --- meshes ----------------------------------------------------------------------------------------


def render_glb(assets: Assets, *, exaggeration: float) -> bytes:
    """The textured mesh, at most GLB_BYTES."""
    from rumu.surface.mesh import MeshSettings
    from rumu.surface.mesh_files import mesh_bytes

    surface, vertices, texture = assets.overview(), _GLB_VERTICES, MAP
    while vertices > 1000:
        settings = MeshSettings(exaggeration=exaggeration, vertices=vertices, texture=texture)
        data = mesh_bytes(surface, settings=settings)
        if len(data) <= GLB_BYTES:
            return data
        vertices, texture = vertices * 2 // 3, texture * 3 // 4
    raise SurfaceError(f"expected a mesh below {GLB_BYTES} bytes, the coarsest has {len(data)}")


def render_ply(assets: Assets, *, exaggeration: float) -> bytes:
    """The mesh with coloured vertices, in metres."""
    from rumu.surface.mesh import MeshSettings
    from rumu.surface.mesh_files import mesh_bytes

    settings = MeshSettings(exaggeration=exaggeration, vertices=_FINE_VERTICES)
    return mesh_bytes(assets.overview(), kind="ply", settings=settings)


def render_stl(assets: Assets, *, exaggeration: float, width: float | None, base: float) -> bytes:
    """The closed solid for a printer, in millimetres. width, base: as in MeshSettings."""
    from rumu.surface.mesh import MeshSettings
    from rumu.surface.mesh_files import mesh_bytes

    settings = MeshSettings(exaggeration=exaggeration, vertices=_FINE_VERTICES, width=width, base=base)
    return mesh_bytes(assets.overview(), kind="stl", settings=settings)


# --- arrays and bytes ------------------------------------------------------------------------------


def _shape(assets: Assets) -> tuple[int, int]:
    """(H, W) of the whole surface."""
    if assets.measured is None:
        height, width = assets.surface().height.shape
        return height, width
    with assets.measured() as surface:
        return surface.shape


def _bands(assets: Assets, name: str) -> Iterator[FloatArray]:
    """An array of the whole surface from its top, of a measured one some rows at a time."""
    if assets.measured is None:
        yield getattr(assets.surface(), name)
        return
    with assets.measured() as surface:
        yield from surface.rows(name)


def _levels_16(bands: Iterator[FloatArray]) -> npt.NDArray[np.uint16]:
    return np.concatenate([band.clip(0, 65535).astype(np.uint16) for band in bands])


def _size(shape: tuple[int, ...], longest: int) -> tuple[int, int]:
    """(width, height) whose longest side is at most `longest`; nothing is enlarged. shape: (H, W, ...)."""
    height, width = shape[:2]
    shrink = min(1.0, longest / max(height, width))
    return max(1, round(width * shrink)), max(1, round(height * shrink))


def _reduce(array: FloatArray, longest: int) -> FloatArray:
    import cv2

    size = _size(array.shape, longest)
    if size == array.shape[1::-1]:
        return array
    return np.asarray(cv2.resize(np.ascontiguousarray(array), size, interpolation=cv2.INTER_AREA))


def _scale_and_offset(assets: Assets) -> tuple[float, float]:
    """Scale and offset that map 16-bit values to the height."""
    if assets.measured is None:
        height = assets.surface().height
        low, high = float(height.min()), float(height.max())
    else:
        with assets.measured() as surface:
            low, high = surface.height_range()
    return max(high - low, 1e-12) / 65535.0, low


def _image(values: Bytes) -> Picture:
    from PIL import Image

    return Image.fromarray(values)


def _webp(image: Picture, *, quality: int) -> bytes:
    packed = io.BytesIO()
    image.convert("RGB").save(packed, "WEBP", quality=quality, method=4)
    return packed.getvalue()


def _png(values: npt.NDArray[Any]) -> bytes:
    import cv2

    done, packed = cv2.imencode(".png", np.ascontiguousarray(values))
    if not done:
        raise ImageError(f"expected a picture that PNG can hold, got {values.dtype} {values.shape}")
    return bytes(packed.tobytes())
