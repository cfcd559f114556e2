"""What is said of single strokes: missing, out of place, turned, short, heavy, ends, spaces between them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rumu.assessment.places import as_lines, box, towards
from rumu.assessment.spacing import Gap, find_gaps
from rumu.assessment.stroke_measures import StrokeFound
from rumu.assessment.stroke_names import HORIZONTAL, RING, VERTICAL, Name, kind_of, names_of
from rumu.assessment.strokes import Blunted, Strokes
from rumu.assessment.thresholds import Noticeable, severity
from rumu.values import BoolArray, FloatArray, IntArray, Registration, Remark


@dataclass(frozen=True, slots=True, eq=False)
class _Said:
    """A stroke with what is needed to speak of it.

    cell: one rms radius of the master in cells. wide: width of the master's strokes, rms radii; whole: of the
    copy's over the master's. common: share of all strokes, by length, that one of them has on average.
    grain: doubt in the logarithm of its width, which the pictures are too coarse to show. coarse: how many
    times the coarser picture was enlarged, 1 when it was not.
    """

    stroke: StrokeFound
    name: Name
    kind: Name
    cell: float
    limits: Noticeable
    wide: float
    whole: float
    common: float
    grain: float
    coarse: float

    def remark(self, kind: str, size: float, unit: str, severity: float, *text: str) -> Remark:
        zh, en = text
        return Remark(kind, size, unit, severity, self.box, zh, en, as_lines(self.stroke.outline))

    def at_its_end(self, kind: str, size: float, severity: float, *text: str) -> Remark:
        """A remark on its exit, or else on its entry, where it is marked."""
        zh, en = text
        outline = _third(self, last=kind == "exit_blunt")
        around = box(outline, margin=0.4 * self.wide * self.cell)
        return Remark(kind, size, "of the master", severity, around, zh, en, as_lines(outline))

    def grave(self, size: float, least: float, rate: float) -> float:
        """A fault in a long stroke is graver than the same one in a dot."""
        return severity(size, least, rate=rate, weight=self.stroke.weight / self.common)

    @property
    def box(self) -> tuple[float, float, float, float]:
        return box(self.stroke.outline, margin=0.4 * self.wide * self.cell)

    @property
    def en(self) -> str:
        """The name at the beginning of a sentence."""
        return self.name.en[0].upper() + self.name.en[1:]

    @property
    def slim(self) -> float:
        """Length in stroke widths."""
        return self.stroke.line.length / max(self.wide, 1e-9)


def of_strokes(strokes: Strokes, registration: Registration, limits: Noticeable) -> Iterator[Remark]:
    """Remarks on single strokes, in no order."""
    wide, cell = strokes.master.width, registration.reference.radius
    names = names_of(strokes.master.lines, width=wide)
    told = [
        _Said(
            s,
            name,
            kind_of(s.line, width=wide),
            cell,
            limits,
            wide,
            strokes.width,
            1.0 / len(names),
            strokes.grain_of(s.line),
            strokes.enlarged,
        )
        for s, name in zip(strokes.strokes, names, strict=True)
    ]
    for k, said in enumerate(told):
        if not said.stroke.present:
            if not _may_be_a_corner(said):
                yield _missing(said, strokes, k)
            continue
        yield from _partly_missing(said, strokes, k)
        yield from _place(said)
        yield from _length(said)
        yield from _width(said)
        yield from _ends(said)
    yield from _spaces(find_gaps(strokes), told, limits)
    yield from _blunt(told, strokes.blunted, limits)


def _share(strokes: Strokes, own: BoolArray | IntArray) -> float:
    """Share of the master's ink in some of its points."""
    radius = strokes.master.points.radius
    return float(radius[own].sum() / radius.sum())


def _missing(said: _Said, strokes: Strokes, k: int) -> Remark:
    share = _share(strokes, strokes.master.points.owner == k)
    return said.remark(
        "missing", share, "of the ink", 8.0 + 60.0 * share,
        f"漏寫了{said.name.zh}，約佔全字墨跡的 {share:.0%}。對照範本，補上這一筆。",
        f"{said.en} is missing, about {share:.0%} of the ink. Write this stroke too.",
    )  # fmt: skip


def _may_be_a_corner(said: _Said) -> bool:
    """Whether a short line that joins another is there as ink of which thinning drew no line."""
    joined = not all(said.stroke.line.free)
    return joined and said.slim < 2.0 and said.stroke.inked >= said.limits.inked


