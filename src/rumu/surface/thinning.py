"""A mask -> its centre lines as pixels, and these pixels as paths between nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rumu.values import BoolArray, FloatArray, IntArray

Bytes = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class Path:
    """One run of the centre line without a fork.

    points: (n, 2) float64, (x, y), from node to node, the nodes' own places included.
    radius: (n,) float64, half-width. ends: numbers of the nodes; both the same for a ring.
    """

    points: FloatArray
    radius: FloatArray
    ends: tuple[int, int]

    @property
    def length(self) -> float:
        return float(np.hypot(*np.diff(self.points, axis=0).T).sum())

    def turned(self) -> Path:
        """The same run, from its other end."""
        return Path(self.points[::-1], self.radius[::-1], (self.ends[1], self.ends[0]))


@dataclass(frozen=True, slots=True, eq=False)
class Thinned:
    """nodes: (k, 2) float64 places (x, y) of forks and ends. paths: what runs between them.

    dots: numbers of the nodes that no path reaches. half_width: (H, W), distance of ink from its edge.
    """

    nodes: FloatArray
    paths: list[Path]
    dots: list[int]
    half_width: FloatArray


def thinned(mask: BoolArray) -> Thinned:
    """The centre lines of a mask (H, W) bool, nothing pruned yet: Zhang and Suen's thinning (1984)."""
    import cv2
    from skimage.morphology import skeletonize

    # one pixel of paper all round: ink at the picture's edge has an edge too, and no pixel wraps round
    padded = np.pad(mask, 1).view(np.uint8)
    deep = (
        cv2.distanceTransform(padded, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) - 0.25
    )  # half a pixel, or none where two share the middle
    line = skeletonize(_smooth(padded, deep))
    nodes, paths, dots = _traced(line, np.maximum(deep, 0.5).astype(float))
    moved = [Path(p.points - 1.0, p.radius, p.ends) for p in paths]
    return Thinned(nodes - 1.0, moved, dots, deep[1:-1, 1:-1])


def _smooth(ink: Bytes, deep: FloatArray) -> BoolArray:
    """The ink with its edges smoothed: every notch of an edge would grow a branch. Hairlines stay."""
    import cv2

    quarter = float(deep[ink > 0].mean())  # of a bar's width: half-widths run evenly from 0 to a half
    spread = max(0.35 * quarter, 0.3)
    soft = cv2.GaussianBlur(255 * ink, (0, 0), spread, borderType=cv2.BORDER_CONSTANT)  # the rim stays bare
    return np.asarray((soft > 127) | (ink.astype(bool) & _lost(soft > 127, ink)))


def _lost(smooth: BoolArray, ink: Bytes) -> BoolArray:
    """Ink farther from what smoothing left than an edge's notch: a hairline, or a dot."""
    import cv2

    away = cv2.distanceTransform((~smooth).view(np.uint8), cv2.DIST_L2, 3)
    far = (away > 1.5) & (ink > 0)
    if not far.any():
        return np.asarray(far)
    _, part = cv2.connectedComponents(((~smooth) & (ink > 0)).view(np.uint8), connectivity=8)
    return np.asarray(np.isin(part, np.unique(part[far])))


def _traced(line: BoolArray, deep: FloatArray) -> tuple[FloatArray, list[Path], list[int]]:
    """Nodes, paths and dots of a line one pixel thin, (H, W) bool with a bare rim."""
    import cv2

    width = line.shape[1]
    around = cv2.filter2D(line.view(np.uint8), -1, np.ones((3, 3), np.uint8)) - 1
    fork = line & (around >= 3)
    count, cluster, _, middles = cv2.connectedComponentsWithStats(fork.view(np.uint8), connectivity=8)
    nodes = [*middles[1:]]
    chains = _chains(np.flatnonzero(line & ~fork), cluster.ravel(), width)
    paths, dots = [], []
    flat = deep.ravel()
    for chain, ends in chains:
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
                place = nodes[end - 1]
                r = flat[round(place[1]) * width + round(place[0])]
                points.insert(side * len(points), place[None])
                radius.insert(side * len(radius), np.array([r]))
                numbers.append(end - 1)
            elif ring and side == 1:
                points.append(xy[:1])
                radius.append(flat[at[:1]])
                numbers.append(numbers[0])
            else:
                numbers.append(len(nodes))
                nodes.append(xy[0] if side == 0 else xy[-1])
        paths.append(Path(np.concatenate(points), np.concatenate(radius), (numbers[0], numbers[1])))
    where = np.array(nodes, dtype=float).reshape(-1, 2)
    return where, paths, dots + [k for k in range(count - 1) if not _reached(k, paths)]


def _reached(node: int, paths: list[Path]) -> bool:
    return any(node in path.ends for path in paths)


def _chains(pixels: IntArray, cluster: IntArray, width: int) -> list[tuple[list[int], tuple[int, int]]]:
    """Runs of neighbouring pixels in order, each with what it ends in.

    pixels: flat indices of those with at most two neighbours. cluster: flat, the number of the fork, 0 off
    forks. An end is the number of a fork, 0 where the line stops, -1 twice for a ring.
    """
    steps = np.array((-width, width, -1, 1, -width - 1, -width + 1, width - 1, width + 1))
    number = np.full(len(cluster), -1, np.intp)
    number[pixels] = np.arange(len(pixels))
    around = pixels[:, None] + steps
    beside = number[around]
    # no pixel has more than two neighbours: the numbers of both, -1 for none
    two = -np.sort(-beside, axis=1)[:, :2]
    near: list[list[int]] = two.tolist()
    place: list[int] = pixels.tolist()
    met = -np.sort(-cluster[around], axis=1)[:, :2]
    forks: list[list[int]] = met.tolist()
    chains: list[tuple[list[int], tuple[int, int]]] = []
    seen = bytearray(len(place))
    for start in np.flatnonzero(two[:, 1] < 0).tolist():
        if not seen[start]:
            chain = _walked(start, near, seen)
            first, last = forks[chain[0]], forks[chain[-1]]
            ends = (first[0], first[1] if len(chain) == 1 else last[0])
            chains.append(([place[k] for k in chain], ends))
    for start in range(len(place)):
        if not seen[start]:
            chains.append(([place[k] for k in _walked(start, near, seen)], (-1, -1)))
    return chains


def _walked(start: int, near: list[list[int]], seen: bytearray) -> list[int]:
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
