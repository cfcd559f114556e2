"""Which experiments there are, in which order `all` runs them, and what each needs."""

from __future__ import annotations

import inspect
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any, Literal

from rumu.errors import RumuError
from rumu.values import Bilingual
from rumu_lab.experiments.findings import Findings, RunSettings, keep, kept, still_holds

Status = Literal["ran", "kept", "skipped", "failed"]


@dataclass(frozen=True, slots=True)
class Experiment:
    """module: of rumu_lab.experiments, with `run`. needs: files of the data without which it is skipped.

    in_quick: whether the quick subset has it. alone: only run when asked for by name.
    """

    name: str
    module: str
    title: Bilingual
    needs: tuple[str, ...] = ()
    in_quick: bool = True
    alone: bool = False


_E3C = ("e3c/scores.csv",)
_MASTERS = ("masters/regular/labels.csv",)

EXPERIMENTS: tuple[Experiment, ...] = (
    Experiment("e3c", "people", Bilingual("分數與真人評分", "The mark against people"), _E3C, in_quick=False),
    Experiment(
        "human", "human_marks", Bilingual("表二、圖七：真人評分", "Table 2 and Figure 7: human marks"), _E3C
    ),
    Experiment("levels", "levels", Bilingual("表一：定級", "Table 1: levels")),
    Experiment("severities", "severities", Bilingual("表二：模擬毛病", "Table 2: simulated severities")),
    Experiment("ablation", "ablation", Bilingual("消融", "Ablations"), _E3C),
    Experiment("nuisance", "nuisance", Bilingual("照片的干擾", "Nuisances of the photograph")),
    Experiment(
        "remarks", "remarks", Bilingual("評語說中了沒有", "Faults told back by the remarks"), _E3C, False
    ),
    Experiment("gaming", "gaming", Bilingual("蒙混過關", "Copies that try to fool the mark"), (), False),
    Experiment("identity", "identity", Bilingual("同字與異字", "Same character or another"), _MASTERS, False),
    Experiment("pictures", "pictures", Bilingual("圖四、圖五、圖六", "Figures 4, 5 and 6")),
    Experiment("runtime", "runtime", Bilingual("所需時間", "Runtime")),
    Experiment(
        "development", "character_lists", Bilingual("開發字表", "Development list"), _MASTERS, False, True
    ),
    Experiment(
        "validation", "character_lists", Bilingual("驗證字表", "Validation list"), _MASTERS, False, True
    ),
    Experiment("locked", "character_lists", Bilingual("封存測試", "The locked test"), _MASTERS, False, True),
)


@dataclass(frozen=True, slots=True)
class Ended:
    """How one experiment of a run ended. why: one line for what was skipped or failed."""

    name: str
    status: Status
    seconds: float = 0.0
    why: str | None = None


def find(name: str) -> Experiment:
    """The experiment of this name."""
    return next(experiment for experiment in EXPERIMENTS if experiment.name == name)


def run_one(name: str, settings: RunSettings, **more: Any) -> Findings:
    """Run one experiment, and keep what it found when there is a place for it.

    more: what only this experiment takes. Raises what the experiment raises.
    """
    start = time.perf_counter()
    experiment = find(name)
    run: Callable[..., Any] = import_module(f"rumu_lab.experiments.{experiment.module}").run
    found = _as_findings(name, _called(run, name, settings, more))
    if settings.out is not None:
        keep(found, settings=settings, seconds=time.perf_counter() - start)
    return found


def run_all(
    settings: RunSettings, *, announce: Callable[[str], Callable[[int, int], None]]
) -> Iterator[Ended]:
    """Every experiment that `all` means, one after the other; what still holds is not run again.

    announce: name -> the progress of that experiment.
    """
    for experiment in EXPERIMENTS:
        if not experiment.alone:
            yield _ended(experiment, replace(settings, progress=announce(experiment.name)))


def why_not(experiment: Experiment, settings: RunSettings) -> str | None:
    """One line when an experiment cannot be run here."""
    if settings.quick and not experiment.in_quick:
        return "not in the quick subset"
    absent = [name for name in experiment.needs if not (settings.data / name).is_file()]
    if absent:
        return f"needs {absent[0]} under {settings.data} (set RUMU_DATA or --data)"
    return None


def _ended(experiment: Experiment, settings: RunSettings) -> Ended:
    assert settings.out is not None
    reason = why_not(experiment, settings)
    if reason is not None:
        return Ended(experiment.name, "skipped", why=reason)
    before = kept(experiment.name, out=settings.out)
    if before is not None and still_holds(before, settings=settings):
        return Ended(experiment.name, "kept", float(before["seconds"]))
    start = time.perf_counter()
    try:
        run_one(experiment.name, settings)
    except RumuError as error:
        return Ended(experiment.name, "failed", time.perf_counter() - start, " ".join(str(error).split()))
    return Ended(experiment.name, "ran", time.perf_counter() - start)


def _called(run: Callable[..., Any], name: str, settings: RunSettings, more: Mapping[str, Any]) -> Any:
    """An experiment takes a Setting, or what it names of data, out, quick and progress."""
    takes = inspect.signature(run).parameters
    if "settings" in takes:
        return run(settings, **({"name": name} if "name" in takes else {}), **more)
    offered = {
        "data": settings.data,
        "out": _tables(settings),
        "quick": settings.quick,
        "progress": settings.progress,
    }
    return run(**{key: value for key, value in offered.items() if key in takes}, **more)


def _tables(settings: RunSettings) -> Path | None:
    return None if settings.out is None else settings.out / "tables"


def _as_findings(name: str, found: Any) -> Findings:
    return found if isinstance(found, Findings) else Findings(name, found.summary(), words=found.text())
