"""All methods on copies that people marked: Table 2 and Figure 7, whole characters held out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np

from rumu.values import Bilingual, FloatArray
from rumu_lab.experiments.agreement import (
    COLUMNS,
    FEW_CLUSTERS,
    GradedMethod,
    constant,
    held_out,
    raw_grades,
    side_by_side,
    verdict,
    verdict_sentence,
)
from rumu_lab.experiments.e3c import held_out_marks
from rumu_lab.experiments.findings import Cell, Findings, Table
from rumu_lab.experiments.grading import OURS, OWN, Grades, GradingTask, grade
from rumu_lab.experiments.marked_copies import Copy, chosen_copies
from rumu_lab.experiments.measuring import measure_each
from rumu_lab.experiments.run_settings import RunSettings
from rumu_lab.experiments.simulated_copies import Written

OWN_SCALE = "rumu, its own calibration"
SHARED = "rumu, the shared calibrator"


def run(settings: RunSettings) -> Findings:
    """Table 2 on human marks. Raises CalibrationError when the marked copies are not there."""
    copies = chosen_copies(settings)
    measured = grade_copies(copies, settings)
    pairs = [(c, m) for c, m in zip(copies, measured, strict=True) if m.refused is None]
    marks = np.array([c.mark for c, _ in pairs])
    characters = [c.character for c, _ in pairs]
    own = own_marks([c for c, _ in pairs], [m for _, m in pairs], settings)
    methods = [
        GradedMethod(OWN_SCALE, own, own),
        *_grade_methods([m for _, m in pairs], own, marks, characters),
    ]
    fewest = int(settings.protocol.plain["human"]["fewest_within"])
    rows = side_by_side(methods, marks, characters, ours=SHARED, protocol=settings.protocol, fewest=fewest)
    besides = (OWN_SCALE, *OWN[1:])
    found = verdict(rows, ours=SHARED, besides=besides)
    as_used = side_by_side(
        methods, marks, characters, ours=OWN_SCALE, protocol=settings.protocol, fewest=fewest
    )
    counts = {c: characters.count(c) for c in dict.fromkeys(characters)}
    facts = {
        "copies": len(copies),
        "refused": [m.key for m in measured if m.refused is not None],
        "characters": len(counts),
        "characters_within": sum(n >= fewest for n in counts.values()),
        "could_not_grade": dict(Counter(name for m in measured for name in m.failed)),
        "methods": rows,
        "verdict": found,
        "verdict_as_used": verdict(as_used, ours=OWN_SCALE, besides=(SHARED, *OWN[1:])),
        "one_rater": one_rater([c for c, _ in pairs]),
        "panel": marks.tolist(),
        "own_marks": own.tolist(),
    }
    return Findings("human", facts, (_table(rows, facts),), _sentences(facts))


def grade_copies(copies: list[Copy], settings: RunSettings) -> list[Grades]:
    """Every copy by every method, in order."""
    tasks = [GradingTask(f"human/{c.image.name}", c.character, c.template, Written(c.image)) for c in copies]
    return measure_each(grade, tasks, settings)


def own_marks(copies: list[Copy], measured: list[Grades], settings: RunSettings) -> FloatArray:
    """(N,) our marks by a calibration that saw no copy of the character.

    Quick runs take the marks as shipped, whose calibration saw them all: one more reason why their figures
    are no result.
    """
    if settings.quick:
        return np.array([m.mark for m in measured])
    ours = held_out_marks(settings)
    scores = {m.copy.image: score for m, score in zip(ours.measured, ours.scores, strict=True)}
    return np.array([scores[c.image] for c in copies])


def one_rater(copies: list[Copy]) -> dict[str, float]:
    """Mean and deviation of the absolute error of the k-th rater against the mean of the others."""
    fewest = min(len(c.ratings) for c in copies)
    errors = [
        abs(10.0 * c.ratings[k] - 10.0 * float(np.mean(np.delete(c.ratings, k))))
        for c in copies
        for k in range(fewest)
    ]
    return {"mae": float(np.mean(errors)), "sd": float(np.std(errors)), "n": len(errors)}


def _grade_methods(
    measured: list[Grades], own: FloatArray, marks: FloatArray, characters: list[str]
) -> list[GradedMethod]:
    """Every method through the shared calibrator; ours enters with its held-out mark as raw grade."""
    raw = raw_grades(measured) | {OURS: own / 100.0}
    names = {OURS: SHARED}
    graded = [GradedMethod(names.get(n, n), r, held_out(r, marks, characters)) for n, r in raw.items()]
    return [*graded, constant(marks, characters)]


def _table(rows: list[dict[str, Cell]], facts: Mapping[str, Any]) -> Table:
    rater = facts["one_rater"]
    error = f"{rater['mae']:.2f} ± {rater['sd']:.2f}"
    return Table(
        "table-2-human",
        Bilingual(
            "表二（真人評分）：各方法與評委的差距",
            "Table 2 on human marks: how far each method is from the panel",
        ),
        COLUMNS,
        tuple(rows),
        (
            Bilingual(
                f"E3C：{facts['copies']} 件臨作、{facts['characters']} 個字，整字留出；"
                "所有方法用同樣的數據、同樣的分組、同一個校準器。"
                f"一位評委對其餘評委：{error}。",
                f"E3C: {facts['copies']} copies of {facts['characters']} characters, whole characters held "
                "out; the same data, folds and calibrator for all. "
                f"One rater against the others: {error}.",
            ),
            Bilingual(
                "我們的殘差及權重曾看着這些字選定；其他方法沒有為它們調過。"
                "MBSE、GFSE、IGLS、VICP、AEST 是我們據摘要的重建。",
                "Our residuals and their weights were chosen with these characters in view; the others were "
                "not tuned on them. MBSE, GFSE, IGLS, VICP and AEST are our reconstructions from abstracts.",
            ),
            FEW_CLUSTERS,
        ),
    )


def _sentences(facts: Mapping[str, Any]) -> tuple[Bilingual, ...]:
    found = facts["verdict"]
    ours, rival, name = found["within"], found["best_rival_within"], found["best_rival_by_rank"]
    second = Bilingual(
        f"同字等級相關：我們 {ours:.3f}，對手最高 {rival:.3f}（{name}）。",
        f"Spearman within a character: ours {ours:.3f}, the best rival {rival:.3f} ({name}).",
    )
    return (
        verdict_sentence(found, zh="在真人評分上（同一校準器）", en="On human marks, one calibrator for all"),
        verdict_sentence(
            facts["verdict_as_used"],
            zh="在真人評分上（我們用自己的校準，對手用共用的）",
            en="On human marks, ours with its own calibration, which the others do not have",
        ),
        second,
    )
