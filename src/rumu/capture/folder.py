"""A capture folder becomes a Capture: photographs, lamps, mask, ambient frame, scale.

A folder holds the photographs of one sheet, one lamp each, and one file that says where the lamps stood:

    NAME.dome                RelightLab's, lamps near or far; the images are taken in natural order
    NAME.lp                  names each image beside its lamp; it and the images may lie in folders side by
                             side, as RTIBuilder lays them out
    light_directions*.txt    3 x N or N x 3 numbers; the images are taken in natural order
    NAME.csv, NAME.tsv       a table of names and lamps, x, y, z or angles, see `rumu.capture.lamp_tables`
    capture.json             {"slant": 45} for images a, b, c (tilt 0, 90, 180) and d (270), the paper's kind

and may hold a mask, an ambient frame and, in capture.json beside any of them, spacing_mm, encoding and
orientation.
"""

from __future__ import annotations

import os
from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from rumu.capture.description import DESCRIPTION, Description, description_of, encoding_of, entry_among
from rumu.capture.dome import read_dome, without_fall_off
from rumu.capture.formats import ENCODINGS, Encoding
from rumu.capture.frames import ORIENTATIONS, Orientation, read_frames
from rumu.capture.lamp_files import TABLE_SUFFIXES, kind_of, lamp_file, split_path
from rumu.capture.lamp_tables import read_lamp_table
from rumu.capture.light_files import LampList, read_directions, read_lp
from rumu.capture.lights import direction
from rumu.capture.listed_lamps import check_count, name_notes, photographs_named, told_strengths
from rumu.capture.masks import mask_file, read_folder_mask
from rumu.capture.photographs import (
    FolderImages,
    capture_error,
    photographs_without,
    place,
)
from rumu.errors import CaptureError
from rumu.image_stack import Progress
from rumu.inputs import path_of
from rumu.values import Bilingual, Capture, FloatArray

_PAPER_TILTS = {"a": 0.0, "b": 90.0, "c": 180.0, "d": 270.0}
_ONE_PLANE = 1e-3  # smallest singular value of the lamps that still says three directions


@dataclass(frozen=True, slots=True, eq=False)
class _Lamps:
    """The photographs, their lamps, and the file that says where the lamps stood.

    strengths: (N,) of the lamps, mean 1, None when they are not told. as_shown: whether the lamps are told
    by how the pictures look on a screen. notes: what a person should know. positions: (N, 3) of near lamps,
    in mm; None when they are not told. width: of the photograph in mm; None when it is not told. gone: names
    to leave out of photographs that have a lamp and are not there.
    """

    images: tuple[Path, ...]
    lights: FloatArray
    file: Path
    strengths: FloatArray | None = None
    as_shown: bool = False
    notes: tuple[Bilingual, ...] = ()
    positions: FloatArray | None = None
    width: float | None = None
    gone: frozenset[str] = frozenset()


