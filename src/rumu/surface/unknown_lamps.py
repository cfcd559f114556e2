"""Where the lamps stood, from the photographs of a sheet alone: no sphere, no file.

A sheet that is flat on the whole shows, under lamp i in direction (T_i, 1), a brightness k (1 - T_i . g) at a
place of slopes g = (p, q). Divided by what flat paper shows under the lamp, and by the mean over all lamps,
what is left of N photographs has rank 2: its singular vectors are the lamps and the slopes up to a linear
map. That map is fixed, but for its size and its sign, because slopes have no curl (Yuille and Snow, "Shape
and albedo from multiple images using integrability", 1997); its size is that of the generalised bas-relief
ambiguity (Belhumeur, Kriegman and Yuille, 1999), and is found because paper is equally white: what is steeper
is darker, under any lamp. Its sign, whether ridges are ridges, is told by the fall-off of lamps that stand
near, or taken by rule. Our own, of these parts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from rumu.capture.flat_frames import smooth_gains
from rumu.capture.flatfield import quadratic_terms
from rumu.errors import CaptureError
from rumu.image_stack import SATURATION, ImageStack, Progress
from rumu.surface.stereo import SHADOW_FLOOR
from rumu.values import Bilingual, BoolArray, Capture, FloatArray

Sign = Literal["fall-off", "rule", "asked"]
"""What tells ridges from hollows: light that falls off, the rule that it comes from above, or a person."""
_CELLS = 64  # of the longer side, in which what changes slowly is kept


@dataclass(frozen=True, slots=True)
class UnknownLampSettings:
    """How lamps are found, and when they cannot be.

    side: pixels of the longer side of the reduced photographs. smooth: pixels over which these are smoothed.
    fewest: lamps. least: pixels that are needed, of the sheet and of paper. relief: least of the second
    singular value over the third, since the third is noise. curl: most of the smallest over the second
    smallest singular value of the condition that slopes have no curl.
    paper: share by which the brightness of paper may be off. brightest: share of the pixels that are taken
    for paper first. beside: width in pixels that must all be paper around a place of it. even: share by which
    paper is unevenly white.
    rounds: times that lamps and slopes are found from each other. parts: strips of the sheet, each of which
    tells how steep it is; steep: most of the standard error of that, as a share. falls: share of the
    brightness, over half the sheet, by which a near lamp must show; agree: least correlation of that with
    the lamps.
    """

    side: int = 640
    smooth: float = 1.0
    fewest: int = 4
    least: int = 2000
    relief: float = 1.6
    curl: float = 0.5
    paper: float = 0.1
    brightest: float = 0.4
    beside: int = 7
    even: float = 0.02
    rounds: int = 3
    parts: int = 6
    steep: float = 0.2
    falls: float = 0.02
    agree: float = 0.6


@dataclass(frozen=True, slots=True, eq=False)
class UnknownLamps:
    """Lamps that photographs told.

    capture: the photographs, even, under these lamps, whose directions are kept as they are. unsure: standard
    error of how steep everything is, as a share. sign: what told ridges from hollows.
    """

    capture: Capture
    unsure: float
    sign: Sign


def find_lamps(
    stack: ImageStack,
    *,
    mask: BoolArray,
    names: tuple[str, ...] = (),
    inside_out: bool = False,
    settings: UnknownLampSettings | None = None,
    progress: Progress | None = None,
) -> UnknownLamps:
    """The lamps of N >= 4 photographs of a sheet that is flat on the whole.

    mask: (H, W), what is of the sheet. inside_out: take the other one of both readings, hollows for ridges.
    Raises CaptureError where they cannot be told: too few photographs, no relief, relief in one direction
    only, no paper of one brightness, or lamps that did not move.
    """
    settings = settings or UnknownLampSettings()
    if len(stack) < settings.fewest:
        raise CaptureError(
            f"expected at least {settings.fewest} photographs to find their lamps from, got {len(stack)}",
            zh=f"要從照片找出燈的方向，至少要 {settings.fewest} 張，這裡有 {len(stack)} 張。",
        )
    if progress is not None:
        progress("Finding the lamps", 0, 1)
    even = _evened(stack, mask, settings)
    mean = even.light.mean(axis=0)
    apart = even.light / mean - 1
    on_paper = apart[:, even.paper]  # where nothing is inked, so that no edge of ink passes for relief
    values, vectors = np.linalg.eigh(on_paper @ on_paper.T)
    if values[-2] < (settings.relief**2) * values[-3]:
        raise CaptureError(
            "expected relief that lamps from several sides show, got photographs that hardly differ but for "
            "noise; ink on flat paper looks the same under every lamp, and tells of none",
            zh="照片之間幾乎只有雜訊的差別；要有起伏、燈要在幾個方向。平紙上的墨在任何燈下都一樣，無從得知燈在哪裡。",
        )
    axes = vectors[:, -2:]
    seen = np.einsum("ik,ihw->khw", axes, apart)  # (2, h, w), slopes up to a linear map
    scale = _Scale(0.0, np.zeros(2), 0.0)
    linear: FloatArray = np.eye(2)
    for _ in range(settings.rounds):
        slopes = np.einsum("kl,lhw->khw", linear, seen)
        turned = seen / (1 + np.einsum("k,khw->hw", scale.lean, slopes))
        linear = _without_curl(turned, even.paper, settings)
        slopes = np.einsum("kl,lhw->khw", linear, seen)
        scale = _steepness(mean, slopes, even.paper, settings)
    lamps = (scale.lean - axes @ np.linalg.inv(linear)) / scale.size
    sign, way = _sign(lamps, even.fall_off, settings)
    if inside_out:
        sign, way = "asked", -way
    capture = _capture(stack, mask, names, way * lamps, even)
    note = _note(scale.unsure, sign)
    return UnknownLamps(capture.changed(notes=(note,)), scale.unsure, sign)


@dataclass(frozen=True, slots=True, eq=False)
class _Even:
    """Reduced photographs in which flat paper is evenly bright.

    light: (N, h, w). paper: (h, w), paper of one brightness that all lamps light. slow: (N, 6), the logarithm
    of what was divided by, see `_terms`. fall_off: (N, 2), its slope to the right and upward beyond the mean
    of all, over half the longer side.
    """

    light: FloatArray
    paper: BoolArray
    slow: FloatArray
    fall_off: FloatArray


def _evened(stack: ImageStack, mask: BoolArray, settings: UnknownLampSettings) -> _Even:
    """Divide photographs by what changes slowly: fall-off of lamps, vignetting, their strengths."""
    import cv2

    height, width = stack.shape[1:3]
    scale = max(1.0, max(height, width) / settings.side)
    size = (max(8, round(width / scale)), max(8, round(height / scale)))
    frames = np.stack([stack.reduced(k, size) for k in range(len(stack))]).astype(np.float64)
    frames = frames if frames.ndim == 3 else frames.mean(axis=3)
    frames = np.stack([cv2.GaussianBlur(one, (0, 0), settings.smooth) for one in frames])
    inside = cv2.resize(mask.astype(np.uint8), size, interpolation=cv2.INTER_AREA) > 0
    usable = inside & (frames.min(axis=0) > 2 * SHADOW_FLOOR) & (frames.max(axis=0) < SATURATION)
    usable = cv2.erode(usable.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
    if np.count_nonzero(usable) < settings.least:
        raise CaptureError(
            f"expected a sheet that all lamps light, got {np.count_nonzero(usable)} of {usable.size} cells "
            "that are neither dark nor overexposed in any photograph",
            zh="應有各燈都照到的紙面；這些照片裡太暗或過曝的地方太多。",
        )
    terms = _terms(usable.shape)
    light = np.log(np.maximum(frames, SHADOW_FLOOR))
    common = light.mean(axis=0)
    slow = np.stack([_fit_most(terms, one - common, usable, settings.paper) for one in light])
    level, paper = _paper_of(terms, common, usable, settings)
    slow = slow + level
    even = np.exp(light - np.einsum("nk,khw->nhw", slow, terms))
    fall_off = slow[:, 1:3] - slow[:, 1:3].mean(axis=0)
    return _Even(even, paper, slow, fall_off)


def _places(shape: tuple[int, ...]) -> tuple[FloatArray, FloatArray]:
    """X to the right and y upward of the cells of a picture, 1 at half its longer side."""
    rows, columns = np.indices(shape[:2])
    half = max(shape[:2]) / 2
    return (columns - (shape[1] - 1) / 2) / half, ((shape[0] - 1) / 2 - rows) / half


def _terms(shape: tuple[int, ...]) -> FloatArray:
    """(6, h, w): what changes slowly over the cells of a picture, up to the second degree."""
    return np.ascontiguousarray(np.moveaxis(quadratic_terms(*_places(shape)), -1, 0))


def _fit_most(terms: FloatArray, values: FloatArray, usable: BoolArray, near: float) -> FloatArray:
    """(6,): the slow part of values (h, w), by least squares that lets go of what is off."""
    design, wanted = terms[:, usable].T, values[usable]
    weights = np.ones(len(wanted))
    found: FloatArray = np.zeros(len(terms))
    for _ in range(8):
        found = np.linalg.lstsq(design * weights[:, None], wanted * weights, rcond=None)[0]
        weights = 1 / (1 + ((wanted - design @ found) / near) ** 2)
    return found


def _paper_of(
    terms: FloatArray, common: FloatArray, usable: BoolArray, settings: UnknownLampSettings
) -> tuple[FloatArray, BoolArray]:
    """The slow part (6,) of the brightness of paper, and where paper of one brightness is."""
    import cv2

    chosen = usable & (common >= np.quantile(common[usable], 1 - settings.brightest))
    level: FloatArray = np.zeros(len(terms))
    for _ in range(10):
        level = np.linalg.lstsq(terms[:, chosen].T, common[chosen], rcond=None)[0]
        off = common - np.einsum("k,khw->hw", level, terms)
        middle = float(np.median(off[chosen]))
        chosen = usable & (np.abs(off - middle) < settings.paper)
        if np.count_nonzero(chosen) < settings.least:
            break
    paper = cv2.erode(chosen.astype(np.uint8), np.ones((settings.beside,) * 2, np.uint8)) > 0
    if np.count_nonzero(paper) < settings.least:
        raise CaptureError(
            "expected paper of one brightness, which tells how steep relief is, got too little of it",
            zh="要有一片同樣白的紙，才能看出起伏有多陡；這裡太少。",
        )
    return level, paper


def _without_curl(seen: FloatArray, paper: BoolArray, settings: UnknownLampSettings) -> FloatArray:
    """(2, 2), of length 1: the linear map that makes slopes without curl of (2, h, w)."""
    down, across = np.gradient(seen, axis=1), np.gradient(seen, axis=2)
    conditions = np.stack([-down[0], -down[1], -across[0], -across[1]])[:, paper]
    values, vectors = np.linalg.eigh(conditions @ conditions.T)
    if values[0] > settings.curl**2 * values[1]:
        raise CaptureError(
            "expected relief that runs in more than one direction under lamps from several sides, got what "
            "does not tell where the lamps stood; give them by a file, a sphere or the card",
            zh="起伏與燈都要不只一個方向，才看得出燈在哪裡；請改用燈的檔案、亮球或拍攝卡。",
        )
    return np.asarray(vectors[:, 0].reshape(2, 2))


@dataclass(frozen=True, slots=True, eq=False)
class _Scale:
    """size: by which slopes are to be multiplied. lean: (2,), mean direction of the lamps, times size.

    unsure: standard error of the size, as a share of it.
    """

    size: float
    lean: FloatArray
    unsure: float


def _steepness(
    mean: FloatArray, slopes: FloatArray, paper: BoolArray, settings: UnknownLampSettings
) -> _Scale:
    """How steep slopes (2, h, w) are, by how paper darkens where it is steep under the mean of all lamps.

    Of paper, log mean = c - log(1 + lean . h) - log(1 + |size g|^2) / 2, with g = h / (1 + lean . h).
    """
    from scipy.optimize import least_squares

    spread = max(float(np.sqrt((slopes[:, paper] ** 2).sum(axis=0).mean())), 1e-12)

    def fit(part: BoolArray) -> FloatArray:
        h, wanted = slopes[:, part] / spread, np.log(mean[part])

        def off(x: FloatArray) -> FloatArray:
            turned = np.maximum(1 + x[2] * h[0] + x[3] * h[1], 0.2)
            steep = 0.5 * np.log1p(np.maximum(x[1], -0.5) * (h**2).sum(axis=0) / turned**2)
            return np.asarray(wanted - x[0] + np.log(turned) + steep) / settings.even

        return np.asarray(least_squares(off, [0.0, 0.03, 0.0, 0.0], loss="soft_l1", max_nfev=80).x)

    whole = fit(paper)
    strips = np.array_split(np.arange(len(paper)), settings.parts)
    found = []
    for rows in strips:
        part = np.zeros_like(paper)
        part[rows] = paper[rows]
        if np.count_nonzero(part) > settings.least / settings.parts:
            found.append(float(fit(part)[1]))
    squared = float(whole[1])
    error = float(np.std(found, ddof=1) / np.sqrt(len(found))) if len(found) > 2 else np.inf
    unsure = 0.5 * error / max(squared, 1e-12)  # of its root
    if squared <= 0 or unsure > settings.steep:
        raise CaptureError(
            "the relief is too shallow, or the paper too uneven in its white, to tell how steep it is: paper "
            "should be darker where it is steep; give the lamps by a file, a sphere or the card",
            zh="起伏太淺，或紙的白不均勻，看不出有多陡（陡處的紙應較暗）；請改用燈的檔案、亮球或拍攝卡。",
        )
    return _Scale(float(np.sqrt(squared)) / spread, whole[2:4] / spread, unsure)


def _sign(lamps: FloatArray, fall_off: FloatArray, settings: UnknownLampSettings) -> tuple[Sign, float]:
    """What tells ridges from hollows, and whether lamps (N, 2) are right (1) or the other way round (-1).

    Flat paper is brighter toward a lamp that is near. Of lamps far away, most are taken to stand above, as
    people read shaded pictures; where as many stand below, the first is.
    """
    apart = lamps - lamps.mean(axis=0)
    sizes = float(np.linalg.norm(apart) * np.linalg.norm(fall_off))
    agree = float((apart * fall_off).sum()) / max(sizes, 1e-12)
    near = float(np.sqrt((fall_off**2).sum(axis=1).mean()))
    if near > settings.falls and abs(agree) > settings.agree:
        return "fall-off", float(np.sign(agree))
    above = float(lamps[:, 1].sum())
    even = abs(above) < 0.1 * float(np.abs(lamps[:, 1]).sum())
    return "rule", float(np.sign(lamps[0] @ (0.01, 1.0) if even else above) or 1.0)


def _capture(
    stack: ImageStack, mask: BoolArray, names: tuple[str, ...], lamps: FloatArray, even: _Even
) -> Capture:
    """The photographs, even, under lamps (N, 2) that are told by their slopes."""
    toward = np.column_stack([lamps, np.ones(len(lamps))])
    lengths = np.linalg.norm(toward, axis=1)
    shape = stack.shape[1], stack.shape[2]
    scale = max(shape) / _CELLS
    cells = tuple(max(2, round(side / scale)) for side in shape)
    grids = np.exp(-np.einsum("nk,khw->nhw", even.slow, _terms(cells)))
    return Capture(
        images=stack.times(smooth_gains(list(grids), shape)),  # type: ignore[arg-type]
        lights=toward / lengths[:, None],
        mask=mask,
        strengths=lengths / lengths.mean(),
        names=names,
        lamps_as_given=True,
    )


def _note(unsure: float, sign: Sign) -> Bilingual:
    """What a person should know of lamps that photographs told."""
    told = {
        "fall-off": Bilingual(
            "凸凹由燈近處較亮得知",
            "ridges are told from hollows by the light, which is stronger near the lamp",
        ),
        "rule": Bilingual(
            "凸凹無從得知，按燈多在上方來取；若正好相反，請加 --inside-out",
            "ridges cannot be told from hollows: most lamps are taken to stand above; if all is inside out, "
            "add --inside-out",
        ),
        "asked": Bilingual("凸凹按 --inside-out 取相反的一種", "the other reading of ridges was asked for"),
    }[sign]
    return Bilingual(
        "沒有燈的資料：方向由照片本身推得，以紙面平整、紙色均勻為準；"
        f"陡度約準到 {100 * unsure:.0f}%（標準誤差）；{told.zh}。",
        "no lamps were given: their directions come from the photographs alone, for a sheet that is flat on "
        f"the whole and paper of one white; how steep all is, to about {100 * unsure:.0f}% (standard "
        f"error); {told.en}",
    )
