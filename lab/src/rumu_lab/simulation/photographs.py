"""Photographs of a copy as people send them: printed grids, shades, coloured inks, thin pens, turned pages.

    photograph(ink, grid=Grid("mi", gray=100), shade=Shade(0.5, 90), colour=INKS["vermilion"], seed=1)

They are made of a glyph's ink, laid on paper with grain and blur, and stored as JPEG stores them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from io import BytesIO

import numpy as np
import numpy.typing as npt
from PIL import Image

from rumu.errors import SurfaceError
from rumu.values import BoolArray, FloatArray

Photograph = npt.NDArray[np.uint8]
Colour = tuple[int, int, int]

INKS: Mapping[str, Colour] = {
    "black": (30, 28, 30),
    "red": (222, 22, 22),
    "vermilion": (214, 66, 38),
    "brown": (112, 62, 34),
    "blue-black": (32, 42, 92),
    "blue": (36, 62, 168),
    "green": (24, 110, 60),
}
"""RGB of inks, black among them."""
GRIDS = ("mi", "tian", "jiu", "hui", "fang")
"""米字格 (cross and diagonals), 田字格 (cross), 九宫格 (nine squares), 回宫格 (a square within), 方格."""


@dataclass(frozen=True, slots=True)
class Grid:
    """A printed grid.

    kind: one of GRIDS. gray: level of its lines, 0-255; colour: RGB in its place. width: of its inner lines,
        as a share of the cell; border_width: the same of the border. dashed: inner lines in dashes.
    cells: how many cells stand side by side; only the middle one is whole when there are more.
    cell: side of a cell over the side of the picture. lean: degrees. keystone: share of the side by which
        the far edge is shorter, as a camera that is held obliquely shows it.
    """

    kind: str = "mi"
    gray: int = 100
    colour: Colour | None = None
    width: float = 0.003
    border_width: float = 0.005
    dashed: bool = False
    cells: int = 1
    cell: float = 0.96
    lean: float = 0.0
    keystone: float = 0.0


@dataclass(frozen=True, slots=True)
class Shade:
    """A shade over the page.

    depth: share of the light that is missing where it is deepest. toward: degrees, anticlockwise from the
        right, of the side where that is. edge: its width as a share of the page; 1 is a smooth shade from one
        side to the other, 0.02 the edge of a shadow.
    """

    depth: float
    toward: float = 0.0
    edge: float = 1.0


def photograph(
    ink: npt.NDArray[np.generic],
    *,
    side: int = 640,
    fill: float = 0.8,
    grid: Grid | None = None,
    shade: Shade | None = None,
    colour: Colour = INKS["black"],
    paper: Colour = (244, 240, 228),
    grain: float = 2.0,
    blur: float = 0.7,
    quality: int = 90,
    seed: int = 0,
) -> Photograph:
    """A photograph of ink, (H, W) bool or in [0, 1]: (side, side, 3) uint8.

    fill: side of the glyph's picture over the side of the photograph. grain: standard deviation of the
    paper's levels. blur: of the lens, pixels. quality: of the JPEG.
    """
    import cv2

    rng = np.random.default_rng(seed)
    page: FloatArray = np.tile(np.array(paper, np.float32), (side, side, 1))
    soft = cv2.GaussianBlur(rng.normal(0.0, 1.0, (side, side)).astype(np.float32), (0, 0), 0.8)
    page += (grain * soft / max(float(soft.std()), 1e-6))[:, :, None]
    if grid is not None:
        page = _lay(page, grid_cover(grid, side=side), grid.colour or (grid.gray, grid.gray, grid.gray))
    page = _lay(page, _placed(ink, side=side, fill=fill), colour)
    if shade is not None:
        page = page * light_under(shade, side=side)[:, :, None]
    page = cv2.GaussianBlur(page, (0, 0), blur) if blur else page
    return _through_jpeg(np.clip(np.rint(page), 0, 255).astype(np.uint8), quality)


def thin_pen(mask: BoolArray, *, width: float) -> FloatArray:
    """The glyph's centre lines drawn with a pen of this width, as a share of the side: (H, W) in [0, 1]."""
    import cv2
    from skimage.morphology import skeletonize

    line = skeletonize(np.asarray(mask, bool))
    away = cv2.distanceTransform((~line).astype(np.uint8), cv2.DIST_L2, 5)
    return np.asarray(np.clip(width * max(mask.shape) / 2 + 0.5 - away, 0.0, 1.0), np.float32)


def light_under(shade: Shade, *, side: int) -> FloatArray:
    """(side, side) float32: the share of the light that reaches each pixel."""
    y, x = np.mgrid[0:side, 0:side].astype(np.float32) / (side - 1) - 0.5
    angle = np.deg2rad(shade.toward)
    direction = float(np.cos(angle)), float(-np.sin(angle))
    reach = abs(direction[0]) + abs(direction[1])
    at = (x * direction[0] + y * direction[1]) / reach  # -0.5 to 0.5 over the page
    depth = np.clip(at / max(shade.edge, 1e-3) + 0.5, 0.0, 1.0)
    return np.asarray(1.0 - shade.depth * depth, dtype=np.float32)


