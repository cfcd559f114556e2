"""Normals of materials that are not Lambert's: gloss, metal, rough and powdery ground.

A material is a shape of reflectance, known but for the brightness of each pixel: Lambert's cosine with a lobe
of gloss (Trowbridge and Reitz's facets with Smith's shadowing, known as GGX), that lobe alone, or a share of
the Lommel-Seeliger law, which stays bright at grazing light as rough ground does. Which materials a capture
shows is voted for by some of its pixels; then every pixel is searched for the normal under which one of these
few explains most of its lamps. A material is not fitted to a pixel by itself: with a dozen lamps it would
explain anything, wrong lamps among it. In the end a pixel has as many unknowns as under Lambert's law, albedo
and normal.

After the search over normals in a dictionary of reflectances by Hui and Sankaranarayanan, "Shape and
spatially-varying reflectance estimation from virtual exemplars" (2017); the dictionary by formulas, the vote
and the outliers are our own. Compiled in `rumu.surface.reflectance_kernels`; this module says what that must
find.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from rumu.image_stack import SATURATION
from rumu.values import BoolArray, FloatArray, IntArray

Kind = Literal["gloss", "metal", "rough"]


@dataclass(frozen=True, slots=True)
class Material:
    """The shape of a reflectance, seen from +z.

    kind: 'gloss', Lambert's law and a lobe; 'metal', the lobe alone; 'rough', Lambert's law and the
        Lommel-Seeliger law. roughness: of the facets, their alpha, in (0, 1]. share: light in the lobe for
        one part in Lambert's law, or, in [0, 1], what the Lommel-Seeliger law has of the whole; 0 is
        Lambert's law. lobe: its heights as a capture shows them, see `rumu.surface.lobe`, by which ground is
        parted from gloss; empty for those of the formula, by which normals are searched for.
    """

    kind: Kind = "rough"
    roughness: float = 1.0
    share: float = 0.0
    lobe: tuple[float, ...] = ()


LAMBERT = Material()
_ROUGHNESS = (0.08, 0.12, 0.18, 0.27, 0.4, 0.6, 0.9)
_GLOSS = (0.1, 0.3, 1.0, 3.0)
MATERIALS: tuple[Material, ...] = (
    LAMBERT,
    *(Material("gloss", one, share) for one in _ROUGHNESS for share in _GLOSS),
    *(Material("metal", one) for one in _ROUGHNESS),
    *(Material("rough", share=share) for share in (0.25, 0.5, 1.0)),
)
"""What is looked for: steps of 1.5 in roughness and of 3 in the strength of gloss, so that a lobe
between two is off by less than `MaterialSettings.proportional` in most of its values."""


@dataclass(frozen=True, slots=True)
class MaterialSettings:
    """How a normal is searched for, and when a material is believed; brightness in shares of the pixel's.

    noise: of a value, at least. step: of brightness, one of 8 bits, which is more for a dark pixel.
        proportional: by how much a formula may be off, as a share of the value. width: a value counts as
        contradicting at this many times both. dark: below it a value says nothing of the brightness at the
        start.
    rounds: most steps of a pixel's search. longest_step: largest turn of the normal in one of them, settled:
        turn that ends the search, each in radians.
    pixels: that vote, all over the mask; seen: how bright they must get, in steps. ink: share of the usual
        brightness below which pixels vote by themselves; fewest: that may. most: materials beside
        Lambert's law. gain: share of the contradictions that each must take away over all voters; drop: share
        of all values by which the first must, since little contradicts where the law holds.
    exact: median error, over the noise, up to which Lambert's law stands without a look at materials: half of
        the lamps then agree to this, which a law that is not the pixel's does not do, and the others are
        forgotten as gloss or shadow.
    strength_prior: how much the material's own share counts for the strength of gloss at a pixel, beside what
        its lamps say.
    lobe_values: of brightness that a lobe is learnt from, at most.
    contradicted: share of a pixel's lamps beyond which no material is believed there, as between mirrors.
    least_lamps: below which no material is looked for.
    patches, patch_side: how many squares of how many pixels are solved on trial. rougher: times the curl of
        the slopes that materials may make of that by Lambert's law; curl: per pixel, below which it does not
        matter.
    """

    noise: float = 0.01
    step: float = 0.004
    proportional: float = 0.1
    width: float = 2.0
    dark: float = 0.03
    rounds: int = 12
    longest_step: float = 0.25
    settled: float = 2e-4
    pixels: int = 400
    seen: float = 5.0
    ink: float = 0.4
    fewest: int = 20
    most: int = 3
    gain: float = 0.1
    drop: float = 0.01
    exact: float = 1.0
    strength_prior: float = 0.02
    lobe_values: int = 24_000
    contradicted: float = 0.4
    least_lamps: int = 8
    patches: int = 24
    patch_side: int = 16
    rougher: float = 1.1
    curl: float = 0.03


@dataclass(frozen=True, slots=True, eq=False)
class MaterialFit:
    """normals: (P, 3), unit. brightness: (P,) by which the shape is multiplied, in the values' unit.

    contradicted: (P,) share of the lamps that contradict, in [0, 1]: a value that is far off counts 1.
    """

    normals: FloatArray
    brightness: FloatArray
    contradicted: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class PixelValues:
    """Brightness of P pixels under N lamps, as if of strength 1, each in shares of its own.

    shares: (P, N), -1 where overexposed. scale: (P,) what a share is. noise2: (P, 1) variance of a share:
    dark pixels are noisier.
    """

    shares: FloatArray
    scale: FloatArray
    noise2: FloatArray

    def __len__(self) -> int:
        return len(self.scale)

    def chosen(self, which: IntArray | BoolArray) -> PixelValues:
        """Some of the pixels."""
        return PixelValues(self.shares[which], self.scale[which], self.noise2[which])


class Lamps:
    """Lamps as materials see them.

    directions: (N, 3), unit. halfway: (N, 3), unit, between lamp and camera. strengths: (N,).
    """

    def __init__(self, lights: FloatArray) -> None:
        self.strengths = np.linalg.norm(lights, axis=1)
        self.directions = lights / self.strengths[:, None]
        halfway = self.directions + np.array([0.0, 0.0, 1.0])
        self.halfway = halfway / np.maximum(np.linalg.norm(halfway, axis=1, keepdims=True), 1e-9)

    def relative(self, rows: FloatArray, settings: MaterialSettings) -> PixelValues:
        """Brightness in shares of each pixel's, which is its nine-tenths quantile. rows: (P, N)."""
        even = rows / self.strengths
        rank = int(np.ceil(0.9 * (rows.shape[1] - 1)))
        scale = np.partition(even, rank, axis=1)[:, rank] + 1e-12
        shares = np.where(rows < SATURATION, even / scale[:, None], -1.0)
        return PixelValues(shares, scale, settings.noise**2 + (settings.step / scale[:, None]) ** 2)

    def starts(self, seen: PixelValues, *normals: FloatArray) -> FloatArray:
        """(P, S, 3) where a search may start: amid halfway directions of bright lamps, at and about normals.

        normals: (P, 3) each; six directions 15 degrees about the last are added.
        """
        mirrored = np.maximum(seen.shares, 0.0) ** 2 @ self.halfway
        u, v = _beside(_turned(normals[-1], np.zeros((1, 3))))
        turns = [(np.cos(k * np.pi / 3), np.sin(k * np.pi / 3)) for k in range(6)]
        around = [normals[-1] + np.tan(np.radians(15.0)) * (x * u + y * v) for x, y in turns]
        found = np.stack([mirrored, *normals, *around], axis=1)
        found[..., 2] = np.maximum(found[..., 2], 0.05 * np.linalg.norm(found, axis=2))
        return np.asarray(found / np.maximum(np.linalg.norm(found, axis=2, keepdims=True), 1e-12))


