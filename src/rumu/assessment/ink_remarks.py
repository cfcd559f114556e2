"""What is said of the ink: torn edges, white run shut, open boxes, blots, what sticks out, dry, pale ink."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from rumu.assessment.advice import BEGINNING, WHOLE, for_stroke
from rumu.assessment.findings import Finding
from rumu.assessment.ink_measures import InkMeasures, InkPatch, StickingOut
from rumu.assessment.named_strokes import NamedStroke
from rumu.assessment.thresholds import Box, RemarkThresholds, as_lines, box, ink_severity, severity
from rumu.strokes.correspondence import StrokeMatch, to_master_cell
from rumu.strokes.naming import direction_of, place_of
from rumu.values import Bilingual, FloatArray, Remark

_AHEAD = 1.0
"""Least cotangent of the angle between a stroke's way and that to the ink which sticks out at its end."""
_END = 0.2
"""Share of a stroke that is its end, where a lump of ink was pressed there and is no blot."""
_IN_CELL = 0.25
"""Least share of how far an end sticks out that it must stick out in the cell, too, where that is known."""
_WINDOW = 0.12
"""Half the side of the box about the worst place of an edge, fractions of the picture."""


def find_ink_faults(
    ink: InkMeasures,
    strokes: Sequence[NamedStroke],
    match: StrokeMatch,
    limits: RemarkThresholds,
) -> Iterator[Finding]:
    """Faults of the ink, each where it is worth a remark or half of that."""
    dry = ink.has_shades and ink.bare >= limits.bare
    yield from _find_edge_fault(ink, limits, dry=dry)
    if not dry:
        for patch in ink.patches:
            if not patch.attached or patch.share > ink.unfound:  # else it may be ink of what was not found
                yield from _find_blot(patch, strokes, match, limits)
        yield from _find_extra_strokes(ink, limits)
    if dry:
        remark = Remark(
            "dry", ink.bare, "of the ink", severity("dry", ink.bare, limits.bare), None,
            f"枯筆露白，筆畫裡約有 {ink.bare:.0%} 沒有墨。",
            f"The brush ran dry: about {ink.bare:.0%} of the strokes is bare.",
        )  # fmt: skip
        yield Finding(remark, ink.bare / limits.bare, WHOLE["dry"], "edge")
    yield from _find_filled_white(ink, limits)
    yield from _find_open_box(ink, strokes, limits)
    blots = [
        box(patch.outline)
        for patch in ink.patches
        if patch.slender < limits.round and not _is_stroke(patch, strokes, match, limits)
    ]
    yield from _find_sticking_out(ink, strokes, match, limits, blots)
    yield from _find_paleness(ink, limits)


def _find_edge_fault(ink: InkMeasures, limits: RemarkThresholds, *, dry: bool) -> Iterator[Finding]:
    """Edges that tremble, or that are torn; dry: then bare streaks make them so."""
    least = limits.tremor * (1.0 if ink.torn >= limits.frayed else limits.smooth)
    much = ink.rough - 1.0
    if not dry and ink.tremor >= limits.weak * least and much >= limits.rougher:
        remark = Remark(
            "rough", much, "of the master", severity("rough", ink.tremor, least), None,
            f"筆畫邊緣抖動，比範本多 {much:.0%}。",
            f"The edges tremble, {much:.0%} more than the master's.",
        )  # fmt: skip
        yield Finding(remark, ink.tremor / least, WHOLE["rough"], "edge")
    if dry or ink.torn < limits.weak * limits.torn:
        return
    region, zh, en = None, "", ""
    if ink.torn_at is not None:
        x, y = ink.torn_at
        region = box(np.array([[x - _WINDOW, y - _WINDOW], [x + _WINDOW, y + _WINDOW]]))
        place = place_of(ink.torn_at)
        zh, en = f"，{place.zh}最明顯", f", most of all at the {place.en}"
    remark = Remark(
        "rough", ink.torn, "of the master", severity("torn", ink.torn, limits.torn), region,
        f"墨邊毛糙破碎，不光潔{zh}。", f"The edges are frayed and torn{en}.",
    )  # fmt: skip
    yield Finding(remark, ink.torn / limits.torn, WHOLE["torn"], "edge")


def _distances(patch: InkPatch, match: StrokeMatch) -> FloatArray:
    """(n,) how far the strokes' points lie from the middle of a patch, in fractions of the picture."""
    return np.asarray(np.hypot(*(match.framed.on_picture(match.moved) - patch.outline.mean(axis=0)).T))


def _is_stroke(
    patch: InkPatch, strokes: Sequence[NamedStroke], match: StrokeMatch, limits: RemarkThresholds
) -> bool:
    """Whether what touches a stroke is the stroke itself, out of its place or too long."""
    if not patch.attached:
        return False
    nearest = int(_distances(patch, match).argmin())
    named = strokes[int(match.master.points.owner[nearest])]
    away = float(np.hypot(*named.shift)) * named.cell
    return away >= limits.off * limits.displaced or named.stroke.length - 1.0 >= limits.off * limits.length


