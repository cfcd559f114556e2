"""Where copy and master part: regions of ink that the other lacks, and strokes that stand elsewhere."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from rumu.assessment.similarity import posed
from rumu.registration.nearest import Nearest
from rumu.values import BoolArray, FloatArray, IntArray, Registration

Kind = Literal["missing", "extra", "displaced"]


@dataclass(frozen=True, slots=True)
class RegionSettings:
    """What makes a region.

    apart: distance in the plane, in rms radii, from which ink has no counterpart (a stroke's half-width is
        about 0.1). together: distance within which such points are one region. share: part of the ink that a
        region must hold. reach: how far apart, in rms radii, a missing and an extra region of like size may
        be to be one displaced stroke.
    """

    apart: float = 0.16
    together: float = 0.15
    share: float = 0.02
    reach: float = 0.8


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """One place where copy and master part.

    points: (n, 2) in the frame of the reference: the master's for 'missing', the copy's otherwise.
    share: of the ink, of the copy for 'extra', of the master otherwise.
    moved: (x, y) from where the master has it to where the copy has it, in rms radii, y up.
    """

    kind: Kind
    points: FloatArray
    share: float
    moved: tuple[float, float] = (0.0, 0.0)


def find_regions(registration: Registration, *, settings: RegionSettings | None = None) -> tuple[Region, ...]:
    """Missing and extra regions; a missing one with an extra one of its size beside it is a displaced one."""
    settings = settings or RegionSettings()
    p, x = (cloud[:, :2] for cloud in posed(registration))
    missing = _without_counterpart(x, p, registration.backward_index, settings)
    extra = _without_counterpart(p, x, registration.forward_index, settings)
    found = []
    for group in missing:
        share = len(group) / len(x)
        partner = _partner(x[group], [p[g] for g in extra], reach=settings.reach)
        if partner is None:
            found.append(Region("missing", x[group], share))
        else:
            copied = p[extra.pop(partner)]
            moved = copied.mean(axis=0) - x[group].mean(axis=0)
            found.append(Region("displaced", copied, share, (float(moved[0]), float(moved[1]))))
    found += [Region("extra", p[group], len(group) / len(p)) for group in extra]
    return tuple(region for region in found if region.share >= settings.share)


def _without_counterpart(
    a: FloatArray, b: FloatArray, match: IntArray, settings: RegionSettings
) -> list[IntArray]:
    """Indices of the regions of a that have no point of b near.

    match: (n,) the point of b that each point of a was matched with: in the plane the nearest is no farther.
    """
    alone = np.hypot(*(a - b.take(match, axis=0)).T) > settings.apart
    fewest = settings.share * len(a) / 4  # less than a region may still be where a missing stroke went
    if np.count_nonzero(alone) < fewest:
        return []
    alone[alone] = Nearest(b, follows=False)(a[alone])[0] > settings.apart**2
    return [group for group in _groups(a, alone, together=settings.together) if len(group) >= fewest]


def _groups(points: FloatArray, chosen: BoolArray, *, together: float) -> list[IntArray]:
    """Indices of the connected groups of the chosen points; each is reached step by step from its first.

    There are few as a rule, and SciPy's graphs and trees would take longer to import than to search them.
    """
    left = np.flatnonzero(chosen)
    groups = []
    while len(left):
        edge, left = left[:1], left[1:]
        group = [edge]
        while len(edge) and len(left):
            apart = points[left, None] - points[edge]
            near = (np.einsum("ijk,ijk->ij", apart, apart) <= together**2).any(axis=1)
            edge, left = left[near], left[~near]
            group.append(edge)
        groups.append(np.sort(np.concatenate(group)))
    return groups


def _partner(group: FloatArray, others: list[FloatArray], *, reach: float) -> int | None:
    """The index of the group that lies near and has about the same extent, if there is one."""
    best: tuple[float, int] | None = None
    for k, other in enumerate(others):
        distance = float(np.hypot(*(other.mean(axis=0) - group.mean(axis=0))))
        if distance < reach and 0.5 < len(other) / len(group) < 2.0 and (best is None or distance < best[0]):
            best = distance, k
    return best[1] if best else None
