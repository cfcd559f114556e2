"""Surfaces drawn as pictures: 8-bit sRGB arrays, and those as data URIs for a page that needs no network."""

from __future__ import annotations

import base64
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from rumu.capture.stored import to_srgb
from rumu.values import FloatArray, Surface

Picture = npt.NDArray[Any]  # uint8 unless said: (H, W) gray, (H, W, 3) RGB

# Sheets are shown as prints on warm paper, in the light and in the dark page alike.
PAPER = (250, 247, 240)
INK = (38, 36, 34)

# Quiet where the copy agrees, loud where it does not; lightness falls along the scale, so that the order
# survives a grey print and the common kinds of colour blindness.
RESIDUAL_STOPS = ((168, 188, 196), (226, 196, 122), (222, 128, 56), (176, 34, 26))
# Deep to high, with monotone lightness.
HEIGHT_STOPS = ((34, 42, 68), (44, 92, 122), (92, 148, 138), (186, 190, 132), (246, 232, 190))


@dataclass(frozen=True, slots=True)
class PictureSettings:
    """How pictures are made for a page.

    side: longest side in pixels. jpeg_over: bytes of a PNG above which a JPEG is used.
    jpeg_quality: its quality. slant: degrees of the lamp that shades.
    clay: albedo (linear RGB) under which a surface is shaded, so that black ink shows its form.
    """

    side: int = 640
    jpeg_over: int = 220_000
    jpeg_quality: int = 88
    clay: tuple[float, float, float] = (0.86, 0.82, 0.75)
    slant: float = 52.0


_SIDE = PictureSettings().side


def srgb(linear: FloatArray, *, bits: int = 8) -> Picture:
    """(H, W) or (H, W, 3) linear in [0, 1], clipped -> same shape, sRGB (IEC 61966-2-1), 8 or 16 bits."""
    light = np.clip(np.asarray(linear, dtype=np.float32), 0.0, 1.0)
    return np.asarray(np.round(to_srgb(light) * (2**bits - 1)), dtype=np.uint8 if bits == 8 else np.uint16)


def shrink_to_fit(array: npt.NDArray[Any], *, side: int) -> npt.NDArray[Any]:
    """`array` shrunk so that its longer side is at most `side`, by means over pixels; never enlarged."""
    import cv2

    height, width = array.shape[:2]
    scale = side / max(height, width)
    if scale >= 1:
        return array
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    return np.asarray(cv2.resize(array, size, interpolation=cv2.INTER_AREA))


def data_uri(picture: Picture, *, settings: PictureSettings | None = None) -> str:
    """8-bit gray or RGB -> 'data:image/png;base64,...', or a JPEG when the PNG of a photograph is large."""
    settings = settings or PictureSettings()
    kind, data = "png", png_bytes(picture)
    if len(data) > settings.jpeg_over:
        kind, data = "jpeg", _encode(picture, "JPEG", quality=settings.jpeg_quality)
    return f"data:image/{kind};base64,{base64.b64encode(data).decode('ascii')}"


def png_bytes(picture: Picture) -> bytes:
    """The file content of `picture`, uint8 or uint16, gray or RGB."""
    if picture.dtype == np.uint8:
        return _encode(picture, "PNG", compress_level=7)
    import cv2  # Pillow writes no 16-bit colour

    ordered = picture if picture.ndim == 2 else picture[:, :, ::-1]
    return bytes(cv2.imencode(".png", ordered)[1])


def _encode(picture: Picture, kind: str, **options: Any) -> bytes:
    import io

    from PIL import Image

    stream = io.BytesIO()
    Image.fromarray(picture).save(stream, kind, **options)
    return stream.getvalue()


def albedo_picture(surface: Surface, *, settings: PictureSettings | None = None) -> Picture:
    """The sheet as a camera saw it: albedo, brightest percent at white, in sRGB."""
    settings = settings or PictureSettings()
    small = shrink_to_fit(surface.albedo, side=settings.side)
    return srgb(small / max(float(np.percentile(small, 99)), 1e-6))


def shaded_picture(surface: Surface, *, tilt: float, settings: PictureSettings | None = None) -> Picture:
    """The form alone: `surface` under one lamp (tilt in degrees), as if all of one pale clay."""
    from rumu.surface.relight import relight

    settings = settings or PictureSettings()
    pale = np.broadcast_to(np.array(settings.clay, dtype=np.float32), (*surface.height.shape, 3))
    clay = replace(surface, albedo_from=pale)
    lit = relight(clay, tilt=tilt, slant=settings.slant)
    return srgb(shrink_to_fit(np.asarray(lit, dtype=np.float32), side=settings.side))


def normals_picture(surface: Surface) -> Picture:
    """Normals as colours: red = x, green = y, blue = z, each from [-1, 1]; unmeasured pixels are paper."""
    colours = np.round((surface.normals + 1) * 127.5).astype(np.uint8)
    if surface.source == "photometric":
        colours[~surface.mask] = PAPER
    return np.asarray(shrink_to_fit(colours, side=_SIDE))


def height_picture(surface: Surface) -> tuple[Picture, tuple[float, float]]:
    """Height as colours and the range (low, high) of the colour bar, in the surface's unit.

    The range leaves out half a percent at each end, so that one wild pixel does not choose the colours.
    """
    inside = surface.height[surface.mask] if surface.mask.any() else surface.height
    low, high = (float(v) for v in np.percentile(inside, (0.5, 99.5)))
    low = min(low, 0.0) if surface.source != "photometric" else low
    share = shrink_to_fit((surface.height - low) / max(high - low, 1e-12), side=_SIDE)
    picture = colour_scale(share, stops=HEIGHT_STOPS)
    if surface.source == "photometric":
        picture[shrink_to_fit(surface.mask.astype(np.float32), side=_SIDE) < 0.5] = PAPER
    return picture, (low, high)


def share_picture(share: FloatArray) -> Picture:
    """A map of shares in [0, 1] as gray: 0 is dark, 1 is white."""
    return np.asarray(np.round(np.clip(shrink_to_fit(share, side=_SIDE), 0, 1) * 255), dtype=np.uint8)


def colour_scale(share: FloatArray, *, stops: tuple[tuple[int, int, int], ...]) -> Picture:
    """(...,) shares in [0, 1], clipped -> (..., 3) colours between the stops."""
    at = np.linspace(0, 1, len(stops))
    clipped = np.clip(share, 0, 1)
    channels = [np.interp(clipped, at, [stop[c] for stop in stops]) for c in range(3)]
    return np.asarray(np.round(np.stack(channels, axis=-1)), dtype=np.uint8)


def css_gradient(stops: tuple[tuple[int, int, int], ...]) -> str:
    """The same stops as a CSS gradient from left to right, for colour bars."""
    return "linear-gradient(90deg, " + ", ".join(f"rgb({r} {g} {b})" for r, g, b in stops) + ")"
