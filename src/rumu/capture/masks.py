"""The mask of a capture folder: where it lies, and what it says."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from rumu.capture.description import DESCRIPTION, Description
from rumu.capture.frames import Frames, size_of, with_file_name
from rumu.capture.image import read_mask
from rumu.capture.photographs import FolderImages, capture_error
from rumu.errors import CaptureError, ImageError
from rumu.image_stack import pixels_of
from rumu.values import BoolArray

_LOOKED_AT = 2000  # about how many pixels on either side of a mask are looked at
_BLACK = 0.02  # brightness under the brightest lamp below which nothing is seen
_TIMES = 4.0  # as bright must what an inverted mask leaves out be


def read_folder_mask(images: FolderImages, description: Description, frames: Frames) -> BoolArray:
    """(H, W) of the frames, True where the object is; without a mask where the frames are opaque.

    Raises CaptureError for a mask that cannot be read, of another size, black all over, or inverted.
    """
    shape = frames.stack.shape[1:3]
    path = mask_file(images, description)
    if path is None:
        return np.ones(shape, dtype=bool) if frames.opaque is None else frames.opaque
    try:
        mask = read_mask(path, upright=frames.upright)
    except ImageError as error:
        named = with_file_name(error, path)
        raise CaptureError(f"mask {named}", zh=None if named.zh is None else f"遮罩 {named.zh}") from error
    if mask.shape != shape:
        raise capture_error(
            path,
            en=f"expected a mask of {shape[1]} x {shape[0]} pixels, got {size_of(mask.shape)}",
            zh=f"遮罩應是 {shape[1]} x {shape[0]} 像素，卻是 {size_of(mask.shape)}",
        )
    if not mask.any():
        raise capture_error(
            path,
            en="expected a mask with white where the object is, it is black all over",
            zh="遮罩中物體處應是白色，這裡卻全是黑色",
        )
    _check_not_inverted(path, mask, frames)
    if frames.opaque is not None:
        mask &= frames.opaque
        if not mask.any():
            raise capture_error(
                path,
                en="the photographs are transparent wherever the mask is white",
                zh="遮罩白色處，照片都是透明的",
            )
    return mask


def _check_not_inverted(path: Path, mask: BoolArray, frames: Frames) -> None:
    """Raise CaptureError where what the mask covers is black, and what it leaves out is not."""
    if mask.all():
        return
    pixels = np.concatenate([pixels_of(mask, about=_LOOKED_AT), pixels_of(~mask, about=_LOOKED_AT)])
    values = frames.stack.at(pixels)
    bright = (values if values.ndim == 2 else values.mean(axis=2)).max(axis=0)
    covered = mask.reshape(-1)[pixels]
    inside, outside = float(np.median(bright[covered])), float(np.median(bright[~covered]))
    if inside < _BLACK and outside > _TIMES * max(inside, _BLACK):
        raise capture_error(
            path,
            en="seems to be inverted: what it covers is black under every lamp, what it leaves out is not; "
            "white belongs where the object is",
            zh="似乎黑白相反：白色處在每盞燈下都是黑的，黑色處卻不是；物體處應是白色",
        )


def mask_file(images: FolderImages, description: Description) -> Path | None:
    """The file of the mask: the one that capture.json names, else that of the folder or of the one above.

    Raises CaptureError when the one that is named is not there, or when there are several.
    """
    if description.mask is not None:
        mask = images.find(description.mask, any_suffix=False)
        if mask is None:
            raise capture_error(
                images.folder / DESCRIPTION,
                en=f"expected the mask {description.mask}, there is no such file",
                zh=f"所指的遮罩 {description.mask} 不在這組照片裡；請一併放入",
            )
        return mask
    plain = images.by_stem("mask")
    if plain is not None:
        return plain
    named = [p for p in images.images() if p.stem.lower().endswith(".mask")]
    if len(named) > 1:
        names = ", ".join(p.name for p in named)
        raise capture_error(
            images.folder, en=f"expected one mask, found {names}", zh=f"遮罩應只有一個，卻有 {names}"
        )
    return named[0] if named else _mask_above(images)


def _mask_above(images: FolderImages) -> Path | None:
    """The mask that several captures share, one folder up; not one that belongs to photographs beside it."""
    above = FolderImages(images.folder.resolve().parent)
    try:
        mask = None if above.photographs else above.by_stem("mask")
    except CaptureError:  # the folder above need not be readable, nor in order
        return None
    return mask if mask is not None and images.may_read(mask) else None
