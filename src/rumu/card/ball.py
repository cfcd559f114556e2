"""The shiny ball on the card: where it lies, how large it is, and the lamps that it mirrors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rumu.capture.spheres import Sphere, lamps_of_spheres
from rumu.card.finding import CardView
from rumu.card.light_fit import BallLight
from rumu.errors import CaptureError
from rumu.image_stack import ImageStack, Photograph
from rumu.values import FloatArray


@dataclass(frozen=True, slots=True)
class BallSettings:
    """How a ball is looked for.

    height: millimetres above the card that are looked at first. side: millimetres of the square around the
    ring. fine: pixels for each millimetre, at most. dark: share of the white beside it, below which a place
    is of the ball in all photographs. least: millimetres of its radius. far: millimetres from the ring's
    middle in which its middle lies. round: share of its outline that must be near a circle; near: share of
    the radius that is near. known, guessed: degrees, standard deviation of a direction where the focal length
    is known and where it is guessed.
    """

    height: float = 8.0
    side: float = 44.0
    fine: float = 16.0
    dark: float = 0.82
    least: float = 3.0
    far: float = 9.0
    round: float = 0.7
    near: float = 0.04
    known: float = 1.0
    guessed: float = 2.5


@dataclass(frozen=True, slots=True, eq=False)
class FoundBall:
    """A ball on the card. light: see `BallLight`. radius: millimetres."""

    light: BallLight
    radius: float


def find_ball(
    photographs: Sequence[Photograph], views: Sequence[CardView], *, settings: BallSettings | None = None
) -> FoundBall | None:
    """The ball in the ring of the card; None where there is none that is round and shows its lamps."""
    settings = settings or BallSettings()
    layout = views[0].layout
    width, height = layout.size
    target = np.array([layout.ball[0] - width / 2, height / 2 - layout.ball[1], settings.height])
    scale = min(settings.fine, float(np.median([view.scale() for view in views])))
    looks = [_Look.toward(target, view, settings.side, scale) for view in views]
    frames = [look.picture(one) for look, one in zip(looks, photographs, strict=True)]
    circle = _outline(frames, scale, settings)
    if circle is None:
        return None
    try:
        found = lamps_of_spheres(ImageStack.of_arrays(frames), [circle])
    except CaptureError:
        return None
    middle, radius = _in_space(circle, looks)
    lights = [
        look.axes.T @ _seen_nearby(light, circle, look)
        for light, look in zip(found.lights, looks, strict=True)
    ]
    spread = settings.known if all(view.focal_is_known for view in views) else settings.guessed
    return FoundBall(BallLight(middle, np.array(lights), spread), radius)


@dataclass(frozen=True, slots=True, eq=False)
class _Look:
    """A photograph as a camera at the same place would show it that looks at the ball.

    place: (3,) of the camera, millimetres. axes: (3, 3), rows right, up and toward the camera. focal: pixels.
    matrix: (3, 3) from its pixels to the photograph's. side: pixels.
    """

    place: FloatArray
    axes: FloatArray
    focal: float
    matrix: FloatArray
    side: int

    @classmethod
    def toward(cls, target: FloatArray, view: CardView, side: float, scale: float) -> _Look:
        """The look of a view at a target; side: millimetres. scale: pixels for each at the target."""
        place, R = view.camera()
        back = (place - target) / np.linalg.norm(place - target)
        right = np.cross([0.0, 1.0, 0.0], back)
        right /= np.linalg.norm(right)
        axes = np.stack([right, np.cross(back, right), back])
        pixels, focal = round(side * scale), float(scale * np.linalg.norm(place - target))
        to_ray = np.array(
            [
                [1 / focal, 0, -(pixels - 1) / 2 / focal],
                [0, -1 / focal, (pixels - 1) / 2 / focal],
                [0, 0, -1.0],
            ]
        )
        return cls(place, axes, focal, view.lens() @ R @ axes.T @ to_ray, pixels)

    def picture(self, photograph: Photograph) -> FloatArray:
        """(side, side) linear."""
        import cv2

        light = photograph.light()
        gray = np.ascontiguousarray(light if light.ndim == 2 else light.mean(axis=2))
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        size = (self.side, self.side)
        return np.asarray(cv2.warpPerspective(gray, self.matrix, size, flags=flags), np.float32)


def _outline(frames: Sequence[FloatArray], scale: float, settings: BallSettings) -> Sphere | None:
    """The circle of what is darker than the paper in every photograph; None where nothing round is."""
    import cv2

    rows, columns = np.indices(frames[0].shape)
    middle = (len(frames[0]) - 1) / 2
    away = np.hypot(columns - middle, rows - middle)
    outside = (away > 0.42 * len(frames[0])) & (away < 0.5 * len(frames[0]))
    brightest = np.max([one / max(float(np.quantile(one[outside], 0.8)), 1e-6) for one in frames], axis=0)
    brightest = cv2.medianBlur(brightest.astype(np.float32), 5)  # the printed ring is thinner
    dark = ((brightest < settings.dark) & (away < (settings.far + 14.0) * scale)).astype(np.uint8)
    dark = cv2.morphologyEx(dark, cv2.MORPH_OPEN, np.ones((2 * round(0.5 * scale) + 1,) * 2, np.uint8))
    count, labels, stats, _ = cv2.connectedComponentsWithStats(dark)
    if count < 2:
        return None
    largest = 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    contours, _ = cv2.findContours(
        (labels == largest).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE
    )
    hull = cv2.convexHull(max(contours, key=len)).reshape(-1, 2).astype(np.float64)
    return _round(hull, middle, scale, settings)


def _round(hull: FloatArray, middle: float, scale: float, settings: BallSettings) -> Sphere | None:
    """The circle through a closed outline (n, 2), if it is one, of the right size, and in the ring."""
    closed = np.vstack([hull, hull[:1]])
    along = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
    at = np.linspace(0, along[-1], 360, endpoint=False)
    points = np.column_stack([np.interp(at, along, closed[:, k]) for k in (0, 1)])
    centre, radius = points.mean(axis=0), 1.0
    for _ in range(20):
        offset = points - centre
        distance = np.maximum(np.hypot(*offset.T), 1e-6)
        radius = float(np.median(distance))
        off = distance - radius
        trust = 1 / (1 + (off / (0.02 * radius)) ** 2)
        design = np.column_stack([offset / distance[:, None], np.ones(len(points))]) * trust[:, None]
        centre = centre + np.linalg.lstsq(design, off * trust, rcond=None)[0][:2]
    distance = np.hypot(*(points - centre).T)
    share = float((np.abs(distance / radius - 1) < settings.near).mean())
    far = float(np.hypot(*(centre - middle))) > settings.far * scale
    if share < settings.round or radius < settings.least * scale or far:
        return None
    return Sphere(
        float(centre[0]), float(centre[1]), radius + 0.5
    )  # an outline runs through middles of pixels


def _in_space(circle: Sphere, looks: Sequence[_Look]) -> tuple[FloatArray, float]:
    """Middle (3,) and radius, in millimetres, of a ball that lies on the card."""
    middles, radii = [], []
    for look in looks:
        x, y = circle.x - (look.side - 1) / 2, (look.side - 1) / 2 - circle.y
        ray = look.axes.T @ np.array([x / look.focal, y / look.focal, -1.0])
        ray /= np.linalg.norm(ray)
        sine = np.sin(np.arctan(circle.radius / look.focal))
        distance = look.place[2] / (sine - ray[2])
        middles.append(look.place + distance * ray)
        radii.append(distance * sine)
    return np.mean(middles, axis=0), float(np.mean(radii))


def _seen_nearby(light: FloatArray, circle: Sphere, look: _Look) -> FloatArray:
    """The lamp (3,) that a ball mirrors to a camera nearby, from the one as if the camera were far away."""
    if not np.isfinite(light).all():
        return light
    half = np.add(light, (0.0, 0.0, 1.0))
    normal = half / np.linalg.norm(half)
    x = (circle.x - (look.side - 1) / 2 + circle.radius * normal[0]) / look.focal
    y = ((look.side - 1) / 2 - circle.y + circle.radius * normal[1]) / look.focal
    middle = np.array([circle.x - (look.side - 1) / 2, (look.side - 1) / 2 - circle.y, -look.focal])
    middle /= np.linalg.norm(middle)
    sine = np.sin(np.arctan(circle.radius / look.focal))
    ray = np.array([x, y, -1.0]) / np.sqrt(x * x + y * y + 1)
    along = float(ray @ middle)
    depth = along - np.sqrt(max(0.0, along**2 - 1 + sine**2))
    true = (depth * ray - middle) / sine
    true /= np.linalg.norm(true)
    return np.asarray(ray - 2 * (ray @ true) * true)
