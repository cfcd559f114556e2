"""Which experiments there are, in which order `all` runs them, and what each needs."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any, Literal

from rumu.errors import RumuError
from rumu.values import Bilingual
from rumu_lab.experiments.findings import Findings
from rumu_lab.experiments.marked_copies import TABLES as _E3C
from rumu_lab.experiments.results import origin_of, write_result
from rumu_lab.experiments.run_settings import RunSettings, code_digest

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


_MASTERS = ("masters/regular/labels.csv",)

EXPERIMENTS: tuple[Experiment, ...] = (
    Experiment("e3c", "e3c", Bilingual("分數與真人評分", "The mark against people"), _E3C, in_quick=False),
    Experiment(
        "nested",
        "nested",
        Bilingual("誰也沒見過的字", "Characters that nobody has seen"),
        _E3C,
        in_quick=False,
    ),
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
class RunStatus:
    """How one experiment of a run ended. why: one line for what was skipped or failed."""

    name: str
    status: Status
    seconds: float = 0.0
    why: str | None = None


def find(name: str) -> Experiment:
    """The experiment of this name."""
    return next(experiment for experiment in EXPERIMENTS if experiment.name == name)


def run_one(name: str, settings: RunSettings, **more: Any) -> Findings:
    """Run one experiment, and write its result where there is a folder for it.

    more: what only this experiment takes. Raises what the experiment raises.
    """
    findings, origin = _run(name, settings, **more)
    if settings.out is not None:
        write_result(findings, origin, settings)
    return findings


def run_all(
    settings: RunSettings, *, announce: Callable[[str], Callable[[int, int], None]]
) -> Iterator[RunStatus]:
    """Every experiment that `all` means, one after the other; one that ended before is not run again.

    announce: name -> the progress of that experiment.
    """
    for experiment in EXPERIMENTS:
        if not experiment.alone:
            yield _run_or_skip(experiment, replace(settings, progress=announce(experiment.name)))


def why_not(experiment: Experiment, settings: RunSettings) -> str | None:
    """One line when an experiment cannot be run here."""
    if settings.quick and not experiment.in_quick:
        return "not in the quick subset"
    absent = [name for name in experiment.needs if not (settings.data / name).is_file()]
    if absent:
        return f"needs {absent[0]} under {settings.data} (set RUMU_DATA or --data)"
    return None


def _run(name: str, settings: RunSettings, **more: Any) -> tuple[Findings, dict[str, Any]]:
    """Findings of an experiment, and what they rest on."""
    start = time.perf_counter()
    experiment = find(name)
    run: Callable[..., Findings] = import_module(f"rumu_lab.experiments.{experiment.module}").run
    if experiment.alone:
        more |= {"name": name}
    findings = run(settings, **more)
    return findings, origin_of(settings, seconds=time.perf_counter() - start)


def _run_stored(
    name: str, data: Path, quick: bool, version: str, settings: RunSettings
) -> tuple[Findings, dict[str, Any]]:
    """What `_run` returns, under the arguments that joblib stores it by; settings are not among them."""
    return _run(name, settings)


def _run_or_skip(experiment: Experiment, settings: RunSettings) -> RunStatus:
    reason = why_not(experiment, settings)
    if reason is not None:
        return RunStatus(experiment.name, "skipped", why=reason)
    stored = settings.memory.cache(_run_stored, ignore=["settings"])
    arguments = (experiment.name, settings.data, settings.quick, code_digest(), settings)
    before = stored.check_call_in_cache(*arguments)
    start = time.perf_counter()
    try:
        findings, origin = stored(*arguments)
    except RumuError as error:
        seconds, why = time.perf_counter() - start, " ".join(str(error).split())
        return RunStatus(experiment.name, "failed", seconds, why)
    write_result(findings, origin, settings)
    return RunStatus(experiment.name, "kept" if before else "ran", float(origin["seconds"]))
