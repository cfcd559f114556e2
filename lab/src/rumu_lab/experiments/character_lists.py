"""The development, validation and locked lists of characters, and the log of every opening of the last.

The locked characters follow from a seed that is not in the project, only its SHA-256 in the protocol.
Whoever opens the test gives the seed; the log takes a line before anything is measured and another with the
result, each with the hash of the line before it, so that no opening can be taken out unseen.
"""

from __future__ import annotations

import csv
import hashlib
import json
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from rumu.errors import CalibrationError
from rumu.values import Bilingual
from rumu_lab.experiments.findings import Findings
from rumu_lab.experiments.protocol import ExperimentProtocol, share_faults
from rumu_lab.experiments.run_settings import RunSettings, commit
from rumu_lab.experiments.severities import Subject, findings_on

MASTERS = "masters/regular"
_GROUPS = 5  # characters are held out by group


def run(settings: RunSettings, *, name: str, seed: str | None = None, log: Path | None = None) -> Findings:
    """The series of one list: 'development', 'validation', or 'locked' with its seed and log.

    Raises CalibrationError for a wrong seed, or a log that was changed.
    """
    pictures = pictures_of(settings.data)
    if name != "locked":
        characters = settings.protocol.plain["characters"][name]
        return findings_on(
            _subjects(characters, pictures, settings), settings, name=name, where=f"the {name} list"
        )
    if seed is None or log is None:
        raise CalibrationError("the locked test needs its seed and a log")
    characters = locked_characters(seed, pictures, settings.protocol)
    write_line(log, {"event": "opened", **_now(settings)})
    found = findings_on(
        _subjects(characters, pictures, settings), settings, name=name, where="the locked test"
    )
    result = {"verdict": found.facts["verdict"], "worst_fold": found.facts["worst_fold"]}
    write_line(log, {"event": "result", **_now(settings), "seed": seed, "result": result})
    openings = [line for line in read_log(log) if line["event"] == "opened"]
    times = len(openings)
    sentence = Bilingual(
        f"封存測試至今打開過 {times} 次（{log}）。" + ("" if times == 1 else "只有第一次算數。"),
        f"The locked test has been opened {times} times so far ({log})."
        + ("" if times == 1 else " Only the first counts."),
    )
    return Findings(
        name, {**found.facts, "openings": openings}, found.tables, (*found.sentences, sentence), found.words
    )


def pictures_of(data: Path) -> dict[str, Path]:
    """Character -> its first picture among the masters in regular script."""
    table = data / MASTERS / "labels.csv"
    if not table.is_file():
        raise CalibrationError(f"{table}: expected the masters here (set RUMU_DATA or --data), found nothing")
    pictures: dict[str, Path] = {}
    with table.open(encoding="utf-8", newline="") as stream:
        for row in csv.DictReader(stream):
            pictures.setdefault(row["character"], table.parent / row["file"])
    return pictures


def locked_characters(seed: str, pictures: Mapping[str, Path], protocol: ExperimentProtocol) -> str:
    """The characters that a seed locks. Raises CalibrationError unless its hash is the declared one."""
    lists = protocol.plain["characters"]
    if hashlib.sha256(seed.encode()).hexdigest() != lists["locked"]["seed_sha256"]:
        raise CalibrationError(
            f"expected the seed whose SHA-256 is {lists['locked']['seed_sha256']}, got another"
        )
    used = set(lists["development"] + lists["validation"] + protocol.plain["human"]["characters"])
    used |= _starter_characters()
    pool = sorted(c for c in pictures if len(c) == 1 and c not in used)
    generator = np.random.default_rng(
        int(hashlib.sha256(f"rumu locked test {seed}".encode()).hexdigest(), 16)
    )
    return "".join(pool[i] for i in generator.permutation(len(pool))[: lists["locked"]["count"]])


def write_line(log: Path, entry: Mapping[str, Any]) -> None:
    """Append one line that carries the hash of the line before it."""
    lines = read_log(log)
    last = json.dumps(lines[-1], ensure_ascii=False, sort_keys=True) if lines else ""
    chained = {**entry, "previous": hashlib.sha256(last.encode()).hexdigest()}
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("a", encoding="utf-8") as stream:
        stream.write(json.dumps(chained, ensure_ascii=False, sort_keys=True) + "\n")


def read_log(log: Path) -> list[dict[str, Any]]:
    """The lines of a log, none without a log. Raises CalibrationError when a line was changed or cut."""
    if not log.is_file():
        return []
    lines: list[dict[str, Any]] = []
    before = ""
    for number, text in enumerate(log.read_text("utf-8").splitlines(), start=1):
        try:
            line = json.loads(text)
            chained = line["previous"] == hashlib.sha256(before.encode()).hexdigest()
        except (ValueError, KeyError, TypeError):
            chained = False
        if not chained:
            raise CalibrationError(f"{log}: line {number} does not follow from the line before it")
        lines.append(line)
        before = text
    return lines


def _subjects(characters: str, pictures: Mapping[str, Path], settings: RunSettings) -> list[Subject]:
    protocol = settings.protocol
    absent = [c for c in characters if c not in pictures]
    if absent:
        raise CalibrationError(f"expected masters of {''.join(absent)} under {MASTERS}, found none")
    each = int(protocol.plain["characters"]["faults_for_each_character"])
    return [
        Subject(c, f"group {k % _GROUPS + 1}", pictures[c], share_faults(k, protocol=protocol, each=each))
        for k, c in enumerate(characters)
    ]


def _starter_characters() -> set[str]:
    from rumu.gallery.starter import starter_works

    return {work.character for work in starter_works()}


def _now(settings: RunSettings) -> dict[str, Any]:
    return {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "commit": commit(),
        "protocol_sha256": settings.protocol.sha256,
    }
