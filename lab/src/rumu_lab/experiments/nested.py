"""The mark on characters that nobody has seen: even the choice of what it rests on is made inside the folds.

A character is left out whole. On the other characters every candidate is validated, again character by
character; the best of them there is fitted on all of those and marks the one left out. Interval and cut-offs
of the levels come from the inner validation as well. So no choice rests on a copy that it is judged on.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations_with_replacement
from typing import Any

import numpy as np

from rumu.assessment.calibration import Charges
from rumu.assessment.features import Features
from rumu.assessment.fitting import Evidence, anchor_scale, fit_evidence
from rumu.values import Bilingual, BoolArray, FloatArray, IntArray
from rumu_lab.experiments.e3c import FEWEST, TAILS, MeasuredCopy, agreement, measure_copy, other_characters
from rumu_lab.experiments.findings import Cell, Column, Findings, Table
from rumu_lab.experiments.marked_copies import read_copies
from rumu_lab.experiments.measuring import measure_each
from rumu_lab.experiments.run_settings import RunSettings
from rumu_lab.experiments.statistics import choose_cuts, level_numbers, quick_kappa

STRETCHES = (1.0, 1.1, 1.2, 1.3, 1.5)
"""Factors by which marks are stretched to see what it costs."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """One way to mark. evidence: what it rests on. charged: with charges and ceilings."""

    name: str
    evidence: Evidence
    charged: bool = True


_DISTANCES: Evidence = {"plane": 500.0, "whole": 500.0}
_FORM: Evidence = {"form": 200.0}
_EDGE: Evidence = {"edge": 500.0, "fullness": 200.0}
_OUTLINE: Evidence = {"outline": 200.0, "fullness": 200.0}
_BARE: Mapping[str, Evidence] = {
    "plane": {"plane": 500.0},
    "distances": _DISTANCES,
    "distances, edge": {**_DISTANCES, **_EDGE},
    "distances, edge, outline": {**_DISTANCES, **_EDGE, **_OUTLINE},
    "form": _FORM,
    "form, edge": {**_FORM, **_EDGE},
    "form, outline": {**_FORM, **_OUTLINE},
    "form, edge, outline": {**_FORM, **_EDGE, **_OUTLINE},
    "form, edge drawn to nought, outline": {**_FORM, **_EDGE, **_OUTLINE, "edge": 2000.0},
    "distances, form, edge, outline": {**_DISTANCES, **_FORM, **_EDGE, **_OUTLINE},
}
CANDIDATES: tuple[Candidate, ...] = tuple(
    Candidate(name + (", charged" if charged else ""), evidence, charged)
    for name, evidence in _BARE.items()
    for charged in (False, True)
)
"""All that the choice is made from."""


@dataclass(frozen=True, slots=True, eq=False)
class MarkedFeatures:
    """N marked copies as arrays.

    vectors: (N, K) features. marks: (N,) the panel's. characters: (N,) number of the character. names: of the
    characters. points, ceilings, pose: (N,) what charges take and the highest marks that they leave.
    highest: (N,) the mark that a copy may reach that is hardly like its master. others: (M, K) features of
    other characters.
    """

    vectors: FloatArray
    marks: FloatArray
    characters: IntArray
    names: tuple[str, ...]
    points: FloatArray
    ceilings: FloatArray
    highest: FloatArray
    others: tuple[Features, ...]

    def given(self, read: FloatArray, chosen: BoolArray, *, charged: bool) -> FloatArray:
        """The marks of chosen copies from what their scale reads."""
        marks = read
        if charged:
            marks = np.minimum(marks - self.strokes[chosen], self.ceilings[chosen]) - self.pose[chosen]
        return np.clip(np.minimum(marks, self.highest[chosen]), 0.0, 100.0)

    @property
    def strokes(self) -> FloatArray:
        """(N,) points taken for missing and surplus strokes."""
        return self.points[:, 0]

    @property
    def pose(self) -> FloatArray:
        """(N,) points taken for lean, place and size."""
        return self.points[:, 1]


def run(settings: RunSettings) -> Findings:
    """Nested validation. Raises CalibrationError when the marked copies are not there."""
    copies = read_copies(settings.data)
    known = arrange(measure_each(measure_copy, copies, settings), other_characters(copies))
    return findings_of(known, validate(known, settings))


def arrange(measured: Sequence[MeasuredCopy], others: Sequence[Features]) -> MarkedFeatures:
    """Measured copies as arrays; those that were refused are left out."""
    kept = [(m, m.features) for m in measured if m.features]
    names, characters = np.unique([m.copy.character for m, _ in kept], return_inverse=True)
    charges = Charges()
    strokes = np.array([charges.stroke_points(f) for _, f in kept])
    pose = np.array([sum(charges.pose_points(f).values()) for _, f in kept])
    return MarkedFeatures(
        np.array([f.vector() for _, f in kept]),
        np.array([m.copy.mark for m, _ in kept]),
        characters,
        tuple(map(str, names)),
        np.column_stack([strokes[:, 0], pose]),
        strokes[:, 1],
        np.array([m.highest for m, _ in kept]),
        tuple(others),
    )


def validate(known: MarkedFeatures, settings: RunSettings) -> dict[str, FloatArray]:
    """Name of a candidate -> (N, C): the mark of copy i by a fit without i's character and character c."""
    found = measure_each(partial(marks_apart, known), CANDIDATES, settings)
    return {candidate.name: marks for candidate, marks in zip(CANDIDATES, found, strict=True)}


