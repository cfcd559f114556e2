"""The photographs of a capture as one stack: of one size, one way round, linear, less the ambient light."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from rumu.capture.decoded_size import check_memory
from rumu.capture.description import DESCRIPTION
from rumu.capture.formats import Encoding, read_header
from rumu.capture.image import read_frame
from rumu.capture.photographs import capture_error
from rumu.capture.stored import turn
from rumu.errors import ImageError
from rumu.values import Bilingual, BoolArray, FloatArray

_AMBIENT_MARGIN = 0.01  # of white, by which the picture without lamps may be brighter: noise, JPEG

Orientation = Literal["auto", "stored", "exif"]
ORIENTATIONS: tuple[Orientation, ...] = get_args(Orientation)


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """The photographs of a capture.

    images: (N, H, W) or (N, H, W, 3). upright: whether they were turned as EXIF says. orientation: the same
    in words, None where EXIF says nothing. notes: what a person should know.
    """

    images: FloatArray
    upright: bool
    orientation: Literal["stored", "exif"] | None
    notes: tuple[Bilingual, ...]


def read_frames(
    paths: tuple[Path, ...],
    *,
    as_shown: bool,
    ambient: Path | None,
    encoding: Encoding,
    orientation: Orientation,
) -> Frames:
    """The photographs as one stack, less the ambient frame, all turned the same way or none.

    as_shown: whether the lamps are told by how the pictures look on a screen; then 'auto' turns them.
    Raises CaptureError where they differ in size, ImageError where one cannot be read.
    """
    upright = orientation == "exif" or (orientation == "auto" and as_shown)
    images, told = _read_images(
        paths, ambient=ambient, encoding=encoding, upright=upright, alike=orientation == "auto"
    )
    if images is None:  # they say different things
        upright = False
        images, told = _read_images(paths, ambient=ambient, encoding=encoding, upright=False, alike=False)
    assert images is not None
    _check_alike(paths, images)
    notes = _orientation_notes(paths, told, upright=upright)
    return Frames(images, upright, ("exif" if upright else "stored") if notes else None, notes)


def _read_images(
    paths: tuple[Path, ...], *, ambient: Path | None, encoding: Encoding, upright: bool, alike: bool
) -> tuple[FloatArray | None, list[int]]:
    """The stack, and the EXIF orientation of each frame, by which it was turned if `upright`.

    None for the stack where all were to be turned `alike` and their orientations differ.
    """
    check_memory([read_header(path).image_memory() for path in paths], paths[0].parent)
    first, told = _read_one(paths[0], encoding=encoding)
    orientations = [told]
    first = np.ascontiguousarray(turn(first, told)) if upright else first
    dark = None
    if ambient is not None:
        dark, told = _read_one(ambient, encoding=encoding)
        dark = turn(dark, told) if upright else dark
        _check_same_size(ambient, dark, paths[0], first)
    images = np.empty((len(paths), *first.shape), dtype=np.float32)
    for i, path in enumerate(paths):
        if i:
            image, told = _read_one(path, encoding=encoding)
            orientations.append(told)
            if upright and alike and told != orientations[0]:
                return None, orientations
            image = turn(image, told) if upright else image
        else:
            image = first
        _check_same_size(path, image, paths[0], first)
        if ambient is not None and dark is not None:
            _check_ambient(ambient, dark, path, image)
        images[i] = image if dark is None else np.maximum(image - dark, 0)
    peak = float(images.max())
    if peak > 1:
        images /= np.float32(peak)
    return images, orientations


def _check_ambient(ambient: Path, dark: FloatArray, path: Path, image: FloatArray) -> None:
    """Raise CaptureError where a frame is no brighter than without its lamp."""
    if float(np.median(dark)) > float(np.median(image)) + _AMBIENT_MARGIN:
        raise capture_error(
            path,
            en=f"darker than {ambient.name}, which should show the sheet with all lamps off; was this "
            f"lamp off, or one on in {ambient.name}, or the exposure another one?",
            zh=f"比 {ambient.name} 還暗；{ambient.name} 應是關掉所有燈拍的。是這張的燈沒開，"
            f"還是 {ambient.name} 開著燈，或曝光不同",
        )


def _check_alike(paths: tuple[Path, ...], images: FloatArray) -> None:
    """Raise CaptureError when one picture stands under several names: no two photographs are equal.

    Frames that are black or white all over are told later for what they are.
    """
    seen: dict[bytes, int] = {}
    for i, image in enumerate(images):
        first = seen.setdefault(image[image.shape[0] // 2].tobytes(), i)  # a row tells most frames apart
        if first != i and np.ptp(image) > 0 and np.array_equal(image, images[first]):
            raise capture_error(
                paths[i],
                en=f"the same picture as {paths[first].name}, to the last pixel; each lamp needs a "
                "photograph of its own",
                zh=f"與 {paths[first].name} 完全相同；每盞燈要有自己的一張照片",
            )


def _read_one(path: Path, *, encoding: Encoding) -> tuple[FloatArray, int]:
    try:
        return read_frame(path, encoding=encoding)
    except ImageError as error:
        raise with_file_name(error, path) from error


def with_file_name(error: ImageError, path: Path) -> ImageError:
    """The error with the name of the file alone: the folders above it are those of a server, perhaps."""
    zh = None if error.zh is None else error.zh.replace(str(path), path.name)
    return ImageError(str(error).replace(str(path), path.name), zh=zh)


def _orientation_notes(paths: tuple[Path, ...], told: list[int], *, upright: bool) -> tuple[Bilingual, ...]:
    turned = [(path.name, one) for path, one in zip(paths, told, strict=True) if one != 1]
    if not turned:
        return ()
    names = ", ".join(name for name, _ in turned[:4]) + ("..." if len(turned) > 4 else "")
    values = ", ".join(sorted({str(one) for _, one in turned}))
    if upright:
        note = Bilingual(
            f"{names}：依 EXIF 方向（{values}）轉正了照片，燈的方向以轉正後的畫面為準。若燈是按相機存下的畫面"
            f'量的，請在 {DESCRIPTION} 寫 "orientation": "stored"。',
            f"{names}: turned upright as EXIF says (orientation {values}), with the lamps as in the picture "
            "that is shown. If they were measured in the picture that the camera stored, write "
            f'"orientation": "stored" in {DESCRIPTION}',
        )
    else:
        note = Bilingual(
            f"{names}：照片帶有 EXIF 方向（{values}），這裡不轉動照片：拍攝時相機不動，"
            f'燈的方向是按相機存下的畫面量的。若要轉正，請在 {DESCRIPTION} 寫 "orientation": "exif"。',
            f"{names}: EXIF asks to show them turned (orientation {values}); they are read as the camera "
            "stored them, since it stood still and lamps are measured in that picture. To turn them, write "
            f'"orientation": "exif" in {DESCRIPTION}',
        )
    return (note,)


def _check_same_size(path: Path, image: FloatArray, first_path: Path, first: FloatArray) -> None:
    if image.shape[:2] != first.shape[:2]:
        raise capture_error(
            path,
            en=f"expected {size_of(first)} pixels as in {first_path.name}, got {size_of(image)}",
            zh=f"應與 {first_path.name} 一樣是 {size_of(first)} 像素，卻是 {size_of(image)}",
        )
    if image.ndim != first.ndim:
        kinds = {2: Bilingual("灰階", "gray"), 3: Bilingual("彩色", "colour")}
        raise capture_error(
            path,
            en=f"expected {kinds[first.ndim].en} as in {first_path.name}, got {kinds[image.ndim].en}",
            zh=f"應與 {first_path.name} 一樣是{kinds[first.ndim].zh}，卻是{kinds[image.ndim].zh}",
        )


def size_of(image: FloatArray | BoolArray) -> str:
    """Width and height as messages tell them."""
    return f"{image.shape[1]} x {image.shape[0]}"
