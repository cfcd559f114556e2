"""A hand-held camera: one photograph of a sheet of paper on a desk, with the true place of every point.

The sheet is a cylinder, rolled across, along, or not at all, seen through a pinhole. It is lit from one side,
perhaps with the shadow of a hand; then come blur, noise and JPEG. Nothing here knows what is printed on the
sheet, and no code is shared with what reads it.

Frame: the middle of the flat sheet is the origin, x to the right and y down along it, z away from the camera;
the sheet's width is 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rumu.errors import ImageError
from rumu.values import FloatArray

Picture = npt.NDArray[np.uint8]

_STEP = 8  # pixels of the photograph between those whose ray is followed; the rest lie between them
_ROUNDS = 12  # of the search for where a ray meets the sheet
_ARC = np.linspace(-1.5, 1.5, 3001)  # of the sheet's width, across the roll, from its middle


@dataclass(frozen=True, slots=True)
class Conditions:
    """How a photograph is taken.

    tilt, towards
        Degrees between the camera's axis and the normal of the sheet, 0-60, and to which side it leans.
    turn
        Degrees by which the camera is turned about its own axis, clockwise.
    distance
        From the camera to the middle of the sheet, in sheet widths: smaller has more perspective.
    fill
        Share of the photograph's width or height that the sheet takes, whichever it fills more; the sheet is
        in the middle and never cut off up to 1.
    bend, bend_along
        Height of the sheet's wave, in sheet widths, and whether it is rolled about a horizontal axis.
    megapixels, landscape
        Size of the photograph, of 3 by 4 or 4 by 3.
    light, light_from
        How much darker the far side is than the near one, 0-1, and from where the light comes, degrees.
    shadow
        How much light the shadow of a hand takes where it falls, 0-1.
    colour
        Colour of the light, linear red, green and blue.
    blur, noise, jpeg
        Standard deviation of the blur in pixels of a 12-megapixel photograph; of the noise, of 255, at
        middle grey; JPEG quality 1-100, or None.
    desk
        Colour of the desk, sRGB 0-255.
    gamma
        The camera stores light to the power of 1 / gamma; None for the curve of sRGB.
    """

    tilt: float = 0.0
    towards: float = 0.0
    turn: float = 0.0
    distance: float = 2.0
    fill: float = 0.85
    bend: float = 0.0
    bend_along: bool = False
    megapixels: float = 12.0
    landscape: bool = False
    light: float = 0.0
    light_from: float = 0.0
    shadow: float = 0.0
    colour: tuple[float, float, float] = (1.0, 1.0, 1.0)
    blur: float = 0.0
    noise: float = 0.0
    jpeg: int | None = None
    desk: tuple[int, int, int] = (96, 78, 60)
    gamma: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Photograph:
    """A photograph and where it shows what.

    picture: (h, w, 3) uint8 sRGB. conditions: how it was taken. sheet: (height, width) of the flat picture.
    """

    picture: Picture
    conditions: Conditions
    sheet: tuple[int, int]

    def points(self, flat: FloatArray) -> FloatArray:
        """(n, 2) x and y in the photograph of points (n, 2) x and y of the flat picture, both in pixels.

        The middle of the first pixel is (0, 0).
        """
        return _Camera(self.picture.shape[:2], self.sheet, self.conditions).project(flat)


def draw_conditions(rng: np.random.Generator, *, most_tilt: float = 35.0) -> Conditions:
    """Conditions as people photograph: every one somewhere between ideal and bad."""
    return Conditions(
        tilt=float(rng.uniform(0, most_tilt)),
        towards=float(rng.uniform(0, 360)),
        turn=float(rng.normal(0, 6)),
        distance=float(rng.uniform(1.4, 3.0)),
        fill=float(rng.uniform(0.7, 0.92)),
        bend=float(rng.choice([0.0, rng.uniform(0.0, 0.03)])),
        bend_along=bool(rng.random() < 0.5),
        megapixels=float(rng.choice([3.0, 8.0, 12.0])),
        light=float(rng.uniform(0.0, 0.5)),
        light_from=float(rng.uniform(0, 360)),
        shadow=float(rng.choice([0.0, rng.uniform(0.1, 0.4)])),
        colour=(1.0, float(rng.uniform(0.85, 1.0)), float(rng.uniform(0.7, 1.0))),
        blur=float(rng.uniform(0.5, 2.0)),
        noise=float(rng.uniform(1.0, 6.0)),
        jpeg=int(rng.integers(60, 96)),
        desk=tuple(int(c) for c in rng.integers(20, 140, 3)),  # type: ignore[arg-type]
    )


def take_photograph(flat: Picture, conditions: Conditions, *, seed: int = 0) -> Photograph:
    """Photograph a flat picture, (H, W, 3) uint8 sRGB, that is printed on a sheet.

    seed: of the noise, of the shadow's place and of the desk's grain. Raises ImageError for another kind of
    picture, or when a side of the sheet is turned away from the camera.
    """
    import cv2

    if flat.ndim != 3 or flat.shape[2] != 3 or flat.dtype != np.uint8:
        raise ImageError(f"expected a (H, W, 3) uint8 picture, got {flat.shape} {flat.dtype}")
    rng = np.random.default_rng(seed)
    height, width = flat.shape[:2]
    camera = _Camera(_size(conditions), (height, width), conditions)
    x, y = camera.unproject()
    per_pixel = _scale(x, y)  # pixels of the flat picture for each of the photograph
    gathered = _to_linear(flat)
    if per_pixel > 1:
        gathered = cv2.GaussianBlur(gathered, (0, 0), 0.5 * per_pixel)
    paper = cv2.remap(gathered, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    on_sheet = _coverage(x, width) * _coverage(y, height)
    grain = cv2.GaussianBlur(rng.normal(0, 1, x.shape).astype(np.float32), (0, 0), 3) * 0.15
    desk = _to_linear(np.array(conditions.desk, np.uint8)[None, None]) * (1 + grain[..., None])
    seen = on_sheet[..., None] * paper + (1 - on_sheet[..., None]) * desk
    seen *= _light(x / width, y / height, conditions, rng)[..., None]
    seen *= np.asarray(conditions.colour, np.float32)
    blur = conditions.blur * float(np.sqrt(conditions.megapixels / 12.0))
    if blur > 0:
        seen = cv2.GaussianBlur(seen, (0, 0), blur)
    picture = 255.0 * (
        _to_srgb(seen) if conditions.gamma is None else np.clip(seen, 0, 1) ** (1 / conditions.gamma)
    )
    if conditions.noise > 0:
        picture += rng.normal(0, conditions.noise, picture.shape).astype(np.float32) * np.sqrt(
            0.25 + picture / 170.0
        )
    photograph = np.clip(np.round(picture), 0, 255).astype(np.uint8)
    if conditions.jpeg is not None:
        _, data = cv2.imencode(".jpg", photograph[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, conditions.jpeg])
        photograph = np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR), np.uint8)[..., ::-1]
    return Photograph(np.ascontiguousarray(photograph), conditions, (height, width))


class _Camera:
    """The pinhole, the sheet and the way between them."""

    def __init__(self, size: tuple[int, int], sheet: tuple[int, int], conditions: Conditions) -> None:
        self.size, self.sheet, self.conditions = size, sheet, conditions
        tilt, towards, turn = np.radians([conditions.tilt, conditions.towards, conditions.turn])
        axis = np.array([-np.sin(towards), np.cos(towards), 0.0])
        self.R = _rotation(np.array([0.0, 0.0, 1.0]), turn) @ _rotation(axis, tilt)
        self.t = np.array([0.0, 0.0, conditions.distance])
        self.focal, self.middle = 1.0, np.zeros(2)
        edge = self.project(_edge_of(sheet))
        self.focal = conditions.fill * float(np.min(np.array(size[::-1]) / np.ptp(edge, axis=0)))
        self.middle = (np.array(size[::-1]) - 1) / 2 - self.focal * (edge.min(axis=0) + edge.max(axis=0)) / 2

    def project(self, flat: FloatArray) -> FloatArray:
        """Pixels of the flat picture -> pixels of the photograph."""
        height, width = self.sheet
        s = (np.asarray(flat, float) + 0.5 - [width / 2, height / 2]) / width
        rolled = 1 if self.conditions.bend_along else 0
        across, depth = self._profile()
        point = np.zeros((len(s), 3))
        point[:, 1 - rolled] = s[:, 1 - rolled]
        point[:, rolled] = np.interp(s[:, rolled], _ARC, across)
        point[:, 2] = np.interp(s[:, rolled], _ARC, depth)
        seen = point @ self.R.T + self.t
        if (seen[:, 2] <= 0.05).any():
            raise ImageError("expected the whole sheet to lie in front of the camera")
        return np.asarray(seen[:, :2] / seen[:, 2:] * self.focal + self.middle)

    def unproject(self) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
        """Every pixel of the photograph -> x and y in the flat picture, (h, w) float32 each."""
        import cv2

        (h, w), (height, width) = self.size, self.sheet
        column, row = np.meshgrid(np.arange(0, w + _STEP, _STEP), np.arange(0, h + _STEP, _STEP))
        rays = np.stack(
            [column - self.middle[0], row - self.middle[1], np.full(column.shape, self.focal)], -1
        )
        rays = rays @ self.R  # R.T @ ray, in the sheet's frame
        origin = -self.t @ self.R
        rolled = 1 if self.conditions.bend_along else 0
        across, depth = self._profile()
        z = np.zeros(column.shape)
        for _ in range(_ROUNDS):
            point = origin[:2] + rays[..., :2] * ((z - origin[2]) / rays[..., 2])[..., None]
            z = np.interp(point[..., rolled], across, depth)
        point[..., rolled] = np.interp(point[..., rolled], across, _ARC)
        flat = point * width + [width / 2 - 0.5, height / 2 - 0.5]
        at = np.meshgrid(np.arange(w, dtype=np.float32) / _STEP, np.arange(h, dtype=np.float32) / _STEP)
        x, y = (cv2.remap(flat[..., k].astype(np.float32), *at, cv2.INTER_LINEAR) for k in (0, 1))
        return x, y

    def _profile(self) -> tuple[FloatArray, FloatArray]:
        """The roll seen from its side: across it and away from the camera, at every `_ARC`."""
        slope = self.conditions.bend * np.pi * np.cos(np.pi * (_ARC + 0.2))
        slope = np.clip(slope, -0.6, 0.6)
        step = _ARC[1] - _ARC[0]
        across, depth = (
            np.concatenate([[0.0], np.cumsum((f[1:] + f[:-1]) / 2) * step])
            for f in (np.sqrt(1 - slope**2), slope)
        )
        middle = len(_ARC) // 2
        return across - across[middle], depth - depth[middle]


def _edge_of(sheet: tuple[int, int]) -> FloatArray:
    """(n, 2) points along the edge of the flat picture."""
    height, width = sheet
    along, none = np.linspace(0, 1, 50), np.zeros(50)
    x = np.concatenate([along, along, none, none + 1]) * width - 0.5
    y = np.concatenate([none, none + 1, along, along]) * height - 0.5
    return np.column_stack([x, y])


def _rotation(axis: FloatArray, angle: float) -> FloatArray:
    """(3, 3) rotation about a unit axis by an angle in radians (Rodrigues)."""
    K = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.asarray(np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K)


def _size(conditions: Conditions) -> tuple[int, int]:
    """Height and width in pixels."""
    shorter = round(float(np.sqrt(conditions.megapixels * 1e6 * 0.75)))
    longer = round(shorter * 4 / 3)
    return (shorter, longer) if conditions.landscape else (longer, shorter)


def _scale(x: FloatArray, y: FloatArray) -> float:
    """The median number of flat pixels to a pixel of the photograph."""
    middle = len(x) // 2
    dx, dy = np.diff(x[middle]), np.diff(y[middle])
    return float(np.median(np.hypot(dx, dy)))


def _coverage(at: FloatArray, length: int) -> FloatArray:
    """1 within the sheet, 0 outside of it, and between at the edge, for positions in flat pixels."""
    return np.asarray(np.clip(at + 1.0, 0, 1) * np.clip(length - at, 0, 1), np.float32)


def _light(x: FloatArray, y: FloatArray, conditions: Conditions, rng: np.random.Generator) -> FloatArray:
    """(h, w) factor of the light at places of the sheet, 0-1 within it."""
    angle = np.radians(conditions.light_from)
    along = (x - 0.5) * np.cos(angle) + (y - 0.5) * np.sin(angle)
    light = 1 - conditions.light * np.clip(0.5 - along, 0, 1)
    if conditions.shadow > 0:
        way, place = rng.uniform(0, 2 * np.pi), rng.uniform(0.1, 0.45)
        edge = (x - 0.5) * np.cos(way) + (y - 0.5) * np.sin(way) - place + 0.04 * np.sin(7 * x + 5 * y)
        light = light * (1 - conditions.shadow / (1 + np.exp(np.clip(-edge / 0.015, -50, 50))))
    return np.asarray(light, np.float32)


def _to_linear(picture: Picture) -> npt.NDArray[np.float32]:
    """SRGB of 8 bits -> linear light in [0, 1] (IEC 61966-2-1)."""
    c = np.arange(256) / 255.0
    table = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4).astype(np.float32)
    return np.asarray(table[picture])


def _to_srgb(linear: FloatArray) -> npt.NDArray[np.float32]:
    """Linear light -> sRGB in [0, 1]."""
    v = np.clip(linear, 0, 1)
    return np.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055).astype(np.float32)
