"""Why a copy is not marked: a code, and a sentence in Chinese and English.

The limits were found on half of the characters and held on the other half; `python benchmarks/refusal.py`
prints both. A right copy must not be refused, so each limit stands clear of the worst right copy at hand;
what is wrong and slips through is left to the mark, which is then low.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from rumu.assessment.evidence import RefusalFigures


@dataclass(frozen=True, slots=True)
class RefusalLimits:
    """When a copy is refused. Shares are of 1; lengths are in rms radii of the ink.

    half_dark: half-dark pixels for each pixel of outline above which a picture is noise, not ink.
    small: size over the master's, for what is else like it; pixels: rms radius of the ink, in pixels.
    light, hollow: height of the ink over the master's, below which, and how much better the edges of strokes
        are covered than their middle, above which only an outline was drawn; or new: share of the ink that
        is new when closed lines are filled, and gained: likeness that this must not cost.
    fits, like: residual in the plane up to which, and likeness from which, nothing more is asked. in_place:
        share of the ink in its place from which it is the master's, whatever lacks or is too much.
    beyond: share of the master that falls outside the picture, over ink on the border.
    part, part_gain: likeness of a part of the picture alone, and how much more than that of the whole.
    reversed_at, reversal: likeness to the master mirrored or turned, and how much more than as it is.
    clear: clearness from which ink is clean. Old silk and rubbings lie below it: their crops hold stains and
        parts of neighbours, so they are never refused as several characters or as another.
    strange: strangeness from which it is another character; odd: from which it may be one where its residual
        in the plane is above odd_fits, so that the mark is odd_most at the highest, and the less the stranger
        it is: nothing from `nothing` on.
    """

    half_dark: float = 20.0
    small: float = 0.25
    pixels: float = 8.0
    light: float = 0.5
    hollow: float = 0.3
    new: float = 0.45
    gained: float = -0.06
    fits: float = 0.20
    like: float = 0.80
    in_place: float = 0.96
    beyond: float = 0.05
    part: float = 0.40
    part_gain: float = 0.25
    reversed_at: float = 0.45
    reversal: float = 0.15
    clear: float = 25.0
    strange: float = -0.03
    odd: float = -0.18
    odd_fits: float = 0.22
    odd_most: float = 39.0
    nothing: float = 0.1


@dataclass(frozen=True, slots=True)
class Refusal:
    """code: one word or two, for programs and lists. zh, en: one sentence each, for a person."""

    code: str
    zh: str
    en: str


def check_copy(
    figures: RefusalFigures, *, limits: RefusalLimits | None = None
) -> tuple[Refusal | None, float]:
    """(Why the copy cannot be marked, or None; the highest mark, 0-100, that it may get).

    A copy that is hardly like its master may be another character, which a mark alone does not see when
    its strokes lie alike: its mark is capped.
    """
    limits = limits or RefusalLimits()
    for code, holds in _ALWAYS.items():
        if holds(figures, limits):
            return reason(code), 0.0
    if figures.position < limits.fits or figures.likeness > limits.like:
        return None, 100.0
    if figures.in_place >= limits.in_place:
        return None, 100.0
    found = next((reason(code) for code, holds in _MISFITS.items() if holds(figures, limits)), None)
    return found, _highest(figures, limits)


def _highest(e: RefusalFigures, limits: RefusalLimits) -> float:
    """What a copy may reach that is hardly like its master, see RefusalLimits; 100 for any other."""
    if e.strangeness <= limits.odd or e.position <= limits.odd_fits:
        return 100.0
    share = (limits.nothing - e.strangeness) / (limits.nothing - limits.odd)
    return limits.odd_most * max(share, 0.0)


def reason(code: str) -> Refusal:
    """The sentences of a code; those of what holds no writing for a code that is not known."""
    return Refusal(code, *_SENTENCES.get(code, _SENTENCES["blank"]))


def _noise(e: RefusalFigures, limits: RefusalLimits) -> bool:
    return e.copy.quality.get("between", 0.0) > limits.half_dark


def _too_small(e: RefusalFigures, limits: RefusalLimits) -> bool:
    if 1.0 / e.registration.probe.pixel < limits.pixels:
        return True
    return e.registration.scale < limits.small and e.likeness > limits.part  # a single dot is not small


def _outline(e: RefusalFigures, limits: RefusalLimits) -> bool:
    if e.lightness >= limits.light:
        return False
    new, gained = e.filling if e.hollowness <= limits.hollow else (1.0, 0.0)
    return new > limits.new and gained > limits.gained


def _cut_off(e: RefusalFigures, limits: RefusalLimits) -> bool:
    return e.beyond > limits.beyond


def _several(e: RefusalFigures, limits: RefusalLimits) -> bool:
    if e.clearness < limits.clear:
        return False
    likeness, gain = e.part_gain
    return gain > limits.part_gain and likeness > limits.part


def _mirrored(e: RefusalFigures, limits: RefusalLimits) -> bool:
    return _reversed(e, max(e.mirrored, e.turned), limits) and e.mirrored > e.turned


def _upside_down(e: RefusalFigures, limits: RefusalLimits) -> bool:
    return _reversed(e, e.turned, limits)


def _reversed(e: RefusalFigures, gain: float, limits: RefusalLimits) -> bool:
    return gain > limits.reversal and e.likeness + gain > limits.reversed_at


def _another(e: RefusalFigures, limits: RefusalLimits) -> bool:
    return e.clearness >= limits.clear and e.strangeness > limits.strange


Tests = dict[str, Callable[[RefusalFigures, RefusalLimits], bool]]

_ALWAYS: Tests = {"noise": _noise, "too small": _too_small, "outline only": _outline, "cut off": _cut_off}
"""Asked of every copy, and quick."""

_MISFITS: Tests = {
    "several characters": _several,
    "mirrored": _mirrored,
    "upside down": _upside_down,
    "another character": _another,
}
"""Asked of a copy that neither fits nor stands in its place; the first that holds is the reason."""

_SENTENCES: dict[str, tuple[str, str]] = {
    "blank": (
        "畫面上沒有字。",
        "nothing is written in the picture",
    ),
    "black": (
        "畫面一片黑，看不到紙。",
        "the picture is black and shows no paper",
    ),
    "noise": (
        "畫面裏是噪點或雜物，不是寫在紙上的字。",
        "the picture holds noise or other things and no writing on paper",
    ),
    "flat": (
        "這個曲面是平的，沒有可比的起伏；請改用一張字的圖片。",
        "the surface is flat and holds no relief to compare; mark the ink of one image instead",
    ),
    "too small": (
        "字太小，看不清筆畫；請靠近些再拍，讓字佔畫面一半以上。",
        "the writing is too small to see its strokes; let it fill more than half of the picture",
    ),
    "cut off": (
        "字被畫面的邊切掉了一部分；請把整個字拍進畫面。",
        "a part of the character is cut off by the edge of the picture; show all of it",
    ),
    "several characters": (
        "畫面裏不止一個字；請只留與範字相同的那一個。",
        "there are several characters in the picture; leave only the one that the master shows",
    ),
    "mirrored": (
        "這個字左右反了；請檢查照片是不是鏡像。",
        "the character is mirrored; see whether the photo was flipped",
    ),
    "upside down": (
        "這個字上下顛倒了；請把照片轉正。",
        "the character is upside down; turn the photo",
    ),
    "outline only": (
        "只描了筆畫的輪廓，裏面是空的；請用毛筆寫實。",
        "only the outline of the strokes is drawn and they are hollow; write them with the brush",
    ),
    "another character": (
        "寫的不是範字上的那個字，或者看不出是字；請核對範字。",
        "this is not the master's character, or no character at all; see whether the master is the right one",
    ),
}
