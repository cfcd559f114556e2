"""What an experiment found: figures, tables and sentences, kept as files that a report is made of later."""

from __future__ import annotations

import csv
import json
import math
import subprocess
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from rumu.values import Bilingual
from rumu_lab.experiments.measuring import BEHIND, code_hash
from rumu_lab.experiments.protocol import ExperimentProtocol, declared

Cell = str | float | int | None

_RULES = (
    *(
        "statistics",
        "agreement",
        "e3c",
        "people",
        "groups",
        "human",
        "levels",
        "severities",
        "nuisance",
        "runtime",
        "ablation",
        "density",
    ),
    *("remarks", "gaming", "identity", "locked", "pictures", "findings"),
)
RESULTS = (
    *dict.fromkeys(part for parts in BEHIND.values() for part in parts),
    *(f"rumu_lab/experiments/{rule}.py" for rule in _RULES),
)
"""What a kept result rests on: all that is measured with, and what the experiments make of it."""
Progress = Callable[[int, int], None]


def _silent(done: int, total: int) -> None:
    pass


@dataclass(frozen=True, slots=True)
class RunSettings:
    """Where an experiment finds its data and keeps what it measures.

    data: folder of the data sets, with e3c/ in it. out: None keeps nothing. quick: the small subset.
    """

    data: Path
    out: Path | None = None
    quick: bool = False
    progress: Progress = _silent

    @property
    def protocol(self) -> ExperimentProtocol:
        """The declaration, cut down when quick."""
        return declared(quick=self.quick)

    @property
    def store(self) -> Path | None:
        """Folder of what was measured."""
        return None if self.out is None else self.out / "measured"


@dataclass(frozen=True, slots=True)
class Column:
    """key: in the rows and in the files. title: for a reader. digits: after the point."""

    key: str
    title: Bilingual
    digits: int = 2


@dataclass(frozen=True, slots=True)
class Table:
    """rows: key -> cell, None where there is none. notes: what it rests on and what it is not."""

    name: str
    title: Bilingual
    columns: tuple[Column, ...]
    rows: tuple[Mapping[str, Cell], ...]
    notes: tuple[Bilingual, ...] = ()

    def shown(self) -> list[list[str]]:
        """Rows as a reader sees them."""
        return [[_shown(row.get(column.key), column) for column in self.columns] for row in self.rows]

    def text(self) -> str:
        """The table for a terminal."""
        lines = [[column.title.en for column in self.columns], *self.shown()]
        widths = [max(len(line[k]) for line in lines) for k in range(len(self.columns))]
        body = ["  ".join(c.ljust(w) for c, w in zip(line, widths, strict=True)).rstrip() for line in lines]
        return "\n".join([self.title.en, *body, *(note.en for note in self.notes)])


@dataclass(frozen=True, slots=True)
class Findings:
    """What one experiment found. facts: all its figures, plain. sentences: what follows from them.

    words: for a terminal, where the experiment writes its own instead of tables.
    """

    name: str
    facts: Mapping[str, Any]
    tables: tuple[Table, ...] = ()
    sentences: tuple[Bilingual, ...] = ()
    words: str = ""

    def summary(self) -> dict[str, Any]:
        """All figures, plain."""
        return dict(self.facts)

    def text(self) -> str:
        """Tables and sentences for a terminal."""
        words = [self.words] if self.words else []
        return "\n\n".join([*words, *(t.text() for t in self.tables), *(s.en for s in self.sentences)])


def keep(findings: Findings, *, settings: RunSettings, seconds: float) -> dict[str, Any]:
    """Write OUT/results/NAME.json and a CSV a table; returns what was written.

    Raises OutputError when OUT cannot be written.
    """
    from rumu.outputs import whole_file

    assert settings.out is not None
    kept = {
        **origin(settings),
        "seconds": round(seconds, 1),
        **asdict(findings),
    }
    with whole_file(settings.out / "results" / f"{findings.name}.json") as part:
        part.write_text(
            json.dumps(_plain(kept), ensure_ascii=False, indent=1, allow_nan=False) + "\n", "utf-8"
        )
    for table in findings.tables:
        write_csv(table, settings.out / "tables" / f"{table.name}.csv", settings=settings)
    return kept


def origin(settings: RunSettings) -> dict[str, Any]:
    """What a result rests on: protocol, code, commit, time, and whether it is the quick subset."""
    return {
        "protocol_sha256": settings.protocol.sha256,
        "code_sha256": code_hash(RESULTS),
        "commit": commit(),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "quick": settings.quick,
    }


def kept(name: str, *, out: Path) -> dict[str, Any] | None:
    """What OUT holds of an experiment, or None."""
    file = out / "results" / f"{name}.json"
    try:
        found: dict[str, Any] = json.loads(file.read_text("utf-8"))
    except (OSError, ValueError):
        return None
    return found


def findings_of(plain: Mapping[str, Any]) -> Findings:
    """Findings from what `keep` wrote."""
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


def still_holds(plain: Mapping[str, Any], *, settings: RunSettings) -> bool:
    """Whether a kept result was measured by this very code under this very protocol."""
    now = {
        "protocol_sha256": settings.protocol.sha256,
        "code_sha256": code_hash(RESULTS),
        "quick": settings.quick,
    }
    return all(plain.get(key) == value for key, value in now.items())


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


def method_name(name: str) -> str:
    """The name to print: what we reconstructed from an abstract is not its authors' method."""
    from rumu_lab.baselines.methods import RECONSTRUCTED

    return f"{name}-based (reconstructed)" if name in RECONSTRUCTED else name


def commit() -> str | None:
    """The checkout's commit, with '+' where files differ from it; None outside of a checkout."""
    root = Path(__file__).resolve().parents[3]
    if not (root / ".git").exists():
        return None
    try:
        ask = ["git", "-C", str(root), "describe", "--always", "--abbrev=12", "--dirty=+", "--exclude=*"]
        answer = subprocess.run(ask, capture_output=True, text=True, check=True, timeout=20)
    except (OSError, subprocess.SubprocessError):
        return None
    return answer.stdout.strip()


def _shown(cell: Cell, column: Column) -> str:
    if cell is None or (isinstance(cell, float) and not math.isfinite(cell)):
        return "–"
    if column.key in ("method", "where"):
        return method_name(str(cell))
    return f"{round(cell, column.digits) + 0.0:.{column.digits}f}" if isinstance(cell, float) else str(cell)


def _plain(value: Any) -> Any:
    """As JSON can say it: arrays as lists, NaN and infinity as null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return str(value) if isinstance(value, Path) else value
