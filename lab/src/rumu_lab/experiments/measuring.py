"""Copies against their masters: our mark and every other method's raw grade, each pair measured once.

All methods see the same two surfaces. What was measured is appended to a file as it comes, under the hash
of the code that measured it, so that a run goes on where it stopped and no new code meets old figures.
"""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from rumu_lab.experiments.simulated_copies import Picture, Recipe, Written

if TYPE_CHECKING:
    from rumu.assessment.measurement import PreparedMaster
    from rumu.values import Registration
    from rumu_lab.baselines.cell import Cell

Progress = Callable[[int, int], None]

_NEIGHBOURS = 7

Work = Callable[..., "Measured"]
"""work(task, pictures=folder) of one of the names in BEHIND."""

OURS = "rumu"
RESIDUAL = "5-D residual"
SIMILARITY = "two-sided similarity"
SIM_PAPER = "the paper's SIM"
OWN = (OURS, RESIDUAL, SIMILARITY, SIM_PAPER)
"""Raw grades that come with our own registration: the mark over 100, what is left before any calibration (one
less the mean of the upper quartiles both ways, in rms radii), and the two similarities."""


@dataclass(frozen=True, slots=True)
class GradingTask:
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


def measure_ours(task: GradingTask, *, pictures: Path | None = None) -> Measured:
    """One copy by our mark, and the grades that come with our registration."""
    from rumu import pipeline

    mark = pipeline.assess(drawn(task.copy, pictures), _master(task.master), remarks=False)
    if mark.score is None or mark.registration is None:
        return Measured(task.key, task.cluster, refused=str(mark.refused))
    own = {
        OURS: mark.score / 100.0,
        RESIDUAL: residual_grade(mark.registration),
        SIMILARITY: float(mark.similarity or 0.0),
        SIM_PAPER: float(mark.sim_paper or 0.0),
    }
    return Measured(task.key, task.cluster, own)


def measure_others(task: GradingTask, *, pictures: Path | None = None) -> Measured:
    """One copy by every other method."""
    from rumu import pipeline
    from rumu.errors import RumuError
    from rumu_lab.baselines.cell import cell_of

    try:
        cell = cell_of(pipeline.surface_of(drawn(task.copy, pictures)))
    except RumuError as refusal:
        return Measured(task.key, task.cluster, refused=str(refusal))
    grades, failed = _by_the_others(cell, _cell(task.master))
    return Measured(task.key, task.cluster, grades, failed)


def drawn(recipe: Recipe, pictures: Path | None) -> Path | Picture:
    """The picture of a recipe, from the folder of pictures where it was made before."""
    if pictures is None or isinstance(recipe, Written):
        return recipe.picture()
    import numpy as np
    from PIL import Image

    from rumu.outputs import whole_file

    file = pictures / f"{hashlib.sha256(repr(recipe).encode()).hexdigest()[:32]}.png"
    if not file.is_file():
        with whole_file(file) as part:
            Image.fromarray(np.asarray(recipe.picture())).save(part, "PNG")
    return np.asarray(Image.open(file))


def residual_grade(registration: Registration) -> float:
    """1 less the mean of the upper quartiles of the residuals, both ways, in rms radii."""
    import numpy as np

    ways = registration.forward, registration.backward
    return 1.0 - float(np.mean([np.percentile(way, 75) for way in ways]))


def _by_the_others(cell: Cell, reference: Cell) -> tuple[dict[str, float], tuple[str, ...]]:
    from rumu.errors import RumuError
    from rumu_lab.baselines.methods import METHODS

    grades, failed = {}, []
    for name, method in METHODS.items():
        try:
            grades[name] = method(cell, reference).raw
        except RumuError:
            grades[name] = 0.0
            failed.append(name)
    return grades, tuple(failed)


@functools.lru_cache(maxsize=4)  # copies of one master come in a row
def _master(master: Path) -> PreparedMaster:
    from rumu import pipeline

    return pipeline.prepare_master(master)


@functools.lru_cache(maxsize=4)
def _cell(master: Path) -> Cell:
    from rumu_lab.baselines.cell import cell_of

    return cell_of(_master(master).surface)


