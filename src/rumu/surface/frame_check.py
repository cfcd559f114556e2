"""Whether the photographs of a capture can be used: lit, not overexposed, of a sheet that stayed."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from rumu.errors import CaptureError
from rumu.image_stack import SATURATION, pixels_of
from rumu.surface.stereo import SHADOW_FLOOR, enough_lit
from rumu.values import Bilingual, BoolArray, Capture, FloatArray, Surface

Item = TypeVar("Item")
Answer = TypeVar("Answer")
_BRIGHT_STEP = 4  # every so many of the pixels that are looked at tell how bright a frame gets
_SMALL = 64  # pixels of the shorter side of frames that are not halved first
_THREADS = 4  # that reduce photographs, each with a whole one in its bits


@dataclass(frozen=True, slots=True)
class FrameCheckSettings:
    """When a photograph cannot be used.

    black: share of the brightness of the brightest frame, below which nearly all of a black frame stays, or
        below the floor of shadow. white: share of the pixels that are saturated in an overexposed frame.
        usable: least share of the pixels that three frames show neither dark nor saturated. bright: quantile
        of the pixels that tells how bright a frame gets. pixels: about how many are looked at.
    spread: times by which the brightest frame exceeds the darkest, when it is noted.
    side: pixels, of the reduced frames that are laid on each other. detail: pixels, of the largest detail
        that is compared. still: correlation above which a frame did not move. least_shift: pixels by which a
        frame must be off. agreement: correlation that it must reach when it is laid right. miss: to which
        share what is missing from full correlation must fall then. rounds: of laying frames on the others.
        trial: about how many frames are looked at first, of more than twice as many, where all may have
        moved.
    """

    black: float = 0.02
    white: float = 0.9
    usable: float = 0.01
    bright: float = 0.995
    spread: float = 1.6
    side: int = 384
    detail: int = 31
    still: float = 0.97
    least_shift: float = 0.75
    agreement: float = 0.9
    miss: float = 0.4
    rounds: int = 3
    trial: int = 10
    pixels: int = 20_000


def check_exposure(capture: Capture, *, settings: FrameCheckSettings | None = None) -> None:
    """Raise CaptureError, with the names of the frames, when they are black or overexposed."""
    settings = settings or FrameCheckSettings()
    frames = _few_pixels(capture, settings)
    names = _names(capture)
    bright = np.quantile(frames[:, ::_BRIGHT_STEP], settings.bright, axis=1)
    white = (frames >= SATURATION).mean(axis=1)
    dark = bright <= max(SHADOW_FLOOR, settings.black * float(bright.max()))
    if dark.any():
        which = _listed(names, dark)
        raise CaptureError(
            f"{which.en}: black, no lamp lit the sheet (lens cap, or the lamp was off); take the photograph "
            "again, or leave it out (--leave-out)",
            zh=f"{which.zh}：全黑，燈沒有照到紙（鏡頭蓋沒拿下，或燈沒開）；請重拍，或除去這一張（--leave-out）。",
        )
    usable = enough_lit(frames[:, None]).mean()
    if (white < settings.white).all() and not ((frames > SHADOW_FLOOR) & (frames < SATURATION)).any():
        raise CaptureError(
            "expected photographs with shades between black and white, got black and white alone, as of "
            "1 bit: how bright a place is tells its slope; take files as the camera wrote them",
            zh="照片只有全黑與全白（1 位元），沒有深淺；斜率要由明暗算出，請用相機原來的檔案。",
        )
    if (white >= settings.white).any() or (usable < settings.usable and white.max() > 0.5):
        over = white >= min(settings.white, float(white.max()))
        which, share = _listed(names, over), 100 * white[over].min()
        raise CaptureError(
            f"{which.en}: overexposed, {'' if share >= 99.5 else 'at least '}{share:.0f}% of the pixels are "
            "white; take the photographs again with a shorter exposure, or leave them out (--leave-out)",
            zh=f"{which.zh}：曝光過度，{'' if share >= 99.5 else '至少 '}{share:.0f}% 的像素全白；"
            "請縮短曝光重拍，或除去這幾張（--leave-out）。",
        )
    if usable < settings.usable:
        raise CaptureError(
            "the photographs are too dark: hardly a pixel is lit in three of them; take them again with a "
            "longer exposure or stronger lamps",
            zh="照片太暗：幾乎沒有一處在三張照片裡都照亮；請延長曝光，或用更亮的燈重拍。",
        )


def exposure_notes(
    capture: Capture, surface: Surface, *, settings: FrameCheckSettings | None = None
) -> tuple[Bilingual, ...]:
    """What a person should know of photographs that are not equally bright; empty when they are.

    surface: of the capture. Lamps of known strengths are left out.
    """
    spread = surface.quality.get("strength_spread", 1.0)
    if capture.strengths is not None or spread < (settings or FrameCheckSettings()).spread:
        return ()
    return (
        Bilingual(
            f"照片的亮度相差到 {spread:.2g} 倍，不是燈的強弱不同，就是曝光不同；已經扣除。"
            "請用手動曝光，並固定光圈、快門與感光度。",
            f"the photographs differ in brightness by up to {spread:.2g} times, by their lamps or their "
            "exposure; this was taken out. Fix aperture, shutter and ISO, and use no automatic exposure",
        ),
    )


def check_still(capture: Capture, *, settings: FrameCheckSettings | None = None) -> None:
    """Raise CaptureError when sheet or camera moved between four or more photographs.

    Each frame is laid on what the other frames say it should look like under its lamp: that differs from it
    by nothing but a shift if it moved, whatever the relief.
    """
    import cv2

    settings = settings or FrameCheckSettings()
    if len(capture.lights) < 4:
        return
    frames, scale = _reduced(capture, settings)
    doubtful = _beside_at_half_size(frames, capture.lights, settings)
    if not doubtful:
        return
    others, window = _Others(frames, capture.lights), _window(frames)

    def compared(number: int) -> tuple[float, bool]:
        here, there = _details(frames[number], settings), _details(others.frame(number), settings)
        alike = _correlation(here, there, window)
        if alike > settings.still:
            return 0.0, False
        offset, _ = cv2.phaseCorrelate(there, here, window)
        off = float(np.hypot(*offset))
        if off < settings.least_shift:
            return off, False
        return off, _is_clear(here, there, window, off_by=offset, before=alike, settings=settings)

    found = _in_threads(compared, doubtful)
    if all(off < settings.least_shift for off, _ in found):
        return  # whatever differs, as cast shadows do, nothing lies beside where it should
    moved = [(i, off * scale) for i, (off, clear) in zip(doubtful, found, strict=True) if clear]
    if not moved:
        details = _in_threads(lambda frame: _details(frame, settings), frames)
        before = _likenesses(frames, details, capture.lights, settings)
        moved = [
            (i, far * scale)
            for i, far in _all_moved(frames, details, capture.lights, settings, before=before)
        ]
    if not moved:
        return
    names = _names(capture)
    which = _listed([names[i] for i, _ in moved], np.ones(len(moved), bool))
    far = max(distance for _, distance in moved)
    raise CaptureError(
        f"{which.en}: moved against the other photographs, by about {far:.0f} pixels; camera and sheet "
        "must stay where they are. Take the photographs again, lay them on each other first (--align), or "
        "leave out those that cannot be laid (--leave-out)",
        zh=f"{which.zh}：與其他照片錯開了約 {far:.0f} 像素；拍攝時相機與紙都不能動，請重拍，"
        "或先把照片對齊（--align），或除去對不齊的（--leave-out）。",
    )


class _Others:
    """What all other frames say of each, by Lambert's law; numbers: of those of which they tell."""

    def __init__(self, frames: FloatArray, lights: FloatArray) -> None:
        inverse = np.linalg.pinv(lights)
        self._frames, self._lights = frames, lights.astype(np.float32)
        self._scaled = inverse.astype(np.float32) @ frames.reshape(len(frames), -1)
        self._own = np.einsum("nk,kn->n", lights, inverse).astype(np.float32)
        self.numbers = [int(i) for i in np.flatnonzero(self._own < 0.95)]  # else none stands on its side

    def frame(self, number: int) -> FloatArray:
        """(h, w) float32, the frame that the others make."""
        own = self._own[number]
        wanted = self._lights[number] @ self._scaled
        wanted -= own * self._frames[number].reshape(-1)
        wanted /= 1 - own
        np.maximum(wanted, 0, out=wanted)
        return np.asarray(wanted.reshape(self._frames.shape[1:]))