def _find_blot(
    patch: InkPatch, strokes: Sequence[NamedStroke], match: StrokeMatch, limits: RemarkThresholds
) -> Iterator[Finding]:
    """Round ink that belongs to none of the strokes."""
    if (
        patch.slender >= limits.round
        or patch.share < limits.blot
        or _is_stroke(patch, strokes, match, limits)
    ):
        return
    region = box(patch.outline)
    zh, en = _place_of_box(region)
    end = _pressed_end(patch, strokes, match) if patch.attached else None
    if end is not None:
        text = end
    elif patch.attached:
        text = Bilingual(f"{zh}有一團墨漬。", f"There is a blot at the {en}.")
    else:
        text = Bilingual(f"{zh}濺了一滴墨。", f"A drop of ink fell on the paper at the {en}.")
    severe, outline = ink_severity("blot", patch.share), as_lines(patch.outline)
    remark = Remark("blot", patch.share, "of the ink", severe, region, *text, outline)
    yield Finding(remark, patch.share / limits.blot, WHOLE["blot" if end is None else "pressed"], "blot")


def _pressed_end(patch: InkPatch, strokes: Sequence[NamedStroke], match: StrokeMatch) -> Bilingual | None:
    """What is said where the ink lies at a free end of a stroke, which was pressed there; else None."""
    owner = match.master.points.owner
    on_ink = np.array([named.is_on_ink for named in strokes])[owner]
    away = _distances(patch, match)
    nearest = int(np.where(on_ink, away, np.inf).argmin())
    named, own = strokes[int(owner[nearest])], np.flatnonzero(owner == owner[nearest])
    share = float(np.searchsorted(own, nearest)) / max(len(own) - 1, 1)
    reach = float(np.ptp(patch.outline, axis=0).max()) / 2 + match.master.width * named.cell
    if not on_ink[nearest] or away[nearest] > reach or _END < share < 1.0 - _END:
        return None
    if not named.stroke.line.free[int(named.is_nearer_exit(nearest))]:
        return None
    zh, en = named.end_word(nearest)
    return Bilingual(
        f"{named.name.zh}{zh}按得太重，積成一團墨。",
        f"{named.en} is pressed so hard at its {en} that the ink has run into a lump.",
    )


def _find_extra_strokes(ink: InkMeasures, limits: RemarkThresholds) -> Iterator[Finding]:
    """Long ink that belongs to none of the strokes, where there is more of it than what strokes did not find.

    Such a stroke stands elsewhere, and the ink is its own. What lies along another stroke is its edge.
    """
    extra = [
        patch
        for patch in ink.patches
        if patch.slender >= limits.round
        and not patch.link
        and patch.share >= limits.extra
        and (patch.reach >= limits.extra_reach or not patch.attached)
    ]
    if sum(patch.share for patch in extra) - ink.unfound < limits.extra:
        return
    for patch in extra:
        region = box(patch.outline)
        zh, en = _place_of_box(region)
        remark = Remark(
            "extra", patch.share, "of the ink", ink_severity("extra", patch.share), region,
            f"{zh}多出一筆，約佔全字墨跡的 {patch.share:.0%}。",
            f"There is a stroke too many at the {en}, about {patch.share:.0%} of the ink.",
            as_lines(patch.outline),
        )  # fmt: skip
        yield Finding(remark, patch.share / limits.extra, WHOLE["extra"], "extra")


def _place_of_box(region: Box) -> Bilingual:
    """Where the middle of a box lies."""
    return place_of(np.array([region[0] + region[2], region[1] + region[3]]) / 2)


def _find_filled_white(ink: InkMeasures, limits: RemarkThresholds) -> Iterator[Finding]:
    """White that ran shut; heavy strokes and this are one cause."""
    if not ink.filled or ink.filled[0].lost < limits.weak * limits.filled:
        return
    shut = [white for white in ink.filled if white.lost >= limits.filled] or list(ink.filled[:1])
    points = np.concatenate([white.outline for white in shut])
    zh, en = place_of((shut[0].outline.min(axis=0) + shut[0].outline.max(axis=0)) / 2)
    text = (
        (f"{zh}的留白糊住了。", f"The white at the {en} has run shut.")
        if len(shut) == 1
        else (
            f"有 {len(shut)} 處留白糊住了，{zh}最甚。",
            f"The white has run shut in {len(shut)} places, most of all at the {en}.",
        )
    )
    size = shut[0].lost * float(np.sqrt(len(shut)))
    remark = Remark(
        "filled", shut[0].lost, "of the master", severity("filled", size, limits.filled), box(points), *text,
        as_lines(*(white.outline for white in shut)),
    )  # fmt: skip
    yield Finding(remark, shut[0].lost / limits.filled, WHOLE["filled"], "weight")