def reflected(normals: FloatArray, lamps: Lamps, material: Material) -> FloatArray:
    """(P, N): what a material of brightness 1 shows under each lamp of strength 1. normals: (P, 3)."""
    facing = np.maximum(normals @ lamps.directions.T, 0.0)
    toward = np.maximum(normals[:, 2:], 1e-3)
    if material.kind == "rough":
        grazing = 2.0 * facing / (facing + toward)
        return np.asarray((1.0 - material.share) * facing + material.share * grazing)
    halfway = normals @ lamps.halfway.T
    a2 = material.roughness**2
    spread = halfway * halfway * (a2 - 1.0) + 1.0
    masked = 2.0 * facing / (facing + np.sqrt(a2 + (1.0 - a2) * facing**2))
    seen = 2.0 / (toward + np.sqrt(a2 + (1.0 - a2) * toward**2))
    lobe = 0.25 * a2 / (spread * spread) * masked * seen
    return np.asarray(lobe if material.kind == "metal" else facing + material.share * lobe)


def fit_material(
    seen: PixelValues,
    lamps: Lamps,
    material: Material,
    *,
    starts: FloatArray,
    settings: MaterialSettings,
) -> MaterialFit:
    """The normal of each pixel under which a material explains most of its values.

    starts: (P, S, 3); the best of them is improved on by damped
    Gauss-Newton steps over normal and brightness, with weights that forget what contradicts (Geman-McClure).
    """
    best = rate(seen, lamps, material, starts[:, 0], settings)
    for k in range(1, starts.shape[1]):
        best = _better(best, rate(seen, lamps, material, starts[:, k], settings))
    damping, moving = np.full(len(seen), 1e-3), np.ones(len(seen), bool)
    for _ in range(settings.rounds):
        trial, step = _stepped(seen, lamps, material, best, damping=damping, settings=settings)
        damping = np.where(trial.contradicted < best.contradicted, 0.3 * damping, 10.0 * damping)
        best = _better(best, trial, among=moving)
        moving &= step > settings.settled
    return best


