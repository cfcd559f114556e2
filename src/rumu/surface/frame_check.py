"""Whether the photographs of a capture can be used: lit, not overexposed, of a sheet that stayed."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from rumu.errors import CaptureError
from rumu.image_stack import SATURATION, pixels_of
from rumu.surface.stereo import SHADOW_FLOOR, enough_lit
from rumu.values import Bilingual, BoolArray, Capture, FloatArray, Surface

Item = TypeVar("Item")
Answer = TypeVar("Answer")
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
    bright = np.quantile(frames, settings.bright, axis=1)
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
    settings = settings or FrameCheckSettings()
    if len(capture.lights) < 4:
        return
    frames, scale = _reduced(capture, settings)
    details = _in_threads(lambda frame: _details(frame, settings), frames)
    laid = _laid_on_the_others(frames, details, capture.lights, settings)
    shifts = _in_threads(lambda one: _shift_of(*one[1:], settings), laid)
    far_off = [(one[0], shift) for one, shift in zip(laid, shifts, strict=True)]
    moved = [(i, shift * scale) for i, shift in far_off if shift >= settings.least_shift]
    if not moved:
        likenesses = np.array([likeness for *_, likeness in laid])
        del laid
        all_moved = _all_moved(frames, details, capture.lights, settings, before=likenesses)
        moved = [(i, far * scale) for i, far in all_moved]
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


def _from_the_others(frames: FloatArray, lights: FloatArray) -> Iterator[tuple[int, FloatArray]]:
    """Each frame's number, and the frame (h, w) that Lambert's law makes of all others."""
    hat = lights @ np.linalg.pinv(lights)
    own = np.diag(hat)
    seen = np.flatnonzero(own < 0.95)  # else no others stand on its side
    others = (hat - np.diag(own))[seen] / (1.0 - own[seen, None])
    fitted = others.astype(np.float32) @ frames.reshape(len(frames), -1)
    for i, wanted in zip(seen, fitted, strict=True):
        yield int(i), np.maximum(wanted, np.float32(0)).reshape(frames.shape[1:])


def _laid_on_the_others(
    frames: FloatArray, details: Sequence[FloatArray], lights: FloatArray, settings: FrameCheckSettings
) -> list[tuple[int, FloatArray, FloatArray, float]]:
    """Each frame's number, its details, those that the others say it should have, and their correlation."""
    window = _window(frames)

    def laid(one: tuple[int, FloatArray]) -> tuple[int, FloatArray, FloatArray, float]:
        number, wanted = one
        there = _details(wanted, settings)
        return number, details[number], there, _correlation(details[number], there, window)

    return _in_threads(laid, list(_from_the_others(frames, lights)))


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
        likenesses = np.array([one for *_, one in _laid_on_the_others(*some, settings)])
        if not _all_moved(*some, settings, before=likenesses):
            return []
    window = _window(frames)
    edges = [_edges(frame) for frame in frames]
    shifts = np.array([cv2.phaseCorrelate(edges[0], one, window)[0] for one in edges])
    for _ in range(settings.rounds):
        for i, wanted in _from_the_others(laid(shifts), lights):
            shifts[i] = cv2.phaseCorrelate(_details(wanted, settings), details[i], window)[0]
        sizes = np.hypot(*(shifts - np.median(shifts, axis=0)).T)
        if sizes.max() < settings.least_shift:
            return []
    shifts -= np.median(shifts, axis=0)
    if not settings.least_shift <= sizes.max() < 0.2 * max(frames.shape[1:]):
        return []
    back = laid(shifts)
    details = [_details(frame, settings) for frame in back]
    after = float(np.median([one for *_, one in _laid_on_the_others(back, details, lights, settings)]))
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


def _shift_of(here: FloatArray, there: FloatArray, before: float, settings: FrameCheckSettings) -> float:
    """By how many pixels the details of a frame are off, 0 where it is not clear; before: correlation."""
    import cv2

    if before > settings.still:
        return 0.0
    window = _window(here[None])
    (dx, dy), _ = cv2.phaseCorrelate(there, here, window)
    size = float(np.hypot(dx, dy))
    if not settings.least_shift <= size < 0.2 * max(here.shape):
        return 0.0
    back = cv2.warpAffine(
        here, np.array([[1.0, 0, -dx], [0, 1, -dy]]), here.shape[::-1], borderMode=cv2.BORDER_REFLECT
    )
    after = _correlation(back, there, window)
    clear = after >= settings.agreement and 1.0 - after <= settings.miss * (1.0 - before)
    return size if clear else 0.0


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
