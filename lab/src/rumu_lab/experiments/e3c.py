"""Agreement of the mark with people on learners' brush copies, whole characters held out.

Every figure on a copy comes from weights, anchors and interval fitted without any copy of its character.
Nothing here is tuned on the copies it reports, but the choice of features and of their weights in the
matching was made on these characters; `nested` takes the choice of features into the folds.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from rumu.assessment.calibration import CUT_OFFS, Calibration, Scale, level_of
from rumu.assessment.features import Features
from rumu.assessment.fitting import PARTS, WHOLE, Evidence, anchor_scale, fit_evidence
from rumu.errors import RefusedImage
from rumu.pipeline import measure
from rumu.values import FloatArray
from rumu_lab.experiments.findings import Findings
from rumu_lab.experiments.marked_copies import Copy, read_copies
from rumu_lab.experiments.measuring import master_at, measure_each
from rumu_lab.experiments.protocol import declared
from rumu_lab.experiments.run_settings import RunSettings

FEWEST = 5
"""A rank correlation within a character is taken where it has at least this many copies."""
STANDING = 41
"""Scores of the held-out copies that are kept, at equal steps, to say where a copy stands among them."""
TAILS = (9, 91)
"""Percentiles of held-out errors at which the 80 % interval ends: a little wide, since characters are few."""


@dataclass(frozen=True, slots=True)
class MeasuredCopy:
    """A copy with what was measured of it, or the reason why it was refused.

    highest: the mark that it may reach, since it is hardly like its master; see `refusal.check_copy`.
    """

    copy: Copy
    features: Features | None
    sim_paper: float = float("nan")
    similarity: float = float("nan")
    refused: str | None = None
    highest: float = 100.0


@dataclass(frozen=True, slots=True, eq=False)
class HeldOutMarks:
    """Marks on held-out characters beside the panel's.

    panel, characters, scores, low, high: (N,) for the marked copies: the panel's marks, what was copied, our
    scores and the ends of their intervals.
    """

    measured: tuple[MeasuredCopy, ...]
    refused: tuple[MeasuredCopy, ...]
    panel: FloatArray
    characters: np.ndarray
    scores: FloatArray
    low: FloatArray
    high: FloatArray
    calibration: Calibration
    figures: Mapping[str, Any] = field(default_factory=dict)

    def text(self) -> str:
        """The figures as a person reads them."""
        f = self.figures
        rows = [
            ("", "Spearman, all", "within a character", "mean abs. error"),
            *(
                (name, *(f"{f[key][k]:.3f}" for k in ("all", "within")), f"{f[key]['mae']:.2f}")
                for name, key in _ROWS
            ),
            ("constant", "-", "-", f"{f['constant_mae']:.2f}"),
        ]
        widths = [max(len(row[k]) for row in rows) for k in range(4)]
        table = "\n".join(
            "  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip() for row in rows
        )
        shares = ", ".join(f"{name} {share:.0%}" for name, share in f["level_shares_of_human_marks"].items())
        scored = ", ".join(f"{name} {share:.0%}" for name, share in f["level_shares_of_scores"].items())
        return "\n".join(
            [
                f"E3C: {f['copies']} copies of {f['characters']} characters, {f['refused']} refused; "
                "each character marked by weights fitted on the others.",
                table,
                f"Within a character: mean over the {f['characters_within']} with {FEWEST} or more copies.",
                f"Panel's marks that fall in the 80 % interval: {f['interval_coverage']:.0%} "
                f"(width {f['interval_width']:.0f} points).",
                f"Levels of the panel's marks: {shares}; of the scores: {scored}.",
            ]
        )


_ROWS = (
    ("rumu's mark", "score"),
    ("two-sided similarity", "similarity"),
    ("the paper's SIM", "sim_paper"),
    ("one rater against the others", "rater"),
)


def run(settings: RunSettings) -> Findings:
    """Mark all copies with their own character held out, and compare with the panel.

    Writes OUT/tables/e3c.csv, one row a copy. Raises CalibrationError when the data is not there.
    """
    marks = held_out_marks(settings)
    if settings.tables is not None:
        write_table(marks, settings.tables / "e3c.csv")
    return Findings("e3c", marks.figures, words=marks.text())


def held_out_marks(settings: RunSettings) -> HeldOutMarks:
    """Our marks of all marked copies, each character marked by what was fitted on the others."""
    copies = read_copies(settings.data)
    measured = measure_each(measure_copy, copies, settings)
    return hold_out_characters(measured, other_characters(copies))


def measure_copy(copy: Copy) -> MeasuredCopy:
    """One copy against its master."""
    from rumu import pipeline
    from rumu.assessment.features import sim_paper, similarity

    try:
        m = measure(pipeline.surface_of(copy.image), master_at(copy.template, copy.character))
    except RefusedImage as refusal:
        return MeasuredCopy(copy, None, refused=str(refusal))
    if m.refusal is not None:
        return MeasuredCopy(copy, None, refused=m.refusal.en)
    similarities = sim_paper(m.registration), similarity(m.registration)
    return MeasuredCopy(copy, m.features, *similarities, highest=m.highest)


def other_characters(copies: list[Copy]) -> list[Features]:
    """Features of each master against the masters of three other characters: a wrong character."""
    masters = sorted({copy.template for copy in copies})
    chosen = ((a, masters[(i + step) % len(masters)]) for i, a in enumerate(masters) for step in (1, 4, 9))
    return [measure(master_at(b).surface, master_at(a)).features for a, b in chosen if a != b]


def fit_panel(
    measured: Sequence[MeasuredCopy], others: list[Features], *, evidence: Evidence = WHOLE
) -> Calibration:
    """Scale and parts from marked copies, anchored; the interval is left at zero width."""
    kept = [(m.features, m.copy) for m in measured if m.features]
    vectors = np.array([features.vector() for features, _ in kept])
    marks, characters = np.array([c.mark for _, c in kept]), [c.character for _, c in kept]

    def fitted(rests_on: Evidence) -> Scale:
        return fit_evidence(vectors, marks, characters, evidence=rests_on)

    return Calibration(
        scale=anchor_scale(fitted(evidence), others=others),
        parts={part: anchor_scale(fitted(rests_on)) for part, rests_on in PARTS.items()},
        interval=(0.0, 0.0),
        provenance=f"{len(marks)} brush copies of {len(set(characters))} "
        "regular-script characters, each marked 1-10 by about ten people (E3C, Sun et al. 2023); "
        "panel mark = mean times ten",
    )


def hold_out_characters(measured: Sequence[MeasuredCopy], others: list[Features]) -> HeldOutMarks:
    """Scores of each character from the others; the interval's offsets likewise, from errors held out."""
    kept, refused = [m for m in measured if m.features], [m for m in measured if not m.features]
    characters = np.array([m.copy.character for m in kept])
    marks = np.array([m.copy.mark for m in kept])
    scores, low, high = (np.empty(len(kept)) for _ in range(3))
    for character in np.unique(characters):
        own = characters == character
        calibration = fit_panel([m for m, mine in zip(kept, own, strict=True) if not mine], others)
        scores[own] = [
            min(calibration.score(m.features), m.highest)
            for m, mine in zip(kept, own, strict=True)
            if mine and m.features
        ]
    for character in np.unique(characters):
        own = characters == character
        ends = np.percentile((marks - scores)[~own], TAILS)
        low[own], high[own] = (np.clip(scores[own] + end, 0, 100) for end in ends)
    ends = np.percentile(marks - scores, TAILS)
    standing = tuple(map(float, np.quantile(scores, np.linspace(0.0, 1.0, STANDING))))
    final = fit_panel(kept, others)
    final = replace(final, interval=(float(ends[0]), float(ends[1])), standing=standing)
    result = HeldOutMarks(tuple(kept), tuple(refused), marks, characters, scores, low, high, final)
    return replace(result, figures=_figures(result))


