"""How far away lamps stand, from the photographs of a flat sheet and the directions of the lamps.

A lamp at distance d in direction l shows at the place x of the sheet, in shares of its width from its middle,

    albedo (n . (l - x/d)) / |l - x/d|^3,

which for 1/d = 0 is Lambert's law of a lamp that is far away. On a sheet that is flat on the whole, relief
evens out over many pixels, so that the logarithm of the brightness tells 1/d of each lamp; what is common to
all lamps, as albedo and the lens, is taken off. From there all lamps are moved until they contradict the
pixels least, whose normals are eliminated one by one (variable projection): their distances, and a little
their directions and strengths. Our own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.capture.dome import places, without_fall_off
from rumu.errors import CaptureError
from rumu.image_stack import SATURATION, pixels_of
from rumu.values import Bilingual, Capture, FloatArray, Surface

_STEP = 1e-4  # by which unknowns are moved to see what that changes
_NEARNESS, _TURNS, _STRENGTH = 0, slice(1, 3), 3  # columns of the unknowns of a lamp


@dataclass(frozen=True, slots=True)
class NearnessSettings:
    """How lamps are placed.

    pixels: most pixels looked at. products: of pixels and pairs of lamps at most: of many lamps fewer pixels
        are looked at. dark: brightness below which a pixel is not looked at, in any lamp.
    least: pixels needed. alike: weight that draws the lamps' distances together. rounds: most steps.
    converged: step that ends them. turn: degrees by which directions are expected to be off. nearness: by
        which 1/d of the flat sheet is, in widths of the photograph. telling: most pixels that count as
        independent of each other.
    outlier: times the usual deviation from which a value counts for less. longest: step of an unknown.
    far: 1/d, in widths, below which a lamp counts as far away. nearest: largest 1/d.
    flat: degrees from the usual normal within which half of a flat sheet lies.
    gain: to what share a contradiction must fall for lamps to be told to stand near; contradiction: share of
        the brightness that contradicts a surface below which nothing is said.
    """

    pixels: int = 2000
    products: int = 4_000_000
    dark: float = 0.03
    least: int = 200
    alike: float = 0.05
    rounds: int = 20
    converged: float = 1e-4
    turn: float = 0.7
    nearness: float = 0.05
    telling: int = 400
    outlier: float = 2.5
    longest: float = 0.2
    far: float = 0.03
    nearest: float = 2.0
    flat: float = 15.0
    gain: float = 0.4
    contradiction: float = 0.008


@dataclass(frozen=True, slots=True, eq=False)
class _Sheet:
    """Some pixels of the photographs, and the lamps as they were told.

    values: (N, P) brightness. at: (P, 2) in widths from the middle, y up. lights: (N, 3). aside: (N, 2, 3),
    unit vectors across each light.
    """

    values: FloatArray
    at: FloatArray
    lights: FloatArray
    aside: FloatArray

    def directions(self, unknowns: FloatArray) -> FloatArray:
        """(N, 3) unit vectors from the middle, turned as the unknowns (N, 4) say."""
        turned = self.lights + np.einsum("nk,nki->ni", unknowns[:, _TURNS], self.aside)
        return np.asarray(turned / np.linalg.norm(turned, axis=1, keepdims=True))

    def lamps(self, unknowns: FloatArray) -> FloatArray:
        """(N, P, 3): the lamp of each pixel, times its strength there."""
        toward = np.repeat(self.directions(unknowns)[:, None], len(self.at), axis=1)
        toward[..., :2] -= unknowns[:, _NEARNESS, None, None] * self.at
        power = np.exp(unknowns[:, _STRENGTH])[:, None] / np.linalg.norm(toward, axis=2) ** 3
        return np.asarray(toward * power[..., None])


def place_lamps(capture: Capture, *, settings: NearnessSettings | None = None) -> Capture:
    """The capture with its lamps at the distances that its photographs show, and without their fall-off.

    capture: of a sheet that is flat on the whole, four lamps or more whose directions are told. The result
    has `positions`, directions from the middle of the sheet, strengths, and a note that says how far away the
    lamps stand.
    Raises CaptureError for fewer lamps, positions that are told already, too few lit pixels, and lamps that
    are far away.
    """
    settings = settings or NearnessSettings()
    if capture.positions is not None:
        raise CaptureError(
            "expected lamps of which directions alone are known; their positions are told already",
            zh="燈的位置已經知道了，不必再從照片推算。",
        )
    sheet = _sheet_of(capture, settings)
    unknowns = _least_contradicting(sheet, _of_flat_sheet(sheet, settings), settings)
    nearness = unknowns[:, _NEARNESS]
    if float(np.median(nearness)) < settings.far:
        raise CaptureError(
            "expected lamps near the sheet, whose light falls off across it; these photographs show no such "
            "lamp: take them as far away",
            zh="照片上看不出燈光由近到遠變弱，燈應離得很遠，不必用 --near-lamps。",
        )
    lights = sheet.directions(unknowns)
    width = capture.mask.shape[1]
    positions = width * lights / np.maximum(nearness, settings.far)[:, None]
    # What is found is the brightness in the middle; lamps of one power that stand nearer are brighter there.
    strengths = np.exp(unknowns[:, _STRENGTH]) * (positions**2).sum(axis=1)
    if capture.strengths is not None:
        strengths = strengths * capture.strengths
    return capture.changed(
        images=without_fall_off(capture.photographs, positions),
        lights=lights,
        positions=positions,
        strengths=strengths / strengths.mean(),
        notes=(*capture.notes, _note(positions, capture)),
    )


def near_notes(
    capture: Capture, surface: Surface, *, settings: NearnessSettings | None = None
) -> list[Bilingual]:
    """A note where photographs contradict lamps that are far away by much more than near ones.

    surface: of the capture. Nothing is said where it cannot be told, as of lamps in one ring, which a bowl of
    paper explains as well.
    """
    settings = settings or NearnessSettings()
    enough = len(capture.lights) > 4 and surface.quality.get("residual", 0.0) > settings.contradiction
    if capture.positions is not None or not enough:
        return []
    try:
        sheet = _sheet_of(capture, settings)
    except CaptureError:
        return []
    near = _least_contradicting(sheet, _of_flat_sheet(sheet, settings), settings)
    away = _least_contradicting(sheet, np.zeros((len(sheet.lights), 4)), settings, far=True)
    gained = _contradiction(sheet, near) < settings.gain * _contradiction(sheet, away)
    if (
        not gained
        or float(np.median(near[:, _NEARNESS])) < settings.far
        or not _is_flat(sheet, near, settings)
    ):
        return []
    return [
        Bilingual(
            "燈光由近到遠變弱，燈應離得很近，算出的斜率因此不準；若紙大致是平的，請用 --near-lamps。",
            "the light falls off across the photographs, so the lamps stood near, and the slopes are off; "
            "where the sheet is flat on the whole, use --near-lamps",
        )
    ]


def _sheet_of(capture: Capture, settings: NearnessSettings) -> _Sheet:
    count = len(capture.lights)
    if count < 4:
        raise CaptureError(
            f"expected four lamps or more, whose distances contradict each other, got {count}",
            zh=f"要推算燈的遠近，至少要 4 盞燈，這裡有 {count} 盞。",
        )
    most = min(settings.pixels, max(settings.products // count**2, settings.telling))
    pixels = pixels_of(capture.mask, about=2 * most)
    seen = capture.photographs.at(pixels)
    raw = (seen if seen.ndim == 2 else seen.mean(axis=2)).astype(np.float64)
    lit = ((raw > settings.dark) & (raw < SATURATION)).all(axis=0)
    if np.count_nonzero(lit) < settings.least:
        raise CaptureError(
            f"expected {settings.least} pixels that every lamp lights, got {np.count_nonzero(lit)}",
            zh=f"每盞燈都照亮的像素至少要 {settings.least} 個，這裡只有 {np.count_nonzero(lit)} 個。",
        )
    chosen = np.flatnonzero(lit)[:: max(1, np.count_nonzero(lit) // most)]
    strengths = np.ones(count) if capture.strengths is None else capture.strengths
    x, y = places(pixels[chosen], capture.mask.shape)
    first = np.cross(capture.lights, (0.0, 0.0, 1.0))
    first[np.linalg.norm(first, axis=1) < 1e-6] = (1.0, 0.0, 0.0)  # straight above, any will do
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return _Sheet(
        raw[:, chosen] / strengths[:, None],
        np.stack([x, y], axis=1) / capture.mask.shape[1],
        capture.lights,
        np.stack([first, np.cross(capture.lights, first)], axis=1),
    )


def _of_flat_sheet(sheet: _Sheet, settings: NearnessSettings) -> FloatArray:
    """(N, 4) unknowns: 1/d of each lamp and its strength, as flat paper shows them."""
    count = len(sheet.lights)
    unknowns = np.zeros((count, 4))
    seen = np.log(sheet.values)
    together = np.eye(count) - 1.0 / count
    for _ in range(settings.rounds):
        lamps = _logarithm_of_flat(sheet, unknowns)
        left = together @ (seen - lamps)
        level = np.median(left, axis=1, keepdims=True)
        left -= level
        trust = _trust(left, settings)
        moved = unknowns.copy()
        moved[:, _NEARNESS] += _STEP
        change = (_logarithm_of_flat(sheet, moved) - lamps) / _STEP
        change -= change.mean(axis=1, keepdims=True)
        effect = (together[:, :, None] * change[:, None]).reshape(count, -1)  # of lamp k on all lamps
        weighted = effect * trust.reshape(-1)
        normal = weighted @ effect.T
        pull = settings.alike * np.trace(normal) / count * together
        step = np.linalg.solve(
            normal + pull + 1e-9 * np.eye(count),
            weighted @ left.reshape(-1) - pull @ unknowns[:, _NEARNESS],
        )
        unknowns[:, _NEARNESS] = np.clip(unknowns[:, _NEARNESS] + step, 0.0, settings.nearest)
        unknowns[:, _STRENGTH] = level[:, 0] - level.mean()
        if np.abs(step).max() < settings.converged:
            break
    return unknowns


def _logarithm_of_flat(sheet: _Sheet, unknowns: FloatArray) -> FloatArray:
    """(N, P): the logarithm of what white, flat paper shows, without the strengths."""
    plain = unknowns.copy()
    plain[:, _STRENGTH] = 0.0
    return np.asarray(np.log(sheet.lamps(plain)[..., 2]))


def _least_contradicting(
    sheet: _Sheet, start: FloatArray, settings: NearnessSettings, *, far: bool = False
) -> FloatArray:
    """(N, 4) unknowns near the start that contradict Lambert's law least.

    far: leaves the lamps far away, and only finds their directions and strengths.
    """
    count = len(sheet.lights)
    turn = np.radians(settings.turn)
    of_one = [1e12 if far else settings.nearness**-2, turn**-2, turn**-2, 0.0]
    prior = np.tile(of_one, count)
    unknowns = start.copy()
    trust = np.ones_like(sheet.values)
    for _ in range(settings.rounds):
        lamps = sheet.lamps(unknowns)
        scaled = _normals(sheet, lamps, trust)
        scale = sheet.values.mean(axis=0)
        left = (sheet.values - np.einsum("npi,pi->np", lamps, scaled)) / scale
        trust = _trust(left, settings)
        weight = np.sqrt(trust)
        effects = np.empty((count, 4, sheet.values.shape[1]))
        for k in range(4):
            moved = unknowns.copy()
            moved[:, k] += _STEP
            change = np.einsum("npi,pi->np", sheet.lamps(moved) - lamps, scaled)
            effects[:, k] = weight * change / (_STEP * scale)
        basis = np.linalg.qr((lamps * weight[..., None]).transpose(1, 0, 2))[0]
        beyond = np.eye(count) - basis @ basis.transpose(0, 2, 1)  # (P, N, N), what no normal explains
        # An effect of lamp i meets one of lamp j in what no normal explains.
        normal = np.einsum("pij,iap,jbp->iajb", beyond, effects, effects, optimize=True)
        pulled = np.einsum("pij,jp->ip", beyond, weight * left)
        noise = _deviation(left) ** 2 * sheet.values.shape[1] / min(sheet.values.shape[1], settings.telling)
        system = normal.reshape(4 * count, -1) / noise + np.diag(prior)
        system += 1e-6 * np.trace(system) / len(system) * np.eye(len(system))
        wanted = np.einsum("iap,ip->ia", effects, pulled).reshape(-1) / noise
        step = np.linalg.solve(system, wanted - prior * (unknowns - start).reshape(-1)).reshape(count, 4)
        unknowns = unknowns + np.clip(step, -settings.longest, settings.longest)
        unknowns[:, _NEARNESS] = np.clip(unknowns[:, _NEARNESS], 0.0, settings.nearest)
        unknowns[:, _STRENGTH] -= unknowns[:, _STRENGTH].mean()
        if np.abs(step).max() < settings.converged:
            break
    return unknowns


def _normals(sheet: _Sheet, lamps: FloatArray, trust: FloatArray) -> FloatArray:
    """(P, 3) normals times albedo by weighted least squares under the lamps (N, P, 3) of each pixel."""
    normal = np.einsum("np,npi,npj->pij", trust, lamps, lamps, optimize=True) + 1e-12 * np.eye(3)
    right = np.einsum("np,npi,np->pi", trust, lamps, sheet.values, optimize=True)
    return np.asarray(np.linalg.solve(normal, right[..., None])[..., 0])


def _is_flat(sheet: _Sheet, unknowns: FloatArray, settings: NearnessSettings) -> bool:
    """Whether most of what is seen faces one way under these lamps."""
    scaled = _normals(sheet, sheet.lamps(unknowns), np.ones_like(sheet.values))
    normals = scaled / np.maximum(np.linalg.norm(scaled, axis=1, keepdims=True), 1e-12)
    usual = np.median(normals, axis=0)
    cosine = normals @ (usual / np.linalg.norm(usual))
    return float(np.degrees(np.arccos(np.clip(np.median(cosine), -1, 1)))) < settings.flat


def _contradiction(sheet: _Sheet, unknowns: FloatArray) -> float:
    """Usual share of the brightness that no normal explains under these lamps."""
    lamps = sheet.lamps(unknowns)
    scaled = _normals(sheet, lamps, np.ones_like(sheet.values))
    left = sheet.values - np.einsum("npi,pi->np", lamps, scaled)
    return _deviation(left / sheet.values.mean(axis=0))


def _deviation(left: FloatArray) -> float:
    """The usual deviation, by the median; a little above 0."""
    return 1.4826 * float(np.median(np.abs(left))) + 1e-4


def _trust(left: FloatArray, settings: NearnessSettings) -> FloatArray:
    """Weights in (0, 1], after Geman and McClure."""
    return np.asarray(1.0 / (1.0 + (left / (settings.outlier * _deviation(left))) ** 2) ** 2)


def _note(positions: FloatArray, capture: Capture) -> Bilingual:
    distances = np.linalg.norm(positions, axis=1)
    low, high = float(distances.min()), float(distances.max())
    unit, factor = ("mm", capture.spacing) if capture.spacing is not None else ("px", 1.0)
    told = f"{factor * low:.0f}-{factor * high:.0f} {unit}"
    return Bilingual(
        f"從照片看，燈離紙的中央 {told}，已照這樣計算。",
        f"by the photographs the lamps stand {told} from the middle of the sheet, and are taken so",
    )
