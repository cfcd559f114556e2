"""What is printed in a cell, in which colours, and how it is taken away again without touching ink over it.

The print is red: in the red channel of a photograph it is nearly as bright as the paper, and ink is dark. A
sheet that was printed in black and white shows as gray there what the reader knows to be print.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from rumu.pages.sheet_layout import (
    FRAME_WIDTH,
    LINE_WIDTH,
    OUTLINE_WIDTH,
    TICK,
    Grid,
    SheetCell,
    inner_lines,
)
from rumu.pages.sheet_models import DOT_RADIUS, MasterShape
from rumu.pages.sheet_sharpening import sharpen
from rumu.values import FloatArray

Colour = tuple[float, float, float]

FRAME: Colour = (0.94, 0.47, 0.40)
LINE: Colour = (0.97, 0.66, 0.60)
FAINT: Colour = (1.0, 0.83, 0.79)
OUTLINE: Colour = (0.94, 0.47, 0.40)
DOT: Colour = (0.96, 0.58, 0.52)

_MODELS = {"faint": FAINT, "outlined": OUTLINE, "dots": DOT}
_BRIGHTEST = 1.2  # times the paper around it that paper is at most
_PLAIN = 0.06  # grayness up to which nothing needs to be taken away
_MORE = 1.25  # times as much print as expected is taken away: paper stays white, ink stays dark
_SHIFT = 4  # bits of a fraction of a pixel in OpenCV's drawing


def grayness(red: float, rest: float) -> float:
    """How gray the printed frames are, 0 in colour and 1 in black and white.

    red, rest: by how much they are darker than the paper in the red channel, and in green and blue.
    """
    in_colour = (1 - FRAME[0]) / (1 - (FRAME[1] + FRAME[2]) / 2)
    return float(np.clip((red / max(rest, 1e-3) - in_colour) / (1 - in_colour), 0.0, 1.0))


def take_print_away(
    red: npt.NDArray[np.float32],
    cell: SheetCell,
    grid: Grid,
    master: MasterShape | None,
    *,
    gray: float,
    gamma: float,
    blur: float,
) -> npt.NDArray[np.uint8]:
    """(n, n): what was written in a cell, dark on white, linear in light.

    red: (n, n), the red channel, 1 on bare paper. gray: see `grayness`. gamma: exponent that turns it into
    light. blur: of the photograph, in millimetres, which is taken back.
    """
    if gray > _PLAIN:
        red = red / _printed_light(cell, grid, master, len(red), gray=gray, blur=blur)
    light = np.clip(red, 0, _BRIGHTEST) ** np.float32(gamma)
    sharp = sharpen(light, smear=blur * len(red) / cell.box.width)
    return np.asarray(255 * np.clip(sharp, 0, 1), np.uint8)


def _printed_light(
    cell: SheetCell, grid: Grid, master: MasterShape | None, side: int, *, gray: float, blur: float
) -> npt.NDArray[np.float32]:
    """(side, side): what the print in a cell leaves of the light, 1 on bare paper."""
    import cv2

    light = np.ones((side, side), np.float32)
    scale = side / cell.box.width
    kinds: dict[tuple[float, Colour], list[FloatArray]] = {}
    for ends, width, colour in _lines(cell, grid):
        kinds.setdefault((width, colour), []).append(np.array(ends))
    for (width, colour), lines in kinds.items():
        _draw(light, lines, width * scale, _level(colour, gray), closed=False)
    if cell.model in _MODELS and master is not None:
        level = _level(_MODELS[cell.model], gray)
        if cell.model == "faint":
            light = np.minimum(light, 1 - (1 - level) * (master.filled(side) > 0.2))
        elif cell.model == "outlined":
            _draw(light, master.outlines, OUTLINE_WIDTH * scale, level, closed=True)
        else:
            dots = [np.array([dot, dot]) for dot in master.dots]
            _draw(light, dots, 2 * DOT_RADIUS * side, level, closed=False)
    smear = max(blur * scale, 0.4)
    return np.asarray(cv2.GaussianBlur(light, (0, 0), smear), np.float32)


def _lines(
    cell: SheetCell, grid: Grid
) -> list[tuple[tuple[tuple[float, float], tuple[float, float]], float, Colour]]:
    """The lines of a cell as shares of it, their widths in millimetres and colours."""
    corners = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    sides = list(zip(corners, (*corners[1:], corners[0]), strict=True))
    if grid == "none":
        tick = TICK / cell.box.width
        ends = [
            (start, tuple(a + tick * (b - a) for a, b in zip(start, end, strict=True)))
            for start, end in sides
        ]
        ends += [
            (end, tuple(b + tick * (a - b) for a, b in zip(start, end, strict=True))) for start, end in sides
        ]
        return [((start, (end[0], end[1])), FRAME_WIDTH, FRAME) for start, end in ends]
    return [(side, FRAME_WIDTH, FRAME) for side in sides] + [
        (line, LINE_WIDTH, LINE) for line in inner_lines(grid)
    ]


def _level(colour: Colour, gray: float) -> float:
    """What a printed colour leaves of the red light."""
    luminance = 0.299 * colour[0] + 0.587 * colour[1] + 0.114 * colour[2]
    return max(1 - _MORE * (gray * (1 - luminance) + (1 - gray) * (1 - colour[0])), 0.2)


def _draw(
    light: npt.NDArray[np.float32],
    lines: Sequence[FloatArray],
    width: float,
    level: float,
    *,
    closed: bool,
) -> None:
    """Draw lines, whose points are shares of the picture, as dark as `level`, where it is brighter."""
    import cv2

    side = len(light)
    drawn = np.zeros(light.shape, np.uint8)
    points = [np.round((line * side - 0.5) * (1 << _SHIFT)).astype(np.int32) for line in lines]
    cv2.polylines(drawn, points, closed, 255, max(1, int(np.ceil(width))), cv2.LINE_AA, _SHIFT)
    np.minimum(light, 1 - (1 - level) * drawn.astype(np.float32) / 255, out=light)
