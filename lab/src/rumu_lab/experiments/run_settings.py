"""Where an experiment finds its data and stores what it measures, and which code measured it."""

from __future__ import annotations

import functools
import hashlib
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from rumu_lab.experiments.protocol import ExperimentProtocol, declared

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from joblib import Memory

Progress = Callable[[int, int], None]

_CODE_AND_DATA = (".py", ".json", ".npz", ".npy", ".png")


def _silent(done: int, total: int) -> None:
    pass


@dataclass(frozen=True, slots=True)
class RunSettings:
    """Where and how an experiment is run.

    data: folder of the data sets, with e3c/ and e3c-more/ in it. out: folder for results; None stores
    nothing. quick: the small subset. progress: called with how many of how many are done. executor: takes
    the work in place of new processes.
    """

    data: Path
    out: Path | None = None
    quick: bool = False
    progress: Progress = _silent
    executor: Executor | None = None

    @property
    def protocol(self) -> ExperimentProtocol:
        """The declaration, cut down when quick."""
        return declared(quick=self.quick)

    @property
    def memory(self) -> Memory:
        """What was measured, under OUT/measured; without OUT nothing is stored."""
        from joblib import Memory

        return Memory(None if self.out is None else self.out / "measured", verbose=0)

    @property
    def tables(self) -> Path | None:
        """Folder of the tables."""
        return None if self.out is None else self.out / "tables"


@functools.cache
def code_digest() -> str:
    """SHA-256 of the code and data of both packages, by which stored measurements are told apart."""
    import rumu
    import rumu_lab

    total = hashlib.sha256()
    for package in (rumu, rumu_lab):
        root = Path(str(package.__file__)).parent
        for path in sorted(p for p in root.rglob("*") if p.suffix in _CODE_AND_DATA):
            total.update(path.relative_to(root.parent).as_posix().encode() + b"\0" + path.read_bytes())
    return total.hexdigest()


def commit() -> str | None:
    """The checkout's commit, with '+' where files differ from it; None outside of a checkout."""
    root = Path(__file__).resolve().parents[4]
    if not (root / ".git").exists():
        return None
    try:
        ask = ["git", "-C", str(root), "describe", "--always", "--abbrev=12", "--dirty=+", "--exclude=*"]
        answer = subprocess.run(ask, capture_output=True, text=True, check=True, timeout=20)
    except (OSError, subprocess.SubprocessError):
        return None
    return answer.stdout.strip()
