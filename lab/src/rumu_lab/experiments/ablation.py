"""What each part of the comparison is worth: height, direction, both ways, groups of features, density.

On human marks, one number a variant, the 5-D residual with the weights of that variant, goes through the
shared calibrator; no weight is fitted, so that variants differ in nothing else. The groups of features that
the mark weighs are left out of it one at a time, its weights fitted anew on the other characters. Gains have
intervals from a bootstrap over characters. Copies with human marks are binarised, so the darkness of ink as
its height is compared on simulated faults of the ink.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from rumu.assessment import fitting
from rumu.assessment.fitting import Evidence
from rumu.values import Bilingual, FloatArray
from rumu_lab.experiments.agreement import GradedMethod, held_out, raw_grades, side_by_side
from rumu_lab.experiments.e3c import HeldOutMarks, held_out_marks
from rumu_lab.experiments.findings import Cell, Column, Findings, Table
from rumu_lab.experiments.grading import Grades, GradingTask
from rumu_lab.experiments.marked_copies import chosen_copies
from rumu_lab.experiments.measuring import measure_each
from rumu_lab.experiments.run_settings import RunSettings
from rumu_lab.experiments.severities import Subject, key_of, starter_subjects, task_of
from rumu_lab.experiments.simulated_copies import Written
from rumu_lab.experiments.statistics import cluster_interval, spearman, within
from rumu_lab.experiments.variants import (
    BACKWARD,
    DENSITY,
    FORWARD,
    HEIGHT_METHODS,
    base_variant,
    base_weights,
    grade_by_heights,
    grade_by_variants,
    variant,
    weights,
)

WHOLE = "all groups"
INK_FAULTS = ("pale", "dry", "blot")


def run(settings: RunSettings) -> Findings:
    """Every variant on the marked copies. Raises CalibrationError when they are not there."""
    copies = chosen_copies(settings)
    tasks = [
        GradingTask(f"ablation/{c.image.name}", c.character, c.template, Written(c.image)) for c in copies
    ]
    grades = measure_each(grade_by_variants, tasks, settings)
    kept = [(c, g) for c, g in zip(copies, grades, strict=True) if g.refused is None]
    marks = np.array([c.mark for c, _ in kept])
    characters = [c.character for c, _ in kept]
    raw = raw_grades([g for _, g in kept])
    density = raw.pop(DENSITY)
    gains = gain_rows(raw, marks, characters, settings)
    groups: list[dict[str, Cell]] = []
    group_gains: list[dict[str, Cell]] = []
    if not settings.quick:  # a quick run has too few copies to fit weights
        groups, group_gains = group_rows(held_out_marks(settings), settings)
    heights = height_table(settings)
    facts: dict[str, Any] = {
        "copies": len(copies),
        "characters": len(set(characters)),
        "base": base_variant(),
        "variants": _rows_beside(
            [GradedMethod(name, v, held_out(v, marks, characters)) for name, v in raw.items()],
            marks,
            characters,
            ours=base_variant(),
            settings=settings,
        ),
        "gains": [*gains, *group_gains],
        "groups": groups,
        "density_measurable": int(np.isfinite(density).sum()),
        "third_dimension": next(g for g in gains if g["what"] == _height_gain(*base_weights())),
        "density": list(heights.rows),
    }
    return Findings("ablation", facts, (*_tables(facts), heights), _sentences(facts))


def _rows_beside(
    graded: Sequence[GradedMethod],
    marks: FloatArray,
    characters: Sequence[str],
    *,
    ours: str,
    settings: RunSettings,
) -> list[dict[str, Cell]]:
    """One row a variant, as in Table 2, beside the variant that the mark uses."""
    protocol = settings.protocol
    fewest = int(protocol.plain["human"]["fewest_within"])
    return side_by_side(graded, marks, characters, ours=ours, protocol=protocol, fewest=fewest)


def gain_rows(
    raw: Mapping[str, FloatArray], marks: FloatArray, characters: Sequence[str], settings: RunSettings
) -> list[dict[str, Cell]]:
    """What a part adds to the mean Spearman within a character, its interval, and whether it is clear."""
    height, direction = base_weights()
    base = base_variant()
    questions = [(_height_gain(h, d), variant(h, d), variant(0.0, d)) for h, d in weights() if h > 0]
    if direction:
        questions.append((f"direction x {direction:g}", base, variant(height, 0.0)))
    questions += [("both ways, against copy to master", base, FORWARD)]
    questions += [("both ways, against master to copy", base, BACKWARD)]
    return [
        {"what": what, **_gain((raw[more], raw[less]), marks, characters, settings=settings)}
        for what, more, less in questions
        if more in raw and less in raw
    ]


def _height_gain(height: float, direction: float) -> str:
    return f"height x {height:g}, with direction" if direction else f"height x {height:g}, without direction"


def _gain(
    pair: tuple[FloatArray, FloatArray],
    marks: FloatArray,
    characters: Sequence[str],
    *,
    settings: RunSettings,
) -> dict[str, Cell]:
    """How much better the first of two gradings ranks the copies of a character."""
    protocol = settings.protocol
    fewest = int(protocol.plain["human"]["fewest_within"])
    with_it, without_it = (within(spearman, r, marks, characters, fewest=fewest) for r in pair)
    gain = np.array([with_it[c] - without_it[c] for c in with_it])
    draw = {"resamples": protocol.resamples, "seed": protocol.resampling_seed}
    low, high = cluster_interval(gain, list(with_it), **draw)
    clear = "helps" if low > 0 else "harms" if high < 0 else "not shown"
    return {"n": len(gain), "gain": float(gain.mean()), "low": low, "high": high, "clear": clear}


# Groups of features left out of the mark, and alone.


def group_variants() -> dict[str, Evidence]:
    """Name -> evidence: all that the mark weighs, that without each group, each group alone.

    The groups are read from the code, so a new one takes part by itself.
    """
    found: dict[str, Evidence] = {WHOLE: fitting.WHOLE}
    for group in fitting.WHOLE:
        rest = {name: shrinkage for name, shrinkage in fitting.WHOLE.items() if name != group}
        found |= {f"without {group}": rest} if rest else {}
    return found | {f"{group} alone": {group: fitting.WHOLE[group]} for group in fitting.WHOLE}


def group_marks(
    held_out: HeldOutMarks, *, chosen: Mapping[str, Evidence] | None = None
) -> dict[str, FloatArray]:
    """Variant -> (N,) marks of copies whose character took no part in the fit; not anchored, no charges.

    chosen: some variants only.
    """
    vectors = np.array([m.features.vector() for m in held_out.measured if m.features])
    marks, characters = held_out.panel, held_out.characters
    found: dict[str, FloatArray] = {}
    for name, evidence in (chosen or group_variants()).items():
        given = np.empty(len(marks))
        for character in np.unique(characters):
            own = characters == character
            others = vectors[~own], marks[~own], characters[~own].tolist()
            scale = fitting.fit_evidence(*others, evidence=evidence)
            given[own] = [scale.weighted_sum(row) for row in vectors[own]]
        found[name] = np.clip(given, 0.0, 100.0)
    return found


def group_rows(
    held_out: HeldOutMarks, settings: RunSettings
) -> tuple[list[dict[str, Cell]], list[dict[str, Cell]]]:
    """Rows of all variants as in Table 2, and what each group adds to the Spearman within a character."""
    marks, characters = held_out.panel, held_out.characters.tolist()
    given = group_marks(held_out)
    graded = [GradedMethod(name, values, values) for name, values in given.items()]
    rows = _rows_beside(graded, marks, characters, ours=WHOLE, settings=settings)
    gains: list[dict[str, Cell]] = [
        {
            "what": f"group {name.removeprefix('without ')}",
            **_gain((given[WHOLE], values), marks, characters, settings=settings),
        }
        for name, values in given.items()
        if name.startswith("without ")
    ]
    return rows, gains


# The darkness of ink as its height.


def height_table(settings: RunSettings) -> Table:
    """Mean Spearman with falling severity, fault by fault, for both kinds of height."""
    subjects = [
        replace(s, faults=tuple(f for f in s.faults if f in INK_FAULTS))
        for s in starter_subjects(settings.protocol)
    ]
    columns = (
        Column("fault", Bilingual("毛病", "fault")),
        Column("n", Bilingual("系列", "series")),
        Column("whole", Bilingual("可量的", "measured")),
        Column("inflation", Bilingual("充氣為高度", "height by inflation")),
        Column("density", Bilingual("墨色為高度", "height by density")),
    )
    note = Bilingual(
        "真人評分的臨作已二值化，墨色只有一種，故此項只能在模擬的墨病上比。數為與程度的等級相關，一為最好。",
        "Copies with human marks are binarised, so this is compared on simulated faults of the ink. Spearman "
        "with falling severity, 1 is best.",
    )
    title = Bilingual("以墨色濃淡為高度", "Ink density as height")
    rows = height_rows([s for s in subjects if s.faults], settings)
    return Table("ablation-density", title, columns, tuple(rows), (note,))


def height_rows(subjects: Sequence[Subject], settings: RunSettings) -> list[dict[str, Cell]]:
    """One row a fault: series, how many could be measured, and each kind's mean Spearman, best 1."""
    protocol = settings.protocol
    severities = (0, *protocol.severities)
    plan = [(s, fault, k) for s in subjects for fault in s.faults for k in severities]
    tasks = {key_of(*step): task_of(*step, seed=protocol.simulation_seed) for step in plan}
    by_key = {g.key: g for g in measure_each(grade_by_heights, list(tasks.values()), settings)}
    rows: list[dict[str, Cell]] = []
    for fault in dict.fromkeys(f for s in subjects for f in s.faults):
        series = [[by_key[key_of(s, fault, k)] for k in severities] for s in subjects if fault in s.faults]
        whole = [one for one in series if all(g.refused is None for g in one)]
        rows.append({"fault": fault, "n": len(series), "whole": len(whole), **_ranks(whole, severities)})
    return rows


