"""A page and the characters found on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from rumu.errors import ImageError
from rumu.values import FloatArray

Direction = Literal["vertical", "horizontal"]
DIRECTIONS: tuple[Direction, ...] = get_args(Direction)


@dataclass(frozen=True, slots=True, eq=False)
class PageCharacter:
    """One character of a page, or one printed cell.

    Parameters
    ----------
    polygon
        (n, 2) float64, x and y of its outline in pixels of the flat page, n >= 4; x right, y down.
    register, column, row
        Where it stands, from 0 in reading order: registers from top to bottom; columns of one register from
        right to left, rows of one column from top to bottom. On a modern page a row of text counts as a
        column, and `row` counts from left to right within it.
    small
        None of the main text; 0 or 1 in the right or left line of a double row of small characters.
    character
        What is written, one character, or None where that is not known.
    certainty
        0-1: that this is one whole character and, where it has a name, that the name is right.
    empty
        True of a printed cell with nothing written in it.
    """

    polygon: FloatArray
    register: int
    column: int
    row: int
    small: int | None = None
    character: str | None = None
    certainty: float = 1.0
    empty: bool = False

    def __post_init__(self) -> None:
        shape = self.polygon.shape
        if len(shape) != 2 or shape[0] < 4 or shape[1] != 2 or not np.isfinite(self.polygon).all():
            raise ImageError(f"expected a finite polygon of four points or more, got {self.polygon!r}")
        if not 0 <= self.certainty <= 1:
            raise ImageError(f"expected a certainty from 0 to 1, got {self.certainty}")

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Left, top, right and bottom in pixels of the flat page."""
        (left, top), (right, bottom) = self.polygon.min(axis=0), self.polygon.max(axis=0)
        return float(left), float(top), float(right), float(bottom)


@dataclass(frozen=True, slots=True, eq=False)
class Page:
    """A page that lies flat and upright, and what stands on it.

    Parameters
    ----------
    picture
        (H, W, 3) uint8 sRGB, the flat page.
    characters
        The characters in reading order; empty cells are not among them.
    cells
        All printed cells in reading order, empty ones too; none on a page without a grid.
    direction
        How columns run: "vertical", or "horizontal" on a modern page.
    """

    picture: npt.NDArray[np.uint8]
    characters: tuple[PageCharacter, ...]
    cells: tuple[PageCharacter, ...] = ()
    direction: Direction = "vertical"

    def __post_init__(self) -> None:
        if self.picture.ndim != 3 or self.picture.shape[2] != 3 or self.picture.dtype != np.uint8:
            raise ImageError(
                f"expected a (H, W, 3) uint8 picture, got {self.picture.shape} {self.picture.dtype}"
            )
        if self.direction not in DIRECTIONS:
            raise ImageError(f"expected a direction of {DIRECTIONS}, got {self.direction!r}")

    @property
    def text(self) -> str:
        """What is written, a column to a line; a character that is not known is 〓."""
        columns: dict[tuple[int, int], str] = {}
        for found in self.characters:
            where = found.register, found.column
            columns[where] = columns.get(where, "") + (found.character or "〓")
        return "\n".join(columns.values())

    def as_json(self) -> dict[str, Any]:
        """The page without its picture, in values of JSON and under the same names."""
        height, width = self.picture.shape[:2]
        return {
            "width": width,
            "height": height,
            "direction": self.direction,
            "characters": [_as_json(found) for found in self.characters],
            "cells": [_as_json(cell) for cell in self.cells],
        }


def _as_json(found: PageCharacter) -> dict[str, Any]:
    return {
        "box": [round(edge, 1) for edge in found.box],
        "polygon": np.round(found.polygon, 1).tolist(),
        "register": found.register,
        "column": found.column,
        "row": found.row,
        "small": found.small,
        "character": found.character,
        "certainty": round(found.certainty, 3),
        "empty": found.empty,
    }
