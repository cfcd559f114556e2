"""How each kind of derived file is made from an original: one function for each, named as in
derived.KINDS."""

from __future__ import annotations

import io
import json
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from rumu.errors import GalleryError, ImageError, SurfaceError
from rumu.gallery.originals import Original
from rumu.gallery.terms import HEIGHT_SOURCES
from rumu.values import FloatArray, Surface

if TYPE_CHECKING:
    from PIL.Image import Image as Picture

Bytes = npt.NDArray[np.uint8]

THUMB, THUMB_NORMALS, MAP, HEIGHTS, SHOWN = 256, 128, 1024, 512, 2048  # longest sides, pixels
GLB_BYTES = 5_000_000
_GLB_VERTICES = 60_000
_PRINT_VERTICES = 250_000  # of STL and PLY: they are made to be printed or measured, not looked at
_BROWSER = {"PNG": "image/png", "JPEG": "image/jpeg", "WEBP": "image/webp"}
_MODES = ("L", "RGB", "P", "1")


# --- pictures --------------------------------------------------------------------------------------


def thumb(original: Original) -> bytes:
    """The picture, WebP."""
    return _webp(_fitted(opened(original.picture()), THUMB), quality=82)


def picture(original: Original) -> bytes:
    """The picture as a browser shows it, WebP."""
    return _webp(_fitted(opened(original.picture()), SHOWN), quality=90)


def shown_as_it_is(data: bytes) -> str | None:
    """The media type of a picture that any browser shows upright and at a bearable size, else None."""
    from PIL import Image

    try:
        with Image.open(io.BytesIO(data)) as image:
            upright = image.getexif().get(0x0112, 1) == 1
            fine = image.format in _BROWSER and image.mode in _MODES and max(image.size) <= SHOWN and upright
            return _BROWSER[str(image.format)] if fine else None
    except (OSError, ValueError, SyntaxError):
        return None


def opened(data: bytes) -> Picture:
    """A picture of the store, upright, 8 bits, gray ('L') or RGB. Raises ImageError when it is none."""
    import tempfile
    from pathlib import Path

    from PIL import Image

    from rumu.capture.formats import decode

    with tempfile.TemporaryDirectory(prefix="rumu-") as folder:
        path = Path(folder) / "picture"
        path.write_bytes(data)
        stored = decode(path)
    values = stored.values
    if values.dtype != np.uint8:
        full = 65535.0 if values.dtype == np.uint16 else 1.0
        values = np.round(np.clip(values.astype(np.float32) / full, 0, 1) * 255).astype(np.uint8)
    if stored.alpha is not None:
        cover = stored.alpha if values.ndim == 2 else stored.alpha[..., None]
        values = np.round(values * cover + 255 * (1 - cover)).astype(np.uint8)
    return Image.fromarray(values)


# --- maps ------------------------------------------------------------------------------------------


def thumb_normals(original: Original) -> bytes:
    """Normals for a thumbnail that answers to a lamp; lossless WebP."""
    return _lossless(_packed_normals(original.surface(), THUMB_NORMALS))


def normals(original: Original) -> bytes:
    """n = value / 127.5 - 1, y up; lossless WebP."""
    return _lossless(_packed_normals(original.surface(), MAP))


def normals_16(original: Original) -> bytes:
    """n = value / 32767.5 - 1, y up; every pixel of the surface; 16-bit PNG."""
    n = original.surface().normals.astype(np.float64)
    return _png(np.round((n + 1.0) * 32767.5).clip(0, 65535).astype(np.uint16)[..., ::-1])


def albedo(original: Original) -> bytes:
    """Albedo in sRGB, WebP."""
    from rumu.surface.mesh import albedo_srgb

    shade = _reduced(original.surface().albedo, MAP)
    return _webp(_picture(albedo_srgb(np.clip(shade, 0, 1))), quality=90)


def mask(original: Original) -> bytes:
    """White on ink, or where a photometric surface was measured; PNG of 8 bits."""
    share = _reduced(original.surface().mask.astype(np.float32), MAP)
    return _png(np.round(share * 255).astype(np.uint8))


def height_16(original: Original) -> bytes:
    """Every pixel of the height: value * scale + offset, both in 'facts'; 16-bit PNG."""
    height = original.surface().height
    scale, offset = _steps(height)
    return _png(np.round((height.astype(np.float64) - offset) / scale).clip(0, 65535).astype(np.uint16))


def heights(original: Original) -> bytes:
    """Height in the unit, float32, little endian, row by row from the top."""
    return _reduced(original.surface().height, HEIGHTS).astype("<f4").tobytes()


def facts(original: Original) -> bytes:
    """What the numbers of the maps mean; JSON."""
    surface = original.surface()
    height, width = surface.height.shape
    of_maps, of_heights = _size(surface.height, MAP), _size(surface.height, HEIGHTS)
    low = _reduced(surface.height, HEIGHTS)
    scale, offset = _steps(surface.height)
    text = HEIGHT_SOURCES[surface.source]
    told = {
        "pixels": list(of_maps),
        "aspect": width / height,
        "unit": surface.unit,
        "spacing": surface.spacing * width / of_maps[0],
        "source": surface.source,
        "source_text": {"zh": text.zh, "en": text.en},
        "heights": {
            "width": of_heights[0],
            "height": of_heights[1],
            "min": float(low.min()),
            "max": float(low.max()),
        },
        "height16": {"width": width, "height": height, "scale": scale, "offset": offset},
        "quality": {name: float(value) for name, value in surface.quality.items()},
        "three_lamps": _three_lamps(original),
    }
    return json.dumps(told, ensure_ascii=False).encode()


