"""What is said of single strokes: missing, out of place, turned, short, heavy, ends, spaces between them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from rumu.assessment.advice import WHOLE, for_stroke
from rumu.assessment.findings import Fault, Finding
from rumu.assessment.missing_remarks import (
    find_missing_hook,
    find_missing_leg,
    find_missing_strokes,
    is_measured,
)
from rumu.assessment.named_strokes import NamedStroke
from rumu.assessment.thresholds import (
    PLACE_DOUBT,
    RemarkThresholds,
    agreed,
    as_lines,
    box,
    contradict,
    severity,
)
from rumu.strokes.correspondence import BluntTips, StrokeMatch
from rumu.strokes.dots import find_lone_stroke
from rumu.strokes.naming import (
    DOT,
    FOLD,
    HORIZONTAL,
    LEFT_FALLING,
    RIGHT_FALLING,
    RING,
    VERTICAL,
    direction_of,
    strokes_title,
    way_of,
)
from rumu.strokes.spacing import StrokeGap, find_gaps
from rumu.values import Bilingual, FloatArray, Remark


def find_stroke_faults(
    every: Sequence[NamedStroke], match: StrokeMatch, limits: RemarkThresholds
) -> Iterator[Finding]:
    """Faults of single strokes, in no order, each where it is worth a remark or half of that."""
    yield from find_missing_strokes(every, match)
    widths = []
    for stroke in every:
        if not is_measured(stroke, match):
            continue
        if stroke.is_hook:
            yield from find_missing_hook(stroke)
            continue
        if stroke.kind == DOT and (small := list(_find_small_dot(stroke))):
            yield from small
            continue
        if stroke.is_on_ink:
            if stroke.stroke.ink.unlike >= limits.unlike * match.enlargement:
                yield from _find_place_faults(stroke)
                yield from _find_length_fault(stroke)
                widths += [(stroke, fault) for fault in _find_width_fault(stroke)]
            yield from _find_end_faults(stroke)
        elif not stroke.stroke.present and len(stroke.legs) > 1:
            yield from find_missing_leg(stroke)
    yield from (fault for _, fault in widths)
    yield from _find_several_widths(widths, limits)
    yield from _find_spacing_fault(find_gaps(match), every, limits)
    yield from _find_blunt_tips(every, match.tips, limits)


def _find_place_faults(named: NamedStroke) -> Iterator[Finding]:
    stroke, limits = named.stroke, named.limits
    shift = _sideways_shift(named)
    size = float(np.hypot(*shift))
    is_there = stroke.ink.moved <= limits.taken_out * stroke.ink.unlike
    if is_there and size >= limits.weak * limits.displaced:
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
    is_turned = abs(stroke.turn) >= limits.weak * least and named.is_laid_well
    if is_turned and named.kind != RING:
        zh, en = _describe_turn(named, stroke.turn)
        way = "clockwise" if stroke.turn > 0 else "anticlockwise"
        yield named.finding(
            Fault(
                "stroke_angle", stroke.turn, "degrees", named.severity("angle", stroke.turn, least),
                abs(stroke.turn) / least,
            ),
            Bilingual(f"斜了 {abs(stroke.turn):.0f}°，{zh}", f"is off by {abs(stroke.turn):.0f}°: {en}"),
            "" if _is_plumb_already(named) else f"{named.kind.zh} {way}",
        )  # fmt: skip


def _sideways_shift(named: NamedStroke) -> FloatArray:
    """The shift of a stroke in cells, without what its length alone does to its middle.

    Each way what its place beside the others, by the pose and by the extent of the whole, and its place in
    the cell agree upon: a stroke that is low for the others may stand high in the cell.
    """
    stroke, limits = named.stroke, named.limits
    along = stroke.line.chord / max(float(np.hypot(*stroke.line.chord)), 1e-9)
    grown = limits.stretched * abs(named.length_change) * stroke.line.length
    shifts = np.stack([named.shift, *named.other_shifts])
    aside = (shifts - np.clip(shifts @ along, -grown, grown)[:, None] * along) * named.cell
    told = np.array([agreed(readings, doubt=PLACE_DOUBT) for readings in aside.T])
    with_its_part = named.explained * told > 0  # is told of the part
    return np.where(with_its_part & (np.abs(told) > np.abs(aside[0])), aside[0], told)


def _is_plumb_already(named: NamedStroke) -> bool:
    """Whether a vertical stands more upright than the master's slanting one: no advice to write it so."""
    across, down = named.stroke.line.chord
    slant = float(np.degrees(np.arctan2(-across, down)))  # above 0 where its foot lies to the left
    return named.kind in (VERTICAL, FOLD) and abs(slant + named.stroke.turn) <= abs(slant)


