"""Whether the lamps that a capture tells are those of its photographs.

Two things give wrong lamps away. The slopes of a surface have no curl: z_xy is the same whichever way round
it is derived. Lamps that are mirrored or turned about the camera's axis mirror or turn all normals alike, and
leave the same residual, but the slopes are then those of no surface. And more than four photographs
contradict lamps in a wrong order by more than they contradict the right ones.

What cannot be found this way: lamps turned by 180 degrees about the camera's axis, which turn the relief
inside out (the curl stays 0 and the residual the same), and any wrong lamp of flat paper, whose normals are
all alike. One axis mirrored and the other one mirrored differ by just that half turn, so both are named.

Ours, not the paper's. Slopes are compared over blocks of pixels of several sizes, since noise is stronger in
small ones and uneven light in large ones; blocks across an edge of ink are left out, because frames that are
half a pixel apart make false slopes there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from rumu.errors import CaptureError
from rumu.surface.robust import pixel_scale
from rumu.surface.stereo import gradients_from_normals
from rumu.surface.strengths import Photometry, estimate_photometry, sample
from rumu.values import Bilingual, BoolArray, Capture, FloatArray

_FITTED = 3000
"""About how many blocks the smooth part of a slope is fitted to."""


@dataclass(frozen=True, slots=True)
class LampCheckSettings:
    """How clear it must be that other lamps fit better before right ones could be blamed.

    curl_ratio: times that the curl must exceed that under other lamps, and theirs that of every further kind.
    sizes: of blocks, one after the other, at which that must hold, with the same angle to within `angle`.
    angle: degrees; also by how far an angle may miss the ones that mistakes make: multiples of 90, and those
        that other orders of the lamps make.
    blocks, cells: fewest blocks across the picture, and fewest places where slopes are compared.
    slope_step: least difference of slope between neighbouring blocks that counts, above what 8 bits round.
    ink_edge: largest difference of log albedo within or between blocks. strong: how many times the usual
        difference of slopes makes relief that stands out from a flat ground.
    residual: share of the brightness that must contradict the lamps before their order is doubted.
    shading: times that share by which the brightness must differ from that of a sheet that faces one way.
    residual_ratio: to what share of that another order must bring it. free_ratio: the same for three
        directions of any kind, which says that the lamps are of another capture.
    rows: most pixels that orders are tried on; orders: most pairs of lamps tried.
    """

    curl_ratio: float = 2.5
    sizes: int = 2
    angle: float = 8.0
    blocks: int = 20
    cells: int = 150
    slope_step: float = 0.008
    ink_edge: float = 0.25
    strong: float = 3.0
    residual: float = 0.04
    shading: float = 0.5
    residual_ratio: float = 0.5
    free_ratio: float = 0.25
    rows: int = 400
    orders: int = 2000


@dataclass(frozen=True, slots=True)
class _Fit:
    """What a set of blocks says: whether mirrored, by which angle in degrees, and how much curl is left.

    given, best, other: curl under the lamps as given, under the best ones, and under the best ones of the
    other kind (turned or mirrored), in shares of all differences of slope.
    """

    mirrored: bool
    angle: float
    given: float
    best: float
    other: float


def check_lamps(
    capture: Capture,
    normals: FloatArray,
    albedo: FloatArray,
    *,
    known: BoolArray,
    strengths: FloatArray,
    settings: LampCheckSettings | None = None,
) -> None:
    """Raise CaptureError when other lamps than those of the capture clearly fit its photographs better.

    normals: (H, W, 3) under the lamps as given; albedo: (H, W) or (H, W, 3); known: (H, W), where they hold;
    strengths: (N,) of the lamps, as they were found. Silent where the photographs do not tell, such as on
    flat paper.
    """
    settings = settings or LampCheckSettings()
    _check_order(capture, strengths, settings)
    fit = _turned_or_mirrored(normals, albedo, known, settings)
    if fit is None:
        return
    order = _order_of(capture.lights, _under(capture.lights, fit), settings)
    if order is not None or abs((fit.angle + 45) % 90 - 45) <= settings.angle:
        raise _wrong_lamps(capture, fit, order)


# --- the curl of the slopes ------------------------------------------------------------------------


def _turned_or_mirrored(
    normals: FloatArray, albedo: FloatArray, known: BoolArray, settings: LampCheckSettings
) -> _Fit | None:
    """How the lamps are wrong, None when that is not clear: the same at neighbouring sizes of blocks."""
    found: dict[bool, list[_Fit | None]] = {False: [], True: []}
    for slopes in _pyramid(normals, albedo, known, settings):
        usual = float(np.median((slopes**2).sum(axis=0)))
        standing_out = (slopes**2).sum(axis=0) > settings.strong**2 * usual
        for strong, part in ((False, slopes), (True, slopes[:, standing_out])):
            found[strong].append(_fit(part, settings))
    for fits in found.values():
        run: list[_Fit] = []
        for fit in fits:
            wrong = fit is not None and _is_clear(fit, settings)
            same = not run or (
                fit is not None
                and fit.mirrored == run[-1].mirrored
                and abs((fit.angle - run[-1].angle + 90) % 180 - 90) <= settings.angle
            )
            run = [*run, fit] if wrong and same and fit is not None else ([fit] if wrong and fit else [])
            if len(run) == settings.sizes:
                return max(run, key=lambda one: one.given / max(one.best, 1e-9))
    return None


def _is_clear(fit: _Fit, settings: LampCheckSettings) -> bool:
    turned = not fit.mirrored and abs(fit.angle) <= settings.angle
    return not turned and settings.curl_ratio * fit.best < min(fit.given, fit.other)


def _pyramid(
    normals: FloatArray, albedo: FloatArray, known: BoolArray, settings: LampCheckSettings
) -> Iterator[FloatArray]:
    """(4, P): p_x, p_y, q_x, q_y between blocks of 1, 2, 4 ... pixels, where no ink begins or ends."""
    gray = albedo if albedo.ndim == 2 else albedo.mean(axis=2)
    ink = np.log(np.maximum(gray, 1e-3))
    p, q = gradients_from_normals(normals)
    sums = np.stack([known, *(np.where(known, one, 0.0) for one in (p, q, ink, ink * ink))]).astype(
        np.float32
    )
    side = 1
    while min(sums.shape[1:]) >= settings.blocks:
        whole = sums[0] > side * side - 0.5
        means = sums[1:] / np.maximum(sums[0], 1.0)
        whole &= means[3] - means[2] ** 2 < settings.ink_edge**2
        p, q = (_less_smooth(one, whole) for one in means[:2])
        parts = [*_differences(p), *_differences(q)]
        near = np.hypot(*_differences(means[2])) < settings.ink_edge
        near &= whole[1:, 1:] & whole[1:, :-1] & whole[:-1, 1:] & whole[:-1, :-1]
        if np.count_nonzero(near) < settings.cells:
            return
        yield np.stack([part[near] for part in parts]).astype(np.float64)
        sums, side = _halve(sums), 2 * side


def _halve(sums: FloatArray) -> FloatArray:
    """(K, H, W) to (K, H // 2, W // 2) by adding two by two."""
    k, h, w = (sums.shape[0], sums.shape[1] // 2, sums.shape[2] // 2)
    return np.asarray(sums[:, : 2 * h, : 2 * w].reshape(k, h, 2, w, 2).sum(axis=(2, 4)))


def _less_smooth(slope: FloatArray, known: BoolArray) -> FloatArray:
    """A slope less its smooth part, a quadric: a bent sheet, or lamps that light it unevenly."""
    h, w = slope.shape
    y, x = np.mgrid[-1 : 1 : h * 1j, -1 : 1 : w * 1j].astype(np.float32)
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y])
    if np.count_nonzero(known) < 2 * len(terms):
        return slope
    few = np.flatnonzero(known)[:: max(1, np.count_nonzero(known) // _FITTED)]
    flat = terms.reshape(len(terms), -1)
    weights = np.linalg.lstsq(flat[:, few].T, slope.ravel()[few], rcond=None)[0]
    return np.asarray(slope - np.tensordot(weights.astype(np.float32), terms, axes=1))


def _differences(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """By x and by y (up), between four neighbouring blocks; their noise is independent, whatever it is."""
    right, left = values[:, 1:], values[:, :-1]
    by_x = 0.5 * (right[:-1] + right[1:] - left[:-1] - left[1:])
    by_y = 0.5 * (right[:-1] + left[:-1] - right[1:] - left[1:])
    return by_x, by_y


def _fit(slopes: FloatArray, settings: LampCheckSettings) -> _Fit | None:
    """The turn and the mirror that leave the least curl; None where there is too little to tell."""
    size = (slopes**2).sum(axis=0)
    if slopes.shape[1] < settings.cells or np.median(size) < settings.slope_step**2:
        return None
    weights = 1.0 / (1.0 + size / np.median(size)) ** 2  # the same under all lamps that are compared
    p_x, p_y, q_x, q_y = slopes * np.sqrt(weights / (weights * size).sum())
    given = float(((p_y - q_x) ** 2).sum())
    turned = _least_angle(p_y - q_x, p_x + q_y)
    mirrored = _least_angle(p_y + q_x, p_x - q_y)
    (best, angle), (other, _) = sorted((turned, mirrored))
    return _Fit(mirrored <= turned, angle, given, best, other)


def _least_angle(at_0: FloatArray, at_90: FloatArray) -> tuple[float, float]:
    """Least sum of squares of cos(t) at_0 + sin(t) at_90, and its t in degrees, within (-90, 90]."""
    both = np.stack([at_0, at_90])
    sizes, axes = np.linalg.eigh(both @ both.T)
    angle = float(np.degrees(np.arctan2(axes[1, 0], axes[0, 0])))
    return float(max(sizes[0], 0.0)), 90.0 - (90.0 - angle) % 180.0


# --- what is wrong, in words -----------------------------------------------------------------------


def _wrong_lamps(capture: Capture, fit: _Fit, order: Bilingual | None) -> CaptureError:
    """The error that says which lamps fit, and what are the likely mistakes."""
    causes = [_mistake(fit)] if order is None else [_mistake(fit), order]
    if capture.orientation is not None:
        causes.append(
            Bilingual(
                '照片帶有 EXIF 方向，也請看 capture.json 的 "orientation"',
                'the photographs carry an EXIF orientation, see "orientation" of capture.json',
            )
        )
    share = f"{100 * fit.best / fit.given:.0f} %"
    return CaptureError(
        f"the lamps do not fit the photographs: {'; '.join(cause.en for cause in causes)}. As they are, "
        f"the slopes are those of no surface; then, their curl falls to {share}. {_AS_GIVEN.en}",
        zh=f"燈的方向與照片不合：{'；'.join(cause.zh for cause in causes)}。"
        f"照現在的方向，算出的斜率不成曲面；改正後旋度降到 {share}。{_AS_GIVEN.zh}",
    )


_AS_GIVEN = Bilingual(
    '若燈的方向確實沒錯，請用 --lamps-as-given，或在 capture.json 寫 "lamps_as_given": true。',
    'If the lamps are right, use --lamps-as-given, or "lamps_as_given": true in capture.json.',
)


def _mistake(fit: _Fit) -> Bilingual:
    """The change of the lamps that makes them fit; photographs cannot tell it from its half turn."""
    turn = round(-fit.angle)
    half = (turn + 360) % 360 - 180
    if not fit.mirrored:
        return Bilingual(
            f"要繞相機的軸逆時針轉 {turn} 度才合（轉 {half} 度也合，只是凹凸相反）",
            f"they fit when they are turned by {turn} degrees counter-clockwise about the optical axis "
            f"(or by {half}, with the relief inside out)",
        )
    if abs(fit.angle) <= 10:
        return Bilingual(
            "y 要反過來才合：y 應向上，影像的行卻是向下數的，請把每個 y 變號"
            "（x 反過來也合，只是凹凸相反，照片分不出是哪一個）",
            "they fit when y is turned. y points up, image rows run down: change the sign of every y "
            "(turning x instead fits as well, with the relief inside out; photographs cannot tell which)",
        )
    if abs(fit.angle) >= 80:
        return Bilingual(
            "x 與 y 要對調才合（對調後都變號也合，只是凹凸相反）",
            "they fit when x and y are exchanged (or exchanged and both turned, with the relief inside out)",
        )
    return Bilingual(
        f"要鏡射（y 變號）並逆時針轉 {turn} 度才合",
        f"they fit when y is turned and they are then turned by {turn} degrees counter-clockwise",
    )


def _under(lights: FloatArray, fit: _Fit) -> FloatArray:
    """(N, 3): the lamps that fit; the half turn of all of them fits as well."""
    t = np.radians(fit.angle)
    turn = np.array([[np.cos(t), np.sin(t), 0.0], [-np.sin(t), np.cos(t), 0.0], [0.0, 0.0, 1.0]])
    mirror = np.diag([1.0, -1.0 if fit.mirrored else 1.0, 1.0])
    return np.asarray(lights @ (mirror @ turn).T)


def _order_of(lights: FloatArray, wanted: FloatArray, settings: LampCheckSettings) -> Bilingual | None:
    """How the lines are out of step when the lamps that fit are the given ones in another order."""
    n, near = len(lights), np.cos(np.radians(settings.angle))
    for turned in (wanted, wanted * (-1.0, -1.0, 1.0)):
        for step in (1, -1):
            for k in range(n):
                order = [(step * i + k) % n for i in range(n)]
                if order == list(range(n)) or (lights[order] * turned).sum(axis=1).min() < near:
                    continue
                if step == -1:
                    return Bilingual("順序顛倒也會這樣", "lines in reversed order do the same")
                lines = min(k, n - k)
                return Bilingual(
                    f"順序錯開 {lines} 行也會這樣", f"so do lines that are out of step by {lines}"
                )
    return None


# --- the order of the lamps ------------------------------------------------------------------------


def _check_order(capture: Capture, strengths: FloatArray, settings: LampCheckSettings) -> None:
    """Raise CaptureError when another order of the lamps, or other lamps, explain the photographs better."""
    n = len(capture.lights)
    rows = sample(capture.images, mask=capture.mask, most=settings.rows)
    if n < 5 or len(rows) < n:
        return
    scale = pixel_scale(rows)
    facing = np.median(rows / scale, axis=0)[:, None]
    given = min(
        _residual(rows, capture.lights, scale), _residual(rows, capture.lights * strengths[:, None], scale)
    )
    if given < settings.residual:
        return
    # No order of the lamps explains more than the three best directions of any kind do.
    free = np.linalg.svd(rows / scale, full_matrices=False)[2][:3].T
    least = _residual(rows, free, scale)
    if least > settings.residual_ratio * given or _residual(rows, facing, scale) < settings.shading * given:
        return
    given = min(given, _residual(rows, _with_strengths(capture, capture.lights), scale))
    if given < settings.residual or least > settings.residual_ratio * given:
        return
    trials = [(_residual(rows, capture.lights[order], scale), order) for order in _orders(n, settings)]
    trials.sort(key=lambda one: one[0])
    for _, order in trials[:3]:
        lights = capture.lights[order]
        fitted = min(_residual(rows, lights, scale), _residual(rows, _with_strengths(capture, lights), scale))
        if fitted < settings.residual_ratio * given:
            raise _wrong_order(capture, order, before=given, after=fitted)
    if given > 2.5 * settings.residual and least < settings.free_ratio * given:
        raise CaptureError(
            f"the lamps do not fit the photographs: {100 * given:.0f} % of the brightness contradicts them, "
            "and other lamps would explain it. Are they those of another capture, or in another order? "
            f"{_AS_GIVEN.en}",
            zh=f"燈的方向與照片不合：亮度有 {100 * given:.0f} % 與它們矛盾，換成別的方向就說得通。"
            f"是不是別組照片的燈，或順序不同？{_AS_GIVEN.zh}",
        )


def _residual(rows: FloatArray, lights: FloatArray, scale: FloatArray) -> float:
    """Median share of the brightness that no normal explains under these lamps, times strength."""
    q, _ = np.linalg.qr(lights)
    return float(np.median(np.abs(rows - (rows @ q) @ q.T) / scale))


def _with_strengths(capture: Capture, lights: FloatArray) -> FloatArray:
    found: Photometry = estimate_photometry(
        capture.images, lights, mask=capture.mask, strengths=capture.strengths
    )
    return np.asarray(lights * found.strengths[:, None])


def _orders(n: int, settings: LampCheckSettings) -> Iterator[list[int]]:
    """Orders that mistakes make: shifted, reversed, two exchanged."""
    for step in (1, -1):
        yield from ([(step * i + k) % n for i in range(n)] for k in range(n) if (step, k) != (1, 0))
    pairs = list(combinations(range(n), 2))
    for i, j in pairs if len(pairs) <= settings.orders else []:
        order = list(range(n))
        order[i], order[j] = j, i
        yield order


def _wrong_order(capture: Capture, order: list[int], *, before: float, after: float) -> CaptureError:
    names = capture.names or tuple(f"photograph {i + 1}" for i in range(len(order)))
    moved = [i for i, k in enumerate(order) if i != k]
    first = ", ".join(f"{names[i]} -> {names[order[i]]}" for i in moved[:3])
    more = ", ..." if len(moved) > 3 else ""
    shares = f"{100 * before:.0f} % / {100 * after:.0f} %"
    return CaptureError(
        "the lamps are in another order than the photographs: what contradicts them falls from "
        f"{100 * before:.0f} to {100 * after:.0f} % of the brightness when each photograph takes the lamp of "
        f"another one ({first}{more}). {_AS_GIVEN.en}",
        zh=f"燈的順序與照片不同：照片改配別張的燈（{first}{more}）時，矛盾的亮度大減（{shares}）。{_AS_GIVEN.zh}",
    )
