"""A photographed or scanned page becomes a `Page`: the recipe.

What characters look like is known above this package, so that a page without a text is named by a function
that is handed in; `rumu.read_page` does so.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from rumu.capture.decoded_size import Reduction
from rumu.capture.image import as_image, read_colours, shrink
from rumu.capture.stored import eight_bits
from rumu.errors import ImageError, RefusedImage
from rumu.pages.bend import find_straightening
from rumu.pages.cell_naming import holds_writing, written_cells, written_looks
from rumu.pages.character_shapes import CharacterShape
from rumu.pages.flatten import flatten_photo
from rumu.pages.free_page import FreePage, find_free_page
from rumu.pages.grids import PageGrid, find_grid
from rumu.pages.naming import NamedShape, name_characters
from rumu.pages.page import Page, PageCharacter
from rumu.pages.page_curves import curves_of_grid, curves_of_page
from rumu.pages.page_ink import Picture
from rumu.pages.page_light import even_light
from rumu.pages.upright import quarter_turns
from rumu.values import FloatArray, IntArray

NameLooks = Callable[[list[tuple[IntArray, IntArray]]], Sequence[tuple[str | None, float]]]
"""Rows and columns of the ink of each character -> its name or None, and how sure that is, 0-1."""
READ_SIZE = Reduction(pixels=12_600_000, above=25_000_000)
"""How a picture in a file is reduced: not at all up to twice a phone's 12 megapixels, else to 12.6."""
WORKING_SIDE = 2400
"""Longest side, in pixels, at which a page is searched; its picture keeps all of its own."""

_MORE_CELLS = 1.05
"""How many times as much of a photograph its cells must cover as those of the page as it lies flat."""
_WHOLE, _MOST_OF_PAGE = 0.98, 0.45
"""Shares of their outline and of the page that cells cover of which none is missing."""


def find_characters(
    picture: str | os.PathLike[str] | npt.NDArray[Any],
    *,
    text: str | None = None,
    name_looks: NameLooks | None = None,
) -> Page:
    """The characters of a page, named by a text, or by what they look like, or not at all.

    picture, text: as of `rumu.read_page`, which also says what is raised. name_looks: asked where there is
    no text.
    """
    shown, found = _find_in_photo(_picture(picture))
    turns = quarter_turns(written_looks(found) if isinstance(found, PageGrid) else found.looks())
    if turns:
        shown = np.ascontiguousarray(np.rot90(shown, turns))
        found = _find(shown)
    if isinstance(found, PageGrid):
        characters, cells, looks = written_cells(found, text), found.cells, written_looks(found)
    else:
        scale = shown.shape[1] / found.width, shown.shape[0] / found.height
        characters, cells, looks = _characters(found, _named(found, text), scale), (), found.looks()
    if text is None and name_looks is not None:
        characters = tuple(
            replace(one, character=name, certainty=one.certainty * sure) if name else one
            for one, (name, sure) in zip(characters, name_looks(looks), strict=True)
        )
    page = _straightened(Page(shown, characters, cells, found.direction), found)
    return replace(page, picture=even_light(page.picture))


def _straightened(page: Page, found: PageGrid | FreePage) -> Page:
    """The page with its columns, lines and rows of cells set straight, where they bend."""
    scale = np.ones(2)
    if isinstance(found, PageGrid):
        curves = curves_of_grid(found)
    else:
        curves, scale = (
            curves_of_page(found),
            np.array(page.picture.shape[1::-1]) / (found.width, found.height),
        )
    straight = find_straightening(curves)
    if straight is None:
        return page

    def moved(those: tuple[PageCharacter, ...]) -> tuple[PageCharacter, ...]:
        if not those:
            return ()
        corners = straight.points(np.concatenate([one.polygon for one in those]) / scale) * scale
        ends = np.cumsum([len(one.polygon) for one in those])[:-1]
        parts = np.split(corners, ends)
        return tuple(replace(one, polygon=part) for one, part in zip(those, parts, strict=True))

    return replace(
        page,
        picture=straight.picture(page.picture, scale=scale),
        characters=moved(page.characters),
        cells=moved(page.cells),
    )