def _likenesses(
    frames: FloatArray, details: Sequence[FloatArray], lights: FloatArray, settings: FrameCheckSettings
) -> FloatArray:
    """Correlations of the details of frames with those that the others say they should have."""
    others, window = _Others(frames, lights), _window(frames)
    return np.array(
        [_correlation(details[i], _details(others.frame(i), settings), window) for i in others.numbers]
    )


def shift_between(
    frame: FloatArray,
    wanted: FloatArray,
    *,
    within: BoolArray | None = None,
    settings: FrameCheckSettings | None = None,
) -> float:
    """By how many pixels a frame (h, w) lies beside what it should look like, see `displacement`."""
    return float(np.hypot(*displacement(frame, wanted, within=within, settings=settings)))


def displacement(
    frame: FloatArray,
    wanted: FloatArray,
    *,
    within: BoolArray | None = None,
    settings: FrameCheckSettings | None = None,
) -> tuple[float, float]:
    """By how many pixels, x and y, a frame (h, w) lies beside what it should look like, by phase correlation.

    within: (h, w), of which alone it is known what it should look like; None for all.
    """
    import cv2

    here, there = (
        _details(np.ascontiguousarray(one), settings or FrameCheckSettings()) for one in (frame, wanted)
    )
    window = _window(here[None])
    if within is not None and not within.all():  # fading out, so that its edge is no detail of both
        window *= cv2.GaussianBlur(within.astype(np.float32), (0, 0), 4.0) * within
    (dx, dy), _ = cv2.phaseCorrelate(there, here, window)
    return float(dx), float(dy)


