"""Results of experiments as files under OUT, of which a report is made later."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from rumu.values import Bilingual
from rumu_lab.experiments.findings import Column, Findings, Table
from rumu_lab.experiments.run_settings import RunSettings, code_digest, commit


def origin_of(settings: RunSettings, *, seconds: float) -> dict[str, Any]:
    """What a result rests on: protocol, code, commit, time, and whether it is the quick subset."""
    return {
        "protocol_sha256": settings.protocol.sha256,
        "code_sha256": code_digest(),
        "commit": commit(),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "quick": settings.quick,
        "seconds": round(seconds, 1),
    }


def write_result(findings: Findings, origin: Mapping[str, Any], settings: RunSettings) -> None:
    """Write OUT/results/NAME.json and a CSV a table. Raises OutputError when OUT cannot be written."""
    from rumu.outputs import whole_file

    assert settings.out is not None and settings.tables is not None
    result = {**origin, **_to_json(asdict(findings))}
    with whole_file(settings.out / "results" / f"{findings.name}.json") as part:
        part.write_text(json.dumps(result, ensure_ascii=False, indent=1, allow_nan=False) + "\n", "utf-8")
    for table in findings.tables:
        write_csv(table, settings.tables / f"{table.name}.csv", settings=settings)


def read_result(name: str, *, out: Path) -> dict[str, Any] | None:
    """What OUT holds of an experiment, or None."""
    try:
        found: dict[str, Any] = json.loads((out / "results" / f"{name}.json").read_text("utf-8"))
    except (OSError, ValueError):
        return None
    return found


def findings_from(plain: Mapping[str, Any]) -> Findings:
    """Findings from a stored result."""
    tables = tuple(
        Table(
            t["name"],
            Bilingual(*t["title"]),
            tuple(Column(c["key"], Bilingual(*c["title"]), c["digits"]) for c in t["columns"]),
            tuple(t["rows"]),
            tuple(Bilingual(*note) for note in t["notes"]),
        )
        for t in plain["tables"]
    )
    return Findings(
        plain["name"],
        plain["facts"],
        tables,
        tuple(Bilingual(*s) for s in plain["sentences"]),
        plain["words"],
    )


def write_csv(table: Table, path: Path, *, settings: RunSettings) -> None:
    """One table as CSV, full precision; every row ends with the protocol's hash and whether it was quick."""
    from rumu.outputs import whole_file

    keys = [column.key for column in table.columns]
    with whole_file(path) as part, part.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow([*keys, "protocol_sha256", "quick"])
        for row in table.rows:
            cells = ["" if row.get(key) is None else row[key] for key in keys]
            writer.writerow([*cells, settings.protocol.sha256, int(settings.quick)])


def _to_json(value: Any) -> Any:
    """Arrays as lists, NaN and infinity as null."""
    if isinstance(value, Mapping):
        return {str(key): _to_json(item) for key, item in value.items()}
    if hasattr(value, "tolist"):
        return _to_json(value.tolist())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_to_json(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return str(value) if isinstance(value, Path) else value
