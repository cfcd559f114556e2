"""The lobe of gloss as a capture shows it, and the ground under it.

Normals are searched for under a formula of gloss, and one that is nearly right finds them well enough. The
ground's colour it does not: far from its middle, where a lobe is weak but most lamps stand, what the formula
has too much of is taken from the ground, and what it lacks is given to it; of dark ground that is most. So
the lobe is learnt from pixels that face many ways: its heights at some angles between normal and halfway
direction are the same for all, while brightness of the ground and strength of the gloss are each pixel's own.

The surface sends light back in the lamp's colour, and the ground in its own: the dichromatic model of Shafer,
"Using color to separate reflection components" (1985). The curve is our own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rumu.surface.reflectance import (
    LAMBERT,
    Lamps,
    Material,
    MaterialSettings,
    PixelValues,
    reflected,
    trusts,
)
from rumu.values import FloatArray

ANGLES = (0.0, 4.0, 8.0, 12.0, 16.0, 20.0, 24.0, 28.0, 34.0, 42.0, 55.0, 80.0)
"""Degrees from the halfway direction at which a lobe is told; between them it is a straight line."""
_DARK_END = 2
"""Angles at the end at which a lobe shows nothing, since a ground that is brighter would explain the same."""


@dataclass(frozen=True, slots=True)
class LobeSettings:
    """How a lobe is learnt.

    pixels: fewest. rounds: in which the curve, and ground and strength, are found by turns.
    ridge: share of the evidence that is added where an angle is hardly seen.
    """

    pixels: int = 60
    rounds: int = 15
    ridge: float = 1e-6


def lobe_of(material: Material, normals: FloatArray, lamps: Lamps) -> FloatArray:
    """(P, N): what gloss shows beside ground of brightness 1, by what was learnt, else by its formula.

    Nothing of ground that has no gloss.
    """
    if material.kind == "rough":
        return np.zeros((len(normals), len(lamps.directions)))
    if not material.lobe:
        return reflected(normals, lamps, material) - reflected(normals, lamps, LAMBERT)
    return np.asarray(material.share * np.interp(_apart(normals, lamps), ANGLES, material.lobe))


def part_ground_and_gloss(
    colours: FloatArray,
    matte: FloatArray,
    lobe: FloatArray,
    weights: FloatArray,
    *,
    usual: FloatArray,
    prior: float,
) -> tuple[FloatArray, FloatArray]:
    """The brightness of the ground (P, C), at least 0, and the strength of the gloss over it (P,).

    colours: (P, N, C), for lamps of strength 1. matte, lobe: (P, N) what ground and gloss of strength 1 show.
    weights: (P, N), the trust in each value. usual: (P,) strength that is likely, which counts for `prior` of
    what the lamps say.
    """
    gray, trusted = colours.mean(axis=2), weights * matte
    power = np.maximum((trusted * matte).sum(axis=1), 1e-9)
    both = (trusted * lobe).sum(axis=1)
    own = (weights * lobe * lobe).sum(axis=1)
    likely = prior * own
    told = (weights * lobe * gray).sum(axis=1) - both * (trusted * gray).sum(axis=1) / power
    sure = np.maximum(own - both * both / power + likely, 1e-12)
    strength = np.maximum((told + likely * usual) / sure, 0.0)
    ground = np.einsum("pn,pnc->pc", trusted, colours) - (strength * both)[:, None]
    return np.maximum(ground / power[:, None], 0.0), strength


def learn_lobe(
    seen: PixelValues,
    lamps: Lamps,
    normals: FloatArray,
    roughness: float,
    *,
    material: MaterialSettings,
    settings: LobeSettings | None = None,
) -> tuple[float, ...]:
    """The heights of a lobe at ANGLES, of a material of share 1, from some of its pixels; empty of too few.

    normals: (P, 3), found under facets of this roughness.
    """
    settings = settings or LobeSettings()
    if len(seen) < settings.pixels:
        return ()
    formula = Material("gloss", roughness, 1.0)
    matte, lobe = reflected(normals, lamps, LAMBERT), lobe_of(formula, normals, lamps)
    hats, none = _hats(_apart(normals, lamps)), np.zeros(len(seen))
    weights = (seen.shares >= 0).astype(float)
    for _ in range(settings.rounds):
        ground, strength = part_ground_and_gloss(
            seen.shares[..., None], matte, lobe, weights, usual=none, prior=material.strength_prior
        )
        shown = ground * matte + strength[:, None] * lobe
        weights = trusts(seen, shown, material)
        sure = weights / (seen.noise2 + (material.proportional * shown) ** 2)
        A = np.einsum("pnk,pnl->kl", hats * (sure * strength[:, None] ** 2)[..., None], hats)
        b = np.einsum("pnk,pn->k", hats, sure * strength[:, None] * (seen.shares - ground * matte))
        curve = np.linalg.solve(A + settings.ridge * (np.trace(A) + 1e-12) * np.eye(len(A)), b)
        curve[-_DARK_END:] = 0.0
        curve = np.minimum.accumulate(np.maximum(curve, 0.0))
        if curve[0] <= 0:
            return ()
        lobe = hats @ curve
    first = lobe_of(formula, normals, lamps)  # as strong as the formula's, so that shares keep their meaning
    return tuple((curve * float((first * lobe).sum() / (lobe * lobe).sum())).tolist())


def _apart(normals: FloatArray, lamps: Lamps) -> FloatArray:
    """(P, N) degrees between normals and halfway directions, of lamps that stand behind the surface 180."""
    angle = np.degrees(np.arccos(np.clip(normals @ lamps.halfway.T, -1.0, 1.0)))
    return np.where(normals @ lamps.directions.T > 0, angle, 180.0)


def _hats(angles: FloatArray, knots: Sequence[float] = ANGLES) -> FloatArray:
    """(P, N, K): how much each knot counts at each angle, between two of them in proportion."""
    return np.stack([np.interp(angles, knots, one) for one in np.eye(len(knots))], axis=-1)