def choose_materials(contradicted: FloatArray, *, settings: MaterialSettings) -> list[int]:
    """Numbers of the materials that explain what Lambert's law does not, the most telling first.

    contradicted: (P, M) of some pixels under each material, of which the first is Lambert's law.
    """
    chosen: list[int] = []
    best = contradicted[:, 0]
    while len(chosen) < settings.most:
        total = np.minimum(best[:, None], contradicted).mean(axis=0)
        one, before = int(total.argmin()), float(best.mean())
        least = settings.gain * before if chosen else max(settings.gain * before, settings.drop)
        if before - total[one] < least:
            break
        chosen.append(one)
        best = np.minimum(best, contradicted[:, one])
    return chosen


def trusts(seen: PixelValues, shown: FloatArray, settings: MaterialSettings) -> FloatArray:
    """(P, N) in [0, 1]: the trust in each value, near 0 for what contradicts what is shown, (P, N)."""
    return _agreement(seen, shown, settings)[0] ** 2


def usual_error(seen: PixelValues, lamps: Lamps, fit: MaterialFit, settings: MaterialSettings) -> FloatArray:
    """(P,): the median of |value - Lambert's law| over the noise, of the lamps that tell anything."""
    shown = fit.brightness[:, None] * reflected(fit.normals, lamps, LAMBERT)
    telling = _telling(seen, shown, settings)
    off = np.sort(np.where(telling, np.abs(seen.shares - shown), np.inf), axis=1)
    middle = np.maximum(np.count_nonzero(telling, axis=1) - 1, 0) // 2
    usual = np.where(telling.any(axis=1), np.take_along_axis(off, middle[:, None], axis=1)[:, 0], 0.0)
    return np.asarray(usual / np.sqrt(seen.noise2[:, 0]))


def doubt(
    seen: PixelValues, lamps: Lamps, normals: FloatArray, settings: MaterialSettings
) -> tuple[FloatArray, BoolArray]:
    """(P,) each: the share of lamps that contradict Lambert's law, and whether it is in doubt.

    normals: (P, 3). In doubt is a pixel of which half of the lamps are further off than `settings.exact`.
    """
    found = rate(seen, lamps, LAMBERT, normals, settings)
    return found.contradicted, usual_error(seen, lamps, found, settings) > settings.exact


def _telling(seen: PixelValues, shown: FloatArray, settings: MaterialSettings) -> BoolArray:
    """(P, N): which lamps say anything: one that shows nothing, as it should, agrees with any narrow lobe."""
    return np.asarray((seen.shares > settings.dark) | ((shown > settings.dark) & (seen.shares >= 0.0)))


def _agreement(
    seen: PixelValues, shown: FloatArray, settings: MaterialSettings
) -> tuple[FloatArray, FloatArray]:
    """(P, N) how far each value agrees, in [0, 1], 0 where overexposed; and the variance it may have."""
    variance = seen.noise2 + (settings.proportional * shown) ** 2
    limit = settings.width**2 * variance
    agrees = limit / (limit + (seen.shares - shown) ** 2)
    return np.where(seen.shares >= 0.0, agrees, 0.0), variance


