"""Where the lamps stood, from how the card's white falls off; and what the camera makes of light.

Blank paper under a lamp at height Z and distance r shows s Z / r^3, times a power of the cosine from the
axis of the lamp, which is aimed at the middle of the card: 0 of a bulb, 1 of a bare LED, more of a beam. All
lamps of a capture are one lamp in several places, and share it. The lens darkens what is far from the
picture's middle, in the same way in all photographs; a photograph stores u = (1 + a) m + b m^2 of the
logarithm m of light (both of full scale), where a = b = 0 if the file's own curve (sRGB) is true. Gray
patches show the same shares of the white wherever they are and however bright. All is fitted at once, by
robust least squares, with the directions that a ball shows where there is one. Our own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rumu.card.layout import GRAYS
from rumu.card.samples import CardPlaces, CardSamples
from rumu.values import FloatArray

_UNIT = 300.0  # millimetres, so that all unknowns are of the order of 1
_FLOOR = 1e-4  # of full scale, below which nothing is told


@dataclass(frozen=True, slots=True)
class LightFitSettings:
    """What is known beforehand, as standard deviations, and how the fit goes.

    white: relative, of one cell of white. gray: of one patch. curve: of a; bend: of b. grays: logarithm by
    which printed grays differ from what was meant. lens: of the terms of the lens, whose share at the corners
    is near lens_usual. distance: logarithm of the distance, around usual_distance millimetres.
    alike: cells of white whose errors are one error, since paper and light are uneven over some millimetres.
    shadow: share by which white may be off before it is taken for shadowed or printed, and left out.
    room: of the light from all sides, as a share of the lamp's in the middle of the card. beam: of the power
    of the cosine by which a lamp's light falls off beside its axis, around beam_usual. turns: most
    evaluations of the fit.
    """

    white: float = 0.012
    gray: float = 0.03
    curve: float = 0.08
    bend: float = 0.03
    grays: float = 0.2
    lens: float = 0.4
    lens_usual: float = -0.5
    distance: float = 1.0
    usual_distance: float = 500.0
    alike: float = 120.0
    shadow: float = 0.06
    room: float = 0.03
    beam: float = 1.0
    beam_usual: float = 0.0
    turns: int = 60


@dataclass(frozen=True, slots=True, eq=False)
class BallLight:
    """What a ball says of the lamps.

    place: (3,) millimetres, its middle, from the card's middle. lights: (N, 3) unit vectors toward the lamps;
    NaN where it shows none. spread: degrees, of one direction.
    """

    place: FloatArray
    lights: FloatArray
    spread: float


@dataclass(frozen=True, slots=True, eq=False)
class LightFit:
    """What was found.

    positions: (N, 3) millimetres from the card's middle. powers: (N,) of the lamps, in one unit. unsure:
    (N,) degrees, standard deviation of each direction from the middle of the card. lens: (3,) of the
    logarithm of what the lens lets through, times the squared distance from the middle, its square and its
    cube. curve: (2,) a and b. room: share of the light in the middle of the card that comes from all sides.
    residual: median share by which white contradicts the fit. ball_off: (N,) degrees between what the ball
    says and the lamp that was found; NaN without.
    """

    positions: FloatArray
    powers: FloatArray
    unsure: FloatArray
    lens: FloatArray
    curve: FloatArray
    room: float
    residual: float
    ball_off: FloatArray


def fit_light(
    samples: Sequence[CardSamples],
    places: CardPlaces,
    *,
    ball: BallLight | None = None,
    settings: LightFitSettings | None = None,
) -> LightFit:
    """The lamps of N photographs from what the card shows in them."""
    from scipy.optimize import least_squares

    settings = settings or LightFitSettings()
    problem = _Problem(samples, places, ball, settings)
    x = problem.start()
    for _ in range(2):
        found = least_squares(problem.residuals, x, loss="soft_l1", method="trf", max_nfev=settings.turns)
        x = found.x
        problem.leave_out_shadows(x)
    positions, powers, rest = problem.parts(x)
    off = np.full(len(samples), np.nan)
    if ball is not None:
        toward = positions - ball.place
        cosine = np.einsum("nk,nk->n", toward, ball.lights) / np.linalg.norm(toward, axis=1)
        off = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    left = np.concatenate(problem.white_residuals(x)) * settings.white
    return LightFit(
        positions,
        powers,
        problem.unsure(x, found.jac, left),
        rest.lens,
        rest.curve,
        rest.room,
        float(np.median(np.abs(left))),
        off,
    )


def light_of(stored: FloatArray, curve: FloatArray) -> FloatArray:
    """Linear light, 1 at full scale, of what a file means as linear. stored: above 0. curve: (2,) a and b."""
    a, b = 1 + curve[0], curve[1]
    u = np.log(np.maximum(stored, _FLOOR))
    # u = a m + b m^2, of which the root that is m = u for a = 1, b = 0; past the bend it goes on straight
    root = np.sqrt(np.maximum(a * a + 4 * b * u, 0.04 * a * a))
    light = np.exp(2 * u / (a + root))
    return np.asarray(np.where(stored < _FLOOR, stored / _FLOOR * light, light))


@dataclass(frozen=True, slots=True, eq=False)
class _Shared:
    """What all photographs have in common. lens, curve, room, beam: see `LightFit`. grays: logarithms."""

    lens: FloatArray
    curve: FloatArray
    room: float
    grays: FloatArray
    beam: float


class _Problem:
    """The unknowns: for each photograph log power, X, Y and log Z; lens; curve; room; beam; log grays."""

    def __init__(
        self,
        samples: Sequence[CardSamples],
        places: CardPlaces,
        ball: BallLight | None,
        settings: LightFitSettings,
    ) -> None:
        self._settings, self._ball, self._places = settings, ball, places
        self._samples = samples
        self._seen = [np.log(np.maximum(one.white, _FLOOR)) for one in samples]
        self._seen_gray = [np.log(np.maximum(one.gray, _FLOOR)) for one in samples]
        self._meant = np.log(np.array(GRAYS))
        self._lit = [np.ones(len(one), bool) for one in self._seen]

    def start(self) -> FloatArray:
        """Lamps to the brighter side of each photograph, 45 degrees up."""
        settings, unknowns = self._settings, []
        x, y = self._places.white.T
        for k, seen in enumerate(self._seen):
            design = np.column_stack([np.ones(len(x)), x, y])
            plane = np.zeros(3)
            for _ in range(3):
                lit = self._lit[k]
                plane = np.linalg.lstsq(design[lit], seen[lit], rcond=None)[0]
                off = seen - design @ plane
                self._lit[k] = off > np.median(off) - 0.4  # beside a plane; a shadow is darker by far
            slope = max(float(np.hypot(*plane[1:])), 1e-6)
            distance = float(np.clip(3 * np.sqrt(0.5) / slope, 150.0, 3 * settings.usual_distance))
            away = distance * np.sqrt(0.5)
            place = np.array([away * plane[1] / slope, away * plane[2] / slope, away])
            power = float(np.median(seen)) - np.log(away / _UNIT) + 3 * np.log(distance / _UNIT)
            unknowns += [power, place[0] / _UNIT, place[1] / _UNIT, np.log(place[2] / _UNIT)]
        return np.array([*unknowns, settings.lens_usual, *(0.0,) * 5, settings.beam_usual, *self._meant])

    def leave_out_shadows(self, x: FloatArray) -> None:
        """Look no more at white that is clearly off."""
        limit = self._settings.shadow / self._settings.white
        self._lit = [np.abs(one) < limit for one in self._all_white(x)]

    def parts(self, x: FloatArray) -> tuple[FloatArray, FloatArray, _Shared]:
        """Positions (N, 3), powers (N,), and what is shared."""
        n = len(self._samples)
        lamps, rest = x[: 4 * n].reshape(n, 4), x[4 * n :]
        places = _UNIT * np.column_stack([lamps[:, 1], lamps[:, 2], np.exp(lamps[:, 3])])
        shared = _Shared(rest[:3], rest[3:5], float(rest[5]), rest[7:], float(rest[6]))
        return places, np.exp(lamps[:, 0]), shared

    def white_residuals(self, x: FloatArray) -> list[FloatArray]:
        """Of each photograph, what its lit white contradicts, in standard deviations."""
        return [one[lit] for one, lit in zip(self._all_white(x), self._lit, strict=True)]

    def _all_white(self, x: FloatArray) -> list[FloatArray]:
        positions, powers, shared = self.parts(x)
        lamps = list(zip(positions, powers, strict=True))
        points = self._places.white
        return [
            (seen - _stored(_light(points, one.out_white, lamp, shared), shared.curve)) / self._settings.white
            for seen, one, lamp in zip(self._seen, self._samples, lamps, strict=True)
        ]

    def residuals(self, x: FloatArray) -> FloatArray:
        """All that contradicts, in standard deviations."""
        settings = self._settings
        positions, powers, shared = self.parts(x)
        lamps = list(zip(positions, powers, strict=True))
        share = 1 / np.sqrt(settings.alike)
        parts = [share * one for one in self.white_residuals(x)]
        for seen, one, lamp in zip(self._seen_gray, self._samples, lamps, strict=True):
            light = _light(self._places.gray, one.out_gray, lamp, shared) + shared.grays[self._places.levels]
            parts.append((seen - _stored(light, shared.curve)) / settings.gray)
        parts.append((shared.grays - self._meant) / settings.grays)
        parts.append(shared.curve / (settings.curve, settings.bend))
        parts.append((shared.lens - (settings.lens_usual, 0.0, 0.0)) / settings.lens)
        parts.append(np.array([shared.room / settings.room]))
        parts.append(np.array([(shared.beam - settings.beam_usual) / settings.beam]))
        distance = np.linalg.norm(positions, axis=1)
        parts.append(np.log(distance / settings.usual_distance) / settings.distance)
        if self._ball is not None:
            toward = positions - self._ball.place
            toward /= np.linalg.norm(toward, axis=1)[:, None]
            apart = np.degrees(toward - self._ball.lights) / self._ball.spread
            parts.append(np.nan_to_num(apart).ravel())
        return np.concatenate(parts)

    def unsure(self, x: FloatArray, jacobian: FloatArray, left: FloatArray) -> FloatArray:
        """(N,) degrees, standard deviation of the directions, by the curvature of the fit."""
        wider = max(1.0, float(np.sqrt(np.mean((left / self._settings.white) ** 2))))
        covariance = wider**2 * np.linalg.pinv(jacobian.T @ jacobian)
        positions, *_ = self.parts(x)
        found = []
        for k, place in enumerate(positions):
            part = slice(4 * k + 1, 4 * k + 4)
            spread = _UNIT * np.diag([1.0, 1.0, place[2] / _UNIT])
            cov = spread @ covariance[part, part] @ spread
            distance = float(np.linalg.norm(place))
            across = np.eye(3) - np.outer(place, place) / distance**2
            found.append(np.degrees(np.sqrt(max(0.0, float(np.trace(across @ cov @ across)))) / distance))
        return np.array(found)


def _light(
    points: FloatArray, out: FloatArray, lamp: tuple[FloatArray, float], shared: _Shared
) -> FloatArray:
    """(n,) logarithm of the light that white sends to the camera from points (n, 2).

    out: (n,) squared distances from the picture's middle. lamp: its position (3,) and power.
    """
    place, power = lamp
    away = (points[:, 0] - place[0]) ** 2 + (points[:, 1] - place[1]) ** 2 + place[2] ** 2
    falls = power * place[2] / _UNIT * (away / _UNIT**2) ** -1.5 * _beside_axis(points, place) ** shared.beam
    middle = power * place[2] / _UNIT * (float(place @ place) / _UNIT**2) ** -1.5
    light = np.log(np.maximum(falls + shared.room * middle, _FLOOR**2))
    return np.asarray(light + passed_by_lens(out, shared.lens))


def _beside_axis(points: FloatArray, place: FloatArray) -> FloatArray:
    """(n,) cosine between the axis of a lamp, which is aimed at the middle, and its rays to points (n, 2)."""
    own = float(place @ place)
    away = (points[:, 0] - place[0]) ** 2 + (points[:, 1] - place[1]) ** 2 + place[2] ** 2
    toward = own - points @ place[:2]
    return np.asarray(np.maximum(toward, 1e-3 * own) / np.sqrt(away * own))


def passed_by_lens(out: FloatArray, lens: FloatArray) -> FloatArray:
    """(n,) logarithm of what the lens lets through. out: squared distances from the picture's middle."""
    return np.asarray(out * (lens[0] + out * (lens[1] + out * lens[2])))


def _stored(light: FloatArray, curve: FloatArray) -> FloatArray:
    """What a photograph stores of light, both as logarithms."""
    return np.asarray((1 + curve[0]) * light + curve[1] * light**2)