def _partly_missing(said: _Said, strokes: Strokes, k: int) -> Iterator[Remark]:
    own = np.flatnonzero(strokes.master.points.owner == k)
    gone = _longest_run(~strokes.covered[own])
    if len(gone) < said.limits.missing * len(own):
        return
    if len(gone) * strokes.master.points.spacing < 2.0 * said.wide:
        return
    share = _share(strokes, own[gone])
    outline = said.stroke.outline[gone]
    yield Remark(
        "missing", share, "of the ink", 4.0 + 60.0 * share, box(outline, margin=0.4 * said.wide * said.cell),
        f"{said.name.zh}缺了一段，約佔全字墨跡的 {share:.0%}。這一筆要寫足。",
        f"A part of {said.name.en} is missing, about {share:.0%} of the ink. Write this stroke out in full.",
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


def _place(said: _Said) -> Iterator[Remark]:
    stroke, limits = said.stroke, said.limits
    shift = _aside(stroke)
    away = float(np.hypot(*shift))
    if away >= limits.displaced:
        zh, en = towards(shift)
        size = away * said.cell
        yield said.remark(
            "displaced", size, "of the cell", said.grave(away, limits.displaced, 3.0),
            f"{said.name.zh}偏{zh}約 {size:.1%} 格。看清它與鄰筆的距離再落筆。",
            f"{said.en} stands about {size:.1%} of the cell too far to the {en}. Measure its distance to its "
            "neighbour.",
        )  # fmt: skip
    # the shorter a stroke, the worse its direction is known
    least = limits.turn * float(np.clip(limits.slender / max(said.slim, 1e-9), 1.0, 2.0))
    if abs(stroke.turn) >= least and said.kind != RING:
        way_zh, way_en = _leaning(said, stroke.turn)
        yield said.remark(
            "stroke_angle", stroke.turn, "degrees", said.grave(stroke.turn, least, 3.0),
            f"{said.name.zh}斜了 {abs(stroke.turn):.0f}°，{way_zh}。落筆前先看準範本的方向。",
            f"{said.en} is off by {abs(stroke.turn):.0f}°: {way_en}. Look at the master's direction first.",
        )  # fmt: skip


def _aside(stroke: StrokeFound) -> FloatArray:
    """The shift of a stroke, without what its length alone does to its middle."""
    along = stroke.line.chord / max(float(np.hypot(*stroke.line.chord)), 1e-9)
    grown = 0.55 * abs(stroke.length - 1.0) * stroke.line.length
    return np.asarray(stroke.shift - np.clip(stroke.shift @ along, -grown, grown) * along)


def _leaning(said: _Said, turn: float) -> Name:
    if said.kind == HORIZONTAL:
        return (
            Name("右端太低", "its right end is too low")
            if turn > 0
            else Name("右端太高", "its right end is too high")
        )
    if said.kind == VERTICAL:
        return (
            Name("下端偏左", "its foot is too far left")
            if turn > 0
            else Name("下端偏右", "its foot is too far right")
        )
    return Name("順時針轉了", "turned clockwise") if turn > 0 else Name("逆時針轉了", "turned anticlockwise")


def _length(said: _Said) -> Iterator[Remark]:
    change, limits = said.stroke.length - 1.0, said.limits
    free = sum(said.stroke.line.free)
    least = limits.length * (1.0, 1.0, 1.6)[2 - free] * (1.0 if said.slim > 4.0 else 1.6)
    least += 2.0 * said.grain / max(said.slim, 1e-9)  # a pixel of the coarser picture
    if abs(change) < least or said.kind == RING:
        return
    kind, zh, en, do_zh, do_en = (
        ("stroke_long", "長", "too long", "提早收筆。", "End it earlier.")
        if change > 0
        else ("stroke_short", "短", "too short", "行筆到位再收。", "Carry it to its end.")
    )
    yield said.remark(
        kind, change, "of the master", said.grave(change, least, 2.6),
        f"{said.name.zh}{zh}了 {abs(change):.0%}。{do_zh}",
        f"{said.en} is {abs(change):.0%} {en}. {do_en}",
    )  # fmt: skip


def _width(said: _Said) -> Iterator[Remark]:
    ratio, least = said.stroke.width / said.whole, said.limits.stroke + said.grain
    if not np.isfinite(ratio) or abs(np.log(ratio)) < least:
        return
    change = ratio - 1.0
    kind, zh, en, do_zh, do_en = (
        ("stroke_heavy", "粗", "heavier", "行筆稍提。", "Lift the brush a little.")
        if change > 0
        else ("stroke_thin", "細", "thinner", "行筆按得實些。", "Press more firmly.")
    )
    yield said.remark(
        kind, change, "of the master", said.grave(float(np.log(ratio)), least, 3.0),
        f"{said.name.zh}比別的筆畫{zh} {abs(change):.0%}。{do_zh}",
        f"{said.en} is {abs(change):.0%} {en} than the other strokes are. {do_en}",
    )  # fmt: skip


def _blunt(told: list[_Said], blunted: Blunted | None, limits: Noticeable) -> Iterator[Remark]:
    """Most tips too wide: not one stroke but the hand lets the brush down at its tips."""
    if blunted is None or blunted.share < limits.tips or blunted.most < 0.6:
        return
    outlines = [_third(told[k], last=bool(end)) for k, end in blunted.ends]
    lost = min(blunted.share, 1.0)  # a tip that swells has lost all of its taper, not more
    yield Remark(
        "exit_blunt", lost, "of the master", severity(blunted.share, limits.tips, rate=3.2),
        box(np.concatenate(outlines)),
        f"筆鋒多禿鈍：{len(outlines)} 處筆鋒失去約 {lost:.0%} 的尖銳。起收筆時漸漸提鋒。",
        f"The tips are blunt: {len(outlines)} of them have lost about {lost:.0%} of their taper. "
        "Lift the brush little by little.",
        as_lines(*outlines),
    )  # fmt: skip


def _ends(said: _Said) -> Iterator[Remark]:
    limits, entry, end = said.limits, said.stroke.entry, said.stroke.exit
    coarse = said.coarse**2  # an end is small: an enlarged picture shows it blurred
    least = coarse * (limits.entry if entry > 0 else limits.faint)
    if abs(entry) >= least:  # not so where it is NaN
        kind, zh, en, do_zh, do_en = (
            ("entry_heavy", "重", "heavy", "落筆輕些，再按下去。", "Set the brush down more lightly.")
            if entry > 0
            else ("entry_light", "輕", "light", "落筆先頓一頓。", "Press as you set the brush down.")
        )
        yield said.at_its_end(
            kind, entry, said.grave(entry, least, 2.2),
            f"{said.name.zh}起筆太{zh}，寬度差 {abs(entry):.0%}。{do_zh}",
            f"{said.en} begins too {en}, by {abs(entry):.0%} of its width. {do_en}",
        )  # fmt: skip
    if end >= coarse * limits.exit:
        yield said.at_its_end(
            "exit_blunt", end, said.grave(end, limits.exit, 2.2),
            f"{said.name.zh}收筆禿鈍，比範本寬 {end:.0%}。收筆時漸漸提鋒。",
            f"{said.en} ends bluntly, {end:.0%} wider than the master's. Lift the brush little by little.",
        )  # fmt: skip


def _third(said: _Said, *, last: bool) -> FloatArray:
    """The outline of the first or the last third of a stroke."""
    line = said.stroke.outline
    return line[len(line) * 2 // 3 :] if last else line[: len(line) - len(line) * 2 // 3]


def _spaces(gaps: tuple[Gap, ...], told: list[_Said], limits: Noticeable) -> Iterator[Remark]:
    """Spaces are uneven when several differ from the master's in different ways."""
    odd = [gap for gap in gaps if abs(gap.change) >= limits.gap]
    if len(gaps) < 2 or not odd:
        return
    spread = float(np.std([gap.change for gap in gaps]))
    if spread < 0.6 * limits.gap:
        return
    worst = max(odd, key=lambda gap: abs(gap.change))
    a, b = told[worst.first], told[worst.second]
    zh, en = ("寬", "wide") if worst.change > 0 else ("窄", "narrow")
    points = np.concatenate([a.stroke.outline, b.stroke.outline])
    yield Remark(
        "spacing", worst.change, "of the master", severity(spread, 0.6 * limits.gap, rate=3.0), box(points),
        f"筆畫間距不勻：{a.name.zh}與{b.name.zh}之間{zh}了 {abs(worst.change):.0%}。先看好留白再落筆。",
        f"The spaces are uneven: that between {a.name.en} and {b.name.en} is {abs(worst.change):.0%} too "
        f"{en}. Look at the white before you write.",
        as_lines(a.stroke.outline, b.stroke.outline),
    )  # fmt: skip