def marks_apart(known: MarkedFeatures, candidate: Candidate) -> FloatArray:
    """(N, C) the mark of copy i by a fit that saw neither i's own character nor character c."""
    count = len(known.names)
    marks = np.full((len(known.marks), count), np.nan)
    for a, b in combinations_with_replacement(range(count), 2):
        seen = (known.characters != a) & (known.characters != b)
        groups = known.characters[seen].astype(str).tolist()
        scale = fit_evidence(known.vectors[seen], known.marks[seen], groups, evidence=candidate.evidence)
        scale = anchor_scale(scale, others=known.others)
        for own, apart in {(a, b), (b, a)}:
            copies = known.characters == own
            read = scale.read_all(known.vectors[copies])
            marks[copies, apart] = known.given(read, copies, charged=candidate.charged)
    return marks


@dataclass(frozen=True, slots=True, eq=False)
class NestedMarks:
    """(N,) each: marks of characters left out, the ends of their intervals, their levels, 0 to 3.

    chosen: the candidate that each character was marked by.
    """

    marks: FloatArray
    low: FloatArray
    high: FloatArray
    levels: IntArray
    chosen: tuple[str, ...]


def mark_nested(known: MarkedFeatures, apart: Mapping[str, FloatArray], cuts: Sequence[float]) -> NestedMarks:
    """Each character by what does best on the others. cuts: of the panel's levels, rising."""
    n = len(known.marks)
    marks, low, high, levels = np.empty(n), np.empty(n), np.empty(n), np.empty(n, np.intp)
    chosen = []
    for character in range(len(known.names)):
        own = known.characters == character
        best = max(apart, key=lambda name: _merit(apart[name][~own, character], known, ~own))
        inner, truth = apart[best][~own, character], known.marks[~own]
        marks[own] = apart[best][own, character]
        ends = np.percentile(truth - inner, TAILS)
        low[own], high[own] = (np.clip(marks[own] + end, 0, 100) for end in ends)
        levels[own] = level_numbers(marks[own], choose_cuts(inner, level_numbers(truth, cuts)))
        chosen.append(best)
    return NestedMarks(marks, low, high, levels, tuple(chosen))


def _merit(marks: FloatArray, known: MarkedFeatures, copies: BoolArray) -> float:
    """What the choice goes by: order before numbers, so the mean of both rank correlations."""
    found = agreement(marks, known.marks[copies], known.characters[copies])
    return 0.5 * (found["all"] + found["within"])


def findings_of(known: MarkedFeatures, apart: Mapping[str, FloatArray]) -> Findings:
    """Figures and tables."""
    cuts = sorted(_panel_cuts().values())
    nested = mark_nested(known, apart, cuts)
    truth = level_numbers(known.marks, cuts)
    inside = (nested.low <= known.marks) & (known.marks <= nested.high)
    facts: dict[str, Any] = {
        "copies": len(known.marks),
        "characters": len(known.names),
        "nested": agreement(nested.marks, known.marks, known.characters),
        "chosen": dict(Counter(nested.chosen)),
        "coverage": float(inside.mean()),
        "width": float(np.mean(nested.high - nested.low)),
        "kappa": quick_kappa(truth, nested.levels),
        "confusion": np.histogram2d(truth, nested.levels, bins=4, range=[[0, 4]] * 2)[0].astype(int).tolist(),
        "candidates": _candidate_rows(known, apart, nested),
        "stretched": _stretched_rows(known, nested),
        "fifths": [*_fifths("the mark", nested.marks, inside), *_fifths("the panel", known.marks, inside)],
    }
    return Findings("nested", facts, _tables(facts), (_sentence(facts),))


def _panel_cuts() -> Mapping[str, float]:
    from rumu_lab.experiments.protocol import declared

    return declared().cut_offs


def _candidate_rows(
    known: MarkedFeatures, apart: Mapping[str, FloatArray], nested: NestedMarks
) -> list[dict[str, Cell]]:
    """Every candidate with its own character left out, and how often it was chosen."""
    rows: list[dict[str, Cell]] = [
        {
            "method": "the choice inside the folds",
            "times": len(known.names),
            **agreement(nested.marks, known.marks, known.characters),
        }
    ]
    own = np.arange(len(known.marks)), known.characters
    for name, marks in apart.items():
        row = agreement(marks[own], known.marks, known.characters)
        rows.append({"method": name, "times": nested.chosen.count(name), **row})
    return rows


