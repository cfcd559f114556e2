"""Where a page shows printed lines: darkness beside the paper, without the writing, along and across."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from rumu.values import BoolArray, FloatArray, IntArray

Picture = npt.NDArray[np.uint8]
Map = npt.NDArray[np.float32]
Evidence = Map | npt.NDArray[np.uint16]
"""In whole numbers of two bytes, where it is compared often."""
Moved = TypeVar("Moved", bound=Evidence)


@dataclass(frozen=True, slots=True)
class PrintedLineSettings:
    """What counts as a printed line. Lengths are pixels of the reduced picture unless they say otherwise.

    reduction: pixels along a line that are averaged. half_length: of the piece of a line that is looked at
        together, in reduced pixels. beside: how far beside a line its paper is looked at. cap: darkness above
        which a line counts no more. slopes: a line may lean by these.
    dark, coloured: writing is darker than this, and its colour less than this share of its darkness.
    writing: most, as a share of the longer side, that connected writing measures. thin: at least. bare,
        piece: a piece of a thin grid has fewer pixels than this share of width and height of its box, and is
        longer than this share of the longer side.
    pitch: least distance of parallel lines.
    printed: darkness of what is printed or written.
    framed: least ratio of the sides of a cell's frame that touches no other. rim: share of its side within
        which its lines lie; whole: share of each side that is dark there. alike: natural logarithm by which
        sizes of frames may differ; frames: least number of them.
    """

    reduction: int = 4
    half_length: int = 4
    beside: int = 4
    cap: float = 0.5
    enough: float = 0.05
    slopes: tuple[float, ...] = (-0.09, -0.06, -0.03, 0.0, 0.03, 0.06, 0.09)
    dark: float = 0.2
    coloured: float = 0.5
    writing: float = 0.1
    thin: int = 3
    bare: float = 2.2
    piece: float = 0.03
    pitch: int = 20
    printed: float = 0.12
    framed: float = 0.7
    rim: float = 0.05
    whole: float = 0.95
    alike: float = 0.1
    frames: int = 12


@dataclass(frozen=True, slots=True, eq=False)
class LineEvidence:
    """What speaks for printed lines in a picture (H, W).

    darkness: (H, W), 0 on paper, 1 black. coloured: (H, W), how far its colour is from gray. writing: (H, W)
    bool, what was taken for writing and left out. across: (H, W / reduction), darkness of a short piece of a
    line that runs along x over that of the paper on both sides of it; down: (H / reduction, W), along y.
    frames: (N, 4), centre x and y, width and height of frames of cells that touch no other.
    """

    darkness: Map
    coloured: Map
    writing: BoolArray
    across: Map
    down: Map
    frames: FloatArray = field(default_factory=lambda: np.zeros((0, 4)))


def find_line_evidence(picture: Picture, *, settings: PrintedLineSettings | None = None) -> LineEvidence:
    """Darkness of a picture (H, W, 3), and what speaks for lines along x and along y."""
    settings = settings or PrintedLineSettings()
    darkness, coloured = measure_darkness(picture)
    writing = find_writing(darkness, coloured, settings)
    bare = np.where(writing, np.float32(0), darkness)
    across = _line_response(bare, settings)
    down = np.ascontiguousarray(_line_response(np.ascontiguousarray(bare.T), settings).T)
    return LineEvidence(darkness, coloured, writing, across, down, _find_frames(darkness, settings))


def reduce_evidence(
    evidence: LineEvidence, share: float, *, settings: PrintedLineSettings | None = None
) -> LineEvidence:
    """What speaks for lines in the picture at a share of its size, where a line that is wider is darker, too.

    share: above 0, at most 1.
    """
    import cv2

    settings = settings or PrintedLineSettings()
    bare = np.where(evidence.writing, np.float32(0), evidence.darkness)
    darkness, bare, coloured = (
        cv2.resize(one, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
        for one in (evidence.darkness, bare, evidence.coloured)
    )
    size = darkness.shape[1], darkness.shape[0]
    writing = cv2.resize(evidence.writing.view(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
    across = _line_response(bare, settings)
    down = np.ascontiguousarray(_line_response(np.ascontiguousarray(bare.T), settings).T)
    return LineEvidence(darkness, coloured, writing, across, down)


def measure_darkness(picture: Picture) -> tuple[Map, Map]:
    """How much darker than the paper, in the darkest channel, and how coloured; shares of its level."""
    import cv2

    red, green, blue = cv2.split(picture)
    lightest, darkest = cv2.max(cv2.max(red, green), blue), cv2.min(cv2.min(red, green), blue)
    paper = paper_level(np.asarray(darkest, np.uint8))
    darkness = np.clip((paper - darkest) / paper, 0, 1)
    return darkness, np.asarray(cv2.subtract(lightest, darkest) / paper, np.float32)


def paper_level(channel: Picture) -> Map:
    """(H, W) float32, 40-255: the paper around each pixel of a channel (H, W) uint8, without its writing."""
    import cv2

    height, width = channel.shape
    size = max(1, width // 4), max(1, height // 4)
    small = cv2.dilate(cv2.resize(channel, size, interpolation=cv2.INTER_AREA), np.ones((3, 3), np.uint8))
    side = max(1, min(17, (min(size) - 1) // 2 * 2 + 1))
    paper = cv2.resize(cv2.medianBlur(small, side), (width, height)).astype(np.float32)
    return np.asarray(np.maximum(paper, 40), np.float32)


def find_writing(darkness: Map, coloured: Map, settings: PrintedLineSettings) -> BoolArray:
    """(H, W) bool: dark gray parts of the size of characters, with a margin; a grid is larger."""
    import cv2

    dark = ((darkness > settings.dark) & (coloured < settings.coloured * darkness)).astype(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(dark, connectivity=8)
    sides, area = stats[:, 2:4], stats[:, 4]
    chosen = (sides.max(axis=1) < settings.writing * max(darkness.shape)) & (
        sides.min(axis=1) > settings.thin
    )
    thick = np.bincount(labels[cv2.erode(dark, np.ones((3, 3), np.uint8)) > 0], minlength=len(area))
    longest = settings.piece * max(darkness.shape)
    chosen &= (
        (thick > 0.02 * area) | (area > settings.bare * sides.sum(axis=1)) | (sides.max(axis=1) < longest)
    )
    chosen[0] = False
    frames = _frames_apart(labels, stats, np.flatnonzero(chosen), settings)
    chosen[frames] = False
    writing = chosen.astype(np.uint8)[labels]
    for left, top, wide, high in stats[frames, :4]:  # strokes within that touch the guides are thicker
        rim = max(2, round(settings.rim * max(wide, high)))
        inside = slice(top + rim, top + high - rim), slice(left + rim, left + wide - rim)
        writing[inside] |= cv2.morphologyEx(dark[inside], cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    return np.asarray(cv2.dilate(writing, np.ones((5, 5), np.uint8)) > 0)


def _find_frames(darkness: Map, settings: PrintedLineSettings) -> FloatArray:
    """(N, 4) centre x and y, width and height of the frames that touch no other, of any colour."""
    import cv2

    printed = (darkness > settings.printed).astype(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(printed, connectivity=8)
    boxes = stats[_frames_apart(labels, stats, np.arange(1, len(stats)), settings), :4].astype(float)
    # from the middle of a line to that of the other
    return np.column_stack([boxes[:, :2] + boxes[:, 2:] / 2, np.maximum(1, boxes[:, 2:] - 1)])


def _frames_apart(
    labels: IntArray, stats: IntArray, parts: IntArray, settings: PrintedLineSettings
) -> IntArray:
    """Of dark parts, by their labels, the frames of cells that stand apart: many hollow ones of one size."""
    wide, high = stats[parts, 2:4].T
    shorter, longer = np.minimum(wide, high), np.maximum(wide, high)
    parts = parts[(shorter >= settings.pitch) & (shorter >= settings.framed * longer)]
    frames = []
    for part in parts:
        left, top, wide, high = stats[part, :4]
        dark = labels[top : top + high, left : left + wide] == part
        rim = max(2, round(settings.rim * max(wide, high)))
        sides = (dark[:rim], dark[-rim:], dark[:, :rim].T, dark[:, -rim:].T)
        if min(side.any(axis=0).mean() for side in sides) >= settings.whole:
            frames.append(part)
    found = np.array(frames, np.intp)
    if not len(found):
        return found
    sizes = stats[found, 2:4]
    alike = (np.abs(np.log(sizes / np.median(sizes, axis=0))) < settings.alike).all(axis=1)
    found = found[alike]
    return np.asarray(found if len(found) >= settings.frames else found[:0], np.intp)


def sum_of_moved(values: Moved, steps: Sequence[tuple[int, int]]) -> Moved:
    """The sum of the values at (row + down, column + right) for all of these steps, 0 beyond the border."""
    height, width = values.shape
    total = np.zeros_like(values)
    for down, right in steps:
        if abs(down) < height and abs(right) < width:
            rows, columns = (
                slice(max(0, -step), min(size, size - step))
                for step, size in ((down, height), (right, width))
            )
            from_rows, from_columns = (
                slice(max(0, step), min(size, size + step)) for step, size in ((down, height), (right, width))
            )
            total[rows, columns] += values[from_rows, from_columns]
    return total


def _line_response(bare: Map, settings: PrintedLineSettings) -> Map:
    """(H, W / reduction): darkness along a short piece of a line along x, over the darker of both sides."""
    import cv2

    height, width = bare.shape
    step, k = settings.reduction, settings.beside
    reduced = cv2.resize(
        np.minimum(bare, settings.cap), (max(1, width // step), height), interpolation=cv2.INTER_AREA
    )
    along = range(-settings.half_length, settings.half_length + 1)
    best = np.zeros_like(reduced)
    for slope in settings.slopes:
        piece = sum_of_moved(reduced, [(round(slope * step * j), j) for j in along])
        ridge = piece[k:-k] - np.maximum(piece[: -2 * k], piece[2 * k :])
        np.maximum(best[k:-k], ridge, out=best[k:-k])
    return np.asarray(best / len(along))


def line_pitch(down: Map, *, settings: PrintedLineSettings | None = None) -> int | None:
    """Likeliest distance of lines along y, in pixels, from the response to them (H / reduction, W), or None.

    Each belt of the picture is compared with itself moved sideways, so lines may bend and converge from belt
    to belt. Guides within cells count as lines here.
    """
    import cv2

    settings = settings or PrintedLineSettings()
    width = down.shape[1]
    total = np.zeros(width)
    for belt in _belts(down, settings):
        profile = np.minimum(belt, settings.enough).mean(axis=0)[None]
        profile = np.clip(profile - cv2.blur(profile, (61, 1)), 0, None)
        profile = cv2.GaussianBlur(profile, (0, 0), 1.0)[0]
        spectrum = np.fft.rfft(profile - profile.mean(), 2 * width)
        total += np.fft.irfft(np.abs(spectrum) ** 2)[:width]
    if total[0] <= 0:
        return None
    peaks = [
        k
        for k in range(settings.pitch, int(0.97 * width) - 1)
        if total[k] == total[max(0, k - 6) : k + 7].max() and total[k] > 0
    ]
    if not peaks:
        return None
    return max(peaks, key=lambda k: total[k])


def _belts(down: Map, settings: PrintedLineSettings) -> list[Map]:
    belt = 4 * settings.half_length
    return [down[top : top + belt] for top in range(0, max(1, down.shape[0] - belt // 2), belt)]