def measure_all(
    tasks: Sequence[GradingTask], *, store: Path | None = None, progress: Progress | None = None
) -> list[Measured]:
    """All tasks by our mark and by every other method, in order. A copy that either refuses is refused."""
    total = 2 * len(tasks)

    def second(done: int, of: int) -> None:
        if progress:
            progress(len(tasks) + done, total)

    def first(done: int, of: int) -> None:
        if progress:
            progress(done, total)

    ours = measure_by(measure_ours, tasks, store=store, progress=first)
    others = measure_by(measure_others, tasks, store=store, progress=second)
    return [_together(a, b) for a, b in zip(ours, others, strict=True)]


def _together(ours: Measured, others: Measured) -> Measured:
    refused = ours.refused or others.refused
    raw = {} if refused else {**ours.raw, **others.raw}
    return replace(ours, raw=raw, failed=others.failed, refused=refused)


def measure_by(
    work: Work, tasks: Sequence[GradingTask], *, store: Path | None = None, progress: Progress | None = None
) -> list[Measured]:
    """work(task) of all tasks, in order, on all cores.

    work: one of `BEHIND`. store: a folder where what is measured is kept, and found again as long as the code
    behind the work is the same.
    """
    file = pictures = None
    if store is not None:
        file = store / f"{work.__name__}-{code_hash(BEHIND[work.__name__])[:16]}.jsonl"
        pictures = store / f"pictures-{code_hash(_PICTURES)[:16]}"
    known = {} if file is None else _read(file)
    missing = [task for task in tasks if task.key not in known]
    done = len(tasks) - len(missing)
    for measured in _in_parallel(functools.partial(work, pictures=pictures), missing):
        known[measured.key] = measured
        done += 1
        if file is not None:
            _append(measured, file)
        if progress:
            progress(done, len(tasks))
    return [known[task.key] for task in tasks]


def _in_parallel(work: Callable[[GradingTask], Measured], tasks: Sequence[GradingTask]) -> Iterator[Measured]:
    """In order, a few neighbours to a process at a time: they share a master, and often a copy."""
    from rumu.executors import cores, in_order

    few = [tasks[k : k + _NEIGHBOURS] for k in range(0, len(tasks), _NEIGHBOURS)]
    for answers in in_order(functools.partial(_each, work), few, processes=min(cores(), len(few)) or 1):
        yield from answers


def _each(work: Callable[[GradingTask], Measured], tasks: Sequence[GradingTask]) -> list[Measured]:
    return [work(task) for task in tasks]


_PICTURES = (
    *("rumu/capture", "rumu/surface", "rumu/gallery/starter", "rumu/gallery/starter.py", "rumu/values.py"),
    *("rumu_lab/simulation", "rumu_lab/experiments/made.py", "rumu_lab/experiments/protocol.json"),
)
_COMPARED = (*_PICTURES, "rumu/registration/points.py", "rumu_lab/experiments/measuring.py")
_MARKED = (*_COMPARED, "rumu/registration", "rumu/assessment", "rumu/pipeline.py")
BEHIND: Mapping[str, tuple[str, ...]] = {
    "measure_ours": _MARKED,
    "measure_others": (*_COMPARED, "rumu_lab/baselines"),
    "measure_variants": (*_MARKED, "rumu_lab/experiments/variants.py"),
    "measure_density": (*_MARKED, "rumu_lab/experiments/density.py"),
}
"""What each kind of work rests on, in files and folders of the package: when one changes, it is done anew."""


def code_hash(parts: Sequence[str] = ("rumu", "rumu_lab")) -> str:
    """SHA-256 of the code and data of the package, or of some files and folders of it."""
    import rumu
    import rumu_lab

    roots = {package.__name__: Path(str(package.__file__)).parent.parent for package in (rumu, rumu_lab)}
    total = hashlib.sha256()
    for part in parts:
        root = roots[part.split("/")[0]]
        for path in sorted({root / part, *(root / part).rglob("*")}):
            if path.is_file() and path.suffix in (".py", ".json", ".npz", ".npy", ".png"):
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
