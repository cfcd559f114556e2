"""Agreement with people on learners' brush copies, whole characters held out.

Data: the E3C copies with their marks (Sun et al., SRAFE, CAAI Trans. Intell. Technol. 2023); each copy was
marked 1-10 by about ten people. The panel's mark is their mean times ten. Every figure on a copy comes from
weights, anchors and interval fitted without any copy of its character. Nothing here is tuned on the copies
it reports, but the choice of residuals and of their weights in the matching was made on these characters.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from rumu.assessment.calibration import LEVELS, Calibration, level_of
from rumu.assessment.features import Features
from rumu.assessment.fitting import PARTS, WEIGHED, anchored, fit_scale
from rumu.assessment.measurement import PreparedMaster, measure
from rumu.errors import CalibrationError, RefusedImage
from rumu.executors import in_order
from rumu.values import FloatArray

Progress = Callable[[int, int], None]

FEWEST = 5
"""A rank correlation within a character is taken where it has at least this many copies."""
TAILS = (9, 91)
"""Percentiles of held-out errors at which the 80 % interval ends: a little wide, since characters are few."""


@dataclass(frozen=True, slots=True)
class Copy:
    """One row of scores.csv. mark: the panel's mark, 0-100; ratings: one a rater, 1-10."""

    image: Path
    template: Path
    character: str
    mark: float
    ratings: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Measured:
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
class Result:
    """Marks on held-out characters beside the panel's. scores, low, high: (N,) for the marked copies."""

    measured: tuple[Measured, ...]
    refused: tuple[Measured, ...]
    scores: FloatArray
    low: FloatArray
    high: FloatArray
    calibration: Calibration
    figures: Mapping[str, Any] = field(default_factory=dict)

    def summary(self) -> dict[str, Any]:
        """All figures, plain."""
        return dict(self.figures)

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


def run(data: str | Path, *, out: str | Path | None = None, progress: Progress | None = None) -> Result:
    """Mark all copies under `data`/e3c with their own character held out, and compare with the panel.

    out: a folder for e3c.csv, one row a copy. Raises CalibrationError when the data is not there.
    """
    copies = read_copies(Path(data))
    measured = measure_all(copies, progress=progress)
    others = other_characters(copies)
    result = held_out([m for m in measured if m.features], [m for m in measured if not m.features], others)
    if out is not None:
        write_table(result, Path(out) / "e3c.csv")
    return result


def read_copies(data: Path) -> list[Copy]:
    """The rows of scores.csv, paths resolved."""
    table = data / "e3c" / "scores.csv"
    if not table.is_file():
        raise CalibrationError(
            f"{table}: expected the E3C marks here (set RUMU_DATA or --data), found nothing"
        )
    with table.open(encoding="utf-8", newline="") as stream:
        return [
            Copy(
                table.parent / row["image"],
                table.parent / row["template"],
                row["character"],
                10.0 * float(row["mean_score"]),
                tuple(map(float, row["ratings"].split())),
            )
            for row in csv.DictReader(stream)
        ]


def measure_all(copies: list[Copy], *, progress: Progress | None = None) -> list[Measured]:
    """Every copy measured against its master, on all cores, in order."""
    measured = []
    for item in in_order(measure_copy, copies):
        measured.append(item)
        if progress:
            progress(len(measured), len(copies))
    return measured


def measure_copy(copy: Copy) -> Measured:
    """One copy against its master."""
    from rumu import pipeline
    from rumu.assessment.similarity import sim_paper, similarity

    master = _master(copy.template)
    try:
        m = measure(pipeline.surface_of(copy.image), master)
    except RefusedImage as refusal:
        return Measured(copy, None, refused=str(refusal))
    if m.refusal is not None:
        return Measured(copy, None, refused=m.refusal.en)
    similarities = sim_paper(m.registration), similarity(m.registration)
    return Measured(copy, m.features, *similarities, highest=m.highest)


def other_characters(copies: list[Copy]) -> list[Features]:
    """Features of each master against the masters of three other characters: a wrong character."""
    masters = sorted({copy.template for copy in copies})
    chosen = ((a, masters[(i + step) % len(masters)]) for i, a in enumerate(masters) for step in (1, 4, 9))
    return [measure(_master(b).surface, _master(a)).features for a, b in chosen if a != b]


