"""What an experiment found: figures, tables of them, and sentences that follow from them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rumu.values import Bilingual

Cell = str | float | int | None


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

    def formatted(self) -> list[list[str]]:
        """Rows as a reader sees them."""
        return [[_format(row.get(column.key), column) for column in self.columns] for row in self.rows]

    def text(self) -> str:
        """The table for a terminal."""
        lines = [[column.title.en for column in self.columns], *self.formatted()]
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

    def text(self) -> str:
        """Tables and sentences for a terminal."""
        words = [self.words] if self.words else []
        return "\n\n".join([*words, *(t.text() for t in self.tables), *(s.en for s in self.sentences)])


def method_name(name: str) -> str:
    """The name to print: what we reconstructed from an abstract is not its authors' method."""
    from rumu_lab.baselines.methods import RECONSTRUCTED

    return f"{name}-based (reconstructed)" if name in RECONSTRUCTED else name


def _format(cell: Cell, column: Column) -> str:
    if cell is None or (isinstance(cell, float) and not math.isfinite(cell)):
        return "–"
    if column.key in ("method", "where"):
        return method_name(str(cell))
    return f"{round(cell, column.digits) + 0.0:.{column.digits}f}" if isinstance(cell, float) else str(cell)