# --- the paper's three photographs -----------------------------------------------------------------


def lamp_a(original: Original) -> bytes:
    """The photograph under the lamp at tilt 0, in sRGB."""
    return _photograph(original, 0)


def lamp_b(original: Original) -> bytes:
    """The photograph under the lamp at tilt 90, in sRGB."""
    return _photograph(original, 1)


def lamp_c(original: Original) -> bytes:
    """The photograph under the lamp at tilt 180, in sRGB."""
    return _photograph(original, 2)


def _three_lamps(original: Original) -> dict[str, float] | None:
    from rumu.capture.lights import paper_tilts

    lamps = None if original.capture is None else paper_tilts(original.capture().lights)
    return None if lamps is None else {"slant": lamps.slant}


def _photograph(original: Original, number: int) -> bytes:
    from rumu.capture.lights import paper_tilts
    from rumu.surface.mesh import albedo_srgb

    capture = None if original.capture is None else original.capture()
    lamps = None if capture is None else paper_tilts(capture.lights)
    if capture is None or lamps is None:
        raise GalleryError(
            "expected a work with photographs under the paper's three lamps, this one has none"
        )
    light = _reduced(capture.images[lamps.order[number]], MAP)
    return _webp(_picture(albedo_srgb(np.clip(light, 0, 1))), quality=95)


# --- meshes ----------------------------------------------------------------------------------------


def glb(original: Original, *, exaggeration: float) -> bytes:
    """The textured mesh, at most GLB_BYTES."""
    from rumu.surface.mesh import MeshSettings, mesh_bytes

    surface, vertices, texture = original.surface(), _GLB_VERTICES, MAP
    while vertices > 1000:
        settings = MeshSettings(exaggeration=exaggeration, vertices=vertices, texture=texture)
        data = mesh_bytes(surface, settings=settings)
        if len(data) <= GLB_BYTES:
            return data
        vertices, texture = vertices * 2 // 3, texture * 3 // 4
    raise SurfaceError(f"expected a mesh below {GLB_BYTES} bytes, the coarsest has {len(data)}")


def stl(original: Original, *, exaggeration: float) -> bytes:
    """The mesh in millimetres, to be printed."""
    return _mesh(original, "stl", exaggeration)


def ply(original: Original, *, exaggeration: float) -> bytes:
    """The mesh with coloured vertices, in metres."""
    return _mesh(original, "ply", exaggeration)


def _mesh(original: Original, kind: Any, exaggeration: float) -> bytes:
    from rumu.surface.mesh import MeshSettings, mesh_bytes

    settings = MeshSettings(exaggeration=exaggeration, vertices=_PRINT_VERTICES)
    return mesh_bytes(original.surface(), kind=kind, settings=settings)


# --- arrays and bytes ------------------------------------------------------------------------------


def _size(array: npt.NDArray[Any], longest: int) -> tuple[int, int]:
    """(width, height) when the longest side is at most so long; nothing is enlarged."""
    height, width = array.shape[:2]
    shrink = min(1.0, longest / max(height, width))
    return max(1, round(width * shrink)), max(1, round(height * shrink))


def _reduced(array: FloatArray, longest: int) -> FloatArray:
    import cv2

    size = _size(array, longest)
    if size == array.shape[1::-1]:
        return array
    return np.asarray(cv2.resize(np.ascontiguousarray(array), size, interpolation=cv2.INTER_AREA))


def _packed_normals(surface: Surface, longest: int) -> Bytes:
    mean = _reduced(surface.normals, longest)
    unit = mean / np.maximum(np.linalg.norm(mean, axis=2, keepdims=True), 1e-6)
    return np.asarray(np.round(unit * 127.5 + 127.5)).clip(0, 255).astype(np.uint8)


def _steps(height: FloatArray) -> tuple[float, float]:
    """Scale and offset that bring a height to 16 bits."""
    offset = float(height.min())
    return max(float(height.max()) - offset, 1e-12) / 65535.0, offset


def _fitted(image: Picture, longest: int) -> Picture:
    from PIL import Image

    if max(image.size) <= longest:
        return image
    fitted = image.copy()
    fitted.thumbnail((longest, longest), Image.Resampling.LANCZOS)
    return fitted


def _picture(values: Bytes) -> Picture:
    from PIL import Image

    return Image.fromarray(values)


def _webp(image: Picture, *, quality: int) -> bytes:
    packed = io.BytesIO()
    image.convert("RGB").save(packed, "WEBP", quality=quality, method=4)
    return packed.getvalue()


def _lossless(values: Bytes) -> bytes:
    packed = io.BytesIO()
    # Method 2 at quality 50 is within a tenth of the smallest file and several times as quick.
    _picture(values).save(packed, "WEBP", lossless=True, method=2, quality=50)
    return packed.getvalue()


def _png(values: npt.NDArray[Any]) -> bytes:
    import cv2

    done, packed = cv2.imencode(".png", np.ascontiguousarray(values))
    if not done:
        raise ImageError(f"expected a picture that PNG can hold, got {values.dtype} {values.shape}")
    return bytes(packed.tobytes())
