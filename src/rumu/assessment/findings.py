"""Faults that were measured, and which of them a teacher would speak of: few, the worst first, each once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from rumu.assessment.thresholds import RemarkThresholds
from rumu.values import Bilingual, Remark

POSE_KINDS = ("size", "offset", "lean")
"""Of the whole in its cell: listed apart on every page, so that they never come first."""
PARTS_OF_KINDS: Mapping[str, tuple[str, ...]] = {
    "ink": ("heavy", "thin"),
    "brushwork": (
        "rough", "dry", "blot", "filled", "heavy", "thin", "stroke_heavy", "stroke_thin", "entry_heavy",
        "entry_light", "exit_blunt", "no_hook", "stroke_angle",
    ),
    "structure": (
        "aspect", "squeeze", "part_place", "inner", "spacing", "displaced", "stroke_angle", "stroke_long",
        "stroke_short", "sticks_out", "open", "missing", "extra",
    ),
}  # fmt: skip
"""Part of the mark -> the kinds of remark that explain why it is low."""
_LENGTHS = {"sticks_out", "stroke_long", "stroke_short"}
_TOLD_WITH = 1.6
"""How many times the smallest worth a remark a second fault of one cause must be, to be told too."""
_TOLD_SECOND = {"stroke_angle", "stroke_heavy", "stroke_thin", *_LENGTHS, *POSE_KINDS}
"""Kinds that may be told second: where a turned stroke stands, and how it begins, is less sure."""
_JUST_BELOW = 0.99
"""Of the first remark's severity, which one of the pose may reach."""


class Fault(NamedTuple):
    """kind, size, unit, severity: as in a remark. excess: its size over the smallest worth a remark."""

    kind: str
    size: float
    unit: str
    severity: float
    excess: float


@dataclass(frozen=True, slots=True)
class Finding:
    """A fault, before it is chosen.

    remark: with what is wrong, as a whole sentence, and not what to do. excess: its size over the smallest
    that is worth a remark. advice: what to do, the fittest first; of one assessment no two remarks end alike.
    cause: what is told once. predicate: the fault without its subject, so that two of one stroke can be told
    in one sentence. covers: cause and kind of faults that it tells of together, which are not told by
    themselves.
    """

    remark: Remark
    excess: float
    advice: tuple[Bilingual, ...] = ()
    cause: str = ""
    predicate: Bilingual | None = None
    covers: tuple[tuple[str, str], ...] = ()


def choose_remarks(
    found: Sequence[Finding], *, parts: Mapping[str, float], limits: RemarkThresholds
) -> tuple[tuple[Remark, ...], tuple[Remark, ...]]:
    """The remarks to be made, and the faults besides that are worth one; the worst first.

    A fault that a remark only mentions is among those besides, too, with its size.
    parts: of the mark, 0-100; one that is low is explained, by a small fault if there is no greater one.
    """
    covered = {fault for f in found for fault in f.covers}
    single = [f for f in found if (f.cause, f.remark.kind) not in covered]
    ordered = sorted(_merge_causes(single), key=lambda f: -f.remark.severity)
    chosen: list[Finding] = []
    for finding in ordered:
        slight = chosen and finding.remark.severity < limits.slight * chosen[0].remark.severity
        if finding.excess < 1.0 or slight or len(chosen) >= limits.at_most:
            continue
        if finding.remark.kind in POSE_KINDS and any(f.remark.kind in POSE_KINDS for f in chosen):
            continue
        chosen.append(finding)
    chosen = _explain_parts(chosen, ordered, parts, limits)
    chosen = _pose_not_first(sorted(chosen, key=lambda f: -f.remark.severity))
    told = {(f.cause or f.remark.kind, f.remark.kind) for f in chosen}
    left = sorted(
        (f for f in found if f.excess >= 1.0 and (f.cause or f.remark.kind, f.remark.kind) not in told),
        key=lambda f: -f.remark.severity,
    )
    return tuple(_with_advice(chosen)), tuple(_advised(f.remark, f.advice[:1]) for f in left)


def _merge_causes(found: Iterable[Finding]) -> list[Finding]:
    """One finding for each cause: its worst, which also tells of the next if that is worth a remark."""
    by_cause: dict[str, list[Finding]] = {}
    for finding in found:
        by_cause.setdefault(finding.cause or finding.remark.kind, []).append(finding)
    merged = []
    for same in by_cause.values():
        worst, *others = sorted(same, key=lambda f: -f.remark.severity)
        second = next((f for f in others if _adds_to(f, worst)), None)
        merged.append(worst if second is None or worst.predicate is None else _told_together(worst, second))
    return merged


def _adds_to(second: Finding, worst: Finding) -> bool:
    """Whether a fault of the same cause is worth telling with its worst, and is another one."""
    kinds = {worst.remark.kind, second.remark.kind}
    same = len(kinds) == 1 or kinds <= _LENGTHS
    sure = second.excess >= _TOLD_WITH and second.remark.kind in _TOLD_SECOND
    return sure and second.predicate is not None and not same


def _told_together(worst: Finding, second: Finding) -> Finding:
    more = second.predicate or Bilingual("", "")
    remark = worst.remark
    zh, en = remark.zh.removesuffix("。"), remark.en.removesuffix(".")
    return replace(worst, remark=replace(remark, zh=f"{zh}，又{more.zh}。", en=f"{en}, and {more.en}."))


def _explain_parts(
    chosen: list[Finding], found: list[Finding], parts: Mapping[str, float], limits: RemarkThresholds
) -> list[Finding]:
    """The chosen ones, the least of them exchanged where a low part of the mark has no remark."""
    needed: list[Finding] = []
    for part, kinds in PARTS_OF_KINDS.items():  # the part that fewest kinds explain comes first
        value = parts.get(part, 100.0)
        if value >= limits.part_explained or any(f.remark.kind in kinds for f in needed):
            continue
        best = next((f for f in (*chosen, *found) if f.remark.kind in kinds), None)
        if best is not None:
            needed.append(best)
    kept = [f for f in chosen if f not in needed][: max(limits.at_most - len(needed), 0)]
    return [*kept, *needed][: limits.at_most]


def _pose_not_first(chosen: list[Finding]) -> list[Finding]:
    """The same with a remark on size, place or lean behind another one, if there is another."""
    other = next((f for f in chosen if f.remark.kind not in POSE_KINDS), None)
    if other is None:
        return chosen
    highest = _JUST_BELOW * other.remark.severity
    lowered = [
        replace(f, remark=replace(f.remark, severity=min(f.remark.severity, highest)))
        if f.remark.kind in POSE_KINDS
        else f
        for f in chosen
    ]
    return sorted(lowered, key=lambda f: -f.remark.severity)


def _with_advice(chosen: list[Finding]) -> list[Remark]:
    """The remarks with what to do; what was said once is not said again."""
    said: set[Bilingual] = set()
    remarks = []
    for finding in chosen:
        new = tuple(advice for advice in finding.advice if advice not in said)[:1]
        said.update(new)
        remarks.append(_advised(finding.remark, new))
    return remarks


def _advised(remark: Remark, advice: tuple[Bilingual, ...]) -> Remark:
    return replace(
        remark,
        zh="".join([remark.zh, *(words.zh for words in advice)]),
        en=" ".join([remark.en, *(words.en for words in advice)]),
    )
