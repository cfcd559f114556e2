"""Flat-field frames: photographs of a blank, even sheet, by which the photographs of a capture are divided.

One frame under even light tells the vignetting of the lens; one for each lamp tells how its light falls
off, too. Only what changes slowly is taken from them, so that neither their noise nor their dust comes in.
Their ambient light is not taken off: photograph them in the dark.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rumu.capture.formats import Encoding
from rumu.capture.frames import read_named, size_of
from rumu.capture.photographs import FLAT, FolderImages, as_argument, capture_error
from rumu.image_stack import SATURATION, Floats, ImageStack, Photograph, Pixels
from rumu.values import Bilingual, Capture, FloatArray

_TINY = 1e-3  # least factor, so that nothing becomes 0 or negative


@dataclass(frozen=True, slots=True)
class FlatFrameLimits:
    """When a frame is no flat field, and how fine it is read.

    darkest: median of the frame, as a share of white, below which noise would be divided by. uneven: darkest
        place as a share of the brightest, below which the same holds for a corner. saturated: share of the
        pixels that may be overexposed.
    detail: how far the frame is off what lies around, as a share, from which it shows more than blank paper.
        around: spread of that surrounding, in cells. side: cells of the frame's longer side.
    """

    darkest: float = 0.05
    uneven: float = 0.05
    saturated: float = 0.001
    detail: float = 0.15
    around: float = 6.0
    side: int = 96


@dataclass(frozen=True, slots=True, eq=False)
class SmoothGain:
    """Factors that change slowly, kept in cells. grid: (h, w) float32. shape: (H, W) of the photographs."""

    grid: FloatArray
    shape: tuple[int, int]

    def at(self, pixels: Pixels) -> Floats:
        """(P,) float32 factors of some pixels, linear between the middles of the cells."""
        rows, columns = np.divmod(pixels, self.shape[1])
        top, down = self._between(rows, 0)
        left, across = self._between(columns, 1)
        above = self.grid[top, left] * (1 - across) + self.grid[top, left + 1] * across
        below = self.grid[top + 1, left] * (1 - across) + self.grid[top + 1, left + 1] * across
        return np.clip(above * (1 - down) + below * down, _TINY, 1.0).astype(np.float32)

    def _between(self, places: Pixels, axis: int) -> tuple[Pixels, Floats]:
        """The cell before each place, and how far it lies toward the next; the outermost go on straight."""
        cells, size = self.grid.shape[axis], self.shape[axis]
        at = (places.astype(np.float32) + np.float32(0.5)) * np.float32(cells / size) - np.float32(0.5)
        first = np.clip(at.astype(np.int64), 0, cells - 2)
        return first, (at - first).astype(np.float32)


def smooth_gains(grids: Sequence[FloatArray], shape: tuple[int, int]) -> list[SmoothGain]:
    """Factors of photographs (H, W) from grids (h, w), all by one number so that none is above 1."""
    least = 1 / max(float(one.max()) for one in grids)
    return [SmoothGain((least * one).astype(np.float32), shape) for one in grids]


def unused_flat_notes(folder: Path) -> tuple[Bilingual, ...]:
    """A note where a flat-field frame lies among the photographs and is not used."""
    found = [one for one in FolderImages(folder).images() if FLAT.fullmatch(one.stem)]
    return tuple(
        Bilingual(
            f"{one.name} 是平場照片，沒有用到；--flat-field {as_argument(str(one))} 可用它除去不均勻的光。",
            f"{one.name} is taken for a flat-field frame and not used; --flat-field {as_argument(str(one))} "
            "divides the photographs by it",
        )
        for one in found
    )


def divide_by_flat_frames(
    capture: Capture,
    path: str | os.PathLike[str],
    *,
    encoding: Encoding = "auto",
    limits: FlatFrameLimits | None = None,
) -> Capture:
    """Divide the photographs of a capture by flat-field frames.

    Parameters
    ----------
    capture
        The photographs. They are divided when they are asked for, and keep their own bits until then.
    path
        A frame of a blank, even sheet for all photographs; or a folder of frames. Where the folder's frames
        have the names of the photographs, each is of one lamp; else their mean is taken for all.
    encoding
        Of the frames, as for `read_capture`.
    limits
        When a frame is refused.

    Returns
    -------
    Capture
        With the same lamps. Frames of single lamps also tell the strengths of the lamps, where the capture
        did not know them: what a sheet that faces the camera shows in its middle over the height of the lamp.

    Raises
    ------
    CaptureError
        Naming the frame that is dark, overexposed, of another size, no blank sheet, or not there.
    """
    limits = limits or FlatFrameLimits()
    height, width = capture.mask.shape
    frames, of_lamps = _frames_of(Path(path), capture.names)
    upright = capture.orientation == "exif"
    read = (read_named(one, encoding=encoding, upright=upright)[0] for one in frames)
    lights = [_light_of(one, (height, width), file, limits) for one, file in zip(read, frames, strict=True)]
    single = of_lamps and len(frames) > 1
    fields = lights if single else [np.mean([one / _middle(one) for one in lights], axis=0)]
    gains = smooth_gains([_middle(one) / one for one in fields], (height, width))
    stack: ImageStack = capture.photographs.times(gains if single else gains * len(capture.lights))
    strengths, notes = capture.strengths, [_note(len(frames), single)]
    if single and strengths is None and (capture.lights[:, 2] > 0.05).all():
        told = np.array([_middle(one) for one in lights]) / capture.lights[:, 2]
        strengths = told / told.mean()
    return capture.changed(images=stack, strengths=strengths, notes=(*capture.notes, *notes))


def _frames_of(path: Path, names: Sequence[str]) -> tuple[list[Path], bool]:
    """The frames, one file or those of a folder; and whether each is of one lamp, in their order then."""
    if path.is_file():
        return [path], False
    if not path.is_dir():
        raise capture_error(
            path, en="expected a flat-field frame or a folder of them, there is none", zh="找不到平場照片"
        )
    found = FolderImages(path).photographs
    if not found:
        raise capture_error(path, en="expected flat-field frames, found none", zh="這裡應有平場照片，卻沒有")
    by_stem = {one.stem.casefold(): one for one in found}
    wanted = [Path(name).stem.casefold() for name in names]
    there = [stem in by_stem for stem in wanted]
    if not any(there):
        return found, False
    if not all(there):
        missing = names[there.index(False)]
        raise capture_error(
            path,
            en=f"expected a flat-field frame for each photograph, found none named like {missing}",
            zh=f"每張照片應有同名的平場照片，卻沒有 {missing} 的",
        )
    return [by_stem[stem] for stem in wanted], True


def _light_of(
    photograph: Photograph, shape: tuple[int, int], path: Path, limits: FlatFrameLimits
) -> FloatArray:
    """(h, w) float32: the light that a frame shows, in cells. Raises CaptureError for no flat field."""
    import cv2

    if photograph.samples.shape[:2] != shape:
        raise capture_error(
            path,
            en=f"expected a flat-field frame of {size_of(shape)} pixels as the photographs, got "
            f"{size_of(photograph.samples.shape)}",
            zh=f"平場照片應與照片一樣是 {size_of(shape)} 像素，卻是 {size_of(photograph.samples.shape)}",
        )
    _check_exposure(path, photograph, limits)
    scale = max(1.0, max(shape) / limits.side)
    size = (max(2, round(shape[1] / scale)), max(2, round(shape[0] / scale)))
    frame = ImageStack([photograph]).frame(0)
    gray = np.ascontiguousarray(frame if frame.ndim == 2 else frame.mean(axis=2))
    cells = np.asarray(cv2.resize(gray, size, interpolation=cv2.INTER_AREA))
    light = np.asarray(cv2.GaussianBlur(cells, (0, 0), 1.0, borderType=cv2.BORDER_REPLICATE))
    if light.min() < limits.uneven * light.max():
        raise capture_error(
            path,
            en=f"too uneven for a flat field: its darkest place has {100 * light.min() / light.max():.0f}% "
            "of the brightest",
            zh=f"太不均勻，不能作平場：最暗處只有最亮處的 {100 * light.min() / light.max():.0f}%",
        )
    around = cv2.GaussianBlur(cells, (0, 0), limits.around, borderType=cv2.BORDER_REPLICATE)
    detail = float(np.quantile(np.abs(cells / around - 1), 0.95))
    if detail > limits.detail:
        raise capture_error(
            path,
            en=f"expected a blank, even sheet as flat field, got one with detail of {100 * detail:.0f}%",
            zh=f"平場照片應是空白均勻的紙，這張卻有 {100 * detail:.0f}% 的明暗變化",
        )
    return light


def _check_exposure(path: Path, photograph: Photograph, limits: FlatFrameLimits) -> None:
    white = count = 0
    medians = []
    for part in photograph.parts():
        white += int(np.count_nonzero(part >= SATURATION))
        count += part.size
        medians.append(float(np.median(part)))
    if white > limits.saturated * count:
        raise capture_error(
            path,
            en=f"overexposed: {100 * white / count:.1f}% of this flat-field frame is white, which says "
            "nothing of the light there",
            zh=f"過曝：這張平場照片有 {100 * white / count:.1f}% 是全白，看不出那裡的光",
        )
    middle = float(np.median(medians))
    if middle < limits.darkest:
        raise capture_error(
            path,
            en=f"too dark for a flat field: {100 * middle:.1f}% of white in the median, expected "
            f"{100 * limits.darkest:.0f}% or more",
            zh=f"太暗，不能作平場：中位數只有白的 {100 * middle:.1f}%，至少要 {100 * limits.darkest:.0f}%",
        )


def _middle(light: FloatArray) -> float:
    """The mean of the ninth of the cells in the middle."""
    height, width = light.shape
    part = light[height // 3 : -(height // 3) or None, width // 3 : -(width // 3) or None]
    return float(part.mean())


def _note(count: int, single: bool) -> Bilingual:
    if single:
        return Bilingual(
            f"照片各除以同名的平場照片（{count} 張），燈的強度也取自其中。",
            f"each photograph was divided by the flat-field frame of its lamp ({count} frames), which "
            "also tell the strengths of the lamps",
        )
    return Bilingual(
        f"照片都除以 {count} 張平場照片的平均。",
        f"the photographs were divided by the mean of {count} flat-field frame(s)",
    )
