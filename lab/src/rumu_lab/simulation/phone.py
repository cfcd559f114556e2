"""A phone above a printed card on a desk, in a dark room, with one small lamp: JPEGs as it stores them.

Written from the physics alone: every pixel's ray is followed to the card, to the relief of the sheet that
lies in its window, or to a mirror ball. The lamp is near and its light falls off with the square of the
distance; a lens darkens the corners; the sensor has shot and read noise; the picture is stored as an 8-bit
sRGB JPEG with what a phone writes in its EXIF.

Frame: the card's middle is the origin, x right, y up, z toward the camera; all lengths in millimetres.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from PIL import Image

from rumu.errors import CaptureError
from rumu.values import BoolArray, FloatArray
from rumu_lab.simulation.lamps import NearLamp, cast_shadow, normals_of

_DIAGONAL_35 = 43.2666  # millimetres, of the film that focal lengths are told for
_REACH = 500.0  # millimetres at which a lamp has its power
_WITHIN = 5  # rays along each side of a pixel, on the ball
_RANGE = 2  # rounds in which a ray finds the height where it meets the relief
_FOCAL_35, _FOCAL_MM, _MODEL, _MAKE, _EXPOSURE, _TIME = 0xA405, 0x920A, 0x0110, 0x010F, 0x829A, 0x9003


@dataclass(frozen=True, slots=True, eq=False)
class LaidSheet:
    """A sheet with relief that lies on the card.

    height: (h, w) millimetres above the card. albedo: (h, w) linear. spacing: millimetres of one pixel.
    middle: (x, y) where its middle lies on the card.
    """

    height: FloatArray
    albedo: FloatArray
    spacing: float
    middle: tuple[float, float] = (0.0, 0.0)

    @property
    def normals(self) -> FloatArray:
        """(h, w, 3) unit normals."""
        return normals_of(self.height, spacing=self.spacing)


@dataclass(frozen=True, slots=True, eq=False)
class CardScene:
    """What lies on the desk.

    print: (H, W) linear reflectance of the printed card, from its upper left corner. size: (width, height)
    of its paper. sheet: what lies on it. ball: (x, y, radius) of a mirror ball; None without one.
    desk: reflectance around the card. room: light from all sides, as a share of the lamp's at the middle.
    """

    print: FloatArray
    size: tuple[float, float]
    sheet: LaidSheet | None = None
    ball: tuple[float, float, float] | None = None
    desk: float = 0.12
    room: float = 0.0


@dataclass(frozen=True, slots=True)
class PhoneCamera:
    """Where the phone is, and what it makes of light.

    position: of the lens. lean: degrees about x and y by which it looks beside straight down. roll: degrees
        about its axis. focal: in millimetres of 35-mm film. size: (width, height) in pixels.
    corners: share of the light that the lens takes from the corners beyond cos^4. blur: standard deviation
        in pixels. white: linear level of white paper in the middle. noise: standard deviation at that level;
        read: the same in the dark. curve: what is done to linear light in [0, 1] before sRGB, as phones add
        contrast.
    quality: of the JPEG. exif: whether it says the focal length, the model, the exposure and the date.
    """

    position: tuple[float, float, float] = (0.0, -8.0, 320.0)
    lean: tuple[float, float] = (0.0, 0.0)
    roll: float = 0.0
    focal: float = 26.0
    size: tuple[int, int] = (1500, 2000)
    corners: float = 0.15
    blur: float = 0.7
    white: float = 0.5
    noise: float = 0.008
    read: float = 0.0015
    curve: Callable[[FloatArray], FloatArray] | None = None
    quality: int = 93
    exif: bool = True
    colour: tuple[float, float, float] = field(default=(1.0, 0.94, 0.84))


@dataclass(frozen=True, slots=True)
class HandLamp:
    """A small lamp that is aimed at the card's middle, or near it.

    position: millimetres from there. radius: of its disc, as a ball shows it. lobe: its light falls off with
    this power of the cosine from its axis; 0 shines alike to all sides, a bare LED has 1. aim: millimetres
    from the card's middle, where its axis meets the card.
    """

    position: tuple[float, float, float]
    radius: float = 12.0
    lobe: float = 0.0
    aim: tuple[float, float] = (0.0, 0.0)


def reflectance_of_print(picture: npt.NDArray[np.uint8]) -> FloatArray:
    """Reflectance, 0.03 of toner to 0.9 of paper, of a page (H, W) as a screen shows it in gray levels."""
    shown = np.arange(256) / 255
    light = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)
    return np.asarray((0.03 + 0.87 * light).astype(np.float32)[picture])


def wavy_sheet(
    *, size: tuple[float, float] = (100.0, 120.0), spacing: float = 0.15, relief: float = 0.35, seed: int = 0
) -> LaidSheet:
    """A sheet of smooth random relief, flat along its sides, with blots of ink.

    size: width and height; relief: standard deviation of its height, all in millimetres.
    """
    import cv2

    rng = np.random.default_rng(seed)
    shape = (int(size[1] / spacing), int(size[0] / spacing))
    z = cv2.GaussianBlur(rng.normal(0, 1, shape), (0, 0), 2.1 / spacing)
    fine = cv2.GaussianBlur(rng.normal(0, 1, shape), (0, 0), 0.75 / spacing)
    z = relief * (z / z.std() + 0.15 * fine / fine.std())
    down, across = (np.minimum(np.arange(n), np.arange(n)[::-1]) * spacing / 9 for n in shape)
    rim = np.clip(np.minimum(down[:, None], across[None, :]), 0, 1)
    blots = cv2.GaussianBlur(rng.normal(0, 1, shape), (0, 0), 1.8 / spacing) > 0
    return LaidSheet(z * rim**2 * (3 - 2 * rim), np.where(blots, 0.25, 0.8), spacing)


def take_card_photograph(scene: CardScene, camera: PhoneCamera, lamp: HandLamp, *, seed: int = 0) -> bytes:
    """The JPEG of a scene under a lamp. seed: of the noise. Raises CaptureError when the lamp is below it."""
    import cv2

    if lamp.position[2] <= 0:
        raise CaptureError(f"expected a lamp above the card, got z = {lamp.position[2]}")
    rays = _rays(camera)
    light = _seen_on_card(scene, camera, lamp, rays)
    if scene.ball is not None:
        light = _with_ball(light, scene, camera, lamp, rays)
    light *= _lens(camera, rays)
    white = _irradiance(np.zeros((1, 1, 3)), np.array([[[0.0, 0.0, 1.0]]]), lamp)[0, 0] * (1 + scene.room)
    light *= camera.white / (0.9 * white)
    if camera.blur:
        light = cv2.GaussianBlur(light.astype(np.float32), (0, 0), camera.blur)
    return _stored(light, camera, np.random.default_rng(seed))


def _rays(camera: PhoneCamera) -> FloatArray:
    """(H, W, 3) directions from the lens through the middle of every pixel, z = -1 along its axis."""
    width, height = camera.size
    focal = camera.focal / _DIAGONAL_35 * np.hypot(width, height)
    x = (np.arange(width) - (width - 1) / 2) / focal
    y = ((height - 1) / 2 - np.arange(height)) / focal
    rays = np.empty((height, width, 3), np.float32)
    rays[..., 0], rays[..., 1], rays[..., 2] = x[None, :], y[:, None], -1.0
    return np.asarray(rays @ _rotation(camera).T.astype(np.float32))


def _rotation(camera: PhoneCamera) -> FloatArray:
    """(3, 3) from the camera's frame to the card's."""
    (sx, sy, sr), (cx, cy, cr) = (of(np.radians([*camera.lean, camera.roll])) for of in (np.sin, np.cos))
    tip = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    turn = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    spin = np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]])
    return np.asarray(tip @ turn @ spin)


def _meets(camera: PhoneCamera, rays: FloatArray, z: FloatArray | float) -> FloatArray:
    """(H, W, 3): where rays reach a height."""
    origin = np.array(camera.position, np.float32)
    t = (z - origin[2]) / rays[..., 2]
    return np.asarray(origin + t[..., None] * rays)


def _seen_on_card(scene: CardScene, camera: PhoneCamera, lamp: HandLamp, rays: FloatArray) -> FloatArray:
    """(H, W): light that the card, the sheet on it and the desk send to the camera."""
    place = _meets(camera, rays, 0.0)
    per_pixel = float(np.median(np.abs(np.diff(place[len(place) // 2, :, 0]))))
    albedo = _looked_up(scene.print, scene.size, (0.0, 0.0), place, per_pixel, outside=scene.desk)
    normals = np.zeros_like(place)
    normals[..., 2] = 1.0
    shadow = np.zeros(albedo.shape, bool)
    sheet = scene.sheet
    if sheet is not None:
        h, w = sheet.height.shape
        size = (w * sheet.spacing, h * sheet.spacing)
        for _ in range(_RANGE):
            z = _looked_up(sheet.height, size, sheet.middle, place, 0.0, outside=0.0)
            place = _meets(camera, rays, z)
        on = _looked_up(np.ones((h, w)), size, sheet.middle, place, 0.0, outside=0.0) > 0.5
        laid = _looked_up(sheet.albedo, size, sheet.middle, place, per_pixel, outside=0.0)
        albedo = np.where(on, laid, albedo)
        true = sheet.normals
        n = np.stack(
            [_looked_up(true[..., k], size, sheet.middle, place, 0.0, outside=0.0) for k in range(3)], -1
        )
        normals = np.where(
            on[..., None], n / np.maximum(np.linalg.norm(n, axis=-1, keepdims=True), 1e-6), normals
        )
        beside = np.array(lamp.position) - (*sheet.middle, 0.0)
        dark = cast_shadow(sheet.height, lamp=NearLamp(tuple(beside)), spacing=sheet.spacing)
        shadow = _looked_up(dark.astype(np.float32), size, sheet.middle, place, 0.0, outside=0.0) > 0.5
    light = _irradiance(place, normals, lamp)
    light[shadow | _in_the_balls_shadow(place, scene, lamp)] = 0.0
    room = scene.room * _irradiance(np.zeros((1, 1, 3)), np.array([[[0.0, 0.0, 1.0]]]), lamp)[0, 0]
    return np.asarray(albedo * (light + room))


def _looked_up(
    grid: FloatArray,
    size: tuple[float, float],
    middle: tuple[float, float],
    place: FloatArray,
    per_pixel: float,
    *,
    outside: float,
) -> FloatArray:
    """(H, W): values of a grid that covers `size` millimetres around `middle`, averaged over a pixel."""
    import cv2

    h, w = grid.shape
    fine = w / size[0] * per_pixel  # pixels of the grid for each of the photograph
    values = np.asarray(grid, np.float32)
    if fine > 1:
        values = cv2.GaussianBlur(values, (0, 0), 0.4 * fine)
    column = ((place[..., 0] - middle[0]) / size[0] + 0.5) * w - 0.5
    row = (0.5 - (place[..., 1] - middle[1]) / size[1]) * h - 0.5
    return np.asarray(
        cv2.remap(
            values,
            column.astype(np.float32),
            row.astype(np.float32),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=outside,
        )
    )


def _irradiance(place: FloatArray, normals: FloatArray, lamp: HandLamp) -> FloatArray:
    """(H, W): cosine over the square of the distance, 1 for what faces the lamp at its reach."""
    toward = np.array(lamp.position, np.float32) - place
    squared = np.einsum("hwk,hwk->hw", toward, toward)
    cosine = np.einsum("hwk,hwk->hw", toward, normals) / np.sqrt(squared)
    axis = np.array(lamp.position, np.float32) - np.array([*lamp.aim, 0.0], np.float32)
    beside = np.maximum(toward @ axis, 0.0) / np.sqrt(squared) / np.linalg.norm(axis)
    return np.asarray(np.maximum(cosine, 0.0) * beside**lamp.lobe * _REACH**2 / squared)


def _in_the_balls_shadow(place: FloatArray, scene: CardScene, lamp: HandLamp) -> BoolArray:
    if scene.ball is None:
        return np.zeros(place.shape[:2], bool)
    x, y, radius = scene.ball
    toward = np.array(lamp.position) - place
    toward = toward / np.linalg.norm(toward, axis=-1, keepdims=True)
    away = np.array([x, y, radius]) - place
    along = np.einsum("hwk,hwk->hw", away, toward)
    beside = np.einsum("hwk,hwk->hw", away, away) - along**2
    return np.asarray((along > 0) & (beside < radius**2))


def _with_ball(
    light: FloatArray, scene: CardScene, camera: PhoneCamera, lamp: HandLamp, rays: FloatArray
) -> FloatArray:
    """The light with a mirror ball before it, which shows the lamp, the card, and a dark room."""
    assert scene.ball is not None
    x, y, radius = scene.ball
    centre = np.array([x, y, radius])
    away = centre - np.array(camera.position)
    unit = rays / np.linalg.norm(rays, axis=-1, keepdims=True)
    row, column = np.nonzero(away @ away - (unit @ away) ** 2 < (1.1 * radius) ** 2)
    right, down = rays[0, 1] - rays[0, 0], rays[1, 0] - rays[0, 0]
    steps = (np.arange(_WITHIN) + 0.5) / _WITHIN - 0.5
    parts = [
        _mirrored(rays[row, column] + i * down + j * right, light[row, column], scene, camera, lamp)
        for i in steps
        for j in steps
    ]
    light = light.copy()
    light[row, column] = np.mean(parts, axis=0)
    return light


def _mirrored(
    rays: FloatArray, behind: FloatArray, scene: CardScene, camera: PhoneCamera, lamp: HandLamp
) -> FloatArray:
    """(P,): what rays (P, 3) see on the ball, or `behind` where they pass it."""
    assert scene.ball is not None
    x, y, radius = scene.ball
    centre, place = np.array([x, y, radius]), np.array(camera.position)
    ray = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    along = ray @ (centre - place)
    beside = (centre - place) @ (centre - place) - along**2
    hit = place + (along - np.sqrt(np.maximum(radius**2 - beside, 0)))[:, None] * ray
    normal = (hit - centre) / radius
    mirrored = ray - 2 * np.einsum("pk,pk->p", ray, normal)[:, None] * normal
    toward = np.array(lamp.position) - hit
    distance = np.linalg.norm(toward, axis=1)
    cosine = np.einsum("pk,pk->p", mirrored, toward) / distance
    shows_lamp = np.arccos(np.clip(cosine, -1, 1)) < np.arctan(lamp.radius / distance)
    falls = np.minimum(mirrored[:, 2], -1e-3)
    ground = (hit - (hit[:, 2] / falls)[:, None] * mirrored)[None]
    seen = _looked_up(scene.print, scene.size, (0.0, 0.0), ground, 0.0, outside=scene.desk)[0]
    up = np.broadcast_to(np.array([0.0, 0.0, 1.0]), ground.shape)
    seen = np.where(mirrored[:, 2] < -1e-3, 0.55 * seen * _irradiance(ground, up, lamp)[0], 0.003)
    return np.where(beside < radius**2, np.where(shows_lamp, 30.0, seen), behind)


def _lens(camera: PhoneCamera, rays: FloatArray) -> FloatArray:
    """(H, W): what the lens lets through, by the angle from its axis."""
    cosine = (rays @ (_rotation(camera) @ np.array([0.0, 0.0, -1.0]))) / np.linalg.norm(rays, axis=-1)
    height, width = cosine.shape
    y, x = np.ogrid[:height, :width]
    out = np.hypot(x - (width - 1) / 2, y - (height - 1) / 2) / (np.hypot(width, height) / 2)
    return np.asarray(cosine**4 * (1 - camera.corners * out**2))


def _stored(light: FloatArray, camera: PhoneCamera, rng: np.random.Generator) -> bytes:
    """Linear light as the JPEG of a phone."""
    spread = np.sqrt(camera.read**2 + camera.noise**2 * np.maximum(light, 0) / camera.white)
    channels = []
    for share in camera.colour:
        noisy = share * light + rng.standard_normal(light.shape, np.float32) * spread
        value = np.clip(noisy, 0, 1)
        if camera.curve is not None:
            value = np.clip(camera.curve(value), 0, 1)
        shown = np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055)
        channels.append(np.round(255 * shown).astype(np.uint8))
    exif = Image.Exif()
    if camera.exif:
        exif[_MAKE], exif[_MODEL] = "Simulated", "Phone 1"
        details = exif.get_ifd(0x8769)
        details[_FOCAL_35], details[_FOCAL_MM] = round(camera.focal), 5.6
        details[_EXPOSURE], details[_TIME] = 1 / 60, "2026:05:04 20:15:00"
    stream = io.BytesIO()
    Image.fromarray(np.dstack(channels)).save(stream, "JPEG", quality=camera.quality, exif=exif)
    return stream.getvalue()