def read_capture(
    path: str | os.PathLike[str],
    *,
    encoding: Encoding = "auto",
    orientation: Orientation = "auto",
    within: Path | None = None,
    leave_out: Collection[str] = (),
    mm_per_pixel: float | None = None,
    progress: Progress | None = None,
) -> Capture:
    """Read a capture folder.

    Parameters
    ----------
    path : path
        A folder, or the .lp, light_directions*.txt, .csv or capture.json in it that says where the lamps
        stood. Of several kinds in one folder the .lp wins, since it names its images; then
        light_directions*.txt; a .csv comes last.
    encoding : {'auto', 'linear', 'srgb'}
        'auto' takes JPEG, WebP and files with a colour profile for a screen as such, and everything else as
        linear; 'linear' or 'srgb' says it outright, and so does "encoding" in capture.json, which is used
        when `encoding` is 'auto'.
    orientation : {'auto', 'stored', 'exif'}
        'stored' takes the photographs as the sensor saw them, 'exif' turns them as their EXIF orientation
        says; so does "orientation" in capture.json when this is 'auto'. 'auto' turns them only when
        capture.json tells the lamps, which people do by looking at the pictures, and all say the same.
    within : path, optional
        A folder that holds the capture and every file that may be read, such as that of an upload. Without it
        an .lp and capture.json may name files anywhere.
    leave_out : collection of str, optional
        Names of photographs that are not used, with or without their suffix; an .lp may name one that is
        not there.
    mm_per_pixel : float, optional
        Scale of the photographs, instead of what the folder says.
    progress : callable, optional
        Called with what is done, how many parts of it are done and how many there are.

    Returns
    -------
    Capture
        images: (N, H, W) or (N, H, W, 3) float32, linear, in [0, 1], kept in the bits of their files until
        they are asked for; lights: (N, 3) unit vectors toward the lamps; mask: (H, W) bool, all True where no
        mask was found; spacing: millimetres per pixel or None; notes: what was read otherwise than it was
        written.

    Raises
    ------
    CaptureError, ImageError
        Naming the file and what was expected there.

    Notes
    -----
    An image named ambient (the lamps off) is subtracted, and what falls below 0 becomes 0. When any float
    image exceeds 1, all are divided by the one brightest value, so that their ratios stay.
    The mask is "mask" of capture.json, else mask.png, else NAME.mask.png, else mask.png one folder up when
    no photographs lie beside it.
    """
    _check_choice("encoding", encoding, ENCODINGS)
    _check_choice("orientation", orientation, ORIENTATIONS)
    images, description, lamps = _find_files(path, within, leave_out)
    lamps, folder = _without(lamps, [name for name in leave_out if name not in lamps.gone]), images.folder
    turned = (
        entry_among(folder, "orientation", description.orientation, ORIENTATIONS)
        if orientation == "auto"
        else orientation
    )
    frames = read_frames(
        lamps.images,
        as_shown=lamps.as_shown,
        ambient=images.by_stem("ambient"),
        encoding=encoding_of(folder, description, told=encoding),
        orientation=turned,
        progress=progress,
    )
    of_dome = None if lamps.width is None else lamps.width / frames.stack.shape[2]
    spacing = mm_per_pixel or description.spacing_mm or of_dome
    positions, told = _in_pixels(lamps, of_dome or spacing)
    stack = frames.stack if positions is None else without_fall_off(frames.stack, positions)
    return Capture(
        images=stack,  # type: ignore[arg-type]
        lights=lamps.lights,
        mask=read_folder_mask(images, description, frames),
        strengths=lamps.strengths,
        spacing=spacing,
        names=tuple(
            image.relative_to(folder).as_posix() if image.is_relative_to(folder) else str(image)
            for image in lamps.images
        ),
        orientation=frames.orientation,
        notes=(*lamps.notes, *told, *frames.notes),
        lamps_as_given=description.lamps_as_given,
        positions=positions,
    )


def _in_pixels(lamps: _Lamps, spacing: float | None) -> tuple[FloatArray | None, list[Bilingual]]:
    """Places of near lamps in pixels, and a note where no scale tells them. spacing: mm of a pixel."""
    if lamps.positions is None:
        return None, []
    if spacing is not None:
        return lamps.positions / spacing, []
    where = place(lamps.file)
    note = Bilingual(
        f'{where.zh}：有燈的位置，卻沒有照片的寬度（"imageWidth" 為 0），因此只取燈的方向、當作很遠。'
        "請給比例（--mm-per-pixel，或 capture.json 的 spacing_mm）；或用 --near-lamps 由照片求距離。",
        f'{where.en}: tells where the lamps stood, but not how wide the photograph is ("imageWidth" is 0), '
        "so only their directions are used, as if they were far away; give the scale (--mm-per-pixel, or "
        "spacing_mm in capture.json), or find how far away they were from the photographs (--near-lamps)",
    )
    return None, [note]


def check_capture_files(path: str | os.PathLike[str], *, within: Path | None = None) -> None:
    """Raise CaptureError for lamps, names of images or a mask that `read_capture` would refuse.

    No image is read, so that an upload can be refused at once. Arguments: see `read_capture`.
    """
    images, description, _ = _find_files(path, within)
    mask_file(images, description)


def _find_files(
    path: str | os.PathLike[str], within: Path | None, leave_out: Collection[str] = ()
) -> tuple[FolderImages, Description, _Lamps]:
    whole = path_of(path, error_type=CaptureError, expected="the path of a capture folder")
    folder, named = split_path(whole)
    images = FolderImages(folder, within=within)
    images.check_links()
    description = description_of(folder)
    lamps = _read_lamps(images, named, description, leave_out)
    _check_lamps(lamps)
    return images, description, lamps


