"""Brush strokes of a glyph, found in its ink alone, so that a fault can be put into one of them.

Our own reconstruction: the skeleton of the ink is a graph; spurs are pruned, forks closer to each other
than the brush is wide are one crossing, and at a crossing the two branches that continue each other best
are one stroke. The brush is a disc that slides along each path, so a stroke keeps the ink it shares with
another. A writer's strokes need not be these: a turning written without lifting is two strokes here.

Positions are (row, column) in pixels; the row grows downward.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from rumu.errors import SurfaceError
from rumu.values import BoolArray, FloatArray, IntArray, Polyline
from rumu_lab.simulation.ink import brush_depth

_EIGHT = np.ones((3, 3), dtype=bool)


@dataclass(frozen=True, slots=True)
class SeparationSettings:
    """How the skeleton becomes strokes; lengths in brush radii at the place itself.

    spur: a twig shorter than this beyond its fork is no stroke.
    crossing: forks joined by less than this are one crossing.
    bend: degrees that a stroke may turn in a crossing. corner: degrees within a stroke at which it is cut.
    """

    spur: float = 1.2
    crossing: float = 1.5
    bend: float = 50.0
    corner: float = 65.0


@dataclass(frozen=True, slots=True, eq=False)
class BrushStroke(Polyline):
    """One brush stroke: the line of its middle, (row, column) in pixels, about one pixel apart.

    free: whether its first and its last end are tips, not joints to another stroke.
    ink: (H, W) bool, its pixels, those that it shares with a crossing stroke included.
    """

    free: tuple[bool, bool]
    ink: BoolArray


def separate(mask: BoolArray, *, settings: SeparationSettings | None = None) -> tuple[BrushStroke, ...]:
    """The brush strokes of an ink mask (H, W) bool, longest first; every ink pixel belongs to one or more.

    Raises SurfaceError when the mask holds no ink.
    """
    from scipy.ndimage import distance_transform_edt

    mask = np.asarray(mask, dtype=bool)
    if mask.ndim != 2 or not mask.any():
        raise SurfaceError(f"expected an (H, W) mask that holds ink, got {mask.shape} with {int(mask.sum())}")
    settings = settings or SeparationSettings()
    # A border of paper, so that ink at the edge of the picture has a middle as well.
    reach = np.asarray(distance_transform_edt(np.pad(mask, 1)))[1:-1, 1:-1]
    paths = _centre_lines(_prune(mask, reach, settings), reach, settings)
    return _share_ink(paths, mask)


# The graph: what lies between forks, and the forks.


@dataclass(frozen=True, slots=True, eq=False)
class _Graph:
    """branches: ordered pixels (N, 2). ends: for each branch the node at its first and last pixel, or -1.

    nodes: (M, 2) float64, the middle of each fork.
    """

    branches: list[IntArray]
    ends: list[tuple[int, int]]
    nodes: FloatArray


def _prune(mask: BoolArray, reach: FloatArray, settings: SeparationSettings) -> _Graph:
    from skimage.morphology import skeletonize

    skeleton = np.asarray(skeletonize(mask))
    for _ in range(6):
        graph = _build_graph(skeleton)
        spurs = [
            b
            for b, e in zip(graph.branches, graph.ends, strict=True)
            if _is_spur(b, e, graph, reach, settings)
        ]
        if not spurs:
            break
        skeleton = skeleton.copy()
        for spur in spurs:
            skeleton[tuple(spur.T)] = False
        skeleton = np.asarray(skeletonize(skeleton))
    return graph


def _is_spur(
    branch: IntArray, ends: tuple[int, int], graph: _Graph, reach: FloatArray, settings: SeparationSettings
) -> bool:
    if (ends[0] < 0) == (ends[1] < 0):
        return False
    fork = graph.nodes[max(ends)]
    radius = _largest_near(reach, fork)
    tip = branch[0] if ends[0] < 0 else branch[-1]
    return float(np.linalg.norm(tip - fork)) < settings.spur * radius


def _build_graph(skeleton: BoolArray) -> _Graph:
    from scipy.ndimage import convolve, label

    crowd = convolve(skeleton.astype(np.int8), _EIGHT.astype(np.int8), mode="constant") - 1
    forks, count = label(skeleton & (crowd >= 3), _EIGHT)
    nodes = np.array([np.argwhere(forks == k + 1).mean(axis=0) for k in range(count)]).reshape(-1, 2)
    pieces, number = label(skeleton & (forks == 0), _EIGHT)
    branches, ends = [], []
    for piece in range(1, number + 1):
        branch = _in_order(np.argwhere(pieces == piece))
        branches.append(branch)
        ends.append(_nodes_at(branch, forks))
    return _Graph(branches, ends, nodes)


def _in_order(pixels: IntArray) -> IntArray:
    """The pixels of a thin curve from one end to the other (or around, when it is closed)."""
    left = {(int(r), int(c)) for r, c in pixels}
    degree = {p: sum(q in left for q in _neighbours(p)) for p in left}
    here = min(left, key=lambda p: (degree[p], p))
    order = [here]
    left.discard(here)
    while left:
        near = [q for q in _neighbours(here) if q in left]
        if not near:
            break
        # A straight neighbour before a diagonal one, or the corner pixel of a staircase is left behind.
        here = min(near, key=lambda q: (abs(q[0] - here[0]) + abs(q[1] - here[1]), q))
        order.append(here)
        left.discard(here)
    return np.array(order)


def _neighbours(p: tuple[int, int]) -> list[tuple[int, int]]:
    return [(p[0] + i, p[1] + j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]


def _nodes_at(branch: IntArray, forks: IntArray) -> tuple[int, int]:
    """The fork beside the first and beside the last pixel of a branch, -1 for a free tip."""
    found = []
    for row, column in (branch[0], branch[-1]):
        window = forks[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2]
        found.append({int(k) - 1 for k in window[window > 0]})
    first, last = found
    if len(branch) == 1:  # a single pixel may join two forks
        both = sorted(first)
        return (both[0], both[1]) if len(both) > 1 else (both[0] if both else -1, -1)
    return (min(first, default=-1), min(last, default=-1))


# The strokes: branches that continue each other across a crossing.


@dataclass(frozen=True, slots=True, eq=False)
class _CentreLine(Polyline):
    free: tuple[bool, bool]


def _centre_lines(graph: _Graph, reach: FloatArray, settings: SeparationSettings) -> list[_CentreLine]:
    crossing, inner = _crossings(graph, reach, settings)
    arms = [  # (crossing, branch, which end of it)
        (crossing[node], b, side)
        for b, ends in enumerate(graph.ends)
        if b not in inner
        for side, node in enumerate(ends)
        if node >= 0
    ]
    centres = {
        k: graph.nodes[[n for n, c in crossing.items() if c == k]].mean(axis=0)
        for k in set(crossing.values())
    }
    wide = {
        k: max(_largest_near(reach, graph.nodes[n]) for n, c in crossing.items() if c == k) for k in centres
    }
    partner: dict[tuple[int, int], tuple[int, int]] = {}
    for k, centre in centres.items():
        here = [(b, side) for node, b, side in arms if node == k]
        partner |= _pair_arms(here, graph, centre, wide[k], settings)
    chains = _chains([b for b in range(len(graph.branches)) if b not in inner], partner)
    joints = {(b, side): (centres[k], wide[k]) for k, b, side in arms}
    whole = [_join(chain, graph, reach, joints) for chain in chains]
    return [piece for path in whole for piece in _cut_at_corners(path, settings)]


def _crossings(
    graph: _Graph, reach: FloatArray, settings: SeparationSettings
) -> tuple[dict[int, int], set[int]]:
    """For each fork the crossing that it belongs to, and the branches that lie inside one."""
    crossing = {n: n for n in range(len(graph.nodes))}
    inner = set()
    for b, (first, last) in enumerate(graph.ends):
        if first < 0 or last < 0 or first == last:
            continue
        radius = (_largest_near(reach, graph.nodes[first]) + _largest_near(reach, graph.nodes[last])) / 2
        if len(graph.branches[b]) < settings.crossing * radius:
            inner.add(b)
            old, new = crossing[last], crossing[first]
            crossing = {n: new if c == old else c for n, c in crossing.items()}
    return crossing, inner


def _pair_arms(
    arms: list[tuple[int, int]],
    graph: _Graph,
    centre: FloatArray,
    radius: float,
    settings: SeparationSettings,
) -> dict[tuple[int, int], tuple[int, int]]:
    """The arms of one crossing in pairs, straightest first; what bends too far stays alone."""
    heading = {arm: _heading(arm, graph, centre, radius) for arm in arms}
    bends = sorted(
        (180.0 - _degrees_between(heading[a], heading[b]), a, b)
        for a, b in combinations(arms, 2)
        if a[0] != b[0]
    )
    partner: dict[tuple[int, int], tuple[int, int]] = {}
    for bend, a, b in bends:
        if a not in partner and b not in partner and bend <= settings.bend:
            partner[a], partner[b] = b, a
    return partner


def _heading(arm: tuple[int, int], graph: _Graph, centre: FloatArray, radius: float) -> FloatArray:
    """Unit vector of an arm away from its crossing, read beyond the ink that the strokes share."""
    branch = graph.branches[arm[0]][:: -1 if arm[1] else 1].astype(np.float64)
    away = np.linalg.norm(branch - centre, axis=1)
    beyond = branch[(away > 0.8 * radius) & (away < 3.0 * radius)]
    direction = beyond[-1] - beyond[0] if len(beyond) > radius else branch[-1] - centre
    return np.asarray(direction / max(float(np.linalg.norm(direction)), 1e-9))


def _chains(
    branches: list[int], partner: dict[tuple[int, int], tuple[int, int]]
) -> list[list[tuple[int, int]]]:
    """Branches in a row, each with the side at which it is entered."""
    chains, seen = [], set()
    # Tips first: a chain that is begun in its middle would be cut there.
    starts = [(b, s) for b in branches for s in (0, 1) if (b, s) not in partner] + [(b, 0) for b in branches]
    for start in starts:
        chain, arm = [], start
        while arm[0] not in seen:
            seen.add(arm[0])
            chain.append(arm)
            leaving = (arm[0], 1 - arm[1])
            if leaving not in partner:
                break
            arm = partner[leaving]
        if chain:
            chains.append(chain)
    return chains


def _join(
    chain: list[tuple[int, int]],
    graph: _Graph,
    reach: FloatArray,
    joints: dict[tuple[int, int], tuple[FloatArray, float]],
) -> _CentreLine:
    """One path through its crossings, straight and evenly wide where another stroke hides it."""
    points, radii = [], []
    for b, side in chain:
        branch = graph.branches[b][:: -1 if side else 1].astype(np.float64)
        clear = np.ones(len(branch), dtype=bool)
        for joint in (joints.get((b, 0)), joints.get((b, 1))):
            if joint is not None:
                clear &= np.linalg.norm(branch - joint[0], axis=1) > 0.9 * joint[1]
        if not clear.any():
            clear[len(branch) // 2] = True
        points.append(branch[clear])
        radii.append(reach[tuple(branch[clear].astype(int).T)])
    first, last = chain[0], (chain[-1][0], 1 - chain[-1][1])
    for arm, at in ((first, 0), (last, -1)):
        if arm in joints:  # a stroke that ends on another reaches into it, no wider than it came
            tip = joints[arm][0][None]
            points[at] = np.concatenate([tip, points[at]] if at == 0 else [points[at], tip])
            radii[at] = np.concatenate([radii[at][:1], radii[at]] if at == 0 else [radii[at], radii[at][-1:]])
    free = (first not in joints, last not in joints)
    return _resample(_CentreLine(np.concatenate(points), np.concatenate(radii), free))


def _resample(path: _CentreLine) -> _CentreLine:
    """The same path with points about one pixel apart."""
    along = path.along
    t = np.linspace(0.0, along[-1], max(int(along[-1]) + 1, 2))
    columns = [np.interp(t, along, values) for values in (*path.points.T, path.radius)]
    return _CentreLine(np.stack(columns[:2], axis=1), columns[2], path.free)


def _cut_at_corners(path: _CentreLine, settings: SeparationSettings) -> list[_CentreLine]:
    """A turning of the brush, 折, ends a stroke when there is a real stroke on both sides of it."""
    n, arm = len(path.points), int(2.0 * np.median(path.radius)) + 2
    turning = np.zeros(n)
    for i in range(arm, n - arm):
        before, after = path.points[i] - path.points[i - arm], path.points[i + arm] - path.points[i]
        turning[i] = _degrees_between(before, after)
    cuts: list[int] = []
    margin = 2 * arm
    while True:
        turning[:margin] = turning[n - margin :] = 0.0
        for cut in cuts:
            turning[max(cut - margin, 0) : cut + margin] = 0.0
        best = int(turning.argmax())
        if turning[best] < settings.corner:
            break
        cuts.append(best)
    marks = [0, *sorted(cuts), n - 1]
    return [
        _CentreLine(
            path.points[a : b + 1],
            path.radius[a : b + 1],
            (path.free[0] and a == 0, path.free[1] and b == n - 1),
        )
        for a, b in pairwise(marks)
    ]


def _share_ink(paths: list[_CentreLine], mask: BoolArray) -> tuple[BrushStroke, ...]:
    """Share the ink out: to the stroke whose brush covers a pixel deepest, and to all that cover it."""
    depth = np.stack([brush_depth(mask.shape, path.points, path.radius) for path in paths])
    owner = depth.argmax(axis=0)
    strokes = [
        BrushStroke(path.points, path.radius, path.free, mask & ((owner == k) | (depth[k] > -0.5)))
        for k, path in enumerate(paths)
    ]
    return tuple(sorted(strokes, key=lambda stroke: (-stroke.length, *stroke.points[0])))


def _largest_near(field: FloatArray, place: FloatArray) -> float:
    """The largest value within a pixel of a place: the middle of a fork need not lie on the skeleton."""
    row, column = (int(v) for v in np.round(place))
    return float(field[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2].max())


def _degrees_between(a: FloatArray, b: FloatArray) -> float:
    length = max(float(np.linalg.norm(a) * np.linalg.norm(b)), 1e-9)
    return float(np.degrees(np.arccos(np.clip(np.dot(a, b) / length, -1.0, 1.0))))
