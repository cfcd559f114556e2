"""What each part of the comparison is worth on human marks: height, direction, both ways, density, features.

One number a variant, the 5-D residual with the weights of that variant, goes through the shared calibrator;
no weight is fitted, so that variants differ in nothing else. Gains have intervals from a bootstrap over
characters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from rumu.values import Bilingual, FloatArray
from rumu_lab.experiments.agreement import Graded, held_out, side_by_side
from rumu_lab.experiments.density import density_table
from rumu_lab.experiments.findings import Cell, Column, Findings, RunSettings, Table
from rumu_lab.experiments.human_marks import chosen_copies
from rumu_lab.experiments.measuring import GradingTask, Measured, measure_by
from rumu_lab.experiments.simulated_copies import Written
from rumu_lab.experiments.statistics import cluster_interval, spearman, within
from rumu_lab.experiments.variants import (
    BACKWARD,
    DENSITY,
    FORWARD,
    base_variant,
    base_weights,
    measure_variants,
    variant,
    weights,
)


def run(settings: RunSettings) -> Findings:
    """Every variant on the marked copies. Raises CalibrationError when they are not there."""
    copies = chosen_copies(settings)
    tasks = [
        GradingTask(f"ablation/{c.image.name}", c.character, c.template, Written(c.image)) for c in copies
    ]
    measured = measure_by(measure_variants, tasks, store=settings.store, progress=settings.progress)
    kept = [(c, m) for c, m in zip(copies, measured, strict=True) if m.refused is None]
    marks = np.array([c.mark for c, _ in kept])
    characters = [c.character for c, _ in kept]
    raw = {name: _column([m for _, m in kept], name) for name in kept[0][1].raw}
    density = raw.pop(DENSITY)
    rows = variant_rows(raw, marks, characters, settings)
    gains = gain_rows(raw, marks, characters, settings)
    groups, group_gains = ([], []) if settings.quick else _groups(settings)
    facts: dict[str, Any] = {
        "copies": len(copies),
        "characters": len(set(characters)),
        "base": base_variant(),
        "variants": rows,
        "gains": [*gains, *group_gains],
        "groups": groups,
        "density_measurable": int(np.isfinite(density).sum()),
        "third_dimension": next(g for g in gains if g["what"] == _height_gain(*base_weights())),
    }
    ink = density_table(settings)
    facts["density"] = list(ink.rows)
    return Findings("ablation", facts, (*_tables(facts), ink), _sentences(facts))


def _groups(settings: RunSettings) -> tuple[list[dict[str, Cell]], list[dict[str, Cell]]]:
    """Groups of evidence left out of the fitted mark; a quick run has too few copies to fit it."""
    from rumu_lab.experiments.groups import group_rows, predictions
    from rumu_lab.experiments.people import marked_copies

    marked = marked_copies(settings)
    return group_rows(predictions(marked), marked, settings)


def _column(measured: Sequence[Measured], name: str) -> FloatArray:
    return np.array([m.raw[name] for m in measured], dtype=float)


def variant_rows(
    raw: Mapping[str, FloatArray], marks: FloatArray, characters: Sequence[str], settings: RunSettings
) -> list[dict[str, Cell]]:
    """One row a variant, as in Table 2, beside the variant that the mark uses."""
    graded = [Graded(name, values, held_out(values, marks, characters)) for name, values in raw.items()]
    fewest = int(settings.protocol.plain["human"]["fewest_within"])
    return side_by_side(
        graded, marks, characters, ours=base_variant(), protocol=settings.protocol, fewest=fewest
    )


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
        _gain(what, (raw[more], raw[less]), marks, characters, settings=settings)
        for what, more, less in questions
        if more in raw and less in raw
    ]


def _height_gain(height: float, direction: float) -> str:
    return f"height x {height:g}, with direction" if direction else f"height x {height:g}, without direction"


def _gain(
    what: str,
    pair: tuple[FloatArray, FloatArray],
    marks: FloatArray,
    characters: Sequence[str],
    *,
    settings: RunSettings,
) -> dict[str, Cell]:
    protocol = settings.protocol
    fewest = int(protocol.plain["human"]["fewest_within"])
    with_it, without = (within(spearman, r, marks, characters, fewest=fewest) for r in pair)
    gain = np.array([with_it[c] - without[c] for c in with_it])
    low, high = cluster_interval(
        gain, list(with_it), resamples=protocol.resamples, seed=protocol.resampling_seed
    )
    clear = "helps" if low > 0 else "harms" if high < 0 else "not shown"
    return {
        "what": what,
        "n": len(gain),
        "gain": float(gain.mean()),
        "low": low,
        "high": high,
        "clear": clear,
    }


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
    told = {
        "helps": ("第三維有用", "The third dimension helps"),
        "harms": ("第三維有害", "The third dimension harms"),
        "not shown": ("第三維有用與否，未能證明", "That the third dimension helps is NOT shown"),
    }[str(found["clear"])]
    alone = Bilingual(
        f"{told[0]}：以分數所用的權重，單看殘差（不擬合），同字等級相關增加 {span}。",
        f"{told[1]} at the weight that the mark uses, as one residual with nothing fitted: gain in Spearman "
        f"within a character {span}.",
    )
    groups = [g for g in facts["gains"] if str(g["what"]).startswith("group ")]
    return (alone, _left_out(groups)) if groups else (alone,)


def _left_out(groups: Sequence[Mapping[str, Any]]) -> Bilingual:
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
