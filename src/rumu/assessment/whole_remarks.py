"""What is said of the whole character and of its parts: lean, size, place, weight, proportion."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rumu.assessment.advice import WHOLE
from rumu.assessment.features import ink_weight
from rumu.assessment.findings import Fault, Finding
from rumu.assessment.part_measures import InnerMeasures, PartMeasures
from rumu.assessment.thresholds import PLACE_DOUBT, RemarkThresholds, agreed, as_lines, box, severity
from rumu.strokes.correspondence import StrokeMatch
from rumu.strokes.naming import direction_of, way_of
from rumu.values import Bilingual, BoolArray, FloatArray, Registration, Remark

_HALVES = {
    "across": (Bilingual("左旁", "left part"), Bilingual("右旁", "right part")),
    "down": (Bilingual("上部", "upper part"), Bilingual("下部", "lower part")),
}
_EXTENT = {
    "across": (Bilingual("寬", "wide"), Bilingual("窄", "narrow")),
    "down": (Bilingual("高", "tall"), Bilingual("扁", "flat")),
}


_DOUBT = 0.05
"""Logarithm of a width up to which two measures of it may have different signs and still agree."""
_SIZE_DOUBT = 0.02
"""Relative size up to which the same holds."""
_ONLY_TO_EXPLAIN = 0.99
"""Excess of a fault that is told only where a low part of the mark has no other."""
_OFF = 0.06
"""Relative width from which a part itself is called wide or narrow, and not only one beside the other."""


@dataclass(frozen=True, slots=True, eq=False)
class PoseSeen:
    """How the whole stands. framed: whether that is the writer's doing and not the photographer's."""

    match: StrokeMatch
    registration: Registration
    framed: bool

    @property
    def lean(self) -> float:
        """Degrees, positive clockwise."""
        return self.match.pose.angle

    @property
    def sizes(self) -> tuple[float, float, float]:
        """Of the copy over the master's, less 1: by what strokes agree upon, its extent and its spread."""
        match = self.match
        return match.pose.scale - 1.0, match.extent[0] - 1.0, match.spread[0] - 1.0

    @property
    def size(self) -> float:
        """What is sure of them: between the middle one and that of its extent, which is what the eye sees."""
        middle = agreed(self.sizes, doubt=_SIZE_DOUBT)
        return middle and (middle + self.sizes[1]) / 2

    @property
    def aspect(self) -> float:
        """Of the copy's width over its height, over the same of the master, less 1; 0 where that is alike."""
        return float(np.expm1(self.match.pose.aspect))

    @property
    def offset(self) -> FloatArray:
        """(x right, y DOWN), fractions of the cell: how far its middle is from the master's.

        What is sure of it: by what its strokes agree upon, by its edges and by the middle of its strokes.
        """
        match = self.match
        if not match.covered.any():
            return np.zeros(2)
        middle = match.places[match.covered].mean(axis=0)
        readings = [match.extent[1], match.spread[1]]
        if match.squeeze is None:  # a squeeze keeps the outer edges and moves all between them
            readings.append(match.pose.linear @ middle + match.pose.shift - middle)
        away = np.stack(readings) * self.registration.reference.radius
        return np.array([agreed(each, doubt=PLACE_DOUBT) for each in away.T.tolist()])

    @property
    def heaviness(self) -> float:
        """Natural logarithm of the ink's mean depth over the master's, for its size."""
        return ink_weight(self.registration)

    @property
    def weights(self) -> tuple[float, ...]:
        """Natural logarithms of the width of the strokes over the master's, read in two or three ways.

        That of most strokes, and of all ink, both for the size of the character; and, where the picture is
        the cell, of all ink as it stands on the paper.
        """
        strokes, ink = float(np.log(max(self.match.width, 1e-6))), self.heaviness
        if not self.framed:
            return strokes, ink
        size = self.registration.probe.radius / max(self.registration.reference.radius, 1e-9)
        return strokes, ink, ink + float(np.log(max(size, 1e-6)))


