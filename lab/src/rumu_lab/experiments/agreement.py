"""Methods side by side on the same copies, through the same calibrator, on the same folds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rumu.values import Bilingual, FloatArray
from rumu_lab.experiments.findings import Cell, Column
from rumu_lab.experiments.grading import Grades
from rumu_lab.experiments.protocol import ExperimentProtocol
from rumu_lab.experiments.statistics import (
    Labels,
    cluster_interval,
    cluster_means,
    holm,
    order_accuracy,
    paired_p,
    spearman,
    within,
)

CONSTANT = "constant"


@dataclass(frozen=True, slots=True, eq=False)
class GradedMethod:
    """One method on N copies.

    raw: (N,) its own grades, from which ranks are taken; None for a constant, which ranks nothing.
    given: (N,) 0-100, its held-out marks, from which the error is taken.
    """

    name: str
    raw: FloatArray | None
    given: FloatArray


def raw_grades(measured: Sequence[Grades]) -> dict[str, FloatArray]:
    """Method -> (N,) raw grades of copies that were not refused."""
    return {name: np.array([m.raw[name] for m in measured]) for name in measured[0].raw}


def held_out(raw: FloatArray, marks: FloatArray, folds: Labels) -> FloatArray:
    """(N,) marks of each fold by the shared calibrator fitted on the other folds."""
    from rumu_lab.baselines.calibrator import fit

    labels, given = np.asarray(folds), np.empty(len(marks))
    for fold in np.unique(labels):
        own = labels == fold
        curve = fit(raw[~own], marks[~own])
        given[own] = [curve.read(float(value)) for value in raw[own]]
    return given


def constant(marks: FloatArray, folds: Labels) -> GradedMethod:
    """The median of the other folds' marks, for every copy."""
    labels = np.asarray(folds)
    given = np.empty(len(marks))
    for fold in np.unique(labels):
        given[labels == fold] = np.median(marks[labels != fold])
    return GradedMethod(CONSTANT, None, given)


def side_by_side(
    methods: Sequence[GradedMethod],
    marks: FloatArray,
    clusters: Labels,
    *,
    ours: str,
    protocol: ExperimentProtocol,
    fewest: int = 2,
) -> list[dict[str, Cell]]:
    """One row a method, least error first.

    all, within: Spearman of the raw grade with the marks, over all copies and as mean over clusters of at
    least `fewest` copies; order: share of pairs of a cluster in the right order; mae, sd: of the absolute
    error; difference: mean error less ours; p, p_copies: Wilcoxon against ours on the means of clusters, and
    on copies, Holm's; *_low, *_high: 95 %.
    """
    draw = {"resamples": protocol.resamples, "seed": protocol.resampling_seed}
    errors = {m.name: np.abs(m.given - marks) for m in methods}
    mine = errors[ours]
    rows = []
    for method in methods:
        error = errors[method.name]
        row: dict[str, Cell] = {
            "method": method.name,
            "n": len(marks),
            **_ranks(method.raw, marks, clusters, fewest=fewest, draw=draw),
            "mae": float(error.mean()),
            "sd": float(error.std()),
            **_ends("mae", cluster_interval(error, clusters, **draw)),
        }
        if method.name != ours:
            row |= {"difference": float((error - mine).mean())}
            row |= _ends("difference", cluster_interval(error - mine, clusters, **draw))
        rows.append(row)
    _test(rows, errors, clusters, ours=ours)
    return sorted(rows, key=lambda row: float(row["mae"] or 0.0))


def _ranks(
    raw: FloatArray | None, marks: FloatArray, clusters: Labels, *, fewest: int, draw: Mapping[str, int]
) -> dict[str, Cell]:
    if raw is None:
        return {}
    each = within(spearman, raw, marks, clusters, fewest=fewest)
    order = within(order_accuracy, raw, marks, clusters, fewest=fewest)
    values = np.array(list(each.values()))
    return {
        "all": spearman(raw, marks),
        "within": float(values.mean()),
        **_ends("within", cluster_interval(values, list(each), **draw)),
        "order": float(np.mean(list(order.values()))),
    }


def _test(
    rows: Sequence[dict[str, Cell]], errors: Mapping[str, FloatArray], clusters: Labels, *, ours: str
) -> None:
    means = {name: cluster_means(error, clusters) for name, error in errors.items()}
    others = [row for row in rows if row["method"] != ours]
    p = [paired_p(means[str(row["method"])], means[ours]) for row in others]
    each = [paired_p(errors[str(row["method"])], errors[ours]) for row in others]
    for row, corrected, over_copies in zip(others, holm(p), holm(each), strict=True):
        row |= {"p": corrected, "p_copies": over_copies}


