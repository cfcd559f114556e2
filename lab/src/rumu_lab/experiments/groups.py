"""Each group of the evidence that the mark weighs left out, and alone: what it adds on human marks.

Groups and names are read from the code, so that a new group is ablated without being told. Weights are fitted
anew on the other characters for every variant, as the mark's own are.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from rumu.values import FloatArray
from rumu_lab.experiments.agreement import Graded, side_by_side
from rumu_lab.experiments.findings import Cell, RunSettings
from rumu_lab.experiments.people import Marked
from rumu_lab.experiments.statistics import cluster_interval, spearman, within

WHOLE = "all groups"


def variants() -> dict[str, tuple[str, ...]]:
    """Name -> the evidence it weighs: everything the mark weighs, less each group, and each group alone."""
    from rumu.assessment.features import GROUPS
    from rumu.assessment.fitting import WEIGHED

    found = {WHOLE: tuple(WEIGHED)}
    used = {g: [n for n in names if n in WEIGHED] for g, names in GROUPS.items()}
    for group, names in used.items():
        rest = tuple(n for n in WEIGHED if n not in names)
        if names and rest:
            found[without(group)] = rest
    found |= {alone(group): tuple(names) for group, names in used.items() if names}
    return found


def without(group: str) -> str:
    """The name of the variant that lacks a group."""
    return f"without {group}"


def alone(group: str) -> str:
    """The name of the variant that has only this group."""
    return f"{group} alone"


def predictions(
    marked: Marked, *, chosen: Mapping[str, tuple[str, ...]] | None = None
) -> dict[str, FloatArray]:
    """Variant -> (N,) marks of copies whose character took no part in the fit; not anchored, no charges.

    chosen: some variants only.
    """
    from rumu.assessment.fitting import fit_scale

    evidence, marks = np.array(marked.evidence), np.array(marked.panel)
    characters = np.array(marked.characters)
    found: dict[str, FloatArray] = {}
    for name, weighed in (chosen or variants()).items():
        given = np.empty(len(marks))
        for character in np.unique(characters):
            own = characters == character
            scale = fit_scale(evidence[~own], marks[~own], characters[~own].tolist(), names=weighed)
            given[own] = [scale.sum_of(row) for row in evidence[own]]
        found[name] = np.clip(given, 0.0, 100.0)
    return found


def group_rows(
    given: Mapping[str, FloatArray], marked: Marked, settings: RunSettings
) -> tuple[list[dict[str, Cell]], list[dict[str, Cell]]]:
    """Rows of all variants as in Table 2, and what each group adds to the Spearman within a character."""
    marks, characters = np.array(marked.panel), list(marked.characters)
    protocol = settings.protocol
    fewest = int(protocol.plain["human"]["fewest_within"])
    graded = [Graded(name, values, values) for name, values in given.items()]
    rows = side_by_side(graded, marks, characters, ours=WHOLE, protocol=protocol, fewest=fewest)
    ranks = {n: within(spearman, v, marks, characters, fewest=fewest) for n, v in given.items()}
    gains: list[dict[str, Cell]] = []
    for name in given:
        if name.startswith("without "):
            group = name.removeprefix("without ")
            gains.append({"what": f"group {group}", **_gain(ranks[WHOLE], ranks[name], settings)})
    return rows, gains


def _gain(more: Mapping[str, float], less: Mapping[str, float], settings: RunSettings) -> dict[str, Cell]:
    gain = np.array([more[c] - less[c] for c in more])
    draw = {"resamples": settings.protocol.resamples, "seed": settings.protocol.resampling_seed}
    low, high = cluster_interval(gain, list(more), **draw)
    clear = "helps" if low > 0 else "harms" if high < 0 else "not shown"
    return {"n": len(gain), "gain": float(gain.mean()), "low": low, "high": high, "clear": clear}
