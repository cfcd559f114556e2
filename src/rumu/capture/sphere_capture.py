"""A folder of photographs whose lamps are told by mirror spheres that lie in them, as a Capture."""

from __future__ import annotations

import os
from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np

from rumu.capture.formats import Encoding
from rumu.capture.photographs import capture_error
from rumu.capture.spheres import FoundLamps, Sphere, find_spheres, lamps_of_spheres
from rumu.capture.unlit import read_unlit_photographs
from rumu.image_stack import Progress
from rumu.values import Bilingual, BoolArray, Capture

_BESIDE = 1.1  # of its radius, within which a sphere and the shadow at its foot are no sheet
_APART = 3.0  # degrees between what two spheres say of a lamp, from which it is noted
_FEWEST = 3  # lamps that a surface takes


def read_sphere_capture(
    path: str | os.PathLike[str],
    *,
    spheres: Sequence[Sphere] = (),
    leave_out: Collection[str] = (),
    encoding: Encoding = "auto",
    progress: Progress | None = None,
) -> Capture:
    """Read a folder of photographs in which mirror spheres tell the lamps.

    Parameters
    ----------
    path : path
        The folder. What it says of lamps is not looked at; encoding, orientation, spacing_mm and mask of its
        capture.json are, and so are a mask and an ambient frame.
    spheres : sequence of Sphere, optional
        Where they are; found by themselves unless they are given.
    leave_out : collection of str, optional
        Names of photographs that are not used, with or without their suffix.
    encoding : {'auto', 'linear', 'srgb'}
        How the samples are read, as of `rumu.read_capture`.
    progress : callable, optional
        Called with what is done, how many parts of it are done and how many there are.

    Returns
    -------
    Capture
        Of the photographs that show their lamp on a sphere; the spheres are outside its mask. With several
        spheres a lamp is the mean direction, and notes say where they differ.

    Raises
    ------
    CaptureError, ImageError
        When there is no sphere, one is too small or outside the photographs, or fewer than three photographs
        show their lamp on it.
    """
    read = read_unlit_photographs(
        path,
        show=Bilingual("有反光球的", "with a mirror sphere"),
        leave_out=leave_out,
        encoding=encoding,
        progress=progress,
    )
    frames, names = read.frames, read.names
    if progress is not None:
        progress("Looking for spheres", 0, 1)
    circles = list(spheres) or find_spheres(frames.stack)
    found = lamps_of_spheres(frames.stack, circles)
    kept = np.flatnonzero(np.isfinite(found.lights[:, 0]))
    if len(kept) < _FEWEST:
        raise capture_error(
            Path(path),
            en=f"expected at least {_FEWEST} photographs that show their lamp on a sphere, got {len(kept)}",
            zh=f"至少要有 {_FEWEST} 張照片在球上看得到燈，這裡只有 {len(kept)} 張",
        )
    mask = read.mask & ~discs(frames.stack.shape[1:3], circles)
    if not mask.any():
        raise capture_error(
            Path(path), en="expected a sheet beside the spheres, got none", zh="球以外沒有可量的部分"
        )
    return Capture(
        images=frames.stack.chosen(kept.tolist()),  # type: ignore[arg-type]
        lights=found.lights[kept],
        mask=mask,
        spacing=read.description.spacing_mm,
        names=tuple(names[i] for i in kept),
        orientation=frames.orientation,
        notes=(_spheres_note(circles), *sphere_notes(names, found), *frames.notes),
        lamps_as_given=read.description.lamps_as_given,
    )


def discs(shape: tuple[int, ...], spheres: Sequence[Sphere]) -> BoolArray:
    """(H, W) bool: what spheres cover, with the shadow at their foot."""
    rows, columns = np.ogrid[: shape[0], : shape[1]]
    covered = np.zeros(shape[:2], bool)
    for one in spheres:
        covered |= (columns - one.x) ** 2 + (rows - one.y) ** 2 <= (_BESIDE * one.radius) ** 2
    return covered


def sphere_notes(names: Sequence[str], found: FoundLamps) -> list[Bilingual]:
    """What is noted of lamps on which spheres differ, and of photographs that show none."""
    notes = []
    for name, apart in zip(names, found.apart, strict=True):
        if apart >= _APART:
            notes.append(
                Bilingual(
                    f"{name}：幾個球說的燈相差 {apart:.1f} 度；燈太近，或有一個球不對。",
                    f"{name}: the spheres say lamps {apart:.1f} degrees apart; the lamp is near, or one is "
                    "wrong",
                )
            )
    dark = [name for name, light in zip(names, found.lights, strict=True) if not np.isfinite(light[0])]
    if dark:
        notes.append(
            Bilingual(
                f"{'、'.join(dark)}：球上看不到燈的反光，沒有使用。",
                f"no highlight is seen in {', '.join(dark)}; left out",
            )
        )
    return notes


def _spheres_note(spheres: Sequence[Sphere]) -> Bilingual:
    places = "; ".join(f"{one.x:.1f}, {one.y:.1f}, {one.radius:.1f}" for one in spheres)
    return Bilingual(
        f"燈的方向取自反光球（球心與半徑，像素）：{places}；球本身不算在表面裡。",
        f"the lamps are those that mirror spheres show (centre and radius in pixels: {places}); the spheres "
        "are no part of the surface",
    )