def _describe_turn(named: NamedStroke, turn: float) -> Bilingual:
    if named.kind == HORIZONTAL:
        return (
            Bilingual("右端太低", "its right end is too low")
            if turn > 0
            else Bilingual("右端太高", "its right end is too high")
        )
    if named.kind in (VERTICAL, FOLD):
        return (
            Bilingual("下端偏左", "its foot is too far left")
            if turn > 0
            else Bilingual("下端偏右", "its foot is too far right")
        )
    if named.kind in (LEFT_FALLING, RIGHT_FALLING):
        return (
            Bilingual("太平", "it is too flat")
            if (turn > 0) == (named.kind == LEFT_FALLING)
            else Bilingual("太陡", "it is too steep")
        )
    return (
        Bilingual("順時針轉了", "turned clockwise")
        if turn > 0
        else Bilingual("逆時針轉了", "turned anticlockwise")
    )


def _find_length_fault(named: NamedStroke) -> Iterator[Finding]:
    change, limits = named.length_change, named.limits
    least = limits.length * (1.0 if any(named.stroke.line.free) else limits.length_unsure)
    least *= 1.0 if named.slenderness > limits.short else limits.length_unsure
    error = named.match.width_error(named.stroke.line)
    least += 2.0 * error / max(named.slenderness, 1e-9)  # a pixel of the coarser picture
    least *= named.match.enlargement**2
    # its ink at the ends, and its length in the cell where that is known, must not say the contrary
    ink = named.stroke.ink
    readings = [change, -ink.lacking]
    if named.framed:
        readings.append((1.0 + change) * named.match.pose.scale - 1.0)
    if contradict(readings, doubt=limits.length_doubt) or (change > 0 and not named.is_laid_well):
        return
    if change > 0 and np.isfinite(ink.unlike):
        change = min(change, -ink.lacking)  # a line that is laid on too much ink looks far too long
    # a line may stop before its ink does, and ink that lies elsewhere is lacking, too: between the two
    line, told = named.stroke.length - 1.0, change
    if change < 0 and np.isfinite(ink.lacking):
        told = (line - max(ink.lacking, 0.0)) / 2
    excess = min(abs(change) / least, max(abs(told), abs(line)) / limits.length)
    if excess < limits.weak or change > limits.longest or named.kind == RING:
        return
    if change < 0 and named.is_cut_off:
        return
    kind, zh, en = ("stroke_long", "長", "too long") if change > 0 else ("stroke_short", "短", "too short")
    yield named.finding(
        Fault(kind, told, "of the master", named.severity("length", change, least), excess),
        Bilingual(f"{zh}了 {abs(told):.0%}", f"is {abs(told):.0%} {en}"),
        named.kind.zh,
    )  # fmt: skip


def _find_small_dot(named: NamedStroke) -> Iterator[Finding]:
    """A dot that stands alone and holds half of the ink that it should, or less."""
    alone, limits = find_lone_stroke(named.match, named.position), named.limits
    if alone is None or alone.area > limits.small_dot:
        return
    size = alone.area - 1.0
    excess = size / (limits.small_dot - 1.0)
    remark = named.remark(
        "stroke_short", size, "of the master", named.severity("length", size, limits.length),
        f"{named.name.zh}太小，只有範本的 {alone.area:.0%}。",
        f"{named.en} is too small, {alone.area:.0%} of the master's.",
    )  # fmt: skip
    shown = replace(remark, region=named.box(alone.outline), outline=as_lines(alone.outline))
    yield Finding(shown, excess, for_stroke("stroke_short", named.kind.zh), named.cause)


def _find_width_fault(named: NamedStroke) -> Iterator[Finding]:
    width, limits = named.stroke.width, named.limits
    least = limits.stroke + named.match.width_error(named.stroke.line)
    if not np.isfinite(width) or width <= 0:
        return
    # beside the master's, and beside the other strokes: where all are heavy this one is not spoken of; and no
    # more than is seen, since who writes a part narrow need not write its strokes thin
    beside_master = agreed(np.log([width, named.stroke.written_width]).tolist(), doubt=0.0)
    size = agreed([beside_master, float(np.log(width / named.match.width))], doubt=0.0)
    if abs(size) < limits.weak * least:
        return
    change = float(np.exp(size)) - 1.0
    ink, is_great = named.stroke.ink, abs(size) > limits.believed
    least_shown = limits.fuller if is_great else limits.somewhat_fuller
    is_seen = is_great or np.isfinite(ink.unlike)
    if is_seen and ink.fuller * np.sign(change) < least_shown * abs(change):
        return
    kind, zh, en = ("stroke_heavy", "粗", "heavier") if change > 0 else ("stroke_thin", "細", "thinner")
    yield named.finding(
        Fault(kind, change, "of the master", named.severity("width", size, least), abs(size) / least),
        Bilingual(f"比範本{zh} {abs(change):.0%}", f"is {abs(change):.0%} {en} than the master's"),
        named.kind.zh,
    )  # fmt: skip


