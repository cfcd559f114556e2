"""Comparison -> what a teacher would say: where, what, how much, what to do, in Chinese and English.

Every remark comes from a measurement and carries its size; nothing is said below the size at which a
person would see it. What the whole character does is said once and not again of each stroke.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from rumu.assessment.ink_measures import InkMeasures, measure_ink
from rumu.assessment.stroke_remarks import remarks_on_strokes
from rumu.assessment.thresholds import RemarkThresholds, as_lines, box, ink_severity, severity
from rumu.strokes.correspondence import CharacterMatch, MasterStrokes, match_strokes
from rumu.strokes.naming import direction_of, place_of
from rumu.values import FloatArray, Registration, Remark, Surface

COARSE_TREMOR = 1.5
"""Power of a picture's enlargement with which the threshold of tremor grows: enlarged edges are rough."""


def write_remarks(
    copy: Surface,
    registration: Registration,
    master: MasterStrokes,
    *,
    thresholds: RemarkThresholds | None = None,
) -> tuple[Remark, ...]:
    """At most five remarks on a copy that is registered to its master, the worst first."""
    return choose_worst(find_faults(copy, registration, master, thresholds=thresholds), thresholds=thresholds)


def find_faults(
    copy: Surface,
    registration: Registration,
    master: MasterStrokes,
    *,
    thresholds: RemarkThresholds | None = None,
) -> tuple[Remark, ...]:
    """Every fault of a copy that is large enough for a remark, the worst first."""
    limits = thresholds or RemarkThresholds()
    strokes = match_strokes(copy, registration, master)
    ink = measure_ink(strokes, copy, master)
    found = [
        *_remarks_on_whole(strokes, registration, limits),
        *_remark_on_parts(strokes, limits),
        *remarks_on_strokes(strokes, registration, limits),
        *_remarks_on_ink(ink, replace(limits, tremor=limits.tremor * strokes.enlargement**COARSE_TREMOR)),
    ]
    return tuple(sorted(found, key=lambda r: -r.severity))


def choose_worst(
    found: Iterable[Remark], *, thresholds: RemarkThresholds | None = None
) -> tuple[Remark, ...]:
    """The worst first; of one kind no more than a few, so that the list does not repeat itself."""
    limits = thresholds or RemarkThresholds()
    kinds: Counter[str] = Counter()
    chosen: list[Remark] = []
    for remark in sorted(found, key=lambda r: -r.severity):
        if kinds[remark.kind] < limits.of_a_kind and len(chosen) < limits.at_most:
            kinds[remark.kind] += 1
            chosen.append(remark)
    return tuple(chosen)


def _remarks_on_whole(
    strokes: CharacterMatch, registration: Registration, limits: RemarkThresholds
) -> Iterator[Remark]:
    lean, size, weight = strokes.pose.angle, strokes.pose.scale - 1.0, strokes.width - 1.0
    if abs(lean) >= limits.lean:
        zh, en = ("右", "clockwise") if lean > 0 else ("左", "anticlockwise")
        yield Remark(
            "lean", lean, "degrees", severity("lean", lean, limits.lean), None,
            f"整字向{zh}傾斜 {abs(lean):.0f}°。先看範本的中軸，落筆時把重心扶正。",
            f"The whole character leans {abs(lean):.0f}° {en}. Find the master's axis and set yours upright.",
        )  # fmt: skip
    if abs(size) >= limits.size:
        zh, en, do_zh, do_en = (
            ("大", "larger", "收緊間架。", "Draw the frame in.")
            if size > 0
            else ("小", "smaller", "把間架撐開。", "Open the frame out.")
        )
        yield Remark(
            "size", size, "of the master", severity("size", size, limits.size), None,
            f"整字比範本{zh} {abs(size):.0%}。{do_zh}",
            f"The whole character is {abs(size):.0%} {en} than the master. {do_en}",
        )  # fmt: skip
    away = _offset(strokes) * registration.reference.radius
    offset = float(np.hypot(*away))
    if offset >= limits.offset:
        zh, en = direction_of(away)
        yield Remark(
            "offset", offset, "of the cell", severity("offset", offset, limits.offset), None,
            f"整字在格中偏{zh}，離範本位置 {offset:.0%} 格。下筆前先定中心。",
            f"The whole stands {offset:.0%} of the cell too far to the {en}. Find the centre first.",
        )  # fmt: skip
    if abs(np.log1p(weight)) >= limits.weight + strokes.width_error(strokes.master.points):
        zh, en, do_zh, do_en = (
            ("粗", "heavier", "行筆稍提，蘸墨少些。", "Lift the brush a little and take less ink.")
            if weight > 0
            else ("細", "thinner", "行筆按得實些。", "Press the brush more firmly.")
        )
        yield Remark(
            "heavy" if weight > 0 else "thin", weight, "of the master",
            severity("weight", float(np.log1p(weight)), limits.weight), None,
            f"筆畫比範本{zh}約 {abs(weight):.0%}。{do_zh}",
            f"Strokes are about {abs(weight):.0%} {en} than the master's. {do_en}",
        )  # fmt: skip


