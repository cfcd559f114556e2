"""Two attempts at one master: what got better and what did not, as a whole, by part, and by stroke.

A difference counts only where it is larger than the error of measuring. A fault is called gone only when it
was looked for again and was clearly larger than the smallest that is told.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np

from rumu.characters.stroke_data import evenly_spaced
from rumu.values import FloatArray, Remark

Change = Literal["better", "same", "worse"]
Status = Literal["gone", "smaller", "same", "larger", "turned", "new"]
STATUSES: tuple[Status, ...] = ("gone", "smaller", "same", "larger", "turned", "new")

_ASPECTS: Mapping[str, tuple[str, int]] = {
    "stroke_short": ("length", -1), "stroke_long": ("length", 1),
    "stroke_thin": ("width", -1), "stroke_heavy": ("width", 1),
    "entry_light": ("entry", -1), "entry_heavy": ("entry", 1),
    "thin": ("weight", -1), "heavy": ("weight", 1),
}  # fmt: skip
_SIGNED = frozenset({"lean", "size", "stroke_angle", "spacing"})
"""Kinds whose size itself says to which side the fault lies."""
_OF_THE_POSE = frozenset({"lean", "size", "offset"})
"""Kinds that are looked for only where the picture is the cell that was written in."""
_OF_SEVERAL = frozenset({"exit_blunt"})
"""Kinds that may be told of several strokes at once, where it is chance which of them were found."""
_STEP = 0.02
"""Of the cell: between points of lines that are compared."""


class Marked(Protocol):
    """What is compared: an Assessment, or a mark that was stored."""

    @property
    def score(self) -> float | None: ...

    @property
    def parts(self) -> Mapping[str, float]: ...

    @property
    def remarks(self) -> tuple[Remark, ...]: ...

    @property
    def untold(self) -> tuple[Remark, ...] | None:
        """Faults that were found but not told; None where that was not kept."""
        ...


@dataclass(frozen=True, slots=True)
class FaultPrecision:
    """error: of measuring its size, between two photographs of one copy. least: the smallest that is told."""

    error: float
    least: float


@dataclass(frozen=True, slots=True)
class ProgressSettings:
    """What is larger than chance; `python benchmarks/repeats.py` prints what it is taken from.

    mark: points from which people see the same order of two copies of one character in five pairs of six; two
    photographs of one copy differ by less than two. parts: the same of each part.
    faults: by aspect, in the unit of its remarks; error: clearly more than nine of ten differences of two
    photographs of one copy. relative: the error of any other aspect, as a share of the larger size.
    near: share of the master's cell within which lines are of one stroke; near_copy: the same in the copies'
    own cells, which are not laid on each other.
    """

    mark: float = 8.0
    parts: Mapping[str, float] = field(
        default_factory=lambda: {"brushwork": 8.0, "structure": 8.0, "ink": 12.0}
    )
    faults: Mapping[str, FaultPrecision] = field(
        default_factory=lambda: {
            "length": FaultPrecision(0.15, 0.08),
            "width": FaultPrecision(0.2, 0.2),
            "entry": FaultPrecision(0.16, 0.1),
            "exit_blunt": FaultPrecision(0.13, 0.16),
            "displaced": FaultPrecision(0.025, 0.013),
            "stroke_angle": FaultPrecision(4.0, 3.0),
            "sticks_out": FaultPrecision(0.03, 0.05),
            "missing": FaultPrecision(0.01, 0.02),
            "extra": FaultPrecision(0.006, 0.012),
            "blot": FaultPrecision(0.006, 0.009),
            "filled": FaultPrecision(0.2, 0.6),
            "lean": FaultPrecision(2.5, 3.0),
            "size": FaultPrecision(0.06, 0.08),
            "offset": FaultPrecision(0.015, 0.04),
            "aspect": FaultPrecision(0.07, 0.12),
            "weight": FaultPrecision(0.2, 0.14),
            "squeeze": FaultPrecision(0.07, 0.15),
            "part_place": FaultPrecision(0.02, 0.035),
            "inner": FaultPrecision(0.1, 0.15),
            "spacing": FaultPrecision(0.2, 0.25),
        }
    )
    relative: float = 0.34
    near: float = 0.05
    near_copy: float = 0.12


@dataclass(frozen=True, slots=True)
class NumberChange:
    """A number of both attempts, 0-100, and whether it changed by more than the error of measuring."""

    before: float
    after: float
    change: Change


@dataclass(frozen=True, slots=True)
class FaultChange:
    """One fault. before, after: what was found; None where it was not."""

    status: Status
    before: Remark | None
    after: Remark | None

    @property
    def remark(self) -> Remark:
        """The later of the two."""
        remark = self.after or self.before
        assert remark is not None
        return remark


@dataclass(frozen=True, slots=True)
class AttemptProgress:
    """What a later attempt changed. faults: in the order of STATUSES, in each the gravest first."""

    mark: NumberChange
    parts: Mapping[str, NumberChange]
    faults: tuple[FaultChange, ...]


def compare_attempts(
    before: Marked, after: Marked, *, framed: bool, settings: ProgressSettings | None = None
) -> AttemptProgress | None:
    """Compare two marks of copies of one master; None where one of them has no mark.

    framed: whether both pictures are the cells that were written in; only then can place, size and lean of
    the whole be compared.
    """
    settings = settings or ProgressSettings()
    if before.score is None or after.score is None:
        return None
    names = [name for name in after.parts if name in before.parts]
    faults = sorted(
        (f for f in _fault_changes(before, after, settings) if framed or f.remark.kind not in _OF_THE_POSE),
        key=lambda f: (STATUSES.index(f.status), -f.remark.severity),
    )
    return AttemptProgress(
        _number_change(before.score, after.score, settings.mark),
        {
            name: _number_change(
                before.parts[name], after.parts[name], settings.parts.get(name, settings.mark)
            )
            for name in names
        },
        tuple(faults),
    )


def aspect_of(remark: Remark) -> str:
    """What a remark measures: too short and too long are one aspect, the length."""
    return _ASPECTS.get(remark.kind, (remark.kind, 1))[0]


def signed_size(remark: Remark) -> float:
    """The size of a fault, with the side to which it lies where it has one."""
    if remark.kind in _SIGNED:
        return remark.size
    return _ASPECTS.get(remark.kind, ("", 1))[1] * abs(remark.size)


def speak_of_one_stroke(one: Remark, other: Remark, *, settings: ProgressSettings | None = None) -> bool:
    """Whether two remarks, on two copies of one master, are of the same stroke, or both of the whole."""
    settings = settings or ProgressSettings()
    if one.stroke is not None and other.stroke is not None:
        return one.stroke == other.stroke
    for lines, others, near in (
        (one.master_outline, other.master_outline, settings.near),
        (one.outline, other.outline, settings.near_copy),
    ):
        if lines and others:
            return _apart(_points(lines), _points(others)) <= near
    return not (one.outline or other.outline)


def _number_change(before: float, after: float, error: float) -> NumberChange:
    risen = after - before
    return NumberChange(before, after, "same" if abs(risen) < error else "better" if risen > 0 else "worse")


def _fault_changes(before: Marked, after: Marked, settings: ProgressSettings) -> Iterator[FaultChange]:
    first = (*before.remarks, *(before.untold or ()))
    second = (*after.remarks, *(after.untold or ()))
    met: list[Remark] = []
    for remark in before.remarks:
        again = _find_again(remark, second, settings)
        if again is not None:
            met.append(again)
            yield FaultChange(_status(remark, again, settings), remark, again)
        elif (
            after.untold is not None and _is_clear(remark, settings) and not _lacks(second, remark, settings)
        ):
            yield FaultChange("gone", remark, None)
    for remark in after.remarks:
        if remark in met or _lacks(first, remark, settings):
            continue
        earlier = _find_again(remark, first, settings)
        if earlier is None:
            if before.untold is not None and _is_clear(remark, settings):
                yield FaultChange("new", None, remark)
        elif _status(earlier, remark, settings) == "larger":  # it was there, but too small to be told
            yield FaultChange("larger", earlier, remark)


def _find_again(remark: Remark, others: Sequence[Remark], settings: ProgressSettings) -> Remark | None:
    """The fault of the same aspect and stroke, the one of the nearest size where there are several."""
    same = [o for o in others if aspect_of(o) == aspect_of(remark)]
    same = [o for o in same if speak_of_one_stroke(remark, o, settings=settings)]
    return min(same, key=lambda o: abs(signed_size(o) - signed_size(remark)), default=None)


def _lacks(found: Sequence[Remark], remark: Remark, settings: ProgressSettings) -> bool:
    """Whether a copy lacks the stroke of a remark on something else: then nothing is known of it there."""
    return any(
        o.kind == "missing" != remark.kind
        and bool(o.outline)
        and speak_of_one_stroke(o, remark, settings=settings)
        for o in found
    )


def _status(before: Remark, after: Remark, settings: ProgressSettings) -> Status:
    was, now = signed_size(before), signed_size(after)
    if was * now < 0:
        return "turned"
    grown, error = abs(now) - abs(was), _error(before, after, settings)
    return "same" if abs(grown) < error else "larger" if grown > 0 else "smaller"


def _error(before: Remark, after: Remark, settings: ProgressSettings) -> float:
    fault = settings.faults.get(aspect_of(before))
    return fault.error if fault else settings.relative * max(abs(before.size), abs(after.size))


def _is_clear(remark: Remark, settings: ProgressSettings) -> bool:
    """Whether a fault is so large that it would not fall below the smallest that is told by chance."""
    if remark.kind in _OF_SEVERAL and len(remark.outline) > 1:
        return False
    fault = settings.faults.get(aspect_of(remark))
    return fault is None or abs(remark.size) >= fault.least + fault.error


def _points(lines: Sequence[Sequence[tuple[float, float]]]) -> FloatArray:
    """(n, 2): points along the lines, evenly spaced, however finely they were drawn."""
    arrays = (np.array(line, dtype=float).reshape(-1, 2) for line in lines)
    lengths = ((line, float(np.hypot(*np.diff(line, axis=0).T).sum())) for line in arrays)
    return np.concatenate([evenly_spaced(line, 2 + int(length / _STEP)) for line, length in lengths])


def _apart(one: FloatArray, other: FloatArray) -> float:
    """Mean distance from the points of each to the nearest of the other."""
    distances = np.hypot(*(one[:, None] - other[None]).transpose(2, 0, 1))
    return float((distances.min(axis=1).mean() + distances.min(axis=0).mean()) / 2)