def _find_in_photo(photo: Picture) -> tuple[Picture, PageGrid | FreePage]:
    """The page as it lies flat and what stands on it; the photograph itself where that shows more cells.

    Two leaves that do not lie in one plane are flat in no one view.
    """
    flat = flatten_photo(photo)
    found = _find(flat.picture)
    if isinstance(found, PageGrid) and flat.picture is not photo and not _fills_page(found, flat.picture):
        grid = find_grid(photo)
        if grid is not None and holds_writing(grid, photo):
            areas = [
                _area([view(cell.polygon) for cell in one.cells])
                for one, view in ((grid, np.asarray), (found, flat.photo_from_flat))
            ]
            if areas[0] > _MORE_CELLS * areas[1]:
                return photo, grid
    return flat.picture, found


def _fills_page(grid: PageGrid, picture: Picture) -> bool:
    """Whether cells make up a whole rectangle that covers most of a page, so that none can be missing."""
    import cv2

    corners = np.concatenate([cell.polygon for cell in grid.cells]).astype(np.float32)
    outline = cv2.contourArea(cv2.convexHull(corners))
    cells = _area([cell.polygon for cell in grid.cells])
    return bool(cells > _WHOLE * outline and cells > _MOST_OF_PAGE * picture.shape[0] * picture.shape[1])


def _area(polygons: list[FloatArray]) -> float:
    """The area of polygons (n, 2), in square pixels."""
    x, y = np.moveaxis(np.array(polygons), -1, 0)
    return float(np.abs((x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)).sum() / 2)


def _find(shown: Picture) -> PageGrid | FreePage:
    """The cells of a printed grid, or the columns of a page without one."""
    grid = find_grid(shown)
    if grid is not None and holds_writing(grid, shown):
        return grid
    try:
        return find_free_page(shrink(shown, side=WORKING_SIDE))
    except ImageError as error:
        raise RefusedImage(
            "expected a page with writing, got a picture without ink",
            reason="blank",
            zh="這張圖上沒有墨跡，找不到字。",
        ) from error


def _picture(picture: str | os.PathLike[str] | npt.NDArray[Any]) -> Picture:
    """(H, W, 3) uint8 sRGB of a file or an array."""
    if isinstance(picture, np.ndarray):
        if picture.dtype == np.uint8 and picture.ndim == 3 and picture.shape[2] == 3:
            return np.ascontiguousarray(picture)
        samples = eight_bits(as_image(picture))
        return np.ascontiguousarray(np.dstack([samples] * 3) if samples.ndim == 2 else samples)
    return read_colours(picture, reduction=READ_SIZE)


def _named(free: FreePage, text: str | None) -> list[list[NamedShape]]:
    if text is None:
        return [[NamedShape(shape, None, 1.0) for shape in column.shapes] for column in free.columns]
    return name_characters(free, text)


def _characters(
    free: FreePage, named: list[list[NamedShape]], scale: tuple[float, float]
) -> tuple[PageCharacter, ...]:
    return tuple(
        PageCharacter(
            polygon=_corners(one.shape, free) * scale,
            register=column.register,
            column=column.number,
            row=row,
            small=one.shape.small,
            character=one.name,
            certainty=_certainty(one.shape) * one.certainty,
        )
        for column, shapes in zip(free.columns, named, strict=True)
        for row, one in enumerate(shapes)
    )


def _corners(shape: CharacterShape, free: FreePage) -> FloatArray:
    """(4, 2): x and y on the page, clockwise from the upper left."""
    if free.direction == "vertical":
        return shape.corners
    return np.ascontiguousarray(shape.corners[[0, 3, 2, 1], ::-1])


def _certainty(shape: CharacterShape) -> float:
    """How sure it is that this is one whole character, from what it cost to take it for one."""
    return float(np.clip(np.exp(-max(shape.doubt, 0.0) / 2), 0.0, 1.0))
