"""The same character or another? The area under the curve over the sets of masters, and E3C.

In each set every character gives as many pairs of the same character (another work, another version, a
learner's copy and its template) as of two different ones, and each measure is asked to part the two. 1 is
without error, .5 is chance. Intervals come from drawing characters anew, not pairs.

Labels name characters and not forms: some pairs of one character in the regular works show two forms of
it (號 and 号, 臺 and 台) or are labelled wrongly, and the Lanting Xu varies its forms on purpose. Such
pairs stay in; they bound what any comparison of shapes can reach.
"""

from __future__ import annotations

import csv
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rumu.errors import RefusedImage, RegistrationError
from rumu.gallery.masters import Master, read_masters
from rumu.pipeline import measure
from rumu.values import FloatArray
from rumu_lab.experiments.findings import Findings
from rumu_lab.experiments.marked_copies import read_copies
from rumu_lab.experiments.measuring import master_at, measure_each
from rumu_lab.experiments.run_settings import RunSettings

MEASURES: Mapping[str, str] = {
    "score": "the mark as it is given, nothing when refused",
    "mark": "the mark, before any refusal",
    "similarity": "two-sided similarity",
    "position": "what registration leaves in the plane",
    "likeness": "likeness of outlines",
    "beyond others": "likeness beyond what other characters reach",
    "familiarity": "the last with what registration leaves, as refusal weighs them",
}
DRAWS = 1000


@dataclass(frozen=True, slots=True)
class CharacterPair:
    """Two pictures of one character, or of two. character: of the first, by which intervals are drawn."""

    where: str
    character: str
    copy: Path
    master: Path
    same: bool


@dataclass(frozen=True, slots=True)
class PairMeasures:
    """One pair with its measures, more is more alike; None when a picture holds nothing to compare."""

    pair: CharacterPair
    measures: Mapping[str, float] | None


def run(settings: RunSettings, *, chosen: Sequence[CharacterPair] | None = None) -> Findings:
    """How well each measure tells pairs of one character from pairs of two.

    Writes OUT/tables/identity.csv, one row a pair. chosen: other pairs than all of them. Raises RumuError
    when the data is not there.
    """
    chosen = list(pairs(settings.data)) if chosen is None else chosen
    measured = measure_each(measure_pair, chosen, settings)
    if settings.tables is not None:
        write_table(measured, settings.tables / "identity.csv")
    facts = figures(measured)
    return Findings("identity", facts, words=text(facts))


def text(facts: Mapping[str, Any]) -> str:
    """The figures as a person reads them."""
    lines = []
    for where, of_set in facts.items():
        lines.append(
            f"{where}: {of_set['same']} pairs of one character, {of_set['other']} of two, "
            f"{of_set['characters']} characters, {of_set['left_out']} pairs left out"
        )
        for name, meaning in MEASURES.items():
            f = of_set[name]
            lines.append(f"  {f['auc']:.4f} ({f['low']:.4f} to {f['high']:.4f})  {meaning}")
    return "\n".join(lines)