def grid_cover(grid: Grid, *, side: int) -> FloatArray:
    """(side, side) float32 in [0, 1]: how far each pixel is covered by lines."""
    import cv2

    fine, bits = 4, 4  # lines are drawn four times as large, at sixteenths of a pixel
    canvas = np.zeros((fine * side, fine * side), np.uint8)
    turn = cv2.getRotationMatrix2D((0.5, 0.5), grid.lean, 1.0)
    turn = np.vstack([turn, [0.0, 0.0, 1.0]])
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
    inset = np.array([[grid.keystone / 2, 0], [1 - grid.keystone / 2, 0], [1, 1], [0, 1]], np.float32)
    place = cv2.getPerspectiveTransform(corners, inset) @ turn
    for start, stop, width, dashed in _lines(grid):
        thickness = max(1, round(width * grid.cell * side * fine))
        for a, b in _dashes(start, stop) if dashed else ((start, stop),):
            ends = cv2.perspectiveTransform(np.array([[a, b]], np.float64), place)[0] * fine * side
            p, q = (tuple(round(float(v) * 2**bits) for v in end) for end in ends)
            cv2.line(canvas, p, q, 255, thickness, cv2.LINE_AA, bits)
    small = cv2.resize(canvas, (side, side), interpolation=cv2.INTER_AREA)
    return np.asarray(small, np.float32) / np.float32(255)


Point = tuple[float, float]


def _lines(grid: Grid) -> Iterator[tuple[Point, Point, float, bool]]:
    """Ends of each line in shares of the picture, its width in shares of the cell, whether it is dashed."""
    if grid.kind not in GRIDS:
        raise SurfaceError(f"expected a grid among {', '.join(GRIDS)}, got {grid.kind!r}")
    around = range(-(grid.cells // 2), grid.cells // 2 + 1)
    for row in around:
        for column in around:
            x0, y0 = 0.5 + (column - 0.5) * grid.cell, 0.5 + (row - 0.5) * grid.cell
            for (ax, ay), (bx, by), border in _cell_lines(grid.kind):
                start = x0 + ax * grid.cell, y0 + ay * grid.cell
                stop = x0 + bx * grid.cell, y0 + by * grid.cell
                yield start, stop, grid.border_width if border else grid.width, grid.dashed and not border


def _cell_lines(kind: str) -> Iterator[tuple[Point, Point, bool]]:
    """Ends of each line in shares of the cell, and whether it is of the border."""
    square = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    for k in range(4):
        yield square[k], square[(k + 1) % 4], True
    if kind in ("mi", "tian", "hui"):
        yield (0.5, 0.0), (0.5, 1.0), False
        yield (0.0, 0.5), (1.0, 0.5), False
    if kind == "mi":
        yield (0.0, 0.0), (1.0, 1.0), False
        yield (1.0, 0.0), (0.0, 1.0), False
    if kind == "jiu":
        for at in (1 / 3, 2 / 3):
            yield (at, 0.0), (at, 1.0), False
            yield (0.0, at), (1.0, at), False
    if kind == "hui":
        inner = [(0.25 + 0.5 * x, 0.2 + 0.6 * y) for x, y in square]
        for k in range(4):
            yield inner[k], inner[(k + 1) % 4], False


def _dashes(
    start: Point, stop: Point, *, dash: float = 0.03, gap: float = 0.02
) -> Iterator[tuple[Point, Point]]:
    """Pieces of a line, lengths in shares of the picture."""
    a, b = np.array(start), np.array(stop)
    length = float(np.linalg.norm(b - a))
    for at in np.arange(0.0, length, dash + gap):
        first, last = a + (b - a) * at / length, a + (b - a) * min(at + dash, length) / length
        yield (float(first[0]), float(first[1])), (float(last[0]), float(last[1]))


def _placed(ink: npt.NDArray[np.generic], *, side: int, fill: float) -> FloatArray:
    """The ink in the middle of the page, (side, side) float32 in [0, 1]."""
    import cv2

    scale = fill * side / max(ink.shape)
    half = np.array(ink.shape[::-1]) / 2
    place = np.array([[scale, 0.0, side / 2 - scale * half[0]], [0.0, scale, side / 2 - scale * half[1]]])
    soft = cv2.GaussianBlur(ink.astype(np.float32), (0, 0), max(0.3 / scale, 0.3))
    return np.asarray(cv2.warpAffine(soft, place, (side, side), flags=cv2.INTER_LINEAR), np.float32)


def _through_jpeg(page: Photograph, quality: int) -> Photograph:
    stored = BytesIO()
    Image.fromarray(page).save(stored, "JPEG", quality=quality)
    with Image.open(stored) as image:
        return np.array(image.convert("RGB"), np.uint8)


def _lay(page: FloatArray, cover: FloatArray, colour: Colour) -> FloatArray:
    """Ink of a colour on the page; where it is laid on a line the darker of both shows."""
    inked = page * (1 - cover[:, :, None]) + np.array(colour, np.float32) * cover[:, :, None]
    return np.minimum(page, inked)
