"""One thing that is good about a copy, and true: the measure in which it comes nearest to its master."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from rumu.assessment.findings import Finding
from rumu.assessment.ink_measures import InkMeasures
from rumu.assessment.named_strokes import NamedStroke
from rumu.assessment.part_measures import PartMeasures
from rumu.assessment.whole_remarks import PoseSeen
from rumu.strokes.correspondence import StrokeMatch
from rumu.values import Bilingual, FloatArray, Remark


@dataclass(frozen=True, slots=True)
class PraiseSettings:
    """Up to which difference from the master something is good: what a quarter of learners' copies reach.

    shift: mean, fractions of the cell. turn: mean, degrees. length: mean logarithm. weight: logarithm of the
    width; even: mean difference of the strokes' own. ends: mean, shares of a stroke's width. torn: see
    `InkMeasures.torn`. proportion: of two parts, relative; part_place: fraction of the cell. size: relative;
    offset: fraction of the cell; lean: degrees.
    stroke: of the best stroke, mean of its shift, turn and length over the above; its share of all strokes
    is at least that of a common one. far: times the above, from which one stroke alone is not good. part: of
    the mark, 0-100, from which what belongs to it is praised.
    """

    shift: float = 0.016
    turn: float = 3.3
    length: float = 0.07
    weight: float = 0.06
    even: float = 0.14
    ends: float = 0.12
    torn: float = 0.15
    proportion: float = 0.05
    part_place: float = 0.012
    size: float = 0.04
    offset: float = 0.025
    lean: float = 1.5
    stroke: float = 0.6
    far: float = 2.5
    part: float = 50.0


PRAISE = PraiseSettings()


class Praised(NamedTuple):
    """What a praise is sought in; marks: of the parts of the mark, 0-100."""

    match: StrokeMatch
    ink: InkMeasures
    parts: PartMeasures | None
    strokes: Sequence[NamedStroke]
    pose: PoseSeen
    marks: Mapping[str, float]


class PossiblePraise(NamedTuple):
    """A praise that may be true.

    size: of the difference from the master over the largest that is still good. kinds: of the remarks that
    would contradict it. part: of the mark, that it belongs to. stroke: which is praised, by its position.
    """

    size: float
    words: Bilingual
    kinds: tuple[str, ...]
    part: str = ""
    stroke: int | None = None


def write_praise(
    seen: Praised, remarks: Iterable[Remark], *, found: Iterable[Finding] = ()
) -> Bilingual | None:
    """What comes nearest to the master and is not blamed; None where nothing is near enough.

    found: all faults; a stroke with any is not the best one.
    """
    blamed = {remark.kind for remark in remarks}
    at_fault = {f.cause for f in found if f.excess >= 1.0}
    good = [
        praise
        for praise in _candidates(seen)
        if praise.size < 1.0
        and seen.marks.get(praise.part, 100.0) >= PRAISE.part
        and not blamed.intersection(praise.kinds)
        and (praise.stroke is None or f"stroke {praise.stroke}" not in at_fault)
    ]
    return min(good, key=lambda praise: praise.size).words if good else None


def _candidates(seen: Praised) -> Iterator[PossiblePraise]:
    yield from _of_the_whole(seen)
    yield from _of_the_strokes(seen)
    yield from _of_the_brush(seen)


def _of_the_whole(seen: Praised) -> Iterator[PossiblePraise]:
    s, pose, parts = PRAISE, seen.pose, seen.parts
    if pose.framed:
        offset = float(np.hypot(*pose.offset))
        yield PossiblePraise(
            max(*(abs(size) / s.size for size in pose.sizes), offset / s.offset, abs(pose.lean) / s.lean),
            Bilingual(
                "大小合度，位置居中，重心也正。", "Its size, its place in the cell and its axis are right."
            ),
            ("size", "offset", "lean", "aspect"),
        )
    if parts is not None:
        proportion = abs(np.log(max(parts.width[0], 1e-6) / max(parts.width[1], 1e-6)))
        away = float(np.hypot(*parts.apart)) * pose.registration.reference.radius
        across = parts.axis == "across"
        yield PossiblePraise(
            max(proportion / s.proportion, away / s.part_place),
            Bilingual(
                f"{'左右' if across else '上下'}兩部的比例和位置安排得好。",
                f"The {'left and right' if across else 'upper and lower'} parts are in proportion "
                "and well placed.",
            ),
            ("aspect", "squeeze", "part_place", "spacing"),
            "structure",
        )  # fmt: skip


def _of_the_strokes(seen: Praised) -> Iterator[PossiblePraise]:
    s, strokes = PRAISE, [named for named in seen.strokes if named.stroke.present]
    if not strokes:
        return
    weight = np.array([named.stroke.weight for named in strokes])
    shift = np.array([float(np.hypot(*named.shift)) * named.cell for named in strokes])
    turn = np.array([abs(named.stroke.turn) for named in strokes])
    length = np.array([abs(np.log(max(named.stroke.length, 0.05))) for named in strokes])
    if len(strokes) == len(seen.strokes):
        yield PossiblePraise(
            _throughout(shift, weight, s.shift),
            Bilingual(
                "筆畫的位置安排得準，間架穩。", "The strokes stand where the master's do: the frame is firm."
            ),
            ("displaced", "aspect", "squeeze", "part_place", "inner", "spacing", "missing", "extra"),
            "structure",
        )
    yield PossiblePraise(
        _throughout(turn, weight, s.turn),
        Bilingual("筆畫的斜度看得準，筆勢對。", "The slant of the strokes is well observed."),
        ("stroke_angle",),
        "structure",
    )
    yield PossiblePraise(
        _throughout(length, weight, s.length),
        Bilingual("筆畫長短有度。", "The strokes have the right length."),
        ("stroke_long", "stroke_short", "sticks_out", "missing"),
        "structure",
    )
    each = np.mean([shift / s.shift, turn / s.turn, length / s.length], axis=0) / s.stroke
    for named, size in zip(strokes, each.tolist(), strict=True):
        if named.stroke.weight >= named.common:
            words = Bilingual(
                f"{named.name.zh}寫得好：位置、方向、長短都與範本相合。",
                f"{named.en} is well written: its place, direction and length are the master's.",
            )
            moved = (
                "size",
                "offset",
                "lean",
                "aspect",
                "squeeze",
                "part_place",
            )  # with the whole or its part
            yield PossiblePraise(size, words, moved, stroke=named.position)


def _throughout(differences: FloatArray, weight: FloatArray, good: float) -> float:
    """The mean of the strokes' differences over what is good; the worst one counts, too."""
    worst = float(np.max(differences, initial=0.0)) / PRAISE.far
    return max(float(np.average(differences, weights=weight)), worst) / good