def _window(frames: FloatArray) -> FloatArray:
    import cv2

    return np.asarray(cv2.createHanningWindow(frames.shape[:0:-1], cv2.CV_32F))


def _all_moved(
    frames: FloatArray,
    details: Sequence[FloatArray],
    lights: FloatArray,
    settings: FrameCheckSettings,
    *,
    before: FloatArray,
) -> list[tuple[int, float]]:
    """Numbers of the frames that moved, and by how much, when so many did that none is like the others say.

    Edges of ink and relief, which all frames show, lay them on each other, and then Lambert's law does so
    more closely. It is clear when the frames are as the others say afterwards, and were not before, which is
    told by their correlations `before`. Of many frames a few are looked at first, which moved as well where
    so many did. details: of each frame.
    """
    import cv2

    def laid(shifts: FloatArray) -> FloatArray:
        size = frames.shape[:0:-1]
        moves = [np.array([[1.0, 0, -dx], [0, 1, -dy]]) for dx, dy in shifts]
        return np.stack(
            [
                cv2.warpAffine(f, m, size, borderMode=cv2.BORDER_REFLECT)
                for f, m in zip(frames, moves, strict=True)
            ]
        )

    if len(before) < 4 or np.median(before) > settings.still:
        return []
    if len(frames) > 2 * settings.trial:
        few = slice(None, None, len(frames) // settings.trial)
        some = frames[few], details[few], lights[few]
        if not _all_moved(*some, settings, before=_likenesses(*some, settings)):
            return []
    window = _window(frames)
    edges = [_edges(frame) for frame in frames]
    shifts = np.array([cv2.phaseCorrelate(edges[0], one, window)[0] for one in edges])
    for _ in range(settings.rounds):
        others = _Others(laid(shifts), lights)
        for i in others.numbers:
            shifts[i] = cv2.phaseCorrelate(_details(others.frame(i), settings), details[i], window)[0]
        sizes = np.hypot(*(shifts - np.median(shifts, axis=0)).T)
        if sizes.max() < settings.least_shift:
            return []
    shifts -= np.median(shifts, axis=0)
    if not settings.least_shift <= sizes.max() < 0.2 * max(frames.shape[1:]):
        return []
    back = laid(shifts)
    details = [_details(frame, settings) for frame in back]
    after = float(np.median(_likenesses(back, details, lights, settings)))
    miss = (1.0 - after) / (1.0 - float(np.median(before)))
    if after < settings.agreement or miss > settings.miss:
        return []
    return [(i, float(size)) for i, size in enumerate(sizes) if size >= settings.least_shift]


def _details(frame: FloatArray, settings: FrameCheckSettings) -> FloatArray:
    """(h, w) float32 logarithm of a frame, less what is smooth."""
    import cv2

    log = cv2.log(frame + np.float32(0.02))
    return np.asarray(log - cv2.blur(log, (settings.detail, settings.detail)))


def _edges(frame: FloatArray) -> FloatArray:
    """(h, w) float32: how strongly the logarithm of a frame changes, whichever way."""
    import cv2

    log = cv2.GaussianBlur(cv2.log(frame + np.float32(0.02)), (0, 0), 1.0)
    return np.asarray(cv2.magnitude(cv2.Sobel(log, cv2.CV_32F, 1, 0), cv2.Sobel(log, cv2.CV_32F, 0, 1)))


def _beside_at_half_size(frames: FloatArray, lights: FloatArray, settings: FrameCheckSettings) -> list[int]:
    """Numbers of the frames that, at half their size, lie clearly beside what the others say.

    At a quarter of the work this tells of most frames that they stood. Small ones are all named.
    """
    import cv2

    if min(frames.shape[1:]) < _SMALL:
        return _Others(frames, lights).numbers
    halves = np.stack([cv2.resize(one, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA) for one in frames])
    others, window = _Others(halves, lights), _window(halves)
    finer = replace(settings, detail=settings.detail // 2 | 1)

    def is_beside(number: int) -> bool:
        here, there = _details(halves[number], finer), _details(others.frame(number), finer)
        offset, _ = cv2.phaseCorrelate(there, here, window)
        return bool(np.hypot(*offset) >= settings.least_shift / 4)

    return [number for number in others.numbers if is_beside(number)]


def _is_clear(
    here: FloatArray,
    there: FloatArray,
    window: FloatArray,
    *,
    off_by: tuple[float, float],
    before: float,
    settings: FrameCheckSettings,
) -> bool:
    """Whether the details of a frame, moved back by its offset, become far more alike."""
    import cv2

    dx, dy = off_by
    if np.hypot(dx, dy) >= 0.2 * max(here.shape):
        return False
    back = cv2.warpAffine(
        here, np.array([[1.0, 0, -dx], [0, 1, -dy]]), here.shape[::-1], borderMode=cv2.BORDER_REFLECT
    )
    after = _correlation(back, there, window)
    return after >= settings.agreement and 1.0 - after <= settings.miss * (1.0 - before)


def _correlation(a: FloatArray, b: FloatArray, weights: FloatArray) -> float:
    a, b = (a * weights).ravel(), (b * weights).ravel()
    return float(np.dot(a, b)) / max(float(np.sqrt(np.dot(a, a)) * np.sqrt(np.dot(b, b))), 1e-12)


def _in_threads(work: Callable[[Item], Answer], items: Iterable[Item], *, most: int = 64) -> list[Answer]:
    """What `work`, which must let others run, makes of each item; most: threads, if so many cores."""
    with ThreadPoolExecutor(min(most, os.cpu_count() or 1)) as pool:
        return list(pool.map(work, items))


def _reduced(capture: Capture, settings: FrameCheckSettings) -> tuple[FloatArray, float]:
    """(N, h, w) float32 gray frames of `side` pixels at most, and by what they shrank."""
    h, w = capture.mask.shape
    scale = max(1.0, max(h, w) / settings.side)
    size = (max(1, round(w / scale)), max(1, round(h / scale)))

    def reduced(number: int) -> FloatArray:
        small = capture.photographs.reduced(number, size)
        return small if small.ndim == 2 else np.asarray(small.mean(axis=2))

    return np.stack(_in_threads(reduced, range(len(capture.photographs)), most=_THREADS)), scale


def _few_pixels(capture: Capture, settings: FrameCheckSettings) -> FloatArray:
    """(N, P) gray values of some of the pixels in the mask."""
    values = capture.photographs.at(pixels_of(capture.mask, about=settings.pixels))
    return values if values.ndim == 2 else np.asarray(values.mean(axis=2))


def _names(capture: Capture) -> Sequence[str]:
    return capture.names or tuple(f"photograph {i + 1}" for i in range(len(capture.lights)))


def _listed(names: Sequence[str], chosen: BoolArray) -> Bilingual:
    """Names of the chosen frames, not more than six of them."""
    some = [name for name, is_chosen in zip(names, chosen, strict=True) if is_chosen]
    more = len(some) - 6
    en, zh = ", ".join(some[:6]), "、".join(some[:6])
    return Bilingual(f"{zh} 等 {len(some)} 張", f"{en} and {more} more") if more > 0 else Bilingual(zh, en)
