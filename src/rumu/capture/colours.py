"""Embedded colour profiles (ICC): colours as sRGB, whatever space the camera or the scanner wrote them in."""

from __future__ import annotations

import io
import warnings
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from rumu.capture.primaries import read_primaries
from rumu.capture.stored import Samples, eight_bits, full_scale

if TYPE_CHECKING:
    from PIL.Image import Image as Picture

_SAME = 2  # gray levels within which a profile is sRGB under another name
_STEPS = 9  # of each channel, at which a profile is compared with sRGB
_DARK = 64  # of 255: linear light of that becomes 137 in sRGB, what a screen shows stays near it
_STRIP = 512  # rows that are converted at a time
_MODES = {"RGB": "RGB", "GRAY": "L", "CMYK": "CMYK"}


class ProfileWarning(UserWarning):
    """A colour profile that cannot be used, and is ignored."""


class _UnusableProfileError(Exception):
    """Why a colour profile cannot be used."""


@dataclass(frozen=True, slots=True)
class _Conversion:
    """A profile's way to sRGB. transform: of ImageCms, from pictures of `mode` to RGB."""

    mode: str
    transform: Any

    def colours(self, samples: Samples) -> Samples:
        """(H, W, C) uint8 as (H, W, 3) uint8 sRGB, a strip at a time."""
        from PIL import Image, ImageCms

        converted = np.empty((*samples.shape[:2], 3), np.uint8)
        for top in range(0, len(samples), _STRIP):
            rows = np.ascontiguousarray(samples[top : top + _STRIP])
            strip = Image.fromarray(rows if self.mode != "L" else rows[:, :, 0], self.mode)
            converted[top : top + _STRIP] = np.asarray(ImageCms.applyTransform(strip, self.transform))
        return converted


def to_srgb(samples: Samples, profile: bytes | None, *, name: object) -> Samples:
    """Display-encoded samples in the space of a profile as sRGB.

    samples: (H, W) or (H, W, 3), uint8, uint16 or float32 in [0, 1]. Gray stays gray.
    Returns the samples themselves where the profile is as good as sRGB, and where it cannot be used, which a
    ProfileWarning says. The colour library in Pillow computes with 8 bits: colours of 16 bits keep them only
    where the profile is three curves and a matrix, as those of cameras and screens are. Gray keeps its depth.
    """
    if profile is None:
        return samples
    try:
        conversion = _conversion(profile)
        if samples.ndim == 2:
            return _gray_to_srgb(samples, conversion)
        if conversion.mode != "RGB":
            raise _UnusableProfileError(f"it is one of {conversion.mode} pictures")
        if _is_srgb(conversion):
            return samples
        primaries = read_primaries(profile) if samples.dtype == np.uint16 else None
        return conversion.colours(eight_bits(samples)) if primaries is None else primaries.convert(samples)
    except _UnusableProfileError as error:
        _warn(name, error)
        return samples


def is_for_screen(profile: bytes | None) -> bool:
    """Whether samples of a profile are display-encoded; False of linear light, and of no usable profile."""
    if profile is None:
        return False
    try:
        conversion = _conversion(profile)
    except _UnusableProfileError:
        return False
    if conversion.mode == "CMYK":
        return False
    dark = np.full((1, 1, 3 if conversion.mode == "RGB" else 1), _DARK, np.uint8)
    return int(conversion.colours(dark)[0, 0, 1]) < 1.5 * _DARK


def cmyk_to_rgb(inks: Samples, profile: bytes | None, *, name: object) -> Samples:
    """Four inks (H, W, 4), 0 where there is none, as sRGB: by their profile, else as if they were ideal."""
    if profile is not None:
        try:
            conversion = _conversion(profile)
            if conversion.mode != "CMYK":
                raise _UnusableProfileError(f"it is one of {conversion.mode} pictures")
            return conversion.colours(eight_bits(inks))
        except _UnusableProfileError as error:
            _warn(name, error)
    shares = inks.astype(np.float32)
    shares /= np.float32(full_scale(inks))
    return np.asarray((1 - shares[:, :, :3]) * (1 - shares[:, :, 3:]))


def _warn(name: object, error: Exception) -> None:
    warnings.warn(
        ProfileWarning(f"{name}: the colour profile is ignored, the colours are taken as sRGB ({error})"),
        stacklevel=3,
    )


def profile_of(picture: Picture) -> bytes | None:
    """The embedded profile of a picture that Pillow opened."""
    profile = picture.info.get("icc_profile")
    return profile if isinstance(profile, bytes) and profile else None


@lru_cache(maxsize=16)
def _conversion(profile: bytes) -> _Conversion:
    from PIL import ImageCms

    try:
        opened = ImageCms.ImageCmsProfile(io.BytesIO(profile))
        space = opened.profile.xcolor_space.strip()
        if space not in _MODES:
            raise _UnusableProfileError(f"it is one of {space} pictures")
        transform = ImageCms.buildTransform(
            opened,
            ImageCms.createProfile("sRGB"),
            _MODES[space],
            "RGB",
            renderingIntent=ImageCms.Intent.RELATIVE_COLORIMETRIC,
            flags=ImageCms.Flags.BLACKPOINTCOMPENSATION,
        )
    except (ImageCms.PyCMSError, OSError, ValueError, TypeError) as error:
        raise _UnusableProfileError(str(error) or "it cannot be read") from error
    return _Conversion(_MODES[space], transform)


def _is_srgb(conversion: _Conversion) -> bool:
    steps = np.linspace(0, 255, _STEPS).round().astype(np.uint8)
    lattice = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(_STEPS, -1, 3)
    difference = np.abs(conversion.colours(lattice).astype(np.int16) - lattice)
    return int(difference.max()) <= _SAME


def _gray_to_srgb(samples: Samples, conversion: _Conversion) -> Samples:
    """Gray samples by the curve of the profile; many carry the RGB profile of the picture they come from."""
    if conversion.mode == "CMYK":
        raise _UnusableProfileError("it is one of CMYK pictures")
    levels = np.arange(256, dtype=np.uint8)
    ramp = levels.reshape(1, 256, 1).repeat(3 if conversion.mode == "RGB" else 1, axis=2)
    curve = conversion.colours(ramp)[0, :, 1]
    if int(np.abs(curve.astype(np.int16) - levels).max()) <= _SAME:
        return samples
    if samples.dtype == np.uint8:
        return np.asarray(curve[samples])
    if samples.dtype == np.uint16:
        all_levels = np.interp(np.arange(65536) / 257, levels, curve.astype(np.float64) * 257)
        return np.asarray(np.round(all_levels).astype(np.uint16)[samples])
    return np.interp(samples * np.float32(255), levels, curve / 255).astype(np.float32)
