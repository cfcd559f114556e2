"""What the edge of the ink and the white within it look like: torn or clean, open or run shut.

Both are seen at once by anyone who looks at a sheet, wherever its strokes stand.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.values import BoolArray, FloatArray, IntArray, PointSet

SCALE = 96.0
"""Pixels for one rms radius of the writing: finer than the common frame, in which torn edges blur."""
SIDE = 560
"""Pixels along each side of the picture."""


@dataclass(frozen=True, slots=True)
class EdgeSettings:
    """How an edge is looked at. Lengths in pixels of the picture.

    smoothing: of the ink, to see how much of it an even edge would move. outline: of the outline, before its
    turning is summed. shortest: outline below which it is a speck.
    window: side of the square in which the worst place is sought.
    white: half-width from which a white within the ink counts, in pixels of the common frame; reach: how far
    it may have moved there.
    """

    smoothing: float = 3.0
    outline: float = 3.0
    shortest: int = 60
    window: int = 121
    white: float = 2.5
    reach: int = 10


EDGES = EdgeSettings()


@dataclass(frozen=True, slots=True, eq=False)
class EdgeLook:
    """How even the edge of some ink is.

    moved: pixels of ink that smoothing moves, for each pixel of edge. turning: radians for each pixel along
    the smoothed outline. worst: (2,) where most ink is moved, rms radii from the middle, x right, y down.
    worst_share: of all that is moved, in the window there, over the window's share of the edge.
    """

    moved: float
    turning: float
    worst: FloatArray
    worst_share: float


def look_at_edge(mask: BoolArray, points: PointSet) -> EdgeLook:
    """Look at the edge of ink; mask: (H, W); points: of that ink, for its size and place."""
    import cv2

    ink = _enlarge(mask, points)
    smooth = cv2.GaussianBlur(ink.astype(np.float32), (0, 0), EDGES.smoothing) > 0.5
    moved = (smooth != ink).astype(np.float32)
    outlines = [
        line[:, 0, :].astype(float)
        for line in cv2.findContours(ink.view(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)[0]
    ]
    edge = np.zeros(ink.shape, np.float32)
    for line in outlines:
        column, row = line.astype(np.intp).T
        edge[row, column] = 1.0
    side = (EDGES.window, EDGES.window)
    near = cv2.boxFilter(moved, -1, side, normalize=False)
    row, column = np.unravel_index(int(near.argmax()), near.shape)
    beyond = EDGES.window // 2
    mirrored = np.pad(edge, beyond, mode="reflect")  # as the filter has it
    along = float(mirrored[row : row + EDGES.window, column : column + EDGES.window].sum())
    length = max(float(edge.sum()), 1.0)
    share = float(near[row, column]) / max(float(moved.sum()), 1.0)
    return EdgeLook(
        moved=float(moved.sum()) / length,
        turning=_turning(outlines),
        worst=(np.array([column, row]) - (SIDE - 1) / 2) / SCALE,
        worst_share=share / max(along / length, 1e-6),
    )


def _enlarge(mask: BoolArray, points: PointSet) -> BoolArray:
    """(SIDE, SIDE) bool: the ink about its middle, at SCALE."""
    import cv2

    h, w = mask.shape
    longer = max(h, w)
    times = SCALE / (points.radius * longer)
    middle = np.array([w / 2 - 0.5, h / 2 - 0.5]) + points.centre * np.array([longer, -longer])
    image = mask.view(np.uint8) * np.uint8(255)
    if times < 1.0:  # smooth before shrinking, or edges alias
        image = cv2.GaussianBlur(image, (0, 0), 0.4 / times)
    offset = (SIDE - 1) / 2 - times * middle
    M = np.column_stack([times * np.eye(2), offset])
    return np.asarray(cv2.warpAffine(image, M, (SIDE, SIDE), flags=cv2.INTER_LINEAR) > 127)


def _turning(outlines: list[FloatArray]) -> float:
    """Radians of turning for each pixel along the smoothed outlines."""
    from scipy.ndimage import gaussian_filter1d

    turned, length = 0.0, 0.0
    for line in outlines:
        if len(line) < EDGES.shortest:
            continue
        smooth = gaussian_filter1d(line, EDGES.outline, axis=0, mode="wrap")
        step = np.roll(smooth, -1, axis=0) - smooth
        way = np.arctan2(step[:, 1], step[:, 0])
        change = (np.diff(way, append=way[:1]) + np.pi) % (2 * np.pi) - np.pi
        turned += float(np.abs(change).sum())
        length += float(np.hypot(*step.T).sum())
    return turned / max(length, 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class InnerWhite:
    """White that ink encloses.

    pixels: (n, 2) (row, column). half_width: of its widest place, pixels.
    """

    pixels: IntArray
    half_width: float


def find_whites(ink: BoolArray) -> tuple[InnerWhite, ...]:
    """The white that the ink of a picture of the common frame encloses; slits are left out."""
    import cv2

    count, labels = cv2.connectedComponents((~ink).view(np.uint8), connectivity=4)
    depth = cv2.distanceTransform((~ink).view(np.uint8), cv2.DIST_L2, 5)
    outside = labels[0, 0]
    found = []
    for k in range(1, count):
        own = labels == k
        if k != outside and float(depth[own].max()) >= EDGES.white:
            found.append(InnerWhite(np.argwhere(own), float(depth[own].max())))
    return tuple(found)


def white_left(white: InnerWhite, depth: FloatArray) -> float:
    """Half-width of the widest white in a copy where the master has this one, over the master's.

    depth: (H, W) distance of the copy's white to its ink, pixels of the common frame.
    """
    import cv2

    near = np.zeros(depth.shape, np.uint8)
    near[tuple(white.pixels.T)] = 1
    side = 2 * EDGES.reach + 1
    near = cv2.dilate(near, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side)))
    return float(depth[near > 0].max()) / white.half_width
