"""What stands on a page beside its text: notes, headings, ornaments, page numbers, rests of pictures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.pages.columns import Column
from rumu.pages.page_parts import weighted_quantile


@dataclass(frozen=True, slots=True)
class FurnitureSettings:
    """When a column is no column of the text.

    Lengths in sizes of a character; breadth, ink and distance as shares of what is usual on the page.

    thread: a column more slender than this is none. note: the longest note, and how broad and how near to a
    column it is at most. mark: the same of a single character. beyond: how far a column may reach beyond the
    rows of its neighbours. apart: how far from the rest a heading stands at least, and how sparse or short it
    is at most. register: share of the longest register's writing that another one holds at least. longest:
    the least length of a register's longest column. breadth, ink: what columns of writing have.
    """

    thread: float = 0.55
    note: tuple[float, float, float] = (4.0, 0.7, 0.88)
    mark: tuple[float, float, float] = (2.0, 0.7, 1.1)
    beyond: float = 0.4
    apart: tuple[float, float, float] = (1.9, 0.6, 4.0)
    register: float = 0.08
    longest: float = 2.5
    breadth: tuple[float, float] = (0.4, 1.6)
    ink: tuple[float, float] = (0.25, 1.8)
    signature: tuple[float, float, float] = (0.38, 3.6, 0.3)


def text_only(
    registers: list[list[Column]],
    *,
    size: float,
    signed: bool = False,
    settings: FurnitureSettings | None = None,
) -> list[list[Column]]:
    """The registers and columns that belong to the text.

    size: about what a character measures, in pixels. signed: whether the last column of a page of one
    register may be a signature (落款), smaller than the text.
    """
    settings = settings or FurnitureSettings()
    registers = _writing(registers, size, settings)
    kept = []
    for columns in registers:
        signature = (
            columns[-1:] if signed and len(registers) == 1 and _is_signature(columns, settings) else []
        )
        text = _without_notes(columns[: len(columns) - len(signature)], size, settings)
        text = _without_edge(_without_edge(text, size, settings)[::-1], size, settings)[::-1]
        kept.append(text + signature)
    return [columns for columns in kept if columns]


def _writing(registers: list[list[Column]], size: float, settings: FurnitureSettings) -> list[list[Column]]:
    """Registers that look like writing, and hold some."""
    every = [column for columns in registers for column in columns if column.length > settings.longest * size]
    if not every:
        return []
    usual_breadth = _usual([column.breadth for column in every], every)
    usual_ink = _usual([column.density for column in every], every)

    def writing(column: Column) -> int:
        broad, dark = column.breadth / usual_breadth, column.density / usual_ink
        like = settings.breadth[0] < broad < settings.breadth[1] and settings.ink[0] < dark < settings.ink[1]
        return column.length if like else 0

    lengths = [sum(map(writing, columns)) for columns in registers]
    return [
        columns
        for columns, length in zip(registers, lengths, strict=True)
        if length > settings.register * max(lengths)
        and length > 0.5 * sum(column.length for column in columns)
        and max(map(writing, columns)) > settings.longest * size
    ]


def _usual(values: list[float], columns: list[Column]) -> float:
    """The median, each column counted by its length."""
    lengths = np.array([column.length for column in columns], dtype=float)
    return weighted_quantile(np.array(values), lengths, 0.5)


def distance(column: Column, others: list[Column]) -> float:
    """From a column to the next one, in pixels, halfway down it."""
    middle = (column.extent[0] + column.extent[1]) / 2
    here = float(column.ridge.at(middle))
    return min((abs(float(o.ridge.at(middle)) - here) for o in others if o is not column), default=np.inf)


def _without_notes(columns: list[Column], size: float, settings: FurnitureSettings) -> list[Column]:
    """Columns without threads of ink and notes between them."""
    usual = _usual([column.breadth for column in columns], columns)

    def is_note(column: Column) -> bool:
        near = distance(column, columns) / column.pitch
        return column.breadth < settings.thread * usual or any(
            column.length < length * size and column.breadth < breadth * usual and near < beside
            for length, breadth, beside in (settings.note, settings.mark)
        )

    return [column for column in columns if not is_note(column)]


def _is_signature(columns: list[Column], settings: FurnitureSettings) -> bool:
    """Whether the last column is slender and long, and stands low beside the others, within their rows."""
    *text, last = columns
    if len(text) < 2:
        return False
    usual = _usual([column.breadth for column in text], text)
    slender, long, low = settings.signature
    top, bottom = min(one.extent[0] for one in text), max(one.extent[1] for one in text)
    return (
        slender * usual < last.breadth < settings.note[1] * usual
        and last.length > long * last.breadth
        and last.extent[0] > top + low * (bottom - top)
        and last.extent[1] < bottom + usual
        and distance(last, text) > (usual + last.breadth) / 2
    )


def _without_edge(columns: list[Column], size: float, settings: FurnitureSettings) -> list[Column]:
    """Columns without what stands before the first of them: ornaments of corners, and headings apart."""
    while len(columns) > 2:
        first, *rest = columns
        longest = max(column.length for column in rest)
        near = sorted((c for c in rest if c.length > longest / 2), key=lambda c: distance(first, [c]))[:3]
        usual = _usual([column.density for column in near], near)
        over = min(c.extent[0] for c in near) - first.extent[0]
        under = first.extent[1] - max(c.extent[1] for c in near)
        beyond = max(over, under) > settings.beyond * size
        stray = first.length < longest / 2 or first.breadth > settings.breadth[1] * near[0].breadth
        step, sparse, short = settings.apart
        apart = distance(first, rest) > step * first.pitch and (
            first.density < sparse * usual or first.length < short * size
        )
        if not ((beyond and stray) or apart):
            return columns
        columns = rest
    return columns
