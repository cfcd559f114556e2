"""The strokes of a match with what is needed to speak of them: name, kind, number, places."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rumu.assessment.advice import for_stroke
from rumu.assessment.findings import Fault, Finding
from rumu.assessment.thresholds import Box, RemarkThresholds, as_lines, box, severity
from rumu.assessment.whole_remarks import PoseSeen
from rumu.strokes.centre_lines import CentreLine, pixels_at
from rumu.strokes.correspondence import StrokeMatch
from rumu.strokes.measures import MatchedStroke
from rumu.strokes.naming import (
    HORIZONTAL,
    VERTICAL,
    canonical_kind,
    hook_of,
    kind_of,
    name_strokes,
)
from rumu.values import Bilingual, FloatArray, Remark

_ENDS = {
    HORIZONTAL: (Bilingual("左端", "left end"), Bilingual("右端", "right end")),
    VERTICAL: (Bilingual("上端", "top"), Bilingual("下端", "foot")),
}
_OTHER_ENDS = (Bilingual("起筆處", "beginning"), Bilingual("收筆處", "end"))


@dataclass(frozen=True, slots=True, eq=False)
class NamedStroke:
    """A stroke with what is needed to speak of it.

    position: among the master's. shift: (x right, y DOWN), rms radii, without what the parts of the character
    explain, which is `explained`. other_shifts: (k, 2) by the extent of the character instead of its pose,
    and in the cell where that is known; with what its parts explain. cell: one rms radius of the master in
    cells. framed: whether the copy's picture is the cell that it was written in. common: share of all
    strokes, by length, that one of them has on average. number: in the order of writing, from 1; None where
    it is not known.
    """

    stroke: MatchedStroke
    match: StrokeMatch
    name: Bilingual
    kind: Bilingual
    limits: RemarkThresholds
    position: int
    shift: FloatArray
    explained: FloatArray
    other_shifts: FloatArray
    cell: float
    framed: bool
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
        return _ENDS.get(self.kind, _OTHER_ENDS)[int(self.is_nearer_exit(point))]

    def is_nearer_exit(self, point: int) -> bool:
        """Whether one of the master's points lies in the second half of the stroke."""
        own = np.flatnonzero(self.match.master.points.owner == self.position)
        return bool(np.searchsorted(own, point) * 2 >= len(own))

    @property
    def en(self) -> str:
        """The name at the beginning of a sentence."""
        return self.name.en.capitalize()

    @property
    def ink_share(self) -> float:
        """Share of the master's ink in it."""
        points = self.match.master.points
        return float(points.radius[points.owner == self.position].sum() / points.radius.sum())

    @property
    def legs(self) -> list[CentreLine]:
        """All lines of its canonical stroke; none where that is not known."""
        number = self.stroke.line.number
        return [line for line in self.match.master.lines if number and line.number == number]

    @property
    def body(self) -> set[CentreLine]:
        """The lines of its canonical stroke, but for a hook."""
        return {leg for leg in self.legs if leg is not self._hook}

    @property
    def _hook(self) -> CentreLine | None:
        """The hook of its canonical stroke."""
        laid, number = self.match.laid, self.stroke.line.number
        if laid is None or not number:
            return None
        return hook_of(self.legs, laid.character.strokes[number - 1].name)

    @property
    def is_hook(self) -> bool:
        """Whether it is the hook of a stroke of several legs."""
        return self.stroke.line is self._hook

    @property
    def length_change(self) -> float:
        """Of its length, relative to the master's: of its line, or of its ink where that lacks more."""
        change, ink = self.stroke.length - 1.0, self.stroke.ink
        is_clear = change <= -self.limits.shrunk and ink.moved <= self.limits.put_back
        return min(change, max(-ink.lacking, self.limits.exaggerated * change)) if is_clear else change

    @property
    def is_cut_off(self) -> bool:
        """Whether it reaches the border of the copy's picture: there may have been more of it."""
        at = self.stroke.outline
        return float(min(at.min(), 1.0 - at.max())) < self.limits.border

    @property
    def is_on_ink(self) -> bool:
        """Whether it was found, and does not lie across bare paper, from one stroke's ink to another's."""
        return self.stroke.present and self.stroke.inked >= self.limits.on_ink

    def runs_on(self, *, last: bool) -> bool:
        """Whether ink of the copy goes on beyond its exit, or else its entry: then that is no tip."""
        own = np.flatnonzero(self.match.master.points.owner == self.position)
        path = self.match.moved[own] if last else self.match.moved[own][::-1]
        way = path[-1] - path[max(len(path) - 4, 0)]
        way = way / max(float(np.hypot(*way)), 1e-9)
        beyond = np.linspace(*self.limits.beyond_tip, 5) * self.match.copy.width
        return bool(self.match.framed.ink[pixels_at(path[-1] + beyond[:, None] * way)].mean() > 0.5)

    @property
    def is_laid_well(self) -> bool:
        """Whether its ink is as like the master's where its line was laid: else that lies on other ink."""
        ink = self.stroke.ink
        return ink.moved <= self.limits.put_wrong * ink.unlike

    @property
    def slenderness(self) -> float:
        """Length in stroke widths."""
        return self.stroke.line.length / max(self.match.master.width, 1e-9)


def name_all(pose: PoseSeen, limits: RemarkThresholds, *, explained: FloatArray) -> tuple[NamedStroke, ...]:
    """The strokes of a match with their names; explained: (n, 2) how far parts move the master's points."""
    match = pose.match
    width, cell = match.master.width, pose.registration.reference.radius
    lines = match.master.lines
    character = None if match.laid is None else match.laid.character
    names = name_strokes(lines, character)
    kinds = [
        (character and canonical_kind(line, lines, character)) or kind_of(line, width=width) for line in lines
    ]
    squeezed = 0.0 if match.squeeze is None else match.squeeze.apply(match.places) - match.places
    left = squeezed - explained  # the strokes were measured against a squeezed master
    owner = match.master.points.owner
    others = np.stack([match.by_extent, match.in_cell] if pose.framed else [match.by_extent]) - match.places
    return tuple(
        NamedStroke(
            stroke, match, name, kinds[k], limits, k,
            stroke.shift + left[owner == k].mean(axis=0), explained[owner == k].mean(axis=0),
            others[:, owner == k].mean(axis=1), cell,
            pose.framed, 1.0 / len(names), stroke.line.number or None,
        )
        for k, (stroke, name) in enumerate(zip(match.strokes, names, strict=True))
    )  # fmt: skip