def _find_open_box(
    ink: InkMeasures, strokes: Sequence[NamedStroke], limits: RemarkThresholds
) -> Iterator[Finding]:
    """A box such as 口 that is not closed at a corner."""
    if not ink.opened or ink.opened[0].gap < limits.weak * limits.open:
        return
    opening = ink.opened[0]
    size = opening.across * strokes[0].cell
    box_at, corner = place_of(opening.box), direction_of(opening.towards)
    remark = Remark(
        "open", size, "of the cell", severity("open", opening.gap, limits.open), box(opening.outline),
        f"{box_at.zh}的框，{corner.zh}{'角' if len(corner.zh) > 1 else '邊'}沒有封口，缺口約 {size:.0%} 格。",
        f"The box at the {box_at.en} is not closed: its {corner.en} has a gap of {size:.0%} of the cell.",
        as_lines(opening.outline),
    )  # fmt: skip
    yield Finding(remark, opening.gap / limits.open, WHOLE["open"])


def _find_sticking_out(
    ink: InkMeasures,
    strokes: Sequence[NamedStroke],
    match: StrokeMatch,
    limits: RemarkThresholds,
    blots: Sequence[Box],
) -> Iterator[Finding]:
    """Ends of strokes that reach far beyond the master's; blots: what is none."""
    for patch in ink.sticking_out[: limits.at_most]:
        x, y = patch.outline.mean(axis=0)
        if any(x0 <= x <= x1 and y0 <= y <= y1 for x0, y0, x1, y1 in blots):
            continue
        owner = int(((match.moved - patch.middle) ** 2).sum(axis=1).argmin())
        named = strokes[int(match.master.points.owner[owner])]
        is_short = named.length_change <= -limits.length  # then the ink is its own, turned or moved
        if named.is_on_ink and patch.distance * named.cell >= limits.sticks_out and not is_short:
            size = _beyond_end(patch, named, owner)
            if size >= limits.sticks_out:
                yield _sticking_out(patch, named, size, owner, limits)


def _beyond_end(patch: StickingOut, named: NamedStroke, nearest: int) -> float:
    """How far ink lies beyond an end of the master's stroke, in cells; 0 where it lies beside it.

    nearest: the one of the master's points that lies next to it. What lies beside, or at a corner, is
    a stroke out of place.
    Where the cell is known it must lie beyond that end in the cell, too.
    """
    match = named.match
    points = match.master.points
    own = np.flatnonzero(points.owner == named.position)
    last = named.is_nearer_exit(nearest)
    line = named.stroke.line
    if len(own) < 2 or any(line is leg for leg in (named.legs[:-1] if last else named.legs[1:])):
        return 0.0
    path = points.xy[own] if last else points.xy[own][::-1]
    way = path[-1] - path[max(len(path) - 4, 0)]
    way = way / max(float(np.hypot(*way)), 1e-9)
    off = patch.tip - path[-1]
    beyond = float(off @ way)
    if beyond < _AHEAD * abs(off[0] * way[1] - off[1] * way[0]):
        return 0.0
    in_cell = to_master_cell(patch.tip[None], match.framed, match.framed_master)[0] - path[-1]
    if named.framed and float(in_cell @ way) < _IN_CELL * beyond:
        return 0.0
    return patch.distance * beyond / max(float(np.hypot(*off)), 1e-9) * named.cell


def _sticking_out(
    patch: StickingOut, named: NamedStroke, size: float, nearest: int, limits: RemarkThresholds
) -> Finding:
    end = named.end_word(nearest)
    predicate = Bilingual(
        f"{end.zh}出頭約 {size:.0%} 格", f"sticks out at its {end.en} by about {size:.0%} of the cell"
    )
    remark = named.remark(
        "sticks_out", size, "of the cell", named.severity("sticks_out", size, limits.sticks_out),
        f"{named.name.zh}{predicate.zh}。", f"{named.en} {predicate.en}.",
    )  # fmt: skip
    advice = named.kind.zh if named.is_nearer_exit(nearest) else BEGINNING
    return Finding(remark, size / limits.sticks_out, for_stroke("sticks_out", advice), named.cause, predicate)


def _find_paleness(ink: InkMeasures, limits: RemarkThresholds) -> Iterator[Finding]:
    """Ink paler than the darkest of its own page; or all of it much paler than a photograph would show it."""
    if not ink.has_shades:
        return
    overall = 1.0 - ink.darkness
    paleness = overall if overall >= limits.paler else ink.paleness
    if paleness < limits.pale:
        return
    remark = Remark(
        "pale", -paleness, "of the master", severity("pale", paleness, limits.pale), None,
        f"墨色淡了 {paleness:.0%}，不如範本沉著。",
        f"The ink is {paleness:.0%} too pale.",
    )  # fmt: skip
    yield Finding(remark, paleness / limits.pale, WHOLE["pale"], "pale")