def _without(lamps: _Lamps, names: Collection[str]) -> _Lamps:
    """The lamps without the photographs of these names. Raises CaptureError for a name of none."""
    images = photographs_without(lamps.file, lamps.images, names)
    if len(images) == len(lamps.images):
        return lamps
    kept = [i for i, image in enumerate(lamps.images) if image in images]
    strengths = None if lamps.strengths is None else lamps.strengths[kept]
    fewer = replace(
        lamps,
        images=tuple(images),
        lights=lamps.lights[kept],
        strengths=None if strengths is None else strengths / strengths.mean(),
        positions=None if lamps.positions is None else lamps.positions[kept],
    )
    _check_lamps(fewer)
    return fewer


def _check_choice(name: str, value: str, known: tuple[str, ...]) -> None:
    if value not in known:
        raise CaptureError(
            f"{name}: expected one of {', '.join(known)}, got {value!r}",
            zh=f"{name} 應是 {'、'.join(known)} 之一，卻是 {value!r}。",
        )


# --- which images, which lamps ---------------------------------------------------------------------


def _read_lamps(
    images: FolderImages, named: Path | None, description: Description, leave_out: Collection[str]
) -> _Lamps:
    folder = images.folder
    file = named or lamp_file(images, description)
    kind = kind_of(file)
    if kind != ".json" and description.slant is not None:
        raise capture_error(
            folder,
            en=f'{file.name} says where the lamps stood and so does "slant" in {DESCRIPTION}; '
            "keep one of them",
            zh=f'{file.name} 與 {DESCRIPTION} 的 "slant" 都說了燈的位置；請只留一個',
        )
    if kind == ".lp":
        return _from_list(file, read_lp(file, images), images, leave_out)
    if kind in TABLE_SUFFIXES:
        return _from_list(file, read_lamp_table(file, images), images, leave_out)
    if kind == ".dome":
        return _from_dome(file, images)
    return _from_json(file, images, description) if kind == ".json" else _from_table(file, images)


def _from_list(path: Path, listed: LampList, images: FolderImages, leave_out: Collection[str]) -> _Lamps:
    """The photographs of the lamps that a file lists: by their names, or in natural order without any."""
    if not listed.named:
        check_count(path, len(listed.lamps), images)
        found, gone = dict(zip(images.photographs, listed.lamps, strict=True)), frozenset[str]()
    else:
        found, gone = photographs_named(listed.lamps, images, leave_out)
    strengths, told = told_strengths(path, tuple(found.values()))
    return _Lamps(
        tuple(found),
        np.array([lamp.light for lamp in found.values()]).reshape(-1, 3),
        path,
        strengths=strengths,
        notes=(*listed.notes, *told, *(name_notes(path, images, found) if listed.named else ())),
        gone=gone,
    )


def _from_table(path: Path, images: FolderImages) -> _Lamps:
    lights = read_directions(path)
    check_count(path, len(lights), images)
    return _Lamps(tuple(images.photographs), lights, path)


def _from_dome(path: Path, images: FolderImages) -> _Lamps:
    dome = read_dome(path)
    check_count(path, len(dome.lights), images)
    found = tuple(images.photographs)
    return _Lamps(
        found, dome.lights, path, strengths=dome.strengths, positions=dome.positions, width=dome.width
    )


def _from_json(path: Path, images: FolderImages, description: Description) -> _Lamps:
    if description.slant is None:
        raise capture_error(
            path,
            en='expected "slant", the degrees of the lamps from straight above',
            zh='這裡應有 "slant"，即燈偏離正上方的度數',
        )
    given = bool(description.tilts)
    tilts = description.tilts or _PAPER_TILTS
    found, lights = [], []
    for stem, tilt in tilts.items():
        image = images.by_stem(stem) or images.find(stem)
        if image is None and (given or stem != "d"):
            raise capture_error(
                path,
                en=f"expected an image named {stem} (such as {stem}.png), found none",
                zh=f"這裡應有名為 {stem} 的照片（如 {stem}.png），卻沒有",
            )
        if image is not None:
            found.append(image)
            lights.append(direction(tilt=tilt, slant=description.slant))
    return _Lamps(tuple(found), np.array(lights), path, as_shown=True)


def _check_lamps(lamps: _Lamps) -> None:
    count = len(lamps.images)
    if count < 3:
        raise capture_error(
            lamps.file,
            en=f"expected at least 3 images, got {count}",
            zh=f"至少要 3 張照片，這裡有 {count} 張",
        )
    if float(np.linalg.svd(lamps.lights, compute_uv=False)[-1]) <= _ONE_PLANE:
        raise capture_error(
            lamps.file,
            en=f"expected lamps from at least three sides, got {count} that lie in one plane",
            zh=f"燈至少要在三個方向，這裡 {count} 盞燈都在同一平面上",
        )
