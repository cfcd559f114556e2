"""Where everything stands on the card, in millimetres: one geometry for printing it and for reading it.

The origin is the paper's upper left corner, x right, y down. The writing lies in the window, or below the
card where the window is cut out. Which paper it is, the numbers of the markers say.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from rumu.pages.sheet_layout import PAPERS, Box, Paper
from rumu.values import BoolArray, FloatArray

GRAYS = (0.70, 0.45, 0.28, 0.16, 0.08, 0.03)
"""Linear reflectance of the gray patches beside white paper, as they are meant; printers differ."""
FIRST_MARKER: dict[Paper, int] = {"A4": 12, "Letter": 28}
"""The lowest number of a card's markers; those of practice sheets lie below."""
MARKERS = 16
"""Markers of a card."""

MARKER_SIDE = 11.0
"""Side of a marker."""

_MARGIN = 8.0  # from each side of the paper
_SIDE, _TOP, _BOTTOM = 26.0, 40.0, 50.0  # width of the strips around the window
_ROWS = 6  # of markers along each long side, the corners among them
_PATCH, _PITCH = 9.0, 10.0  # side of a gray patch, and from one to the next
_CLEAR = 1.5  # white around what is printed, in which nothing is measured
_EDGE = 3.0  # from the paper's side, within which the desk might show


@dataclass(frozen=True, slots=True)
class GrayPatch:
    """One gray patch. level: its number in GRAYS. box: where it is."""

    level: int
    box: Box


@dataclass(frozen=True)
class CardLayout:
    """The card on one kind of paper."""

    paper: Paper = "A4"

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the paper."""
        return PAPERS[self.paper]

    @property
    def window(self) -> Box:
        """Where the writing lies."""
        width, height = self.size
        return Box(_SIDE, _TOP, width - 2 * _SIDE, height - _TOP - _BOTTOM)

    @cached_property
    def markers(self) -> dict[int, Box]:
        """The markers by their numbers: left side, right side, two at the top and two at the bottom."""
        width, height = self.size
        right, bottom = width - _MARGIN - MARKER_SIDE, height - _MARGIN - MARKER_SIDE
        places = [
            (left, float(top)) for left in (_MARGIN, right) for top in np.linspace(_MARGIN, bottom, _ROWS)
        ]
        places += [
            (share * width - MARKER_SIDE / 2, top) for top in (_MARGIN, bottom) for share in (0.5, 0.72)
        ]
        first = FIRST_MARKER[self.paper]
        return {first + k: Box(x, y, MARKER_SIDE, MARKER_SIDE) for k, (x, y) in enumerate(places)}

    @property
    def ball(self) -> tuple[float, float]:
        """Middle of the ring in which the ball lies."""
        return 0.3 * self.size[0], self.size[1] - 27.0

    @property
    def ring(self) -> float:
        """Radius of that ring, which is also the largest of a ball."""
        return 12.5

    @cached_property
    def patches(self) -> tuple[GrayPatch, ...]:
        """The gray patches: from light to dark above the window, from dark to light below it."""
        width, height = self.size
        above, below = (_SIDE, _TOP - 12.0), (width - _SIDE - 6 * _PITCH, height - 34.0)
        last = len(GRAYS) - 1
        return tuple(
            GrayPatch(level if top else last - level, Box(x + level * _PITCH, y, _PATCH, _PATCH))
            for top, (x, y) in ((True, above), (False, below))
            for level in range(len(GRAYS))
        )

    @property
    def scale(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Both ends of the line of 100 mm."""
        right, y = self.size[0] - _SIDE, self.size[1] - _BOTTOM + 6.0
        return (right - 100.0, y), (right, y)

    @property
    def title(self) -> Box:
        """Where the card's name stands."""
        return Box(_SIDE - 2, _MARGIN, 66.0, 17.0)

    @property
    def steps(self) -> Box:
        """Where the steps of a capture stand."""
        left = _SIDE + 6 * _PITCH + 6
        return Box(left, 21.0, self.size[0] - _MARGIN - MARKER_SIDE - 2 - left, 17.5)

    @cached_property
    def printed(self) -> tuple[Box, ...]:
        """All that is no blank paper, and the window."""
        (x0, y), (x1, _) = self.scale
        ball, around = self.ball, self.ring + 4.0
        return (
            self.window,
            *self.markers.values(),
            *(patch.box for patch in self.patches),
            Box(ball[0] - around, ball[1] - around, 2 * around, 2 * around),
            Box(x0 - 2, y - 3, x1 - x0 + 6, 9.0),
            self.title,
            self.steps,
        )

    def is_white(self, points: FloatArray) -> BoolArray:
        """(n,): whether points (n, 2) lie on blank paper, with some to spare."""
        x, y = points.T
        width, height = self.size
        white = (x > _EDGE) & (x < width - _EDGE) & (y > _EDGE) & (y < height - _EDGE)
        for box in self.printed:
            across = (x > box.left - _CLEAR) & (x < box.left + box.width + _CLEAR)
            white &= ~(across & (y > box.top - _CLEAR) & (y < box.top + box.height + _CLEAR))
        return np.asarray(white)