def pairs(data: Path, *, most: int | None = None, seed: int = 0) -> Iterator[CharacterPair]:
    """One pair of the same and one of another character for each character of each set (E3C: each copy).

    most: at most so many characters a set. seed: chooses the pairs.
    """
    rng = np.random.default_rng(seed)
    regular = read_masters(data / "masters" / "regular")
    yield from _pairs_of_masters("regular, six works", regular, most=most, rng=rng)
    running = read_masters(data / "masters" / "running-lantingxu")
    clear = [m for m in running if "dingwu" not in m.path.parts]
    yield from _pairs_of_masters("Lanting Xu, three versions in ink", clear, most=most, rng=rng)
    yield from _pairs_of_masters("Lanting Xu with the rubbing", running, most=most, rng=rng)
    copies = read_copies(data)
    templates = sorted({copy.template for copy in copies})
    for copy in copies if most is None else copies[:: max(len(copies) // most, 1)]:
        others = [template for template in templates if template != copy.template]
        other = others[int(rng.integers(len(others)))]
        for template, same in ((copy.template, True), (other, False)):
            yield CharacterPair("E3C copies and templates", copy.character, copy.image, template, same)


def _pairs_of_masters(
    where: str,
    masters: Sequence[Master],
    *,
    most: int | None,
    rng: np.random.Generator,
) -> Iterator[CharacterPair]:
    """Copy and master from two works; the other character stands in the work of the right one."""
    by_character: dict[str, list[Master]] = defaultdict(list)
    by_work: dict[str, list[Master]] = defaultdict(list)
    for master in masters:
        by_character[master.character or ""].append(master)
        by_work[master.path.parent.name].append(master)
    shared = [c for c, found in by_character.items() if len({m.path.parent.name for m in found}) > 1]
    chosen = shared if most is None else [shared[k] for k in rng.permutation(len(shared))[:most]]
    for character in chosen:
        found = by_character[character]
        copy = found[int(rng.integers(len(found)))]
        same = [m for m in found if m.path.parent.name != copy.path.parent.name]
        right = same[int(rng.integers(len(same)))]
        others = [m for m in by_work[right.path.parent.name] if m.character != character]
        wrong = others[int(rng.integers(len(others)))]
        yield CharacterPair(where, character, copy.path, right.path, True)
        yield CharacterPair(where, character, copy.path, wrong.path, False)


def measure_pair(pair: CharacterPair) -> PairMeasures:
    """All measures of one pair."""
    from rumu.assessment.calibration import panel
    from rumu.assessment.features import similarity

    try:
        m = measure(master_at(pair.copy).surface, master_at(pair.master))
    except (RefusedImage, RegistrationError):
        return PairMeasures(pair, None)
    mark, figures = panel().score(m.features), m.figures
    values = {
        "score": -1.0 if m.refusal else min(mark, m.highest),
        "mark": mark,
        "similarity": similarity(m.registration),
        "position": -figures.plane_residual,
        "likeness": figures.upright_likeness,
        "beyond others": figures.likeness_beyond_others,
        "familiarity": -figures.strangeness,
    }
    return PairMeasures(pair, values)


def area(same: FloatArray, other: FloatArray) -> float:
    """Share of all (same, other) pairs that stand in the right order; ties count half.

    By ranks: scipy's mannwhitneyu gives the same, nine times slower, since it makes a p value as well.
    """
    from scipy.stats import rankdata

    ranks = rankdata(np.concatenate([same, other]))
    n, m = len(same), len(other)
    return float((ranks[:n].sum() - n * (n + 1) / 2) / (n * m))


def interval(
    values: FloatArray, same: FloatArray, characters: np.ndarray, *, seed: int = 0
) -> tuple[float, float]:
    """95 % interval of `area` when characters are drawn anew, each with all its pairs."""
    rng = np.random.default_rng(seed)
    names, which = np.unique(characters, return_inverse=True)
    members = [np.flatnonzero(which == k) for k in range(len(names))]
    areas = []
    for _ in range(DRAWS):
        drawn = np.concatenate([members[k] for k in rng.integers(len(names), size=len(names))])
        areas.append(area(values[drawn][same[drawn]], values[drawn][~same[drawn]]))
    low, high = np.percentile(areas, (2.5, 97.5))
    return float(low), float(high)


def figures(measured: Sequence[PairMeasures]) -> dict[str, Any]:
    """Set -> measure -> {'auc', 'low', 'high'} with 95 % intervals, and the numbers of pairs."""
    found: dict[str, Any] = {}
    for where in dict.fromkeys(m.pair.where for m in measured):
        mine = [m for m in measured if m.pair.where == where]
        kept = [(m.pair, m.measures) for m in mine if m.measures is not None]
        same = np.array([pair.same for pair, _ in kept])
        characters = np.array([pair.character for pair, _ in kept])
        entry: dict[str, Any] = {
            "same": int(same.sum()),
            "other": int((~same).sum()),
            "characters": len(np.unique(characters)),
            "left_out": len(mine) - len(kept),
        }
        for name in MEASURES:
            values = np.array([measures[name] for _, measures in kept])
            low, high = interval(values, same, characters)
            entry[name] = {"auc": area(values[same], values[~same]), "low": low, "high": high}
        found[where] = entry
    return found


def write_table(measured: Sequence[PairMeasures], path: Path) -> None:
    """One row a pair."""
    from rumu.outputs import whole_file

    with whole_file(path) as part, part.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["set", "character", "copy", "master", "same", *MEASURES])
        for m in measured:
            values = [f"{m.measures[name]:.5f}" if m.measures else "" for name in MEASURES]
            p = m.pair
            writer.writerow([p.where, p.character, p.copy.name, p.master.name, int(p.same), *values])
