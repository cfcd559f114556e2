"""Where the straight lines of a photographed page run to, and the view from above that follows from it.

Points and lines are homogeneous and centred: the middle of the picture is the origin, x to the right, y down.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.values import FloatArray


@dataclass(frozen=True, slots=True)
class VanishingSettings:
    """How families of parallel lines are found, and which views of a page are believed.

    pieces: least number of pieces along each way. lean: most lean of a family of lines against the way that
        most pieces run along, in degrees. base: from which turn on, in degrees, that way is asked.
    agreeing: a piece belongs to a vanishing point that lies in its direction within so many degrees; share:
        least share of a family's length that does. draws: pairs of pieces tried.
    steepest: most tilt of the page against the camera, in degrees.
    focal: focal length over the longer side where the picture does not say; least_focal, most_focal: it may
        have.
    """

    pieces: int = 5
    lean: float = 34.0
    base: float = 20.0
    agreeing: float = 1.5
    share: float = 0.55
    draws: int = 600
    steepest: float = 50.0
    focal: float = 0.8
    least_focal: float = 0.5
    most_focal: float = 4.0


def view_by_lines(pieces: FloatArray, longer: int, *, settings: VanishingSettings) -> FloatArray | None:
    """(3, 3) the view from above by straight pieces (n, 4) of two families of lines; None without them.

    pieces: x and y of both ends of each, centred. longer: longer side of the picture, in pixels.
    """
    angle = _angles(pieces)
    lengths = np.hypot(*(pieces[:, 2:] - pieces[:, :2]).T)
    base = _main_way(angle, lengths, settings)
    back = turn_matrix(-base)
    pieces = (pieces.reshape(-1, 2) @ back[:2, :2].T).reshape(-1, 4)
    angle = _angles(pieces)
    level = np.abs((angle + 90) % 180 - 90) < settings.lean
    upright = np.abs(np.abs(angle) - 90) < settings.lean
    points = [_vanishing_point(pieces[family], longer, settings) for family in (level, upright)]
    if points[0] is None or points[1] is None:
        return None
    matrix = view_from_above(points[0], points[1], longer, settings=settings)
    return None if matrix is None else matrix @ back


def _angles(pieces: FloatArray) -> FloatArray:
    return np.asarray(np.degrees(np.arctan2(pieces[:, 3] - pieces[:, 1], pieces[:, 2] - pieces[:, 0])))


def _main_way(angle: FloatArray, lengths: FloatArray, settings: VanishingSettings) -> float:
    """Degrees, -45 to 45, by which most of the length is turned; 0 where the page stands about upright."""
    if not len(angle):
        return 0.0
    counts = np.bincount(np.floor(angle % 90).astype(np.intp) % 90, lengths, minlength=90)
    smooth = sum(np.roll(counts, step) for step in range(-2, 3))
    way = float(np.argmax(smooth)) + 0.5
    way = way - 90 if way > 45 else way
    return way if abs(way) > settings.base else 0.0


def turn_matrix(degrees: float) -> FloatArray:
    """(3, 3) a turn about the origin, from x towards y."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])


def _vanishing_point(pieces: FloatArray, longer: int, settings: VanishingSettings) -> FloatArray | None:
    """(3,) homogeneous, where most of the pieces (n, 4) run to; None where they do not agree."""
    if len(pieces) < settings.pieces:
        return None
    flat = pieces.reshape(-1, 2) / longer
    ends = np.hstack([flat, np.ones((len(flat), 1))]).reshape(-1, 2, 3)
    lines = np.cross(ends[:, 0], ends[:, 1])
    middles, ways = ends.mean(axis=1)[:, :2], ends[:, 1, :2] - ends[:, 0, :2]
    lengths = np.hypot(*ways.T)
    ways = ways / lengths[:, None]
    draw = np.random.default_rng(0).integers(0, len(lines), (settings.draws, 2))
    candidates = np.cross(lines[draw[:, 0]], lines[draw[:, 1]])
    candidates = candidates[np.linalg.norm(candidates, axis=1) > 1e-9]
    if not len(candidates):
        return None
    allowed = np.sin(np.radians(settings.agreeing))
    votes = [float(lengths[_towards(one, middles, ways) < allowed].sum()) for one in candidates]
    best = candidates[int(np.argmax(votes))]
    for _ in range(3):  # the point that lies best on all lines that run to it
        near = _towards(best, middles, ways) < allowed
        if not near.any():
            return None
        weighted = lines[near] / np.hypot(lines[near, 0], lines[near, 1])[:, None] * lengths[near, None]
        best = np.linalg.svd(weighted, full_matrices=False)[2][-1]
    near = _towards(best, middles, ways) < allowed
    if near.sum() < settings.pieces or lengths[near].sum() < settings.share * lengths.sum():
        return None
    return np.asarray(best * [longer, longer, 1.0])


def _towards(point: FloatArray, middles: FloatArray, ways: FloatArray) -> FloatArray:
    """(n,) sine of the angle between each way and the direction to a homogeneous point."""
    to = point[:2] - point[2] * middles
    across = np.abs(ways[:, 0] * to[:, 1] - ways[:, 1] * to[:, 0])
    return np.asarray(across / np.maximum(np.hypot(*to.T), 1e-12))


def view_from_above(
    right: FloatArray, down: FloatArray, longer: int, *, settings: VanishingSettings
) -> FloatArray | None:
    """(3, 3) the view of a camera turned so that both vanishing points lie at infinity, along x and y.

    right, down: (3,) homogeneous and centred. None for a page that would be too steep.
    """
    right, down = (one / np.linalg.norm(one / [longer, longer, 1]) for one in (right, down))
    focal = settings.focal * longer
    if abs(right[2] * down[2]) > 1e-3:
        square = -(right[0] * down[0] + right[1] * down[1]) / (right[2] * down[2])
        if square > 0 and settings.least_focal < np.sqrt(square) / longer < settings.most_focal:
            focal = float(np.sqrt(square))
    camera = np.diag([focal, focal, 1.0])
    first, second = (np.linalg.solve(camera, one) for one in (right, down))
    first, second = (
        first / np.linalg.norm(first) * np.sign(first[0]),
        second / np.linalg.norm(second) * np.sign(second[1]),
    )
    turned = np.stack([first, second, np.cross(first, second)], axis=1)
    if abs(np.linalg.det(turned)) < 0.5 or turned[2, 2] < np.cos(np.radians(settings.steepest)):
        return None
    return np.asarray(camera @ np.linalg.inv(turned) @ np.linalg.inv(camera))


def other_point(known: FloatArray, longer: int, *, settings: VanishingSettings) -> FloatArray:
    """(3,) the vanishing point of the lines across, where only one is known: of the page least tilted."""
    camera = np.diag([settings.focal * longer, settings.focal * longer, 1.0])
    way = np.linalg.solve(camera, known)
    way = way / np.linalg.norm(way)
    normal = np.array([0, 0, 1.0]) - way[2] * way
    return np.asarray(camera @ np.cross(normal / np.linalg.norm(normal), way))