def _ranks(series: Sequence[Sequence[Grades]], severities: Sequence[int]) -> dict[str, Cell]:
    if not series:
        return {}
    good = -np.array(severities, float)
    return {
        method: float(np.mean([spearman(np.array([g.raw[method] for g in one]), good) for one in series]))
        for method in HEIGHT_METHODS
    }


# What is printed.


_VARIANTS = tuple(
    Column(key, Bilingual(zh, en), digits)
    for key, zh, en, digits in (
        ("method", "做法", "variant", 0),
        ("n", "件數", "N", 0),
        ("within", "同字等級相關", "Spearman within", 3),
        ("within_low", "下限", "low", 3),
        ("within_high", "上限", "high", 3),
        ("all", "總等級相關", "Spearman all", 3),
        ("mae", "絕對誤差均值", "mean abs. error", 2),
        ("sd", "標準差", "SD", 2),
    )
)
_GAINS = tuple(
    Column(key, Bilingual(zh, en), 3)
    for key, zh, en in (
        ("what", "加上什麼", "what is added"),
        ("n", "字數", "characters"),
        ("gain", "同字等級相關增加", "gain in Spearman within"),
        ("low", "下限", "low"),
        ("high", "上限", "high"),
        ("clear", "結論", "shown"),
    )
)


