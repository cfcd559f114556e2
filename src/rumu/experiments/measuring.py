"""Copies against their masters: our mark and every other method's raw grade, each pair measured once.

All methods see the same two surfaces. What was measured is appended to a file as it comes, under the hash
of the code that measured it, so that a run goes on where it stopped and no new code meets old figures.
"""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from rumu.experiments.made import Recipe

if TYPE_CHECKING:
    from rumu.baselines.cell import Cell
    from rumu.values import Registration, Surface

Progress = Callable[[int, int], None]

_NEIGHBOURS = 7

OURS = "rumu"
RESIDUAL = "5-D residual"
SIMILARITY = "two-sided similarity"
SIM_PAPER = "the paper's SIM"
OWN = (OURS, RESIDUAL, SIMILARITY, SIM_PAPER)
"""Raw grades that come with our own registration: the mark over 100, what is left before any calibration (one
less the mean of the upper quartiles both ways, in rms radii), and the two similarities."""


@dataclass(frozen=True, slots=True)
class Task:
    """One copy to be measured. key: unique in its experiment. cluster: its character or work."""

    key: str
    cluster: str
    master: Path
    copy: Recipe


@dataclass(frozen=True, slots=True)
class Measured:
    """What was measured of one copy.

    raw: method -> grade, better is more; in [0, 1] but for the paper's SIM (per cent) and our residual.
    failed: methods that could not grade it (their raw is then 0). refused: why there is nothing to grade.
    """

    key: str
    cluster: str
    raw: Mapping[str, float] = field(default_factory=dict)
    failed: tuple[str, ...] = ()
    refused: str | None = None

    @property
    def mark(self) -> float:
        """Our mark as shipped, 0-100; NaN when refused."""
        return 100.0 * self.raw[OURS] if self.raw else float("nan")


def measure(task: Task) -> Measured:
    """One copy by every method."""
    from rumu import pipeline
    from rumu.errors import RefusedImage

    master = _surface(task.master)
    try:
        copy = pipeline.surface_of(task.copy.picture())
    except RefusedImage as refusal:
        return Measured(task.key, task.cluster, refused=str(refusal))
    mark = pipeline.assess(copy, master)
    if mark.score is None or mark.registration is None:
        return Measured(task.key, task.cluster, refused=str(mark.refused))
    own = {
        OURS: mark.score / 100.0,
        RESIDUAL: residual_grade(mark.registration),
        SIMILARITY: float(mark.similarity or 0.0),
        SIM_PAPER: float(mark.sim_paper or 0.0),
    }
    grades, failed = _by_the_others(copy, task.master)
    return Measured(task.key, task.cluster, own | grades, failed)


def residual_grade(registration: Registration) -> float:
    """1 less the mean of the upper quartiles of the residuals, both ways, in rms radii."""
    import numpy as np

    ways = registration.forward, registration.backward
    return 1.0 - float(np.mean([np.percentile(way, 75) for way in ways]))


def _by_the_others(copy: Surface, master: Path) -> tuple[dict[str, float], tuple[str, ...]]:
    from rumu.baselines.cell import cell_of
    from rumu.baselines.methods import METHODS
    from rumu.errors import RumuError

    cell, reference = cell_of(copy), _cell(master)
    grades, failed = {}, []
    for name, method in METHODS.items():
        try:
            grades[name] = method(cell, reference).raw
        except RumuError:
            grades[name] = 0.0
            failed.append(name)
    return grades, tuple(failed)


@functools.lru_cache(maxsize=4)  # copies of one master come in a row
def _surface(master: Path) -> Surface:
    from rumu import pipeline

    return pipeline.surface_of(master)


@functools.lru_cache(maxsize=4)
def _cell(master: Path) -> Cell:
    from rumu.baselines.cell import cell_of

    return cell_of(_surface(master))


def measure_all(
    tasks: Sequence[Task],
    *,
    work: Callable[[Task], Measured] = measure,
    store: Path | None = None,
    progress: Progress | None = None,
) -> list[Measured]:
    """All tasks, in order, on all cores.

    work: what is done with each; a function of a module. store: a folder where what is measured is kept and
    found again, in a file for each kind of work.
    """
    kind = f"{work.__module__.rpartition('.')[2]}-{work.__name__}"
    file = None if store is None else store / f"{kind}-{code_hash()[:16]}.jsonl"
    known = {} if file is None else _read(file)
    missing = [task for task in tasks if task.key not in known]
    done = len(tasks) - len(missing)
    for measured in _in_parallel(work, missing):
        known[measured.key] = measured
        done += 1
        if file is not None:
            _append(measured, file)
        if progress:
            progress(done, len(tasks))
    return [known[task.key] for task in tasks]


def _in_parallel(work: Callable[[Task], Measured], tasks: Sequence[Task]) -> Iterator[Measured]:
    """In order, a few neighbours to a process at a time: they share a master, and often a copy."""
    from rumu.processes import cores, in_order

    few = [tasks[k : k + _NEIGHBOURS] for k in range(0, len(tasks), _NEIGHBOURS)]
    for answers in in_order(functools.partial(_each, work), few, processes=min(cores(), len(few)) or 1):
        yield from answers


def _each(work: Callable[[Task], Measured], tasks: Sequence[Task]) -> list[Measured]:
    return [work(task) for task in tasks]


def code_hash(*, whole: bool = False) -> str:
    """SHA-256 of all that a measurement rests on: the code and data of the rooms that make and judge copies.

    whole: with the code of the experiments themselves, on which a result rests too.
    """
    import rumu

    root = Path(rumu.__file__).parent
    found = [p for p in sorted(root.rglob("*")) if p.suffix in (".py", ".json", ".npz")]
    rooms = {p: p.relative_to(root).parts[0] for p in found}
    own = {"made.py", "measuring.py", "protocol.json"}
    total = hashlib.sha256()
    for path in found:
        mine = rooms[path] == "experiments" and (whole or path.name in own)
        if mine or rooms[path] not in ("cli", "report", "experiments"):
            total.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes())
    return total.hexdigest()


def _read(file: Path) -> dict[str, Measured]:
    """What a file holds. A last line that an interruption cut short is cut off, so that lines can follow."""
    if not file.is_file():
        return {}
    text = file.read_text("utf-8")
    whole = text[: text.rfind("\n") + 1]
    if whole != text:
        file.write_text(whole, "utf-8")
    known = {}
    for line in whole.splitlines():
        plain = json.loads(line)
        known[plain["key"]] = Measured(**plain | {"failed": tuple(plain["failed"])})
    return known


def _append(measured: Measured, file: Path) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("a", encoding="utf-8") as stream:
        stream.write(json.dumps(asdict(measured), ensure_ascii=False) + "\n")
