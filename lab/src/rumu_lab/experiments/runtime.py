"""How long each method takes for one pair at 512 x 512, side by side in one run, on one core."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from rumu.values import Bilingual
from rumu_lab.experiments.findings import Cell, Column, Findings, Table
from rumu_lab.experiments.grading import OURS
from rumu_lab.experiments.run_settings import RunSettings
from rumu_lab.experiments.simulated_copies import AtDegree


def run(settings: RunSettings) -> Findings:
    """Median times, methods taken in turn so that a busy machine slows all alike."""
    plain = settings.protocol.plain
    repeats = int(plain["quick"]["repeats"] if settings.quick else plain["runtime"]["repeats"])
    jobs = _jobs(plain["runtime"])
    times: dict[str, list[float]] = {name: [] for name in jobs}
    for job in jobs.values():
        job()  # modules are loaded and caches are filled
    for turn in range(repeats):
        for name, job in jobs.items():
            start = time.perf_counter()
            job()
            times[name].append(time.perf_counter() - start)
        settings.progress(turn + 1, repeats)
    rows = time_rows(times)
    facts: dict[str, Any] = {"repeats": repeats, "methods": rows, "side": plain["runtime"]["side"]}
    return Findings("runtime", facts, (_table(facts),))


def time_rows(times: Mapping[str, list[float]]) -> list[dict[str, Cell]]:
    """Median, least and most milliseconds, and the median of the ratios to ours of the same turn."""
    ours = np.array(times[OURS])
    rows: list[dict[str, Cell]] = [
        {
            "method": name,
            "median": 1000.0 * float(np.median(taken)),
            "least": 1000.0 * min(taken),
            "most": 1000.0 * max(taken),
            "ratio": float(np.median(np.array(taken) / ours)),
        }
        for name, taken in times.items()
    ]
    return sorted(rows, key=lambda row: float(row["median"] or 0.0))


def _jobs(plain: Mapping[str, Any]) -> dict[str, Callable[[], object]]:
    """Method -> its work on two surfaces that are there, with all that it makes of them."""
    import cv2

    from rumu import pipeline
    from rumu.gallery.starter import find_work
    from rumu_lab.baselines.cell import cell_of
    from rumu_lab.baselines.methods import METHODS

    cv2.setNumThreads(1)
    work = find_work(plain["work"])
    picture = AtDegree(work.path, plain["degree"], 11).picture()
    copy, master = pipeline.surface_of(picture), pipeline.surface_of(work.path)
    prepared = pipeline.prepare_master(master)
    jobs: dict[str, Callable[[], object]] = {
        "pictures to surfaces, for all": lambda: (
            pipeline.surface_of(picture),
            pipeline.surface_of(work.path),
        ),
        OURS: lambda: pipeline.assess(copy, prepared),
    }
    for name, method in METHODS.items():
        jobs[name] = lambda method=method: method(cell_of(copy), cell_of(master))  # type: ignore[misc]
    return jobs


def _table(facts: Mapping[str, Any]) -> Table:
    columns = (
        Column("method", Bilingual("方法", "method")),
        Column("median", Bilingual("中位數，毫秒", "median, ms"), 1),
        Column("least", Bilingual("最短", "least, ms"), 1),
        Column("most", Bilingual("最長", "most, ms"), 1),
        Column("ratio", Bilingual("與我們之比", "ratio to ours"), 2),
    )
    side = facts["side"]
    note = Bilingual(
        f"{side} × {side} 的一對，各 {facts['repeats']} 次，輪流進行；「圖片成曲面」一步各法共用，另列。"
        "時間隨機器而異，只有比值可比。",
        f"One pair at {side} x {side}, {facts['repeats']} times each, in turn. Reading the pictures is "
        "common to all and stands apart. Times depend on the machine; only ratios compare.",
    )
    title = Bilingual("一對 512 × 512 所需時間", "Time for a pair at 512 x 512")
    return Table("runtime", title, columns, tuple(facts["methods"]), (note,))
