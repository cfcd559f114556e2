"""A folder of photographs of the card, each under one lamp, as a Capture of what lies in its window.

The recipe: find the card in every photograph, lay the window flat, look at white, grays and ball, fit the
lamps, and take the lens and the fall-off of the light out.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np

from rumu.capture.description import description_of, encoding_of
from rumu.capture.dome import without_fall_off
from rumu.capture.exif import read_facts
from rumu.capture.formats import Encoding, read_header
from rumu.capture.frames import kept, read_named
from rumu.capture.memory_plan import plan_memory
from rumu.capture.photographs import capture_error
from rumu.capture.stored import to_srgb
from rumu.capture.unlit import find_photographs
from rumu.card.ball import FoundBall, find_ball
from rumu.card.finding import CardView, find_card
from rumu.card.light_fit import LightFit, fit_light
from rumu.card.samples import CardPlaces, CardSamples, card_places, sample_card
from rumu.card.window import FlatWindow
from rumu.image_stack import ImageStack, Photograph, Progress
from rumu.values import Bilingual, Capture, FloatArray

_SHOWN = Bilingual("拍攝卡", "of the capture card")


@dataclass(frozen=True, slots=True)
class CardCaptureLimits:
    """When photographs of a card are refused or noted.

    inset: millimetres inside the window's line, that are left out. burnt: share of the white that may be
    burnt out. unsure: degrees, standard deviation of a lamp's direction, from which it is no direction.
    apart: degrees between the two lamps farthest apart, at least. spread: least of the three singular values
    of the directions over the root of their number. ball_off: degrees between ball and white, from which it
    is noted. room: share of the light from all sides, from which it is noted.
    """

    inset: float = 1.5
    burnt: float = 0.03
    unsure: float = 4.5
    apart: float = 20.0
    spread: float = 0.1
    ball_off: float = 4.0
    room: float = 0.06


@dataclass(frozen=True, slots=True, eq=False)
class CardLamp:
    """The lamp of one photograph. position: (3,) millimetres from the middle of the window, x right, y up.

    unsure: degrees, standard deviation of its direction from there. ball_off: degrees between what the ball
    says and what was found of both; None without.
    """

    name: str
    position: tuple[float, float, float]
    unsure: float
    ball_off: float | None


@dataclass(frozen=True, slots=True, eq=False)
class CardCapture:
    """A capture that a card made.

    lamps: where they stood, and how sure that is. pixel_mm: side of a pixel. off: millimetres by which the
    markers lie beside their places, the most of all photographs. ball: its radius in millimetres; None
    without one. curve: how the photographs differ from sRGB, see `rumu.card.light_fit`. residual: median
    share by which the card's white contradicts the lamps. flat: its photographs with the fall-off that is
    taken out of those of the capture.
    """

    capture: Capture
    flat: ImageStack
    lamps: tuple[CardLamp, ...]
    pixel_mm: float
    off: float
    ball: float | None
    curve: tuple[float, float]
    residual: float


def read_card_capture(
    path: str | os.PathLike[str],
    *,
    leave_out: Collection[str] = (),
    encoding: Encoding = "auto",
    limits: CardCaptureLimits | None = None,
    progress: Progress | None = None,
) -> CardCapture:
    """Read a folder of photographs of the card.

    Parameters
    ----------
    path : path
        The folder. Three or more photographs of the whole card with the writing in its window, each with the
        lamp in another place, in a dark room. The camera may move a little, and be turned in any way. A lamp
        file or mask in the folder is not looked at; "encoding" of its capture.json is.
    leave_out : collection of str, optional
        Names of photographs that are not used, with or without their suffix.
    encoding : {'auto', 'linear', 'srgb'}
        How the samples are read, as of `rumu.read_capture`.
    limits : CardCaptureLimits, optional
        When photographs are refused or noted.
    progress : callable, optional
        Called with what is done, how many parts of it are done and how many there are.

    Returns
    -------
    CardCapture
        Its capture shows the window, flat, in millimetres; its lamps count as near, and their fall-off is
        taken out.

    Raises
    ------
    CaptureError, ImageError
        Naming the photograph without the card, or in which it is cut off, blurred, dark, burnt out or not
        flat; where lamps did not move, or are too far for the card's white to tell and there is no ball.
    """
    limits = limits or CardCaptureLimits()
    folder = Path(path)
    _, paths = find_photographs(folder, show=_SHOWN, leave_out=leave_out)
    encoding = encoding_of(folder, description_of(folder), told=encoding)
    frames, views, samples, places = _look_at(paths, encoding, limits, progress)
    if progress is not None:
        progress("Finding the lamps", 0, 1)
    ball = find_ball(frames, views)
    light = fit_light(samples, places, ball=None if ball is None else ball.light)
    middle = _window_middle(views[0])
    towards = light.positions - middle
    lights = towards / np.linalg.norm(towards, axis=1)[:, None]
    _check_lamps(paths, lights, light, ball, limits)
    scale = float(np.median([view.scale() for view in views]))
    window = FlatWindow(views[0], scale, limits.inset)
    stack = window.stack(frames, views, light, progress)
    positions = towards * scale
    names = tuple(one.name for one in paths)
    capture = Capture(
        images=without_fall_off(stack, positions),  # type: ignore[arg-type]
        lights=lights,
        mask=np.ones(stack.shape[1:3], bool),
        strengths=light.powers / light.powers.mean(),
        spacing=1 / scale,
        names=names,
        notes=tuple(
            _notes(
                names,
                towards,
                light,
                has_ball=ball is not None,
                knows_focal=all(view.focal_is_known for view in views),
                limits=limits,
            )
        ),
        positions=positions,
    )
    lamps = tuple(
        CardLamp(name, tuple(map(float, place)), float(unsure), None if ball is None else float(off))  # type: ignore[arg-type]
        for name, place, unsure, off in zip(names, towards, light.unsure, light.ball_off, strict=True)
    )
    return CardCapture(
        capture,
        stack,
        lamps,
        1 / scale,
        max(view.off for view in views),
        None if ball is None else ball.radius,
        (float(light.curve[0]), float(light.curve[1])),
        light.residual,
    )


def _look_at(
    paths: Sequence[Path], encoding: Encoding, limits: CardCaptureLimits, progress: Progress | None
) -> tuple[list[Photograph], list[CardView], list[CardSamples], CardPlaces]:
    """The photographs, where the card lies in each, and what its white and grays show at which places."""
    plan = plan_memory([read_header(one) for one in paths], paths[0].parent)
    frames: list[Photograph] = []
    views: list[CardView] = []
    samples: list[CardSamples] = []
    places = None
    for number, one in enumerate(paths):
        if progress is not None:
            progress("Looking for the card", number, len(paths))
        frame, _ = read_named(one, encoding=encoding, upright=False)
        view = find_card(_shown(frame), one, focal_35_mm=read_facts(one).focal_35_mm)
        if views and view.layout != views[0].layout:
            raise capture_error(
                one,
                en=f"expected the {views[0].layout.paper} card of {paths[0].name}, got {view.layout.paper}",
                zh=f"應與 {paths[0].name} 一樣是 {views[0].layout.paper} 的拍攝卡，卻是 {view.layout.paper}",
            )
        places = places or card_places(view.layout)
        seen = sample_card(frame, view, places)
        if seen.burnt > limits.burnt:
            raise capture_error(
                one,
                en=f"burnt out: {100 * seen.burnt:.0f}% of the card's white says nothing; expose shorter",
                zh=f"過曝：卡上的白紙有 {100 * seen.burnt:.0f}% 全白；請縮短曝光",
            )
        frames.append(kept(frame, on_disk=plan.on_disk))
        views.append(view)
        samples.append(seen)
    assert places is not None
    return frames, views, samples, places


def _shown(photograph: Photograph) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """(H, W, 3) uint8 of a photograph, as a screen shows it."""
    samples = photograph.samples
    assert isinstance(samples, np.ndarray)
    if photograph.curve is None or samples.dtype != np.uint8:
        samples = np.round(255 * to_srgb(np.clip(photograph.light(), 0, 1))).astype(np.uint8)
    return np.ascontiguousarray(np.dstack([samples] * 3) if samples.ndim == 2 else samples)


def _window_middle(view: CardView) -> FloatArray:
    """(3,) millimetres from the card's middle to that of the window, y up."""
    (width, height), window = view.layout.size, view.layout.window
    x, y = window.left + window.width / 2 - width / 2, height / 2 - window.top - window.height / 2
    return np.array([x, y, 0.0])


