"""What is said of single strokes: missing, out of place, turned, short, heavy, ends, spaces between them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rumu.assessment.advice import WHOLE, for_stroke
from rumu.assessment.findings import Fault, Finding
from rumu.assessment.thresholds import (
    Box,
    RemarkThresholds,
    as_lines,
    box,
    ink_severity,
    severity,
)
from rumu.strokes.correspondence import BluntTips, CharacterMatch
from rumu.strokes.measures import MatchedStroke
from rumu.strokes.naming import HORIZONTAL, RING, VERTICAL, direction_of, kind_of, name_strokes, way_of
from rumu.strokes.spacing import StrokeGap, find_gaps
from rumu.values import Bilingual, BoolArray, FloatArray, IntArray, Registration, Remark

_ENDS = {
    HORIZONTAL: (Bilingual("左端", "left end"), Bilingual("右端", "right end")),
    VERTICAL: (Bilingual("上端", "top"), Bilingual("下端", "foot")),
}
_OTHER_ENDS = (Bilingual("起筆處", "beginning"), Bilingual("收筆處", "end"))


@dataclass(frozen=True, slots=True, eq=False)
class NamedStroke:
    """A stroke with what is needed to speak of it.

    position: among the master's. shift: (x right, y DOWN), rms radii, without what the parts of the character
    explain. cell: one rms radius of the master in cells. common: share of all strokes, by length, that one of
    them has on average. number: in the order of writing, from 1; None where it is not known.
    """

    stroke: MatchedStroke
    match: CharacterMatch
    name: Bilingual
    kind: Bilingual
    limits: RemarkThresholds
    position: int
    shift: FloatArray
    cell: float
    common: float
    number: int | None = None

    def remark(self, kind: str, size: float, unit: str, severity: float, *text: str) -> Remark:
        """A remark on the whole stroke; text: in Chinese and in English."""
        zh, en = text
        outline, master = as_lines(self.stroke.outline), as_lines(self.master_outline)
        region = self.box(self.stroke.outline)
        return Remark(kind, size, unit, severity, region, zh, en, outline, master, self.number)

    def finding(self, fault: Fault, said: Bilingual, advice: str) -> Finding:
        """A finding on the stroke. said: its predicate. advice: kind of stroke that what to do depends on."""
        kind, size, unit, severe, excess = fault
        remark = self.remark(kind, size, unit, severe, f"{self.name.zh}{said.zh}。", f"{self.en} {said.en}.")
        return Finding(remark, excess, for_stroke(kind, advice), self.cause, said)

    def finding_at_end(self, fault: Fault, said: Bilingual) -> Finding:
        """The same of its exit, or else of its entry, where it is marked."""
        outline = self.end_outline(last=fault.kind == "exit_blunt")
        whole = self.finding(fault, said, self.kind.zh)
        at_end = replace(whole.remark, region=self.box(outline), outline=as_lines(outline))
        return replace(whole, remark=at_end)

    @property
    def cause(self) -> str:
        """All that is said of one stroke is told together."""
        return f"stroke {self.position}"

    @property
    def master_outline(self) -> FloatArray:
        """(n, 2): the stroke on the master's picture, in fractions of it."""
        return self.match.framed_master.on_picture(self.stroke.line.points)

    def severity(self, fault: str, size: float, least: float) -> float:
        """A fault in a long stroke is graver than the same one in a dot."""
        return severity(fault, size, least, weight=self.stroke.weight / self.common)

    def box(self, outline: FloatArray) -> Box:
        """The box of some of its outline, with the margin of a remark."""
        return box(outline, margin=self.limits.margin * self.match.master.width * self.cell)

    def end_outline(self, *, last: bool) -> FloatArray:
        """The outline of the first or the last third of the stroke."""
        line = self.stroke.outline
        return line[len(line) * 2 // 3 :] if last else line[: len(line) - len(line) * 2 // 3]

    def end_word(self, point: int) -> Bilingual:
        """What the end of it is called that is nearer to one of the master's points."""
        own = np.flatnonzero(self.match.master.points.owner == self.position)
        last = bool(np.searchsorted(own, point) * 2 >= len(own))
        return _ENDS.get(self.kind, _OTHER_ENDS)[int(last)]

    @property
    def en(self) -> str:
        """The name at the beginning of a sentence."""
        return self.name.en[0].upper() + self.name.en[1:]

    @property
    def slenderness(self) -> float:
        """Length in stroke widths."""
        return self.stroke.line.length / max(self.match.master.width, 1e-9)


def name_all(
    match: CharacterMatch, registration: Registration, limits: RemarkThresholds, *, explained: FloatArray
) -> tuple[NamedStroke, ...]:
    """The strokes of a match with their names; explained: (n, 2) how far parts move the master's points."""
    width, cell = match.master.width, registration.reference.radius
    names = name_strokes(match.master.lines, width=width)
    squeezed = 0.0 if match.squeeze is None else match.squeeze.apply(match.places) - match.places
    left = squeezed - explained  # the strokes were measured against a squeezed master
    owner = match.master.points.owner
    return tuple(
        NamedStroke(
            stroke, match, name, kind_of(stroke.line, width=width), limits, k,
            stroke.shift + left[owner == k].mean(axis=0), cell, 1.0 / len(names),
        )
        for k, (stroke, name) in enumerate(zip(match.strokes, names, strict=True))
    )  # fmt: skip


def find_stroke_faults(
    every: Sequence[NamedStroke], match: CharacterMatch, limits: RemarkThresholds
) -> Iterator[Finding]:
    """Faults of single strokes, in no order, each where it is worth a remark or half of that."""
    for k, stroke in enumerate(every):
        if not stroke.stroke.present:
            joined = not all(stroke.stroke.line.free)
            is_short = stroke.slenderness < limits.corner
            if not (joined and is_short and stroke.stroke.inked >= limits.inked):
                yield Finding(_missing_remark(stroke, k), 1.0, cause=stroke.cause)
            continue  # else a corner of which thinning drew no line
        yield from (Finding(r, 1.0, cause=stroke.cause) for r in _partly_missing_remark(stroke, k))
        yield from _find_place_faults(stroke)
        yield from _find_length_fault(stroke)
        yield from _find_width_fault(stroke)
        yield from _find_end_faults(stroke)
    yield from _find_spacing_fault(find_gaps(match), every, limits)
    yield from _find_blunt_tips(every, match.tips, limits)


def _ink_share(match: CharacterMatch, own: BoolArray | IntArray) -> float:
    """Share of the master's ink in some of its points."""
    radius = match.master.points.radius
    return float(radius[own].sum() / radius.sum())


def _missing_remark(named: NamedStroke, k: int) -> Remark:
    share = _ink_share(named.match, named.match.master.points.owner == k)
    return named.remark(
        "missing", share, "of the ink", ink_severity("missing", share),
        f"漏寫了{named.name.zh}，約佔全字墨跡的 {share:.0%}。對照範本，補上這一筆。",
        f"{named.en} is missing, about {share:.0%} of the ink. Write this stroke too.",
    )  # fmt: skip


def _partly_missing_remark(named: NamedStroke, k: int) -> Iterator[Remark]:
    match, limits = named.match, named.limits
    own = np.flatnonzero(match.master.points.owner == k)
    gone = _longest_run(~match.covered[own])
    if len(gone) < limits.missing * len(own):
        return
    if len(gone) * match.master.points.spacing < limits.missing_run * match.master.width:
        return
    share = _ink_share(match, own[gone])
    outline = named.stroke.outline[gone]
    yield Remark(
        "missing", share, "of the ink", ink_severity("part missing", share), named.box(outline),
        f"{named.name.zh}缺了一段，約佔全字墨跡的 {share:.0%}。這一筆要寫足。",
        f"A part of {named.name.en} is missing, about {share:.0%} of the ink. Write this stroke out in full.",
        as_lines(outline),
    )  # fmt: skip


def _longest_run(flags: BoolArray) -> IntArray:
    """Indices of the longest run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(int), [0]])))
    if len(edges) == 0:
        return np.zeros(0, int)
    starts, stops = edges[::2], edges[1::2]
    k = int((stops - starts).argmax())
    return np.arange(starts[k], stops[k])


def _find_place_faults(named: NamedStroke) -> Iterator[Finding]:
    stroke, limits = named.stroke, named.limits
    shift = _sideways_shift(named) * named.cell
    size = float(np.hypot(*shift))
    if size >= limits.weak * limits.displaced:
        zh = direction_of(shift).zh
        yield named.finding(
            Fault(
                "displaced", size, "of the cell", named.severity("displaced", size, limits.displaced),
                size / limits.displaced,
            ),
            Bilingual(f"偏{zh}約 {size:.0%} 格", f"stands {way_of(shift)}, by about {size:.0%} of the cell"),
            named.kind.zh,
        )  # fmt: skip
    # the shorter a stroke, the worse its direction is known
    least = limits.turn * float(
        np.clip(limits.slender / max(named.slenderness, 1e-9), 1.0, limits.turn_short)
    )
    if abs(stroke.turn) >= limits.weak * least and named.kind != RING:
        zh, en = _describe_turn(named, stroke.turn)
        way = "clockwise" if stroke.turn > 0 else "anticlockwise"
        yield named.finding(
            Fault(
                "stroke_angle", stroke.turn, "degrees", named.severity("angle", stroke.turn, least),
                abs(stroke.turn) / least,
            ),
            Bilingual(f"斜了 {abs(stroke.turn):.0f}°，{zh}", f"is off by {abs(stroke.turn):.0f}°: {en}"),
            f"{named.kind.zh} {way}",
        )  # fmt: skip


def _sideways_shift(named: NamedStroke) -> FloatArray:
    """The shift of a stroke, without what its length alone does to its middle."""
    stroke = named.stroke
    along = stroke.line.chord / max(float(np.hypot(*stroke.line.chord)), 1e-9)
    grown = named.limits.stretched * abs(stroke.length - 1.0) * stroke.line.length
    return np.asarray(named.shift - np.clip(named.shift @ along, -grown, grown) * along)


def _describe_turn(named: NamedStroke, turn: float) -> Bilingual:
    if named.kind == HORIZONTAL:
        return (
            Bilingual("右端太低", "its right end is too low")
            if turn > 0
            else Bilingual("右端太高", "its right end is too high")
        )
    if named.kind == VERTICAL:
        return (
            Bilingual("下端偏左", "its foot is too far left")
            if turn > 0
            else Bilingual("下端偏右", "its foot is too far right")
        )
    return (
        Bilingual("順時針轉了", "turned clockwise")
        if turn > 0
        else Bilingual("逆時針轉了", "turned anticlockwise")
    )


def _find_length_fault(named: NamedStroke) -> Iterator[Finding]:
    change, limits = named.stroke.length - 1.0, named.limits
    least = limits.length * (1.0 if any(named.stroke.line.free) else limits.length_unsure)
    least *= 1.0 if named.slenderness > limits.short else limits.length_unsure
    error = named.match.width_error(named.stroke.line)
    least += 2.0 * error / max(named.slenderness, 1e-9)  # a pixel of the coarser picture
    least *= named.match.enlargement**2
    if abs(change) < limits.weak * least or named.kind == RING:
        return
    kind, zh, en = ("stroke_long", "長", "too long") if change > 0 else ("stroke_short", "短", "too short")
    yield named.finding(
        Fault(
            kind, change, "of the master", named.severity("length", change, least), abs(change) / least
        ),
        Bilingual(f"{zh}了 {abs(change):.0%}", f"is {abs(change):.0%} {en}"),
        named.kind.zh,
    )  # fmt: skip


def _find_width_fault(named: NamedStroke) -> Iterator[Finding]:
    ratio, limits = named.stroke.width / named.match.width, named.limits
    least = limits.stroke + named.match.width_error(named.stroke.line)
    if not np.isfinite(ratio) or not limits.weak * least <= abs(np.log(ratio)) <= limits.believed:
        return
    change, size = ratio - 1.0, float(np.log(ratio))
    kind, zh, en = ("stroke_heavy", "粗", "heavier") if change > 0 else ("stroke_thin", "細", "thinner")
    yield named.finding(
        Fault(kind, change, "of the master", named.severity("width", size, least), abs(size) / least),
        Bilingual(f"比別的筆畫{zh} {abs(change):.0%}", f"is {abs(change):.0%} {en} than the others"),
        named.kind.zh,
    )  # fmt: skip


def _find_end_faults(named: NamedStroke) -> Iterator[Finding]:
    limits, entry, end = named.limits, named.stroke.entry, named.stroke.exit
    coarse = named.match.enlargement**3  # an end is small: an enlarged picture shows it blurred
    cut_short = named.stroke.length < 1.0 - limits.length  # then its ends are where its middle should be
    least = coarse * (limits.entry if entry > 0 else limits.faint)
    if abs(entry) >= limits.weak * least and (entry > 0 or not cut_short):  # not so where it is NaN
        kind, zh, en = ("entry_heavy", "重", "heavily") if entry > 0 else ("entry_light", "輕", "lightly")
        yield named.finding_at_end(
            Fault(kind, entry, "of the master", named.severity("end", entry, least), abs(entry) / least),
            Bilingual(f"起筆太{zh}", f"begins too {en}"),
        )  # fmt: skip
    least = coarse * limits.exit
    if end >= limits.weak * least and not cut_short:
        yield named.finding_at_end(
            Fault("exit_blunt", end, "of the master", named.severity("end", end, least), end / least),
            Bilingual("收筆禿鈍，鋒沒有收住", "ends bluntly"),
        )  # fmt: skip


def _find_blunt_tips(
    strokes: Sequence[NamedStroke], tips: BluntTips | None, limits: RemarkThresholds
) -> Iterator[Finding]:
    """Most tips too wide: not one stroke but the hand lets the brush down at its tips."""
    if tips is None or tips.lost < limits.weak * limits.tips or tips.blunted < limits.most_tips:
        return
    outlines = [strokes[k].end_outline(last=bool(end)) for k, end in tips.ends]
    masters = [strokes[k].master_outline for k in dict.fromkeys(k for k, _ in tips.ends)]
    lost = min(tips.lost, 1.0)  # a tip that swells has lost all of its taper, not more
    remark = Remark(
        "exit_blunt", lost, "of the master", severity("tips", tips.lost, limits.tips),
        box(np.concatenate(outlines)),
        f"筆鋒多禿鈍，有 {len(outlines)} 處不夠尖。",
        f"The tips are blunt, {len(outlines)} of them.",
        as_lines(*outlines),
        as_lines(*masters),
    )  # fmt: skip
    yield Finding(remark, tips.lost / limits.tips, WHOLE["tips"], "tips")


def _is_straight(named: NamedStroke) -> bool:
    """Whether it is level or upright; of the white beside a dot nobody speaks."""
    return named.kind.zh[:1] in ("橫", "豎")


def _find_spacing_fault(
    gaps: tuple[StrokeGap, ...], strokes: Sequence[NamedStroke], limits: RemarkThresholds
) -> Iterator[Finding]:
    """Spaces are uneven when several differ from the master's in different ways."""
    gaps = tuple(
        gap for gap in gaps if _is_straight(strokes[gap.first]) and _is_straight(strokes[gap.second])
    )
    odd = [gap for gap in gaps if abs(gap.change) >= limits.gap]
    if len(gaps) < 2 or not odd:
        return
    spread = float(np.std([gap.change for gap in gaps]))
    least = limits.uneven * limits.gap
    if spread < least:
        return
    worst = max(odd, key=lambda gap: abs(gap.change))
    a, b = strokes[worst.first], strokes[worst.second]
    zh, en = ("寬", "wide") if worst.change > 0 else ("窄", "narrow")
    points = np.concatenate([a.stroke.outline, b.stroke.outline])
    remark = Remark(
        "spacing", worst.change, "of the master", severity("spacing", spread, least), box(points),
        f"筆畫間距不勻：{a.name.zh}與{b.name.zh}之間{zh}了 {abs(worst.change):.0%}。",
        f"The spaces are uneven: that between {a.name.en} and {b.name.en} is {abs(worst.change):.0%} too "
        f"{en}.",
        as_lines(a.stroke.outline, b.stroke.outline),
        as_lines(a.master_outline, b.master_outline),
    )  # fmt: skip
    yield Finding(remark, spread / least, WHOLE["spacing"], "spacing")
