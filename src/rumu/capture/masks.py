"""The mask of a capture folder: where it lies, and what it says."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from rumu.capture.description import DESCRIPTION, Description
from rumu.capture.frames import Frames, size_of, with_file_name
from rumu.capture.image import read_mask
from rumu.capture.photographs import FolderImages, capture_error
from rumu.errors import CaptureError, ImageError
from rumu.values import BoolArray


def read_folder_mask(images: FolderImages, description: Description, frames: Frames) -> BoolArray:
    """(H, W) of the frames, True where the object is; all True without a mask.

    Raises CaptureError for a mask that cannot be read, of another size, or black all over.
    """
    shape = frames.stack.shape[1:3]
    path = mask_file(images, description)
    if path is None:
        return np.ones(shape, dtype=bool)
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
    return mask


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