def _find_several_widths(
    widths: Sequence[tuple[NamedStroke, Finding]], limits: RemarkThresholds
) -> Iterator[Finding]:
    """Several strokes that are each much too heavy, or too thin, where the whole is not: told as one."""
    for kind in ("stroke_heavy", "stroke_thin"):
        much = [
            (named, fault)
            for named, fault in widths
            if fault.remark.kind == kind and fault.excess >= limits.much_heavier and named.number
        ]
        lines = {named.stroke.line for named, _ in much}
        found = [(named, fault) for named, fault in much if named.body <= lines]
        numbers = sorted({named.number for named, _ in found if named.number})
        if len(numbers) < limits.several:
            continue
        changes = [abs(fault.remark.size) for _, fault in found]
        outlines = [named.stroke.outline for named, _ in found]
        size = float(np.median([fault.remark.size for _, fault in found]))
        title = strokes_title(numbers)
        zh, en = ("粗", "heavier") if kind == "stroke_heavy" else ("細", "thinner")
        remark = Remark(
            kind, size, "of the master",
            severity("width", float(np.log1p(size)), limits.stroke) * len(numbers) ** 0.25,
            box(np.concatenate(outlines)),
            f"{title.zh}比範本{zh} {min(changes):.0%} 至 {max(changes):.0%}。",
            f"{title.en.capitalize()} are {min(changes):.0%} to {max(changes):.0%} {en} than the master's.",
            as_lines(*outlines),
            as_lines(*(named.master_outline for named, _ in found)),
        )  # fmt: skip
        covers = tuple((named.cause, kind) for named, _ in found)
        excess = float(np.median([fault.excess for _, fault in found]))
        yield Finding(remark, excess, for_stroke(kind, ""), "weight", covers=covers)


def _find_end_faults(named: NamedStroke) -> Iterator[Finding]:
    limits, stroke, legs = named.limits, named.stroke, named.legs
    # beside the stroke's middle and by itself: one that is heavy all along does not begin too lightly
    entry, end = (agreed(ends, doubt=0.0) for ends in (
        (stroke.entry, stroke.entry_alone), (stroke.exit, stroke.exit_alone)
    ))  # fmt: skip
    if legs:  # a part of a bent stroke begins or ends at a corner
        entry = entry if stroke.line is legs[0] else 0.0
        end = end if stroke.line is legs[-1] else 0.0
    coarse = named.match.enlargement**3  # an end is small: an enlarged picture shows it blurred
    cut_short = named.length_change < -limits.length  # then its ends are where its middle should be
    least = coarse * (limits.entry if entry > 0 else limits.faint)
    is_other = limits.most_end >= abs(entry) >= limits.weak * least  # not so where NaN
    if is_other and _is_end_unlike(named, last=False) and (entry > 0 or not cut_short):
        kind, zh, en = ("entry_heavy", "重", "heavily") if entry > 0 else ("entry_light", "輕", "lightly")
        severe = named.severity("entry" if entry > 0 else "end", entry, least)
        yield named.finding_at_end(
            Fault(kind, entry, "of the master", severe, abs(entry) / least),
            Bilingual(f"起筆太{zh}", f"begins too {en}"),
        )  # fmt: skip
    least = coarse * limits.exit
    is_whole = not cut_short and not named.is_cut_off and not named.runs_on(last=True)
    if limits.most_end >= end >= limits.weak * least and is_whole and _is_end_unlike(named, last=True):
        yield named.finding_at_end(
            Fault("exit_blunt", end, "of the master", named.severity("end", end, least), end / least),
            Bilingual("收筆禿鈍，鋒沒有收住", "ends bluntly"),
        )  # fmt: skip


def _is_end_unlike(named: NamedStroke, *, last: bool) -> bool:
    """Whether the ink of its exit, or else of its entry, is another than the master's."""
    unlike = named.stroke.ink.exit if last else named.stroke.ink.entry
    return unlike >= named.limits.unlike_end * named.match.enlargement


def _find_blunt_tips(
    strokes: Sequence[NamedStroke], tips: BluntTips | None, limits: RemarkThresholds
) -> Iterator[Finding]:
    """Most tips too wide: not one stroke but the hand lets the brush down at its tips."""
    if tips is None or tips.lost < limits.weak * limits.tips or tips.blunted < limits.most_tips:
        return
    shown = [
        (k, end)
        for k, end in tips.ends
        if _is_end_unlike(strokes[k], last=bool(end)) and not strokes[k].runs_on(last=bool(end))
    ]
    if len(shown) < max(limits.most_tips * len(tips.ends), 2):
        return
    outlines = [strokes[k].end_outline(last=bool(end)) for k, end in shown]
    masters = [strokes[k].master_outline for k in dict.fromkeys(k for k, _ in shown)]
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
    return named.kind in (HORIZONTAL, VERTICAL)


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