def find_whole_faults(pose: PoseSeen, limits: RemarkThresholds) -> Iterator[Finding]:
    """Faults of the whole, each where it is worth a remark or half of that."""
    if pose.framed:
        yield from _find_pose_faults(pose, limits)
    if abs(pose.aspect) >= limits.aspect:
        zh, en = ("寬", "wide") if pose.aspect > 0 else ("窄", "narrow")
        fault = _fault("aspect", pose.aspect, "of the master", limits.aspect)
        remark = Remark(
            *fault[:4], None,
            f"字形太{zh}：以高度論，比範本{zh}約 {abs(pose.aspect):.0%}。",
            f"The character is too {en} for its height, by about {abs(pose.aspect):.0%}.",
        )  # fmt: skip
        yield Finding(remark, fault.excess, WHOLE[en], "aspect")
    strokes = pose.match
    least = limits.weight + strokes.width_error(strokes.master.points)
    # where only some strokes are heavy the whole looks it, and strokes that were laid on other ink look far
    # too heavy or too thin; a small character is heavy for its size though it was written with a thin brush
    weight = agreed(pose.weights, doubt=_DOUBT)
    told = abs(weight) >= limits.weak * least
    if not told:  # else some are heavy, others thin, which may still explain a low mark of the ink
        weight = agreed(pose.weights[1:], doubt=_DOUBT)
    if abs(weight) < limits.weak * least:
        return
    much = np.exp(weight) - 1.0
    zh, en, kind = ("粗", "heavier", "heavy") if weight > 0 else ("細", "thinner", "thin")
    remark = Remark(
        kind, much, "of the master", severity("weight", weight, limits.weight), None,
        f"筆畫比範本{zh}約 {abs(much):.0%}。",
        f"Strokes are about {abs(much):.0%} {en} than the master's.",
    )  # fmt: skip
    excess = abs(weight) / least
    yield Finding(remark, excess if told else min(excess, _ONLY_TO_EXPLAIN), WHOLE[kind], "weight")


def _find_pose_faults(pose: PoseSeen, limits: RemarkThresholds) -> Iterator[Finding]:
    lean, size, away = pose.lean, pose.size, pose.offset
    if abs(lean) >= limits.lean:
        zh, en = ("右", "clockwise") if lean > 0 else ("左", "anticlockwise")
        said = Bilingual(f"向{zh}傾斜 {abs(lean):.0f}°", f"leans {abs(lean):.0f}° {en}")
        yield _of_whole(_fault("lean", lean, "degrees", limits.lean), said, advice="lean")
    # what is too narrow is smaller, too
    by_shape = abs(np.log1p(size)) <= abs(pose.match.pose.aspect) / 2 + _SIZE_DOUBT
    if abs(size) >= limits.size and not by_shape:
        zh, en = ("大", "larger") if size > 0 else ("小", "smaller")
        said = Bilingual(f"比範本{zh} {abs(size):.0%}", f"is {abs(size):.0%} {en} than the master")
        yield _of_whole(_fault("size", size, "of the master", limits.size), said, advice=en)
    offset = float(np.hypot(*away))
    if offset >= limits.offset:
        said = Bilingual(
            f"在格中偏{direction_of(away).zh}，離範本位置約 {offset:.0%} 格",
            f"stands {way_of(away)}, by about {offset:.0%} of the cell",
        )
        yield _of_whole(_fault("offset", offset, "of the cell", limits.offset), said, advice="offset")


def _of_whole(fault: Fault, said: Bilingual, *, advice: str) -> Finding:
    """A finding on the pose of the whole character; said: its predicate."""
    remark = Remark(*fault[:4], None, f"整字{said.zh}。", f"The whole character {said.en}.")
    return Finding(remark, fault.excess, WHOLE[advice], "pose", said)


def find_part_faults(
    match: StrokeMatch,
    parts: PartMeasures | None,
    inner: InnerMeasures | None,
    *,
    known: bool,
    cell: float,
    limits: RemarkThresholds,
) -> tuple[list[Finding], FloatArray]:
    """Faults of proportion, and (n, 2) how far they alone move each of the master's points, rms radii.

    known: whether the character's structure is. cell: one rms radius in cells.
    """
    nothing = np.zeros_like(match.places)
    if not known:
        return _find_unknown_parts(match, limits)
    if inner is not None:
        found = list(_find_inner_faults(match, inner, cell, limits))
        return found, inner.explained if any(f.excess >= 1.0 for f in found) else nothing
    if parts is None:
        return [], nothing
    found = []
    found += _find_width_fault(match, parts, limits)
    found += _find_place_fault(match, parts, cell, limits, told=any(f.excess >= 1.0 for f in found))
    return found, parts.explained if any(f.excess >= 1.0 for f in found) else nothing


def _find_unknown_parts(match: StrokeMatch, limits: RemarkThresholds) -> tuple[list[Finding], FloatArray]:
    """One half much too wide for the other, in a character whose parts are not known."""
    q = match.squeeze
    if q is None or max(q.first / q.second, q.second / q.first) - 1.0 < limits.squeeze_unknown:
        return [], np.zeros_like(match.places)
    first = match.places[:, 0 if q.axis == "across" else 1] < q.border
    explained = q.apply(match.places) - match.places
    parts = PartMeasures(q.axis, first, (q.first, q.second), np.zeros(2), explained)
    return list(_find_width_fault(match, parts, limits)), explained