def _stretched_rows(known: MarkedFeatures, nested: NestedMarks) -> list[dict[str, Cell]]:
    """What it costs to stretch the marks about their mean, and what it gives the ends."""
    rows: list[dict[str, Cell]] = []
    low, high = np.percentile(known.marks, (20, 80))
    for factor in STRETCHES:
        marks = np.clip(nested.marks.mean() + factor * (nested.marks - nested.marks.mean()), 0, 100)
        error = marks - known.marks
        rows.append(
            {
                "factor": factor,
                "mae": float(np.abs(error).mean()),
                "worst": float(error[known.marks <= low].mean()),
                "best": float(error[known.marks >= high].mean()),
                "highest": float(marks.max()),
            }
        )
    return rows


def _fifths(by: str, values: FloatArray, inside: BoolArray) -> list[dict[str, Cell]]:
    """Coverage of the interval in each fifth of the copies by the mark, or by the panel's."""
    fifth = np.digitize(values, np.percentile(values, (20, 40, 60, 80)))
    return [
        {
            "where": f"fifth {k + 1} by {by}",
            "low": float(values[fifth == k].min()),
            "high": float(values[fifth == k].max()),
            "n": int(np.count_nonzero(fifth == k)),
            "coverage": 100.0 * float(inside[fifth == k].mean()),
        }
        for k in range(5)
    ]


def _tables(facts: Mapping[str, Any]) -> tuple[Table, ...]:
    about = Bilingual(
        f"{facts['copies']} 件、{facts['characters']} 個字，整字留出；"
        f"同字等級相關只算有 {FEWEST} 件以上的字。"
        "第一行連選擇也在留出之內；其餘各行是逐字留出的結果，若從中挑最好的一行，就偏高了。",
        f"{facts['copies']} copies of {facts['characters']} characters, each left out whole; within a "
        f"character where it has {FEWEST} copies or more. In the first row the choice is made inside the "
        "folds, too; the best of the other rows flatters itself.",
    )
    figures = Column("within", Bilingual("同字等級相關", "Spearman within"), 3)
    candidates = Table(
        "nested",
        Bilingual("誰也沒見過的字", "Characters that nobody has seen"),
        (
            Column("method", Bilingual("做法", "variant")),
            Column("times", Bilingual("選中字數", "chosen for")),
            Column("all", Bilingual("總等級相關", "Spearman all"), 3),
            figures,
            Column("mae", Bilingual("絕對誤差均值", "mean abs. error")),
        ),
        tuple(facts["candidates"]),
        (about,),
    )
    fifths = Table(
        "nested-interval",
        Bilingual("八成區間，分五段", "The 80 % interval, by fifths"),
        (
            Column("where", Bilingual("哪一段", "where")),
            Column("low", Bilingual("由", "from"), 0),
            Column("high", Bilingual("至", "to"), 0),
            Column("n", Bilingual("件數", "N")),
            Column("coverage", Bilingual("落在區間內 %", "inside %"), 0),
        ),
        tuple(facts["fifths"]),
    )
    stretched = Table(
        "nested-stretched",
        Bilingual("把分數拉開", "The marks stretched about their mean"),
        (
            Column("factor", Bilingual("倍數", "factor"), 1),
            Column("mae", Bilingual("絕對誤差均值", "mean abs. error")),
            Column("worst", Bilingual("最差五分之一偏高", "too high, worst fifth"), 1),
            Column("best", Bilingual("最好五分之一偏高", "too high, best fifth"), 1),
            Column("highest", Bilingual("最高分", "highest mark"), 0),
        ),
        tuple(facts["stretched"]),
    )
    return candidates, fifths, stretched


def _sentence(facts: Mapping[str, Any]) -> Bilingual:
    found, table = facts["nested"], facts["confusion"]
    figures = f"{found['all']:.3f} / {found['within']:.3f} / {found['mae']:.2f}"
    return Bilingual(
        f"連選擇都留出：{figures}；{facts['coverage']:.0%} 落在八成區間（寬 {facts['width']:.0f} 分）；"
        f"定級的二次加權 κ {facts['kappa']:.3f}，評委的級（行，差在前）與我們的級（列）：{table}。",
        f"With the choice inside the folds: {figures} (all, within, error); {facts['coverage']:.0%} lie in "
        f"the 80 % interval, {facts['width']:.0f} points wide; quadratic weighted kappa of the levels "
        f"{facts['kappa']:.3f}, copies by the panel's level (rows, bad first) and ours: {table}.",
    )
