"""How long a command of several stages will take yet: the whole of it, not only the stage that runs."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

_FILES = 9
"""How many files of a surface the time for writing was measured with."""
_PHOTOGRAPHS = 12
"""How many photographs are taken to come before they are counted."""


@dataclass(frozen=True, slots=True)
class Stage:
    """A stage of a command, and what it usually takes of a processor's seconds for a megapixel.

    what: as progress names it. each: for each photograph. once: besides. spread: whether all cores share it.
    counts: whether its parts are the photographs.
    Only ratios count: the stages that are done tell how fast the machine is and how large the photographs
    are.
    """

    what: str
    each: float = 0.0
    once: float = 0.0
    spread: bool = True
    counts: bool = False

    def usual(self, photographs: int) -> float:
        """Seconds for a megapixel of so many photographs on this machine."""
        seconds = self.each * photographs + self.once
        return seconds / (os.cpu_count() or 1) if self.spread else seconds


def _reading(*, align: bool, near: bool, card: bool) -> list[Stage]:
    """The stages of photographs that are read, as the options ask for it."""
    stages = [Stage("Reading photographs", each=0.008, counts=True)]
    if card:
        stages = [Stage("Looking for the card", each=0.05, spread=False, counts=True)]
    if align:
        stages.append(Stage("Finding how the camera moved", each=0.035, spread=False))
        stages.append(Stage("Laying photographs on each other", each=0.01, spread=False))
    return [*stages, Stage("Placing the lamps", once=0.05, spread=False)] if near else stages


def reconstruct_stages(
    files: Collection[str], *, solver: str, align: bool, near: bool, card: bool
) -> list[Stage]:
    """The stages of a reconstruct, with what they took of photographs as `benchmarks/museum.py` makes them.

    files: that are written. The rest: of the options.
    """
    slower = {"least_squares": 0.25, "l1": 0.7}.get(solver, 1.0) * (4.0 if near or card else 1.0)
    stages = _reading(align=align, near=near, card=card)
    stages += [
        Stage("Checking the photographs", each=0.001, once=0.035, spread=False),
        Stage("Looking for other materials", each=0.001, once=0.02, spread=False),
        Stage("Solving for the normals", each=0.017 * slower, once=0.23 * slower),
        Stage("Checking the lamps", once=0.033),
        Stage("Integrating the height", once=0.05, spread=False),
        Stage("Looking at each photograph", each=0.0005, once=0.01, spread=False),
        Stage("Drawing the mesh and the report", once=0.27, spread=False),
        Stage("Writing files", once=0.3 * len(files) / _FILES),
    ]
    drawn = {"mesh.glb", "report.html"} & set(files)
    return [one for one in stages if drawn or not one.what.startswith("Drawing")]


def rti_stages(channels: str, *, align: bool, near: bool, card: bool) -> list[Stage]:
    """The stages of an rti. channels: 'lrgb' or 'rgb', or the basis for which one of them is usual."""
    of_each = 3 if channels in ("rgb", "hsh") else 1
    return [
        *_reading(align=align, near=near, card=card),
        Stage("Fitting the relightable image", each=0.016 * of_each, once=0.05 * of_each),
        Stage("Writing files", once=0.02 * of_each, spread=False),
    ]


_TELLS = 0.04
"""Share of a stage from which its own pace tells how long it will take."""


class RunTime:
    """The time that is left of a command, as its progress tells it. clock: in seconds."""

    def __init__(self, stages: Sequence[Stage], *, clock: Callable[[], float] = time.monotonic) -> None:
        self._stages, self._clock = list(stages), clock
        self._photographs = _PHOTOGRAPHS
        self._what = ""
        self._at: int | None = None  # the stage that runs; None for one that is not among those planned
        self._passed = 0  # stages that ran or were left out
        self._start = self._began = self._last = clock()
        self._first = 0.0  # share of the stage that was done when it was first told of
        self._full = True  # whether the last that was told of was done
        self._took = self._usual = 0.0  # of the stages that ran, really and usually

    @property
    def elapsed(self) -> float:
        """Seconds since the command began."""
        return self._clock() - self._start

    def left(self, what: str, done: int, total: int) -> float | None:
        """Seconds that are left when `done` of `total` parts of a stage are done; None while nothing tells.

        A stage that is not among those of the command counts only while it runs.
        """
        now, share = self._clock(), done / max(total, 1)
        if what != self._what:
            self._begin(what, now, share)
        if self._at is not None and self._stages[self._at].counts:
            self._photographs = total
        self._last, self._full = now, done >= total
        here, known = now - self._began, share - self._first
        usual_here = 0.0 if self._at is None else self._usual_of(self._at)
        usual = self._usual + known * usual_here
        pace = (self._took + (here if known and usual_here else 0.0)) / usual if usual else None
        if known < _TELLS and pace is None:
            return None
        after = sum(map(self._usual_of, range(self._passed, len(self._stages))))
        if known >= _TELLS:
            rest = here * (1 - share) / known
        else:
            rest = max(0.0, (pace or 0.0) * usual_here * (1 - self._first) - here)
        return rest + (pace or 0.0) * after

    def _usual_of(self, number: int) -> float:
        return self._stages[number].usual(self._photographs)

    def _begin(self, what: str, now: float, share: float) -> None:
        """Begin another stage, and count the one before.

        One that is first told of when a part of it is done began when the one before was full.
        """
        began = self._last if self._full else now
        if self._at is not None:
            self._took += began - self._began
            self._usual += self._usual_of(self._at) * (1 - self._first)
        names = [one.what for one in self._stages]
        self._what, self._began = what, began
        self._first = 0.0 if self._full else share
        self._at = names.index(what) if what in names else None
        self._passed = self._passed if self._at is None else self._at + 1
