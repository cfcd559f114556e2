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
    """

    plain: Mapping[str, Any]
    sha256: str
    quick: bool = False

    @property
    def works(self) -> tuple[str, ...]:
        """Ids of the starter works that simulated copies are made of."""
        return tuple(self.plain["quick"]["works"] if self.quick else self.plain["works"])

    @property
    def scripts(self) -> tuple[str, ...]:
        """The five scripts, in the order of the tables."""
        return tuple(self.plain["scripts"])

    @property
    def faults(self) -> tuple[str, ...]:
        """Names of the fault families, in the order that shares them out."""
        return tuple(self.plain["simulated"]["faults"])

    @property
    def faults_for_each_work(self) -> int:
        """How many fault families each work gets."""
        room = self.plain["quick"] if self.quick else self.plain["simulated"]
        return int(room["faults_for_each_work"])

    @property
    def severities(self) -> tuple[int, ...]:
        """Severities above 0."""
        return tuple(self.plain["simulated"]["severities"])

    @property
    def simulation_seed(self) -> int:
        """Seed of the faults."""
        return int(self.plain["simulated"]["seed"])

    @property
    def expected_scores(self) -> dict[str, tuple[float, ...]]:
        """Name of a table -> expected score at severity 0, 1, ... 5; the first is the declared one."""
        tables = self.plain["simulated"]["expected_scores"]
        return {name: tuple(map(float, scores)) for name, scores in tables.items()}

    @property
    def level_seeds(self) -> tuple[int, ...]:
        """Seeds of the copies at the four degrees."""
        return tuple(self.plain["quick"]["level_seeds"] if self.quick else self.plain["levels"]["seeds"])

    @property
    def cut_offs(self) -> dict[str, float]:
        """Lowest score of each level, as used in Table 1."""
        levels = self.plain["levels"]
        return {name: float(low) for name, low in levels["cut_offs"][levels["used"]].items()}

    @property
    def resamples(self) -> int:
        """Resamples of a bootstrap."""
        return int((self.plain["quick"] if self.quick else self.plain["metrics"])["resamples"])

    @property
    def resampling_seed(self) -> int:
        """Seed of every bootstrap."""
        return int(self.plain["metrics"]["seed"])


@lru_cache(maxsize=2)
def declared(*, quick: bool = False) -> ExperimentProtocol:
    """The protocol that comes with the package."""
    content = (resources.files("rumu_lab.experiments") / "protocol.json").read_bytes()
    return ExperimentProtocol(json.loads(content), hashlib.sha256(content).hexdigest(), quick)


def share_faults(number: int, *, protocol: ExperimentProtocol, each: int | None = None) -> tuple[str, ...]:
    """The fault families of work `number`, counted from 0: `each` of them, shared out in turn."""
    each = protocol.faults_for_each_work if each is None else each
    faults = protocol.faults
    return tuple(faults[(number * each + k) % len(faults)] for k in range(each))