def agreement(predicted: FloatArray, marks: FloatArray, characters: np.ndarray) -> dict[str, float]:
    """Spearman over all copies, mean Spearman within a character, mean absolute error."""
    from scipy.stats import spearmanr

    within = [
        float(spearmanr(predicted[characters == c], marks[characters == c])[0])
        for c in np.unique(characters)
        if np.count_nonzero(characters == c) >= FEWEST
    ]
    return {
        "all": float(spearmanr(predicted, marks)[0]),
        "within": float(np.mean(within)),
        "mae": float(np.mean(np.abs(predicted - marks))),
    }


def _figures(result: HeldOutMarks) -> dict[str, Any]:
    measured, marks, characters = result.measured, result.panel, result.characters
    counts = np.unique(characters, return_counts=True)[1]
    inside = (result.low <= marks) & (marks <= result.high)
    raw = {name: np.array([getattr(m, name) for m in measured]) for name in ("similarity", "sim_paper")}
    return {
        "copies": len(measured) + len(result.refused),
        "refused": len(result.refused),
        "characters": len(counts),
        "characters_within": int(np.count_nonzero(counts >= FEWEST)),
        "score": agreement(result.scores, marks, characters),
        **{
            name: agreement(values, marks, characters)
            | {"mae": agreement(_on_panel_scale(values, marks, characters), marks, characters)["mae"]}
            for name, values in raw.items()
        },
        "rater": _one_rater(measured, characters),
        "constant_mae": float(np.mean(np.abs(marks - np.median(marks)))),
        "interval_coverage": float(inside.mean()),
        "interval_width": float(np.mean(result.high - result.low)),
        "level_shares_of_human_marks": _shares(marks, declared().cut_offs),
        "level_shares_of_scores": _shares(result.scores, CUT_OFFS["panel"]),
    }


