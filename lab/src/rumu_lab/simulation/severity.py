"""How large each fault is at each severity: declared before anything was measured with it.

Severity runs from 0 (none) to 5 (gross). It is no mark that a person gave: it is fit for asking whether a
mark falls when a fault grows, and for nothing else.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

GREATEST = 5.0

FaultUnit = Literal["px", "deg", "%", "strokes"]


@dataclass(frozen=True, slots=True)
class FaultKind:
    """One family of faults.

    step: size of the fault for each unit of severity. unit: of that size; 'px' are pixels of a picture
    512 wide, scaled to the picture at hand. zh, en: its name for a person.
    """

    step: float
    unit: FaultUnit
    zh: str
    en: str


KINDS: Mapping[str, FaultKind] = MappingProxyType(
    {
        # one stroke
        "shift": FaultKind(5.0, "px", "筆畫偏移", "a stroke pushed aside"),
        "angle": FaultKind(3.5, "deg", "筆畫斜了", "a stroke at a wrong angle"),
        "short": FaultKind(8.0, "%", "筆畫太短", "a stroke too short"),
        "stroke_thin": FaultKind(1.6, "px", "一筆太細", "one stroke too thin"),
        "stroke_thick": FaultKind(2.0, "px", "一筆太粗", "one stroke too thick"),
        "missing": FaultKind(12.0, "%", "漏筆", "strokes left out"),
        "extra": FaultKind(1.0, "strokes", "多筆", "strokes too many"),
        # the whole character
        "thin": FaultKind(1.6, "px", "通篇太細", "all strokes too thin"),
        "thick": FaultKind(2.0, "px", "通篇太粗", "all strokes too thick"),
        "lean": FaultKind(4.0, "deg", "字形歪斜", "the character leans"),
        "off_centre": FaultKind(11.0, "px", "位置偏離", "off the centre of the cell"),
        "small": FaultKind(8.0, "%", "字太小", "too small"),
        "squeeze": FaultKind(5.0, "%", "左寬右窄", "the left part too wide, the right squeezed"),
        "uneven": FaultKind(3.0, "px", "間距不勻", "uneven spaces between the strokes"),
        # brush and ink
        "wobble": FaultKind(1.0, "px", "筆畫抖動", "trembling edges"),
        "blunt": FaultKind(20.0, "%", "收筆禿鈍", "blunt ends of strokes"),
        "blot": FaultKind(3.0, "%", "墨漬", "blots"),
        "pale": FaultKind(12.0, "%", "墨色太淡", "pale ink"),
        "dry": FaultKind(7.0, "%", "枯筆過多", "dry streaks"),
        # later ones stand last, so that the seeds of the others stay what they were
        "horizontal": FaultKind(2.0, "deg", "一橫斜了", "one horizontal stroke that leans"),
        "entry": FaultKind(15.0, "%", "起筆太重", "an entry too heavy"),
        "narrow": FaultKind(7.0, "%", "字形太窄", "too narrow for its height"),
    }
)
OFF_CENTRE_DOWN = 8.0 / 11.0  # pushed so much up or down for each pixel to the side


def size_of(fault: str, *, severity: float) -> float:
    """Size of a fault at a severity, in the unit of its kind."""
    return KINDS[fault].step * severity
