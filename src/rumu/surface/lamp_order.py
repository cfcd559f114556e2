"""Whether the photographs contradict the lamps of a capture, and lamps in another order less.

Under more than three lamps each pixel says something twice. Whether a wrong order of the lamps leaves
something unexplained is told by trying the orders that mistakes make; whether a light of the room does, by
adding one that is on in all photographs.

Ours, not the paper's.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from rumu.errors import CaptureError
from rumu.surface.robust import pixel_scale
from rumu.surface.strengths import Photometry, estimate_photometry, sample
from rumu.values import Bilingual, Capture, FloatArray


@dataclass(frozen=True, slots=True)
class LampCheckSettings:
    """How clear it must be that other lamps fit better before right ones could be blamed.

    curl_ratio: times that the curl must exceed that under other lamps, and theirs that of every further kind.
    sizes: of blocks, one after the other, at which that must hold, with the same angle to within `angle`.
    angle: degrees; also by how far an angle may miss the ones that mistakes make: multiples of 90, and those
        that other orders of the lamps make.
    uneven: degrees by which single lamps of a ring may miss theirs in another order, while all do not.
    blocks, cells: fewest blocks across the picture, and fewest places where slopes are compared.
    slope_step: least difference of slope between neighbouring blocks that counts, above what 8 bits round.
    ink_edge: largest difference of log albedo within or between blocks. strong: how many times the usual
        difference of slopes makes relief that stands out from a flat ground.
    residual: share of the brightness that must contradict the lamps before their order is doubted.
    shading: times that share by which the brightness must differ from that of a sheet that faces one way.
    residual_ratio: to what share of that another order must bring it. free_ratio: the same for three
        directions of any kind, which says that the lamps are of another capture. exact_ratio: the same for an
        order that explains all there is, whatever the strengths of the lamps.
    ring: least singular value of the lamps and a light from everywhere that tells the two apart. room_light:
        share of the brightness from which such a light is named.
    rows: most pixels that orders are tried on; orders: most pairs of lamps tried.
    pixels: most pixels, or blocks of pixels, whose slopes are compared.
    """

    curl_ratio: float = 2.5
    sizes: int = 2
    angle: float = 8.0
    uneven: float = 20.0
    blocks: int = 20
    cells: int = 150
    slope_step: float = 0.008
    ink_edge: float = 0.25
    strong: float = 3.0
    residual: float = 0.04
    shading: float = 0.5
    residual_ratio: float = 0.5
    free_ratio: float = 0.25
    exact_ratio: float = 0.1
    ring: float = 0.15
    room_light: float = 0.25
    rows: int = 400
    orders: int = 2000
    pixels: int = 1_000_000


AS_GIVEN = Bilingual(
    '若燈的方向確實沒錯，請用 --lamps-as-given，或在 capture.json 寫 "lamps_as_given": true。',
    'If the lamps are right, use --lamps-as-given, or "lamps_as_given": true in capture.json.',
)


def check_order(capture: Capture, strengths: FloatArray, settings: LampCheckSettings | None = None) -> None:
    """Raise CaptureError when another order of the lamps, or other lamps, explain the photographs better.

    strengths: (N,) of the lamps, as they were found.
    """
    settings = settings or LampCheckSettings()
    n = len(capture.lights)
    rows = sample(capture.photographs, mask=capture.mask, most=settings.rows)
    if n < 5 or len(rows) < n:
        return
    scale = pixel_scale(rows)
    facing = np.median(rows / scale, axis=0)[:, None]
    of_equal = unexplained(rows, capture.lights, scale)
    given = min(of_equal, unexplained(rows, capture.lights * strengths[:, None], scale))
    if of_equal >= settings.residual:
        trials = [(unexplained(rows, capture.lights[order], scale), order) for order in _orders(n, settings)]
        trials.sort(key=lambda one: one[0])
        if trials[0][0] < settings.exact_ratio * of_equal:  # no strengths of the lamps do that by chance
            raise _wrong_order(capture, trials[0][1], before=of_equal, after=trials[0][0])
    if given < settings.residual:
        return
    # No order of the lamps explains more than the three best directions of any kind do.
    free = np.linalg.svd(rows / scale, full_matrices=False)[2][:3].T
    least = unexplained(rows, free, scale)
    if least > settings.residual_ratio * given or unexplained(rows, facing, scale) < settings.shading * given:
        return
    given = min(given, unexplained(rows, _with_strengths(capture, capture.lights), scale))
    if given < settings.residual or least > settings.residual_ratio * given:
        return
    _check_room_light(rows, capture, scale, before=given, settings=settings)
    for _, order in trials[:3]:
        lights = capture.lights[order]
        fitted = min(
            unexplained(rows, lights, scale), unexplained(rows, _with_strengths(capture, lights), scale)
        )
        if fitted < settings.residual_ratio * given:
            raise _wrong_order(capture, order, before=given, after=fitted)
    if given > 2.5 * settings.residual and least < settings.free_ratio * given:
        raise CaptureError(
            f"the lamps do not fit the photographs: {100 * given:.0f}% of the brightness contradicts them, "
            "and other lamps would explain it. Are they those of another capture, or in another order? "
            f"{AS_GIVEN.en}",
            zh=f"燈的方向與照片不合：亮度有 {100 * given:.0f}% 與它們矛盾，換成別的方向就說得通。"
            f"是不是別組照片的燈，或順序不同？{AS_GIVEN.zh}",
        )


def _check_room_light(
    rows: FloatArray, capture: Capture, scale: FloatArray, *, before: float, settings: LampCheckSettings
) -> None:
    """Raise CaptureError when a light that is on in all photographs explains what contradicts the lamps.

    Lamps in one ring cannot tell: such a light is to them one from straight above.
    """
    lamps = _with_strengths(capture, capture.lights)
    both = np.column_stack([lamps, np.ones(len(lamps))])
    if len(lamps) < 6 or np.linalg.svd(both, compute_uv=False)[-1] < settings.ring:
        return
    after = unexplained(rows, both, scale)
    constant = np.linalg.lstsq(both, rows.T, rcond=None)[0][3]
    share = float(np.median(constant / rows.mean(axis=1)))
    if after > settings.residual_ratio * before or share < settings.room_light:
        return
    shares = f"{100 * before:.0f}% / {100 * after:.0f}%"
    raise CaptureError(
        f"a light is on in all photographs: it makes {100 * share:.0f}% of their brightness, and explains "
        f"what contradicts the lamps ({shares} without and with it). Photograph in the dark, or add a "
        f"photograph named ambient with all lamps off. {AS_GIVEN.en}",
        zh=f"每張照片裡都有別的燈光，占亮度的 {100 * share:.0f}%；不算它和算它，與燈矛盾的亮度是 {shares}。"
        f"請在暗處重拍，或加一張關掉所有燈拍的 ambient。{AS_GIVEN.zh}",
    )


def unexplained(rows: FloatArray, lights: FloatArray, scale: FloatArray) -> float:
    """Median share of the brightness of pixels, (P, N), that no normal explains under these lamps.

    lights: (N, 3), times strength. scale: (P, 1), the brightness of each pixel.
    """
    q, _ = np.linalg.qr(lights)
    return float(np.median(np.abs(rows - (rows @ q) @ q.T) / scale))


def _with_strengths(capture: Capture, lights: FloatArray) -> FloatArray:
    found: Photometry = estimate_photometry(
        capture.photographs, lights, mask=capture.mask, strengths=capture.strengths
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
    shares = f"{100 * before:.0f}% / {100 * after:.0f}%"
    return CaptureError(
        "the lamps are in another order than the photographs: what contradicts them falls from "
        f"{100 * before:.0f} to {100 * after:.0f}% of the brightness when each photograph takes the lamp of "
        f"another one ({first}{more}). {AS_GIVEN.en}",
        zh=f"燈的順序與照片不同：照片改配別張的燈（{first}{more}）時，矛盾的亮度大減（{shares}）。{AS_GIVEN.zh}",
    )
