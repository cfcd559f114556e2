"""What is said of single strokes: missing, out of place, turned, short, heavy, ends, spaces between them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

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
from rumu.strokes.naming import HORIZONTAL, RING, VERTICAL, direction_of, kind_of, name_strokes
from rumu.strokes.spacing import StrokeGap, find_gaps
from rumu.values import Bilingual, BoolArray, FloatArray, IntArray, Registration, Remark


@dataclass(frozen=True, slots=True, eq=False)
class NamedStroke:
    """A stroke with what is needed to speak of it.

    cell: one rms radius of the master in cells. common: share of all strokes, by length, that one of them has
    on average.
    """

    stroke: MatchedStroke
    match: CharacterMatch
    name: Bilingual
    kind: Bilingual
    limits: RemarkThresholds
    cell: float
    common: float

    def remark(self, kind: str, size: float, unit: str, severity: float, *text: str) -> Remark:
        """A remark on the whole stroke; text: in Chinese and in English."""
        zh, en = text
        outline, master = as_lines(self.stroke.outline), as_lines(self.master_outline)
        return Remark(kind, size, unit, severity, self.box(self.stroke.outline), zh, en, outline, master)

    def remark_on_end(self, kind: str, size: float, severity: float, zh: str, en: str) -> Remark:
        """A remark on its exit, or else on its entry, where it is marked."""
        outline = self.end_outline(last=kind == "exit_blunt")
        lines, master = as_lines(outline), as_lines(self.master_outline)
        return Remark(kind, size, "of the master", severity, self.box(outline), zh, en, lines, master)

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

    @property
    def en(self) -> str:
        """The name at the beginning of a sentence."""
        return self.name.en[0].upper() + self.name.en[1:]

    @property
    def slenderness(self) -> float:
        """Length in stroke widths."""
        return self.stroke.line.length / max(self.match.master.width, 1e-9)


def remarks_on_strokes(
    match: CharacterMatch, registration: Registration, limits: RemarkThresholds
) -> Iterator[Remark]:
    """Remarks on single strokes, in no order."""
    width, cell = match.master.width, registration.reference.radius
    names = name_strokes(match.master.lines, width=width)
    every = [
        NamedStroke(s, match, name, kind_of(s.line, width=width), limits, cell, 1.0 / len(names))
        for s, name in zip(match.strokes, names, strict=True)
    ]
    for k, stroke in enumerate(every):
        if not stroke.stroke.present:
            joined = not all(stroke.stroke.line.free)
            is_short = stroke.slenderness < limits.corner
            if not (joined and is_short and stroke.stroke.inked >= limits.inked):
                yield _missing_remark(stroke, k)  # else a corner of which thinning drew no line
            continue
        yield from _partly_missing_remark(stroke, k)
        yield from _place_remarks(stroke)
        yield from _length_remark(stroke)
        yield from _width_remark(stroke)
        yield from _end_remarks(stroke)
    yield from _spacing_remark(find_gaps(match), every, limits)
    yield from _tips_remark(every, match.tips, limits)


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


def _place_remarks(named: NamedStroke) -> Iterator[Remark]:
    stroke, limits = named.stroke, named.limits
    shift = _sideways_shift(named)
    away = float(np.hypot(*shift))
    if away >= limits.displaced:
        zh, en = direction_of(shift)
        size = away * named.cell
        yield named.remark(
            "displaced", size, "of the cell", named.severity("displaced", away, limits.displaced),
            f"{named.name.zh}偏{zh}約 {size:.1%} 格。看清它與鄰筆的距離再落筆。",
            f"{named.en} stands about {size:.1%} of the cell too far to the {en}. Measure its distance to "
            "its neighbour.",
        )  # fmt: skip
    # the shorter a stroke, the worse its direction is known
    least = limits.turn * float(
        np.clip(limits.slender / max(named.slenderness, 1e-9), 1.0, limits.turn_short)
    )
    if abs(stroke.turn) >= least and named.kind != RING:
        way_zh, way_en = _describe_turn(named, stroke.turn)
        yield named.remark(
            "stroke_angle", stroke.turn, "degrees", named.severity("angle", stroke.turn, least),
            f"{named.name.zh}斜了 {abs(stroke.turn):.0f}°，{way_zh}。落筆前先看準範本的方向。",
            f"{named.en} is off by {abs(stroke.turn):.0f}°: {way_en}. Look at the master's direction first.",
        )  # fmt: skip


def _sideways_shift(named: NamedStroke) -> FloatArray:
    """The shift of a stroke, without what its length alone does to its middle."""
    stroke = named.stroke
    along = stroke.line.chord / max(float(np.hypot(*stroke.line.chord)), 1e-9)
    grown = named.limits.stretched * abs(stroke.length - 1.0) * stroke.line.length
    return np.asarray(stroke.shift - np.clip(stroke.shift @ along, -grown, grown) * along)


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


def _length_remark(named: NamedStroke) -> Iterator[Remark]:
    change, limits = named.stroke.length - 1.0, named.limits
    least = limits.length * (1.0 if any(named.stroke.line.free) else limits.length_unsure)
    least *= 1.0 if named.slenderness > limits.short else limits.length_unsure
    error = named.match.width_error(named.stroke.line)
    least += 2.0 * error / max(named.slenderness, 1e-9)  # a pixel of the coarser picture
    if abs(change) < least or named.kind == RING:
        return
    kind, zh, en, do_zh, do_en = (
        ("stroke_long", "長", "too long", "提早收筆。", "End it earlier.")
        if change > 0
        else ("stroke_short", "短", "too short", "行筆到位再收。", "Carry it to its end.")
    )
    yield named.remark(
        kind, change, "of the master", named.severity("length", change, least),
        f"{named.name.zh}{zh}了 {abs(change):.0%}。{do_zh}",
        f"{named.en} is {abs(change):.0%} {en}. {do_en}",
    )  # fmt: skip


def _width_remark(named: NamedStroke) -> Iterator[Remark]:
    ratio = named.stroke.width / named.match.width
    least = named.limits.stroke + named.match.width_error(named.stroke.line)
    if not np.isfinite(ratio) or abs(np.log(ratio)) < least:
        return
    change = ratio - 1.0
    kind, zh, en, do_zh, do_en = (
        ("stroke_heavy", "粗", "heavier", "行筆稍提。", "Lift the brush a little.")
        if change > 0
        else ("stroke_thin", "細", "thinner", "行筆按得實些。", "Press more firmly.")
    )
    yield named.remark(
        kind, change, "of the master", named.severity("width", float(np.log(ratio)), least),
        f"{named.name.zh}比別的筆畫{zh} {abs(change):.0%}。{do_zh}",
        f"{named.en} is {abs(change):.0%} {en} than the other strokes are. {do_en}",
    )  # fmt: skip


def _tips_remark(
    strokes: list[NamedStroke], tips: BluntTips | None, limits: RemarkThresholds
) -> Iterator[Remark]:
    """Most tips too wide: not one stroke but the hand lets the brush down at its tips."""
    if tips is None or tips.lost < limits.tips or tips.blunted < limits.most_tips:
        return
    outlines = [strokes[k].end_outline(last=bool(end)) for k, end in tips.ends]
    lost = min(tips.lost, 1.0)  # a tip that swells has lost all of its taper, not more
    yield Remark(
        "exit_blunt", lost, "of the master", severity("tips", tips.lost, limits.tips),
        box(np.concatenate(outlines)),
        f"筆鋒多禿鈍：{len(outlines)} 處筆鋒失去約 {lost:.0%} 的尖銳。起收筆時漸漸提鋒。",
        f"The tips are blunt: {len(outlines)} of them have lost about {lost:.0%} of their taper. "
        "Lift the brush little by little.",
        as_lines(*outlines),
    )  # fmt: skip


def _end_remarks(named: NamedStroke) -> Iterator[Remark]:
    limits, entry, end = named.limits, named.stroke.entry, named.stroke.exit
    coarse = named.match.enlargement**2  # an end is small: an enlarged picture shows it blurred
    least = coarse * (limits.entry if entry > 0 else limits.faint)
    if abs(entry) >= least:  # not so where it is NaN
        kind, zh, en, do_zh, do_en = (
            ("entry_heavy", "重", "heavy", "落筆輕些，再按下去。", "Set the brush down more lightly.")
            if entry > 0
            else ("entry_light", "輕", "light", "落筆先頓一頓。", "Press as you set the brush down.")
        )
        yield named.remark_on_end(
            kind, entry, named.severity("end", entry, least),
            f"{named.name.zh}起筆太{zh}，寬度差 {abs(entry):.0%}。{do_zh}",
            f"{named.en} begins too {en}, by {abs(entry):.0%} of its width. {do_en}",
        )  # fmt: skip
    if end >= coarse * limits.exit:
        yield named.remark_on_end(
            "exit_blunt", end, named.severity("end", end, limits.exit),
            f"{named.name.zh}收筆禿鈍，比範本寬 {end:.0%}。收筆時漸漸提鋒。",
            f"{named.en} ends bluntly, {end:.0%} wider than the master's. Lift the brush little by little.",
        )  # fmt: skip


def _spacing_remark(
    gaps: tuple[StrokeGap, ...], strokes: list[NamedStroke], limits: RemarkThresholds
) -> Iterator[Remark]:
    """Spaces are uneven when several differ from the master's in different ways."""
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
    yield Remark(
        "spacing", worst.change, "of the master", severity("spacing", spread, least), box(points),
        f"筆畫間距不勻：{a.name.zh}與{b.name.zh}之間{zh}了 {abs(worst.change):.0%}。先看好留白再落筆。",
        f"The spaces are uneven: that between {a.name.en} and {b.name.en} is {abs(worst.change):.0%} too "
        f"{en}. Look at the white before you write.",
        as_lines(a.stroke.outline, b.stroke.outline),
    )  # fmt: skip