def _tables(facts: Mapping[str, Any]) -> tuple[Table, ...]:
    about = Bilingual(
        f"{facts['copies']} 件、{facts['characters']} 個字；"
        "每種做法只有一個數（殘差上四分位的均值），不擬合權重；"
        f"分數所用的是「{facts['base']}」。",
        f"{facts['copies']} copies of {facts['characters']} characters. One number a variant (mean upper "
        f"quartile of the residuals), no weight fitted; the mark uses '{facts['base']}'.",
    )
    density = Bilingual(
        "以墨色濃淡為高度：這些圖已二值化，"
        f"{facts['copies']} 件中能比的有 {facts['density_measurable']} 件。",
        "Ink density as height: these pictures are binarised, so it can be measured on "
        f"{facts['density_measurable']} of {facts['copies']}.",
    )
    fitted = Bilingual(
        "權重在其餘的字上重新擬合；未錨定，不扣傾斜、位置、大小。各組名出自程序。",
        "Weights are fitted anew on the other characters; not anchored, no charges for lean, place and size. "
        "The groups are those of the code.",
    )
    gains = Bilingual(
        "各部分的增益（按字自助法，95 %）", "What each part adds (bootstrap over characters, 95 %)"
    )
    title, groups = (
        Bilingual("消融", "Ablations"),
        Bilingual("分數去掉一組依據", "The mark with groups left out"),
    )
    tables = [
        Table("ablation", title, _VARIANTS, tuple(facts["variants"]), (about, density)),
        Table("ablation-gains", gains, _GAINS, tuple(facts["gains"]), (about,)),
    ]
    if facts["groups"]:
        tables.append(Table("ablation-groups", groups, _VARIANTS, tuple(facts["groups"]), (fitted,)))
    return tuple(tables)


def _sentences(facts: Mapping[str, Any]) -> tuple[Bilingual, ...]:
    found = facts["third_dimension"]
    span = f"{found['gain']:+.3f} [{found['low']:+.3f}, {found['high']:+.3f}]"
    words = {
        "helps": ("第三維有用", "The third dimension helps"),
        "harms": ("第三維有害", "The third dimension harms"),
        "not shown": ("第三維有用與否，未能證明", "That the third dimension helps is NOT shown"),
    }[str(found["clear"])]
    alone = Bilingual(
        f"{words[0]}：以分數所用的權重，單看殘差（不擬合），同字等級相關增加 {span}。",
        f"{words[1]} at the weight that the mark uses, as one residual with nothing fitted: gain in Spearman "
        f"within a character {span}.",
    )
    groups = [g for g in facts["gains"] if str(g["what"]).startswith("group ")]
    return (alone, _groups_sentence(groups)) if groups else (alone,)


def _groups_sentence(groups: Sequence[Mapping[str, Any]]) -> Bilingual:
    """Which groups the fitted mark is shown to need, and which another group can stand in for."""

    def named(clear: bool) -> str:
        return ", ".join(
            str(g["what"]).removeprefix("group ") for g in groups if (g["clear"] == "helps") == clear
        )

    needed, spared = named(True) or "-", named(False) or "-"
    return Bilingual(
        f"分數的各組依據逐一去掉：證明有用的是 {needed}；未能證明的是 {spared}。",
        f"Of the mark's own groups of evidence, left out one at a time: shown to help {needed}; "
        f"not shown {spared}.",
    )