def _find_width_fault(match: StrokeMatch, parts: PartMeasures, limits: RemarkThresholds) -> Iterator[Finding]:
    ratio = parts.width
    large, small = (0, 1) if ratio[0] > ratio[1] else (1, 0)
    size = ratio[large] / max(ratio[small], 1e-6) - 1.0
    if size < limits.weak * limits.squeeze:
        return
    halves, (much, little) = _HALVES[parts.axis], _EXTENT[parts.axis]
    (zh, en), (zh_other, en_other) = halves[large], halves[small]
    wide, narrow = ratio[large] - 1.0 >= _OFF, 1.0 - ratio[small] >= _OFF
    if wide and narrow:
        text = Bilingual(
            f"{zh}太{much.zh}，{zh_other}太{little.zh}。",
            f"The {en} is too {much.en}, the {en_other} too {little.en}.",
        )
    elif wide:
        text = Bilingual(
            f"{zh}太{much.zh}，與{zh_other}不相稱。", f"The {en} is too {much.en} for the {en_other}."
        )
    else:
        text = Bilingual(
            f"{zh_other}太{little.zh}，與{zh}不相稱。", f"The {en_other} is too {little.en} for the {en}."
        )
        large = small
    points = parts.first if large == 0 else ~parts.first
    fault = _fault("squeeze", size, "of the master", limits.squeeze)
    yield _on_strokes(match, points, fault, text, advice="squeeze")


def _find_place_fault(
    match: StrokeMatch, parts: PartMeasures, cell: float, limits: RemarkThresholds, *, told: bool
) -> Iterator[Finding]:
    """The first part stands off its place beside the second; told: that one is too wide, which moves it."""
    k = 0 if parts.axis == "across" else 1
    away = parts.apart * cell
    if told:
        away = np.where(np.arange(2) == k, 0.0, away)
    off = int(np.abs(away).argmax())
    size = float(abs(away[off]))
    if size < limits.weak * limits.part_place:
        return
    (zh, en), (zh_other, en_other) = _HALVES[parts.axis]
    if off == k:
        word = (
            Bilingual("靠得太近", "too close together")
            if away[k] > 0
            else Bilingual("離得太遠", "too far apart")
        )
        text = Bilingual(
            f"{zh}與{zh_other}{word.zh}，約差 {size:.0%} 格。",
            f"The {en} and the {en_other} stand {word.en}, by about {size:.0%} of the cell.",
        )
    else:
        way = np.where(np.arange(2) == off, away, 0.0)
        text = Bilingual(
            f"{zh}對{zh_other}偏{direction_of(way).zh}約 {size:.0%} 格。",
            f"The {en} stands {way_of(way)} beside the {en_other}, by about {size:.0%} of the cell."
            if parts.axis == "across"
            else f"The {en} stands {way_of(way)} over the {en_other}, by about {size:.0%} of the cell.",
        )
    fault = _fault("part_place", size, "of the cell", limits.part_place)
    yield _on_strokes(match, parts.first, fault, text, advice="part_place")


def _find_inner_faults(
    match: StrokeMatch, inner: InnerMeasures, cell: float, limits: RemarkThresholds
) -> Iterator[Finding]:
    size, away = inner.size - 1.0, inner.apart * cell
    if abs(size) >= limits.weak * limits.inner:
        zh, en = ("大", "large") if size > 0 else ("小", "small")
        text = Bilingual(
            f"框內的部分太{zh}，與外框不相稱。", f"What is enclosed is too {en} for what encloses it."
        )
        fault = _fault("inner", size, "of the master", limits.inner)
        yield _on_strokes(match, inner.points, fault, text, advice=f"inner_{en}")
    off = float(np.hypot(*away))
    if off >= limits.weak * limits.inner_place:
        text = Bilingual(
            f"框內的部分偏{direction_of(away).zh}約 {off:.0%} 格。",
            f"What is enclosed stands {way_of(away)}, by about {off:.0%} of the cell.",
        )
        severe, excess = severity("part_place", off, limits.inner_place), off / limits.inner_place
        fault = Fault("part_place", off, "of the cell", severe, excess)
        yield _on_strokes(match, inner.points, fault, text, advice="inner_place")


def _fault(kind: str, size: float, unit: str, least: float) -> Fault:
    return Fault(kind, size, unit, severity(kind, size, least), abs(size) / least)


def _on_strokes(
    match: StrokeMatch, points: BoolArray, fault: Fault, text: Bilingual, *, advice: str
) -> Finding:
    """A finding on the strokes that some of the master's points belong to."""
    owners = np.unique(match.master.points.owner[points])
    outlines = [match.strokes[int(k)].outline for k in owners]
    masters = [match.framed_master.on_picture(match.master.lines[int(k)].points) for k in owners]
    remark = Remark(*fault[:4], box(np.concatenate(outlines)), *text, as_lines(*outlines), as_lines(*masters))
    return Finding(remark, fault.excess, WHOLE[advice], fault.kind)