def fit_panel(measured: list[Measured], others: list[Features]) -> Calibration:
    """Scale and parts from marked copies, anchored; the interval is left at zero width."""
    kept = [(m.features, m.copy) for m in measured if m.features]
    evidence = np.array([features.evidence() for features, _ in kept])
    marks, characters = np.array([c.mark for _, c in kept]), [c.character for _, c in kept]
    scale = fit_scale(evidence, marks, characters, names=WEIGHED)
    parts = {part: fit_scale(evidence, marks, characters, names=names) for part, names in PARTS.items()}
    return Calibration(
        scale=anchored(scale, others=others),
        parts={part: anchored(scale) for part, scale in parts.items()},
        interval=(0.0, 0.0),
        provenance=f"{len(marks)} brush copies of {len(set(characters))} "
        "regular-script characters, each marked 1-10 by about ten people (E3C, Sun et al. 2023); "
        "panel mark = mean times ten",
    )


def held_out(measured: list[Measured], refused: list[Measured], others: list[Features]) -> Result:
    """Scores of each character from the others; the interval's offsets likewise, from errors held out."""
    characters = np.array([m.copy.character for m in measured])
    marks = np.array([m.copy.mark for m in measured])
    scores = np.empty(len(measured))
    for character in np.unique(characters):
        own = characters == character
        calibration = fit_panel([m for m, mine in zip(measured, own, strict=True) if not mine], others)
        scores[own] = [
            min(calibration.score(m.features), m.highest)
            for m, mine in zip(measured, own, strict=True)
            if mine and m.features
        ]
    low, high = np.empty(len(measured)), np.empty(len(measured))
    for character in np.unique(characters):
        own = characters == character
        offsets = np.percentile((marks - scores)[~own], TAILS)
        low[own], high[own] = (
            np.clip(scores[own] + offsets[0], 0, 100),
            np.clip(scores[own] + offsets[1], 0, 100),
        )
    whole = fit_panel(measured, others)
    offsets = np.percentile(marks - scores, TAILS)
    final = replace(whole, interval=(float(offsets[0]), float(offsets[1])))
    result = Result(tuple(measured), tuple(refused), scores, low, high, final)
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


def _figures(result: Result) -> dict[str, Any]:
    measured = result.measured
    marks = np.array([m.copy.mark for m in measured])
    characters = np.array([m.copy.character for m in measured])
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
            | {"mae": agreement(_lined_up(values, marks, characters), marks, characters)["mae"]}
            for name, values in raw.items()
        },
        "rater": _one_rater(measured, characters),
        "constant_mae": float(np.mean(np.abs(marks - np.median(marks)))),
        "interval_coverage": float(inside.mean()),
        "interval_width": float(np.mean(result.high - result.low)),
        "level_shares_of_human_marks": _shares(marks),
        "level_shares_of_scores": _shares(result.scores),
    }


def _lined_up(values: FloatArray, marks: FloatArray, characters: np.ndarray) -> FloatArray:
    """A raw number put on the panel's scale by a straight line fitted on the other characters."""
    scores = np.empty(len(values))
    for c in np.unique(characters):
        own = characters == c
        slope, offset = np.polyfit(values[~own], marks[~own], 1)
        scores[own] = slope * values[own] + offset
    return scores


def _one_rater(measured: tuple[Measured, ...], characters: np.ndarray) -> dict[str, float]:
    """The k-th rating of every copy against the mean of the others, averaged over k."""
    fewest = min(len(m.copy.ratings) for m in measured)
    figures = []
    for k in range(fewest):
        one = np.array([10.0 * m.copy.ratings[k] for m in measured])
        rest = np.array([10.0 * np.mean(np.delete(m.copy.ratings, k)) for m in measured])
        figures.append(agreement(one, rest, characters))
    return {name: float(np.mean([f[name] for f in figures])) for name in figures[0]}


def _shares(scores: FloatArray) -> dict[str, float]:
    levels = [level_of(float(score)) for score in scores]
    return {name: levels.count(name) / len(levels) for name in (*LEVELS["panel"], "bad")}  # type: ignore[arg-type]


def write_table(result: Result, path: Path) -> None:
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


@lru_cache(maxsize=32)
def _master(path: Path) -> PreparedMaster:
    from rumu.pipeline import prepare_master

    return prepare_master(path)