def _check_lamps(
    paths: Sequence[Path],
    lights: FloatArray,
    light: LightFit,
    ball: FoundBall | None,
    limits: CardCaptureLimits,
) -> None:
    """Raise CaptureError where the lamps, in unit directions (N, 3), are unknown, or all in one place."""
    apart = max(float(np.degrees(np.arccos(np.clip(a @ b, -1, 1)))) for a, b in combinations(lights, 2))
    if apart < limits.apart:
        raise capture_error(
            paths[0].parent,
            en=f"the lamp hardly moved: its places are {apart:.0f} degrees apart at most, expected "
            f"{limits.apart:g} or more; move the lamp round the card, not the card or the camera",
            zh=f"燈幾乎沒動：各處最多相差 {apart:.0f} 度，至少要 {limits.apart:g} 度；"
            "請把燈繞著卡片移動，卡片與相機不動",
        )
    if np.linalg.svd(lights, compute_uv=False)[-1] / np.sqrt(len(lights)) < limits.spread:
        raise capture_error(
            paths[0].parent,
            en="expected lamps from at least three sides, got them nearly in one plane; move the lamp round",
            zh="燈至少要在三個方向，這裡幾乎都在同一平面上；請把燈繞著卡片移動",
        )
    worst = int(np.argmax(light.unsure))
    if light.unsure[worst] > limits.unsure and not _is_shown(ball, worst):
        raise capture_error(
            paths[worst],
            en=f"the card's white tells its lamp to {light.unsure[worst]:.0f} degrees only, expected "
            f"{limits.unsure:g}; bring the lamp nearer, or lay a shiny ball in the ring, where it shows the "
            "lamp",
            zh=f"卡上的白紙只能看出燈的方向到 {light.unsure[worst]:.0f} 度，應在 {limits.unsure:g} 度以內；"
            "請把燈移近，或在圓圈裡放一個看得到燈的亮球",
        )