def _offset(strokes: CharacterMatch) -> FloatArray:
    """(x right, y DOWN), rms radii: how far the middle of the writing stands from the master's."""
    master = strokes.places[strokes.covered]
    if len(master) == 0:
        return np.zeros(2)
    middle = (master.min(axis=0) + master.max(axis=0)) / 2
    if strokes.squeeze is None:
        middle = master.mean(axis=0)
        return np.asarray(strokes.pose.linear @ middle + strokes.pose.shift - middle)
    # a squeeze keeps the outer edges and moves all between them
    copy = strokes.in_cell[strokes.covered]
    return np.asarray((copy.min(axis=0) + copy.max(axis=0)) / 2 - middle)


def _remark_on_parts(strokes: CharacterMatch, limits: RemarkThresholds) -> Iterator[Remark]:
    q = strokes.squeeze
    if q is None or max(q.first / q.second, q.second / q.first) - 1.0 < limits.squeeze:
        return
    parts = (("左", "left"), ("右", "right")) if q.axis == "across" else (("上", "top"), ("下", "bottom"))
    wide, narrow = (0, 1) if q.first > q.second else (1, 0)
    ratio = (q.first, q.second)
    size = ratio[wide] / ratio[narrow] - 1.0
    much = ("寬", "窄", "wide", "narrow") if q.axis == "across" else ("高", "扁", "tall", "flat")
    (zh, en), (zh_other, en_other) = parts[wide], parts[narrow]
    yield Remark(
        "squeeze", size, "of the master", severity("squeeze", size, limits.squeeze), None,
        f"{zh}部太{much[0]}（為範本的 {ratio[wide]:.0%}），{zh_other}部太{much[1]}（{ratio[narrow]:.0%}）。"
        f"先定兩部的交界，{zh}部收緊，讓出位置給{zh_other}部。",
        f"The {en} part is too {much[2]} ({ratio[wide]:.0%} of the master's) and the {en_other} part too "
        f"{much[3]} ({ratio[narrow]:.0%}). Settle first where they meet and draw the {en} part in.",
    )  # fmt: skip


def _remarks_on_ink(ink: InkMeasures, limits: RemarkThresholds) -> Iterator[Remark]:
    dry = ink.bare >= limits.bare
    for patch in ink.patches if not dry else ():
        region = box(patch.outline)
        zh, en = place_of(np.array([region[0] + region[2], region[1] + region[3]]) / 2)
        blot = patch.attached and patch.slender < limits.round
        outline = as_lines(patch.outline)
        if blot and patch.share >= limits.blot:
            yield Remark(
                "blot", patch.share, "of the ink", ink_severity("blot", patch.share), region,
                f"{zh}有一團墨漬，約佔全字墨跡的 {patch.share:.0%}。蘸墨後先在硯邊舔筆。",
                f"There is a blot at the {en}, about {patch.share:.0%} of the ink. Wipe the brush on the "
                "stone before you write.",
                outline,
            )  # fmt: skip
        elif not blot and patch.share >= limits.extra:
            yield Remark(
                "extra", patch.share, "of the ink", ink_severity("extra", patch.share), region,
                f"{zh}多出一筆，約佔全字墨跡的 {patch.share:.0%}。範本此處留白，不要添筆。",
                f"There is a stroke too many at the {en}, about {patch.share:.0%} of the ink. The master is "
                "blank there.",
                outline,
            )  # fmt: skip
    if dry:
        yield Remark(
            "dry", ink.bare, "of the ink", severity("dry", ink.bare, limits.bare), None,
            f"枯筆露白，筆畫裡約有 {ink.bare:.0%} 沒有墨。蘸足墨，行筆慢些。",
            f"The brush ran dry: about {ink.bare:.0%} of the strokes is bare. Take more ink and go slower.",
        )  # fmt: skip
    elif ink.tremor >= limits.tremor:
        yield Remark(
            "rough", ink.rough - 1.0, "of the master", severity("rough", ink.tremor, limits.tremor), None,
            f"筆畫邊緣抖動，比範本多 {ink.rough - 1.0:.0%}。懸腕勻速，一筆寫到底。",
            f"The edges tremble, {ink.rough - 1.0:.0%} more than the master's. Keep an even pace and finish "
            "each stroke in one go.",
        )  # fmt: skip
    paleness = 1.0 - ink.darkness
    if paleness >= limits.pale:
        yield Remark(
            "pale", -paleness, "of the master", severity("pale", paleness, limits.pale), None,
            f"墨色比範本淡 {paleness:.0%}。墨磨濃些，水少些。",
            f"The ink is {paleness:.0%} paler than the master's. Grind it thicker and use less water.",
        )  # fmt: skip
