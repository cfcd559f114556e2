"""What is measured, on what, and how it is judged: declared in protocol.json before the first run.

Every table and report prints the SHA-256 of that file, so that a figure can be traced to its declaration and
a later change of the declaration shows. The characters of the locked test are not in it: they follow from a
seed of which only the hash is there.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources
from typing import Any


@dataclass(frozen=True)
class ExperimentProtocol:
    """The declaration as it was read.

    plain: the file's content. sha256: of its bytes, in hex. quick: a small subset is run, to see that
    everything works; its figures are no result.
    works: ids of the starter works that simulated copies are made of. scripts: the five, in the order of the
    tables. faults: names of the fault families, in the order that shares them out; faults_for_each_work: how
    many each work gets. severities: those above 0. simulation_seed: of the faults.
    expected_scores: name of a table -> expected score at severity 0, 1, ... 5; the first is the declared one.
    level_seeds: of the copies at the four degrees. cut_offs: lowest score of each level, as used in Table 1.
    resamples: of a bootstrap; resampling_seed: of every bootstrap.
    """

    plain: Mapping[str, Any]
    sha256: str
    quick: bool
    works: tuple[str, ...]
    scripts: tuple[str, ...]
    faults: tuple[str, ...]
    faults_for_each_work: int
    severities: tuple[int, ...]
    simulation_seed: int
    expected_scores: Mapping[str, tuple[float, ...]]
    level_seeds: tuple[int, ...]
    cut_offs: Mapping[str, float]
    resamples: int
    resampling_seed: int


@lru_cache(maxsize=2)
def declared(*, quick: bool = False) -> ExperimentProtocol:
    """The protocol that comes with the package."""
    content = (resources.files("rumu_lab.experiments") / "protocol.json").read_bytes()
    plain = json.loads(content)
    simulated, levels, metrics, small = (plain[k] for k in ("simulated", "levels", "metrics", "quick"))
    return ExperimentProtocol(
        plain=plain,
        sha256=hashlib.sha256(content).hexdigest(),
        quick=quick,
        works=tuple(small["works"] if quick else plain["works"]),
        scripts=tuple(plain["scripts"]),
        faults=tuple(simulated["faults"]),
        faults_for_each_work=int((small if quick else simulated)["faults_for_each_work"]),
        severities=tuple(simulated["severities"]),
        simulation_seed=int(simulated["seed"]),
        expected_scores={
            name: tuple(map(float, scores)) for name, scores in simulated["expected_scores"].items()
        },
        level_seeds=tuple(small["level_seeds"] if quick else levels["seeds"]),
        cut_offs={name: float(low) for name, low in levels["cut_offs"][levels["used"]].items()},
        resamples=int((small if quick else metrics)["resamples"]),
        resampling_seed=int(metrics["seed"]),
    )


def share_faults(number: int, *, protocol: ExperimentProtocol, each: int | None = None) -> tuple[str, ...]:
    """The fault families of work `number`, counted from 0: `each` of them, shared out in turn."""
    each = protocol.faults_for_each_work if each is None else each
    faults = protocol.faults
    return tuple(faults[(number * each + k) % len(faults)] for k in range(each))
