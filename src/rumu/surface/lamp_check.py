"""Whether the lamps that a capture tells are those of its photographs.

Two things give wrong lamps away. The slopes of a surface have no curl: z_xy is the same whichever way round
it is derived. Lamps that are mirrored or turned about the camera's axis mirror or turn all normals alike, and
leave the same residual, but the slopes are then those of no surface. And more than four photographs
contradict lamps in a wrong order by more than they contradict the right ones.

What cannot be found this way: lamps turned by 180 degrees about the camera's axis, which turn the relief
inside out (the curl stays 0 and the residual the same); any wrong lamp of flat paper, whose normals are all
alike; and a light of the room under lamps in one ring, which makes all slopes less steep by one factor. One
axis mirrored and the other one mirrored differ by just that half turn, so both are named.

Ours, not the paper's. Slopes are compared over blocks of pixels of several sizes, since noise is stronger in
small ones and uneven light in large ones; blocks across an edge of ink are left out, because frames that are
half a pixel apart make false slopes there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rumu.capture.flatfield import quadratic_terms
from rumu.errors import CaptureError
from rumu.image_stack import each_range
from rumu.surface.lamp_order import AS_GIVEN, LampCheckSettings, unexplained
from rumu.surface.robust import pixel_scale
from rumu.surface.stereo import gradients_from_normals
from rumu.surface.strengths import sample
from rumu.values import Bilingual, BoolArray, Capture, FloatArray

_PARTS = 4
"""Parts of the pixels that are kept, of which a thread looks at one at a time."""
_FITTED = 3000
"""About how many blocks the smooth part of a slope is fitted to."""


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
    settings: LampCheckSettings | None = None,
) -> None:
    """Raise CaptureError when lamps that are turned or mirrored leave a surface, and those given do not.

    normals: (H, W, 3) under the lamps as given; albedo: (H, W) or (H, W, 3); known: (H, W), where they hold.
    Silent where the photographs do not tell, such as on flat paper.
    """
    settings = settings or LampCheckSettings()
    fit = _turned_or_mirrored(normals, albedo, known, settings)
    if fit is None:
        return
    order = _order_of(capture, _under(capture.lights, fit), settings)
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
    """(4, P): p_x, p_y, q_x, q_y between blocks of 1, 2, 4 ... pixels, where no ink begins or ends.

    A large photograph begins with larger blocks, so that it takes little memory.
    """
    sums, side = _first_sums(normals, albedo, known, settings)
    while min(sums.shape[1:]) >= settings.blocks:
        whole = sums[0] > side * side - 0.5
        means = sums[1:] / np.maximum(sums[0], 1.0)
        whole &= means[3] - means[2] ** 2 < settings.ink_edge**2
        p, q = _less_smooth(means[:2], whole)
        parts = [*_differences(p), *_differences(q)]
        near = np.hypot(*_differences(means[2])) < settings.ink_edge
        near &= whole[1:, 1:] & whole[1:, :-1] & whole[:-1, 1:] & whole[:-1, :-1]
        if np.count_nonzero(near) < settings.cells:
            return
        yield np.stack([part[near] for part in parts]).astype(np.float64)
        sums, side = _halve(sums), 2 * side


def _first_sums(
    normals: FloatArray, albedo: FloatArray, known: BoolArray, settings: LampCheckSettings
) -> tuple[FloatArray, int]:
    """(5, h, w) sums over blocks: known pixels, p, q, log albedo and its square; and the side of a block."""
    halvings = 0
    while known.size > settings.pixels * 4**halvings:
        halvings += 1
    side, height = 2**halvings, len(known) // 2**halvings * 2**halvings
    step = max(side, settings.pixels // _PARTS // known.shape[1] // side * side)

    def band(rows: slice) -> FloatArray:
        gray = albedo[rows] if albedo.ndim == 2 else albedo[rows].mean(axis=2)
        ink = np.log(np.maximum(gray, 1e-3))
        p, q = gradients_from_normals(normals[rows])
        inside = known[rows]
        sums = np.empty((5, *inside.shape), np.float32)
        for out, one in zip(sums, (1.0, p, q, ink, ink * ink), strict=True):
            out[...] = np.where(inside, one, np.float32(0))
        for _ in range(halvings):
            sums = _halve(sums)
        return sums

    bands = each_range(band, height, size=step, label="Checking the lamps")
    return np.concatenate(list(bands), axis=1), side


def _halve(sums: FloatArray) -> FloatArray:
    """(K, H, W) to (K, H // 2, W // 2) by adding two by two."""
    h, w = sums.shape[1] // 2 * 2, sums.shape[2] // 2 * 2
    by_rows = sums[:, 0:h:2, :w] + sums[:, 1:h:2, :w]
    return np.asarray(by_rows[:, :, 0::2] + by_rows[:, :, 1::2])


def _less_smooth(slopes: FloatArray, known: BoolArray) -> FloatArray:
    """(2, h, w) slopes less their smooth part, a quadric: a bent sheet, or lamps that light it unevenly."""
    _, h, w = slopes.shape
    y, x = np.ogrid[-1 : 1 : h * 1j, -1 : 1 : w * 1j]
    places = np.flatnonzero(known)
    if len(places) < 12:
        return slopes
    few = places[:: max(1, len(places) // _FITTED)]
    rows, columns = np.divmod(few, w)
    terms = quadratic_terms(x[0, columns], y[rows, 0])
    weights = np.linalg.lstsq(terms, slopes.reshape(2, -1)[:, few].T, rcond=None)[0].astype(np.float32)
    one, by_x, by_y, by_xx, by_xy, by_yy = weights[:, :, None, None]
    x, y = x.astype(np.float32), y.astype(np.float32)
    return np.asarray(slopes - (one + y * (by_y + y * by_yy) + x * (by_x + x * by_xx) + by_xy * x * y))


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
    share = f"{100 * fit.best / fit.given:.0f}%"
    return CaptureError(
        f"the lamps do not fit the photographs: {'; '.join(cause.en for cause in causes)}. As they are, "
        f"the slopes are those of no surface; then, their curl falls to {share}. {AS_GIVEN.en}",
        zh=f"燈的方向與照片不合：{'；'.join(cause.zh for cause in causes)}。"
        f"照現在的方向，算出的斜率不成曲面；改正後旋度降到 {share}。{AS_GIVEN.zh}",
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


def _order_of(capture: Capture, wanted: FloatArray, settings: LampCheckSettings) -> Bilingual | None:
    """How the lines are out of step when the lamps that fit are the given ones in another order.

    On a ring whose lamps stand unevenly that is so on average, and the photographs must agree.
    """
    lights, n = capture.lights, len(capture.lights)
    near, uneven = (float(np.cos(np.radians(angle))) for angle in (settings.angle, settings.uneven))
    for turned in (wanted, wanted * (-1.0, -1.0, 1.0)):
        for step in (1, -1):
            for k in range(n):
                order = [(step * i + k) % n for i in range(n)]
                alike = float((lights[order] * turned).sum(axis=1).min())
                if order == list(range(n)) or alike < uneven:
                    continue
                if alike < near and not (
                    abs(_mean_turn(lights[order], turned)) < settings.angle
                    and _fits_no_worse(capture, order, settings)
                ):
                    continue
                if step == -1:
                    return Bilingual("順序顛倒也會這樣", "lines in reversed order do the same")
                lines = min(k, n - k)
                return Bilingual(
                    f"順序錯開 {lines} 行也會這樣", f"so do lines that are out of step by {lines}"
                )
    return None


def _mean_turn(lights: FloatArray, others: FloatArray) -> float:
    """Degrees about the optical axis from some lamps to others, on average."""
    here, there = (one[:, 0] + 1j * one[:, 1] for one in (lights, others))
    return float(np.degrees(np.angle((there * here.conj()).sum())))


def _fits_no_worse(capture: Capture, order: list[int], settings: LampCheckSettings) -> bool:
    """Whether the photographs contradict the lamps in another order no more than as they are."""
    rows = sample(capture.photographs, mask=capture.mask, most=settings.rows)
    if len(rows) < len(order):
        return False
    scale = pixel_scale(rows)
    return unexplained(rows, capture.lights[order], scale) <= unexplained(rows, capture.lights, scale)
