"""The photographs of a folder, whatever it says of lamps: of captures whose lamps the pictures tell."""

from __future__ import annotations

import os
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from rumu.capture.description import Description, description_of, encoding_of, entry_among
from rumu.capture.formats import Encoding
from rumu.capture.frames import ORIENTATIONS, Frames, read_frames
from rumu.capture.masks import read_folder_mask
from rumu.capture.photographs import FolderImages, capture_error, photographs_without
from rumu.image_stack import Progress
from rumu.values import Bilingual, BoolArray

FEWEST = 3
"""Photographs that a surface takes at least, each under another lamp."""


@dataclass(frozen=True, slots=True, eq=False)
class UnlitPhotographs:
    """N photographs. frames: of one size. names: of their files. mask: (H, W). description: of the folder."""

    frames: Frames
    names: tuple[str, ...]
    mask: BoolArray
    description: Description


def read_unlit_photographs(
    path: str | os.PathLike[str],
    *,
    show: Bilingual,
    leave_out: Collection[str] = (),
    encoding: Encoding = "auto",
    progress: Progress | None = None,
) -> UnlitPhotographs:
    """Read the photographs of a folder.

    path: the folder. What it says of lamps is not looked at; encoding, orientation, spacing_mm and mask of
    its capture.json are, and so are a mask and an ambient frame. show: what they are expected to show, for
    messages. leave_out: names of photographs that are not used, with or without their suffix. encoding: how
    the samples are read, as of `rumu.read_capture`.
    Raises CaptureError, ImageError when there are fewer than three or one cannot be read.
    """
    folder = Path(path)
    images, paths = find_photographs(folder, show=show, leave_out=leave_out)
    description = description_of(folder)
    frames = read_frames(
        tuple(paths),
        as_shown=False,
        ambient=images.by_stem("ambient"),
        encoding=encoding_of(folder, description, told=encoding),
        orientation=entry_among(folder, "orientation", description.orientation, ORIENTATIONS),
        progress=progress,
    )
    mask = read_folder_mask(images, description, frames)
    return UnlitPhotographs(frames, tuple(one.name for one in paths), mask, description)


def find_photographs(
    folder: Path, *, show: Bilingual, leave_out: Collection[str]
) -> tuple[FolderImages, list[Path]]:
    """The images of a folder, and those of them that are photographs.

    show: what they are expected to show. Raises CaptureError when there are fewer than three.
    """
    if not folder.is_dir():
        raise capture_error(
            folder,
            en=f"expected a folder of photographs {show.en}, there is none",
            zh=f"這裡應是{show.zh}照片的資料夾，卻沒有",
        )
    images = FolderImages(folder)
    paths = photographs_without(folder, images.photographs, leave_out)
    if len(paths) < FEWEST:
        raise capture_error(
            folder,
            en=f"expected at least {FEWEST} photographs {show.en}, got {len(paths)}",
            zh=f"至少要有 {FEWEST} 張{show.zh}照片，這裡只有 {len(paths)} 張",
        )
    return images, paths
