"""A mask becomes centre lines: thinned to single pixels, which are then traced from node to node."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from rumu.capture.image import Bytes
from rumu.values import BoolArray, FloatArray, IntArray, Polyline


@dataclass(frozen=True, slots=True)
class ThinningSettings:
    """How the edges of the ink are smoothed before it is thinned: every notch would grow a branch.

    blur: standard deviation of the smoothing, as a share of half the mean half-width; least_blur: the
        smallest, in pixels. notch: pixels from the smoothed ink beyond which ink that smoothing removed is a
        hairline or a dot, and is put back.
    """

    blur: float = 0.35
    least_blur: float = 0.3
    notch: float = 1.5


@dataclass(frozen=True, slots=True, eq=False)
class Segment(Polyline):
    """A centre line between two nodes, in pixels (x column, y row); a single point for a round dot.

    ends: numbers of the nodes that it runs between, the same twice for a ring or a dot.
    """

    ends: tuple[int, int]

    def reversed(self) -> Self:
        """The same line from its other end."""
        return type(self)(self.points[::-1], self.radius[::-1], self.ends[::-1])


@dataclass(frozen=True, slots=True, eq=False)
class RawSkeleton:
    """The centre lines of a mask, as thinning leaves them.

    nodes: (k, 2) float64, (x, y) of forks, ends and dots. segments: what runs between them.
    half_width: (H, W), distance of each ink pixel from the edge.
    """

    nodes: FloatArray
    segments: list[Segment]
    half_width: FloatArray


def thin(mask: BoolArray, *, settings: ThinningSettings | None = None) -> RawSkeleton:
    """Thin a mask (H, W) bool by the method of Zhang and Suen (1984); nothing is pruned."""
    import cv2
    from skimage.morphology import skeletonize

    # one pixel of paper all round: ink at the picture's edge has an edge too, and no pixel wraps round
    padded = np.pad(mask, 1).view(np.uint8)
    depth = (
        cv2.distanceTransform(padded, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) - 0.25
    )  # half a pixel, or none where two share the middle
    line = skeletonize(_smooth_edges(padded, depth, settings or ThinningSettings()))
    nodes, segments, dots = _trace(line, np.maximum(depth, 0.5).astype(float))
    half_width = depth[1:-1, 1:-1]
    nodes = nodes - 1.0
    inner = [Segment(segment.points - 1.0, segment.radius, segment.ends) for segment in segments]
    inner += [Segment(nodes[k][None], np.array([value_near(half_width, nodes[k])]), (k, k)) for k in dots]
    return RawSkeleton(nodes, inner, half_width)


def value_near(values: FloatArray, point: FloatArray) -> float:
    """The largest of the values (H, W) within a pixel of a point (x, y)."""
    column, row = (round(float(v)) for v in point)
    return float(values[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2].max())


def _smooth_edges(ink: Bytes, depth: FloatArray, settings: ThinningSettings) -> BoolArray:
    """The ink with its edges smoothed; hairlines and dots stay."""
    import cv2

    quarter = float(depth[ink > 0].mean())  # of a bar's width: half-widths run evenly from 0 to a half
    blur = max(settings.blur * quarter, settings.least_blur)
    soft = cv2.GaussianBlur(255 * ink, (0, 0), blur, borderType=cv2.BORDER_CONSTANT)  # the rim stays bare
    smooth = soft > 127
    away = cv2.distanceTransform((~smooth).view(np.uint8), cv2.DIST_L2, 3)
    far = (away > settings.notch) & (ink > 0)
    if not far.any():
        return np.asarray(smooth)
    removed = (~smooth) & (ink > 0)
    _, part = cv2.connectedComponents(removed.view(np.uint8), connectivity=8)
    return np.asarray(smooth | (removed & np.isin(part, np.unique(part[far]))))


def _trace(line: BoolArray, depth: FloatArray) -> tuple[FloatArray, list[Segment], list[int]]:
    """Nodes, segments and numbers of lone nodes of a line one pixel thin, (H, W) bool with a bare rim."""
    import cv2

    width = line.shape[1]
    around = cv2.filter2D(line.view(np.uint8), -1, np.ones((3, 3), np.uint8)) - 1
    fork = line & (around >= 3)
    count, cluster, _, middles = cv2.connectedComponentsWithStats(fork.view(np.uint8), connectivity=8)
    nodes = [*middles[1:]]
    segments, dots = [], []
    flat = depth.ravel()
    for chain, ends in _chain_pixels(np.flatnonzero(line & ~fork), cluster.ravel(), width):
        at = np.array(chain)
        xy = np.column_stack([at % width, at // width]).astype(float)
        if len(chain) == 1 and ends == (0, 0):
            dots.append(len(nodes))
            nodes.append(xy[0])
            continue
        points, radius = [xy], [flat[at]]
        numbers = []
        ring = ends == (-1, -1)
        for side, end in enumerate(ends):
            if end > 0:  # it meets a fork: on to its middle
                middle = nodes[end - 1]
                r = flat[round(middle[1]) * width + round(middle[0])]
                points.insert(side * len(points), middle[None])
                radius.insert(side * len(radius), np.array([r]))
                numbers.append(end - 1)
            elif ring and side == 1:
                points.append(xy[:1])
                radius.append(flat[at[:1]])
                numbers.append(numbers[0])
            else:
                numbers.append(len(nodes))
                nodes.append(xy[0] if side == 0 else xy[-1])
        segments.append(Segment(np.concatenate(points), np.concatenate(radius), (numbers[0], numbers[1])))
    reached = {end for segment in segments for end in segment.ends}
    dots += [k for k in range(count - 1) if k not in reached]
    return np.array(nodes, dtype=float).reshape(-1, 2), segments, dots


def _chain_pixels(pixels: IntArray, cluster: IntArray, width: int) -> list[tuple[list[int], tuple[int, int]]]:
    """Runs of neighbouring pixels in order, each with what it ends in.

    pixels: flat indices of those with at most two neighbours. cluster: flat, the number of the fork, 0 off
    forks. An end is the number of a fork, 0 where the line stops, -1 twice for a ring.
    """
    steps = np.array((-width, width, -1, 1, -width - 1, -width + 1, width - 1, width + 1))
    number = np.full(len(cluster), -1, np.intp)
    number[pixels] = np.arange(len(pixels))
    around = pixels[:, None] + steps
    # no pixel has more than two neighbours: the numbers of both, -1 for none
    two = -np.sort(-number[around], axis=1)[:, :2]
    near: list[list[int]] = two.tolist()
    index: list[int] = pixels.tolist()
    met = -np.sort(-cluster[around], axis=1)[:, :2]
    forks: list[list[int]] = met.tolist()
    chains: list[tuple[list[int], tuple[int, int]]] = []
    seen = bytearray(len(index))
    for start in np.flatnonzero(two[:, 1] < 0).tolist():
        if not seen[start]:
            chain = _walk(start, near, seen)
            first, last = forks[chain[0]], forks[chain[-1]]
            ends = (first[0], first[1] if len(chain) == 1 else last[0])
            chains.append(([index[k] for k in chain], ends))
    for start in range(len(index)):
        if not seen[start]:
            chains.append(([index[k] for k in _walk(start, near, seen)], (-1, -1)))
    return chains


def _walk(start: int, near: list[list[int]], seen: bytearray) -> list[int]:
    """Numbers of the pixels from `start` on, neighbour by neighbour; they are marked in `seen`."""
    chain, at = [start], start
    seen[start] = 1
    while True:
        one, other = near[at]
        ahead = one if one >= 0 and not seen[one] else other
        if ahead < 0 or seen[ahead]:
            return chain
        seen[ahead] = 1
        chain.append(ahead)
        at = ahead
