"""Mirror spheres in the photographs of a capture: found by themselves, and what they say of the lamps.

A polished ball is dark but for the lamp that it mirrors. It stands still while the lamp moves, so its outline
is looked for in the mean of all photographs; what is round but shows no highlight that moves is no such ball.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.capture.lights import from_sphere
from rumu.errors import CaptureError
from rumu.image_stack import ImageStack
from rumu.values import FloatArray

_INNER = 0.75  # of the radius, within which a lamp on the camera's side is mirrored, with some to spare
_LEVEL = 1 / 255  # a step of 8 bits, below which no photograph is sure


@dataclass(frozen=True, slots=True)
class SphereSettings:
    """How spheres are looked for.

    side: pixels of the longer side that photographs are reduced to first.
    smallest, largest: radius, as a share of the shorter side. perfect: of cv2.HOUGH_GRADIENT_ALT, how round a
        circle must be. candidates: circles tried.
    reach: share of the radius within which the outline is looked for around a candidate, halved each round of
        `rounds`. near: share of the radius within which a point of the outline agrees. agreeing: share of the
        points that must.
    seen: share of the photographs that must show a highlight. moved: share of the radius by which the
        highlight must move. highlight: most of the inner disc that it takes.
        prominence: times the spread of the inner disc by which it stands out.
    least_radius: pixels, below which a direction is a matter of single pixels. floors: see `_logarithm`; the
        first shows the outline, all show candidates.
    """

    side: int = 1000
    smallest: float = 0.03
    largest: float = 0.6
    perfect: float = 0.55
    candidates: int = 12
    reach: float = 0.12
    rounds: int = 4
    near: float = 0.015
    agreeing: float = 0.63
    seen: float = 0.5
    moved: float = 0.05
    highlight: float = 0.02
    prominence: float = 10.0
    least_radius: float = 12.0
    floors: tuple[float, ...] = (0.01, 0.003, 0.03)


@dataclass(frozen=True, slots=True)
class Sphere:
    """The outline of a sphere in the photographs: centre (x, y) and radius, in pixels.

    Counted from the top left corner; 0 is the middle of the first pixel.
    """

    x: float
    y: float
    radius: float


def find_spheres(stack: ImageStack, *, settings: SphereSettings | None = None) -> list[Sphere]:
    """The mirror spheres that the photographs show, the largest first.

    Raises CaptureError when there is none.
    """
    settings = settings or SphereSettings()
    height, width = stack.shape[1:3]
    scale = max(1.0, max(height, width) / settings.side)
    size = (round(width / scale), round(height / scale))
    frames = [frame if frame.ndim == 2 else frame.mean(axis=2) for frame in _reduced(stack, size)]
    mean = np.mean(frames, axis=0)
    picture = _logarithm(mean, settings.floors[0])
    views = (picture, *(_logarithm(mean, floor) for floor in settings.floors[1:]))
    circles = [_refined(picture, one, settings) for view in views for one in _candidates(view, settings)]
    found: list[Sphere] = []
    for circle, share in sorted(circles, key=lambda pair: -pair[1]):
        if share < settings.agreeing or any(_overlap(circle, other) for other in found):
            continue
        if _shows_a_lamp(frames, circle, settings):
            found.append(circle)
    if not found:
        least = max(round(settings.smallest * min(height, width)), round(settings.least_radius))
        raise CaptureError(
            f"expected a mirror sphere of a radius of {least} pixels or more, found none that is round and "
            "shows a lamp that moves; give it as --sphere x,y,r: its centre from the top left corner and its "
            "radius, in pixels",
            zh=f"找不到反光的球：應是圓的，半徑至少 {least} 像素，且映出移動的燈；請用 --sphere x,y,r "
            "指出球心（從左上角起）與半徑（像素）。",
        )
    ratio = np.array([width / size[0], height / size[1]])
    return sorted(
        (
            Sphere((one.x + 0.5) * ratio[0] - 0.5, (one.y + 0.5) * ratio[1] - 0.5, one.radius * ratio.mean())
            for one in found
        ),
        key=lambda one: -one.radius,
    )


def _logarithm(light: FloatArray, floor: float) -> FloatArray:
    """The logarithm of light; floor: what is added, so that noise in the dark makes no edges."""
    return np.asarray(np.log(light + np.float32(floor)), dtype=np.float32)


def _reduced(stack: ImageStack, size: tuple[int, int]) -> list[FloatArray]:
    return [stack.reduced(number, size) for number in range(len(stack))]


def _candidates(picture: FloatArray, settings: SphereSettings) -> list[Sphere]:
    """Circles in a picture (h, w), by the Hough transform, the surest first."""
    import cv2

    low, high = np.quantile(picture, [0.02, 0.98])
    levels = np.clip((picture - low) / max(high - low, 1e-6) * 255, 0, 255).astype(np.uint8)
    levels = cv2.GaussianBlur(levels, (0, 0), 1.5)
    shorter = min(picture.shape)
    circles = cv2.HoughCircles(
        levels,
        cv2.HOUGH_GRADIENT_ALT,
        dp=1.5,
        minDist=settings.smallest * shorter,
        param1=60,
        param2=settings.perfect,
        minRadius=max(4, round(settings.smallest * shorter)),
        maxRadius=round(settings.largest * shorter),
    )
    if circles is None:
        return []
    return [
        Sphere(*map(float, one[:3])) for one in circles.reshape(-1, circles.shape[-1])[: settings.candidates]
    ]


def _refined(picture: FloatArray, circle: Sphere, settings: SphereSettings) -> tuple[Sphere, float]:
    """The circle through the outline near a candidate, and the share of the outline that agrees.

    Along each radius the strongest edge is taken; a stand or a shadow that hides part of it is outvoted.
    """
    import cv2

    angles = np.linspace(0, 2 * np.pi, 360, endpoint=False)
    share, reach = 0.0, settings.reach
    for _ in range(settings.rounds):
        radii = circle.radius * np.linspace(1 - reach, 1 + reach, 121)
        x = (circle.x + np.outer(np.cos(angles), radii)).astype(np.float32)
        y = (circle.y + np.outer(np.sin(angles), radii)).astype(np.float32)
        profile = cv2.remap(picture, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        edge = np.abs(np.diff(cv2.GaussianBlur(profile, (0, 0), 2.0), axis=1))
        inside = (x >= 0) & (x < picture.shape[1]) & (y >= 0) & (y < picture.shape[0])
        edge = np.where(inside[:, 1:], edge, 0)
        at = np.argmax(edge, axis=1)
        rows = np.arange(len(angles))
        strong = edge[rows, at] > 0.25 * np.median(edge[rows, at])
        radius = 0.5 * (radii[at] + radii[at + 1])
        points = np.stack([circle.x + radius * np.cos(angles), circle.y + radius * np.sin(angles)], axis=1)
        circle, share = _fit_circle(points[strong], circle, settings)
        share *= float(strong.mean())
        reach = max(reach / 2, 2 * settings.near)
    return circle, share


def _fit_circle(points: FloatArray, start: Sphere, settings: SphereSettings) -> tuple[Sphere, float]:
    """The circle through most points (P, 2), and the share of them that are near it."""
    x, y, radius = start.x, start.y, start.radius
    for _ in range(30):
        away = points - (x, y)
        distance = np.maximum(np.hypot(*away.T), 1e-6)
        off = distance - radius
        trust = 1 / (1 + (off / (0.5 * settings.near * radius)) ** 2) ** 2
        design = np.column_stack([away / distance[:, None], np.ones(len(points))]) * np.sqrt(trust)[:, None]
        step = np.linalg.lstsq(design, off * np.sqrt(trust), rcond=None)[0]
        x, y, radius = x + step[0], y + step[1], radius + step[2]
        if np.abs(step).max() < 1e-3:
            break
    off = np.hypot(*(points - (x, y)).T) - radius
    return Sphere(float(x), float(y), float(radius)), float((np.abs(off) < settings.near * radius).mean())


def _overlap(one: Sphere, other: Sphere) -> bool:
    return bool(np.hypot(one.x - other.x, one.y - other.y) < max(one.radius, other.radius))


def _shows_a_lamp(frames: list[FloatArray], circle: Sphere, settings: SphereSettings) -> bool:
    """Whether a highlight is seen within a circle in most frames, and moves."""
    normals = [_light_of(frame, circle, settings) for frame in frames]
    seen = np.array([light for light in normals if light is not None])
    if len(seen) < max(2, settings.seen * len(frames)):
        return False
    return float(np.linalg.norm(seen - seen.mean(axis=0), axis=1).max()) > settings.moved


def _light_of(frame: FloatArray, sphere: Sphere, settings: SphereSettings) -> FloatArray | None:
    """(3,) direction of the lamp that a sphere mirrors in one photograph; None without a highlight.

    A lamp on the camera's side is mirrored within the inner 0.71 of the radius, so the rim, where the sheet
    may shine through a circle that is a little too large, is not looked at.
    """
    gray = frame if frame.ndim == 2 else frame.mean(axis=2)
    rows, columns = np.ogrid[: gray.shape[0], : gray.shape[1]]
    inner = (columns - sphere.x) ** 2 + (rows - sphere.y) ** 2 < (_INNER * sphere.radius) ** 2
    disc = gray[inner]
    if not disc.size:
        return None
    usual, brightest = float(np.median(disc)), float(disc.max())
    spread = 1.4826 * float(np.median(np.abs(disc - usual))) + _LEVEL
    small = float((disc > 0.5 * (usual + brightest)).mean()) < settings.highlight
    if not small or brightest - usual < settings.prominence * spread:
        return None
    try:
        return from_sphere(np.where(inner, gray, usual), centre=(sphere.x, sphere.y), radius=sphere.radius)
    except CaptureError:
        return None


@dataclass(frozen=True, slots=True, eq=False)
class FoundLamps:
    """Lamps that spheres show.

    lights: (N, 3) unit vectors; NaN in photographs where no sphere shows its lamp. apart: (N,) degrees, the
    largest angle between what two spheres say; 0 with one sphere.
    """

    lights: FloatArray
    apart: FloatArray


def lamps_of_spheres(
    stack: ImageStack, spheres: list[Sphere], *, settings: SphereSettings | None = None
) -> FoundLamps:
    """The lamp of each photograph, from the highlights on one sphere or the mean over several.

    Raises CaptureError where a sphere is too small or leaves the photographs, or no photograph shows a lamp.
    """
    settings = settings or SphereSettings()
    height, width = stack.shape[1:3]
    for one in spheres:
        if one.radius < settings.least_radius or not (0 <= one.x < width and 0 <= one.y < height):
            raise CaptureError(
                f"expected a sphere of a radius of {settings.least_radius:g} pixels or more within {width} x "
                f"{height} pixels, got centre {one.x:.1f}, {one.y:.1f} and radius {one.radius:.1f}",
                zh=f"球的半徑至少要 {settings.least_radius:g} 像素，球心要在 {width} × {height} 的照片裡；"
                f"這裡球心是 {one.x:.1f}, {one.y:.1f}，半徑 {one.radius:.1f}。",
            )
    lights, apart = np.full((len(stack), 3), np.nan), np.zeros(len(stack))
    for number, frame in enumerate(stack):
        seen = (_light_of(frame, one, settings) for one in spheres)
        found = [light for light in seen if light is not None]
        if found:
            mean = np.sum(found, axis=0)
            lights[number] = mean / np.linalg.norm(mean)
        if len(found) > 1:
            cosines = np.array(found) @ np.array(found).T
            apart[number] = float(np.degrees(np.arccos(np.clip(cosines.min(), -1, 1))))
    if not np.isfinite(lights).any():
        raise CaptureError(
            "expected the lamp to be seen on a sphere, got no highlight in any photograph",
            zh="沒有一張照片在球上看得到燈的反光。",
        )
    return FoundLamps(lights, apart)