def _on_panel_scale(values: FloatArray, marks: FloatArray, characters: np.ndarray) -> FloatArray:
    """A raw number put on the panel's scale by a straight line fitted on the other characters."""
    scores = np.empty(len(values))
    for c in np.unique(characters):
        own = characters == c
        slope, offset = np.polyfit(values[~own], marks[~own], 1)
        scores[own] = slope * values[own] + offset
    return scores


def _one_rater(measured: tuple[MeasuredCopy, ...], characters: np.ndarray) -> dict[str, float]:
    """The k-th rating of every copy against the mean of the others, averaged over k."""
    fewest = min(len(m.copy.ratings) for m in measured)
    figures = []
    for k in range(fewest):
        one = np.array([10.0 * m.copy.ratings[k] for m in measured])
        rest = np.array([10.0 * np.mean(np.delete(m.copy.ratings, k)) for m in measured])
        figures.append(agreement(one, rest, characters))
    return {name: float(np.mean([f[name] for f in figures])) for name in figures[0]}


def _shares(scores: FloatArray, cuts: Mapping[Any, float]) -> dict[str, float]:
    """The share of each level; cuts: of the panel's marks, or of the scores that estimate them."""
    levels = [level_of(float(score), cuts=cuts) for score in scores]
    return {name: levels.count(name) / len(levels) for name in (*CUT_OFFS["panel"], "bad")}  # type: ignore[arg-type]


def write_table(result: HeldOutMarks, path: Path) -> None:
    """One row a copy: image, character, panel's mark, held-out score with interval, or why refused."""
    from rumu.outputs import whole_file

    with whole_file(path) as part, part.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(
            ["image", "character", "panel", "score", "low", "high", "sim_paper", "similarity", "refused"]
        )
        for m, score, low, high in zip(result.measured, result.scores, result.low, result.high, strict=True):
            numbers = [f"{v:.2f}" for v in (m.copy.mark, score, low, high)]
            writer.writerow(
                [
                    m.copy.image.name,
                    m.copy.character,
                    *numbers,
                    f"{m.sim_paper:.6f}",
                    f"{m.similarity:.6f}",
                    "",
                ]
            )
        for m in result.refused:
            writer.writerow([m.copy.image.name, m.copy.character, f"{m.copy.mark:.2f}", *[""] * 5, m.refused])