def _ends(name: str, interval: tuple[float, float]) -> dict[str, Cell]:
    return {f"{name}_low": interval[0], f"{name}_high": interval[1]}


COLUMNS: tuple[Column, ...] = (
    Column("method", Bilingual("方法", "method")),
    Column("n", Bilingual("件數", "N")),
    Column("within", Bilingual("同字等級相關", "Spearman within"), 3),
    Column("within_low", Bilingual("下限", "low"), 3),
    Column("within_high", Bilingual("上限", "high"), 3),
    Column("all", Bilingual("總等級相關", "Spearman all"), 3),
    Column("order", Bilingual("成對次序正確率", "pairs in order"), 3),
    Column("mae", Bilingual("絕對誤差均值", "mean abs. error")),
    Column("sd", Bilingual("標準差", "SD")),
    Column("mae_low", Bilingual("下限", "low")),
    Column("mae_high", Bilingual("上限", "high")),
    Column("difference", Bilingual("比我們多", "more than ours")),
    Column("difference_low", Bilingual("下限", "low")),
    Column("difference_high", Bilingual("上限", "high")),
    Column("p", Bilingual("p（按字）", "p, clusters"), 4),
    Column("p_copies", Bilingual("p（按件）", "p, copies"), 4),
)


FEW_CLUSTERS = Bilingual(
    "p 為 Wilcoxon 符號秩檢驗（Holm 校正）：按字（或作品）的均值，成對數少，不易分出高下；"
    "按件則把同一字的各件當作獨立，其實不然。",
    "p: Wilcoxon signed rank, Holm's. On means of clusters there are few pairs, so it tells little apart; on "
    "copies it takes those of one character as independent, which they are not.",
)


def verdict(rows: Sequence[Mapping[str, Any]], *, ours: str, besides: Sequence[str] = ()) -> dict[str, Any]:
    """Whether ours comes first and how clearly, from the figures.

    besides: rows that are our own in other clothes, and are no rivals. rank: place of ours by mean absolute
    error; margin: to the best rival, positive when ours is better; not_beaten: rivals from which ours is not
    clearly apart (interval with 0, or p of .05 and more).
    """
    rivals = [row for row in rows if row["method"] not in (ours, *besides)]
    mine = next(row for row in rows if row["method"] == ours)
    ahead = [row["method"] for row in rivals if row["mae"] < mine["mae"]]
    near = [r["method"] for r in rivals if not (r["difference_low"] > 0 and r["p"] < 0.05)]
    best = min(rivals, key=lambda row: float(row["mae"]))
    first_by_rank = max((r for r in rivals if r.get("within") is not None), key=lambda r: float(r["within"]))
    return {
        "ours": ours,
        "rank": 1 + len(ahead),
        "rivals": len(rivals),
        "mae": mine["mae"],
        "best_rival": best["method"],
        "best_rival_mae": best["mae"],
        "margin": float(best["mae"]) - float(mine["mae"]),
        "ahead": ahead,
        "not_beaten": near,
        "clear": not ahead and not near,
        "within": mine["within"],
        "best_rival_by_rank": first_by_rank["method"],
        "best_rival_within": first_by_rank["within"],
    }


def verdict_sentence(found: Mapping[str, Any], *, zh: str, en: str) -> Bilingual:
    """The verdict in words. zh, en: on what."""
    figures_zh = (
        f"絕對誤差均值 {found['mae']:.2f}，最好的對手（{found['best_rival']}）{found['best_rival_mae']:.2f}"
    )
    figures_en = (
        f"mean absolute error {found['mae']:.2f} against {found['best_rival_mae']:.2f} of the best rival "
        f"({found['best_rival']})"
    )
    if found["clear"]:
        return Bilingual(
            f"{zh}，我們明顯居首：{figures_zh}。", f"{en}, ours is first by a clear margin: {figures_en}."
        )
    if not found["ahead"]:
        near = ", ".join(found["not_beaten"])
        return Bilingual(
            f"{zh}，我們居首，但並非明顯領先：{figures_zh}；與這些方法未能分出高下：{near}。",
            f"{en}, ours is first, but NOT by a clear margin: {figures_en}; "
            f"it is not clearly apart from {near}.",
        )
    return Bilingual(
        f"{zh}，我們不居首，名列第 {found['rank']}（共 {found['rivals'] + 1}）：{figures_zh}。",
        f"{en}, ours is NOT first but number {found['rank']} of {found['rivals'] + 1}: {figures_en}.",
    )