def _is_shown(ball: FoundBall | None, number: int) -> bool:
    return ball is not None and bool(np.isfinite(ball.light.lights[number]).all())


def _notes(
    names: Sequence[str],
    towards: FloatArray,
    light: LightFit,
    *,
    has_ball: bool,
    knows_focal: bool,
    limits: CardCaptureLimits,
) -> list[Bilingual]:
    """What a person should know of a card's photographs."""
    worst, far = float(light.unsure.max()), np.linalg.norm(towards, axis=1)
    by = Bilingual("亮球與卡上的白紙", "the ball and the card's white")
    by = by if has_ball else Bilingual("卡上的白紙", "the card's white")
    notes = [
        Bilingual(
            f"燈的位置取自{by.zh}：離窗口中心 {far.min():.0f} 到 {far.max():.0f} 毫米，"
            f"方向約準到 {worst:.1f} 度（標準差，最差的一張）。",
            f"the lamps were told by {by.en}: {far.min():.0f} to {far.max():.0f} mm from the window's "
            f"middle, directions to about {worst:.1f} degrees (standard deviation, of the worst)",
        ),
        Bilingual(
            "尺寸以卡上印的為準：請用尺量，線長應是 100 毫米。",
            "sizes are those printed on the card: measure that its line is 100 mm long",
        ),
    ]
    off = light.ball_off
    for name, apart in zip(names, off, strict=True):
        if np.isfinite(apart) and apart > limits.ball_off:
            notes.append(
                Bilingual(
                    f"{name}：亮球與白紙所說的燈差 {apart:.1f} 度；球不圓、反光的是別的燈，或房間不暗。",
                    f"{name}: ball and white tell lamps {apart:.1f} degrees apart; the ball is not round, "
                    "shows another lamp, or the room was not dark",
                )
            )
    if has_ball and not knows_focal:
        notes.append(
            Bilingual(
                "照片沒有焦距（EXIF），以 26 毫米計；請用未經壓縮軟體處理的原檔。",
                "the photographs tell no focal length (EXIF), 26 mm was taken; original files tell it",
            )
        )
    if light.room > limits.room:
        notes.append(
            Bilingual(
                f"約有 {100 * light.room:.0f}% 的光來自四周；關燈、拉上窗簾，起伏才不會偏小。",
                f"about {100 * light.room:.0f}% of the light comes from all sides, which makes relief look "
                "flatter; darken the room",
            )
        )
    return notes