def rate(
    seen: PixelValues,
    lamps: Lamps,
    material: Material,
    normals: FloatArray,
    settings: MaterialSettings,
    *,
    brightness: FloatArray | None = None,
) -> MaterialFit:
    """The brightness of each pixel under given normals, from a guess if there is one; what contradicts."""
    shape = reflected(normals, lamps, material)
    if brightness is None:
        certain = seen.noise2 + (settings.proportional * seen.shares) ** 2
        weights = np.where(seen.shares > settings.dark, 1.0 / certain, 0.0)
        brightness = _scaled(weights, shape, seen.shares)
    agrees, variance = _agreement(seen, brightness[:, None] * shape, settings)
    brightness = _scaled(agrees**2 / variance, shape, seen.shares)
    shown = brightness[:, None] * shape
    agrees, _ = _agreement(seen, shown, settings)
    telling = _telling(seen, shown, settings)
    count = np.maximum(np.count_nonzero(telling, axis=1), 1)
    return MaterialFit(normals, brightness, 1.0 - (telling * agrees).sum(axis=1) / count)


def _scaled(weights: FloatArray, shape: FloatArray, shares: FloatArray) -> FloatArray:
    """(P,) the weighted least-squares brightness."""
    return np.asarray((weights * shape * shares).sum(axis=1) / ((weights * shape**2).sum(axis=1) + 1e-20))


def _stepped(
    seen: PixelValues,
    lamps: Lamps,
    material: Material,
    now: MaterialFit,
    *,
    damping: FloatArray,
    settings: MaterialSettings,
) -> tuple[MaterialFit, FloatArray]:
    """One damped Gauss-Newton step, and by how much it turns each normal along the longer of two axes, (P,).

    Derivatives are differences over a hundredth of a radian.
    """
    apart = 0.01
    u, v = _beside(now.normals)
    shape = reflected(now.normals, lamps, material)
    shown = now.brightness[:, None] * shape
    agrees, variance = _agreement(seen, shown, settings)
    weights = agrees**2 / variance
    columns: list[FloatArray] = [
        now.brightness[:, None]
        * (reflected(_turned(now.normals, apart * one), lamps, material) - shape)
        / apart
        for one in (u, v)
    ]
    columns.append(shape)
    off = np.where(seen.shares >= 0.0, seen.shares - shown, 0.0)
    A = np.moveaxis(np.array([[(weights * a * b).sum(axis=1) for a in columns] for b in columns]), 2, 0)
    b = np.stack([(weights * a * off).sum(axis=1) for a in columns], axis=1)
    diagonal = np.einsum("pii->pi", A)
    diagonal += damping[:, None] * diagonal + 1e-9 * diagonal.max(axis=1, keepdims=True) + 1e-20
    step = np.linalg.solve(A, b[..., None])[..., 0]
    size = np.hypot(step[:, 0], step[:, 1])
    shorter = np.minimum(1.0, settings.longest_step / np.maximum(size, 1e-12))[:, None]
    normals = _turned(now.normals, shorter * (step[:, :1] * u + step[:, 1:2] * v))
    brightness = np.maximum(now.brightness + shorter[:, 0] * step[:, 2], 0.0)
    turn = shorter[:, 0] * np.abs(step[:, :2]).max(axis=1)
    return rate(seen, lamps, material, normals, settings, brightness=brightness), turn


def _beside(normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors at right angles to each normal, nz > 0, and to each other (Duff et al. 2017)."""
    x, y, z = normals.T
    a = -1.0 / (1.0 + z)
    b = x * y * a
    return np.stack([1.0 + x * x * a, b, -x], axis=1), np.stack([b, 1.0 + y * y * a, -y], axis=1)


def _turned(normals: FloatArray, by: FloatArray) -> FloatArray:
    """Unit normals that lie beside others, never turned away from the camera."""
    moved = normals + by
    moved[:, 2] = np.maximum(moved[:, 2], 0.05)
    return np.asarray(moved / np.linalg.norm(moved, axis=1, keepdims=True))


def _better(one: MaterialFit, other: MaterialFit, *, among: BoolArray | None = None) -> MaterialFit:
    """Pixel by pixel the one that is contradicted less; of pixels that are not `among`, the first."""
    wins: BoolArray = other.contradicted < one.contradicted
    if among is not None:
        wins &= among
    return MaterialFit(
        np.where(wins[:, None], other.normals, one.normals),
        np.where(wins, other.brightness, one.brightness),
        np.where(wins, other.contradicted, one.contradicted),
    )