def _of_the_brush(seen: Praised) -> Iterator[PossiblePraise]:
    s, match, ink = PRAISE, seen.match, seen.ink
    ratios = np.array([named.stroke.width for named in seen.strokes if named.stroke.present])
    ratios = ratios[np.isfinite(ratios)]
    if len(ratios):
        uneven = float(np.abs(np.log(ratios / match.width)).mean())
        heavy = max(abs(weight) for weight in seen.pose.weights)
        yield PossiblePraise(
            max(heavy / s.weight, uneven / s.even),
            Bilingual(
                "粗細得當，提按分明。",
                "The strokes have the master's weight: lifting and pressing are told apart.",
            ),
            ("heavy", "thin", "stroke_heavy", "stroke_thin", "filled"),
            "brushwork",
        )
    ends = np.abs([v for named in seen.strokes for v in (named.stroke.entry, named.stroke.exit)])
    ends = ends[np.isfinite(ends)]
    if len(ends):
        yield PossiblePraise(
            _throughout(ends, np.ones(len(ends)), s.ends),
            Bilingual("起筆、收筆看得仔細，寫出了範本的樣子。", "The entries and exits are the master's."),
            ("entry_heavy", "entry_light", "exit_blunt", "stroke_thin", "stroke_heavy", "rough"),
            "brushwork",
        )
    yield PossiblePraise(
        max(ink.torn / s.torn, 0.3),
        Bilingual("墨邊乾淨，行筆穩。", "The edges are clean: the brush moved steadily."),
        ("rough", "dry", "blot", "filled", "heavy"),
    )
