"""Printed grids on a flat page: cells in reading order, which are empty, and the writing without the grid."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from rumu.errors import ImageError
from rumu.pages.cell_edges import place_edges
from rumu.pages.cell_guides import guides_within, lines_to_a_side
from rumu.pages.cell_ink import find_cell_ink
from rumu.pages.cell_lattice import (
    Lattice,
    best_sizes,
    fit_between,
    grow_lattices,
    smallest_fitting,
)
from rumu.pages.cell_scores import EdgeMaps, edges_at, map_edges
from rumu.pages.even_cells import evenness_of_lines, has_sides_both_ways, uneven_sizes
from rumu.pages.framed_cells import corners_on_frames, join_frames
from rumu.pages.lattice_fill import fill_lattice
from rumu.pages.lattice_model import LatticeModel
from rumu.pages.lattice_room import evidence_beside, has_room_beside
from rumu.pages.line_evidence import (
    LineEvidence,
    Picture,
    PrintedLineSettings,
    find_line_evidence,
    line_pitch,
)
from rumu.pages.page import Direction, PageCharacter
from rumu.values import BoolArray, FloatArray


@dataclass(frozen=True, slots=True)
class PageGridSettings:
    """When a picture shows a grid.

    sides: longer side, in pixels, of the reduced pictures that lines are looked for in, in this order.
    first: least number of cells that a lattice grows from. cells, drawn: least number of cells that are
        drawn at least this well. contrast: least fit of the best cells over that of places between the
        lines; strength: least fit. share: of the cells of a lattice that are drawn. cut: a cell may reach
        beyond the picture by this share of its side.
    clear: the same over that of places just beside the sides, of a lattice that is large enough, where cells
        have an inner square; beside_side: how far beside, as a share of a cell.
    even: median share by which cells may differ in width or in height, whichever differs less, and uneven: in
        the other; few_even: in that, of fewer than `few` cells.
    clearly: strength of the best cells, from which lines are printed ones beyond doubt. Where no lattice has
        it, as of patches of paper around characters, cells may differ by `faintly_even`, and the lightest
        stretch of their sides must have this share of the mean darkness: `evenly`.
    sizes: sizes of cells that are looked for, one after the other; leaf: most by which they may differ, as a
        factor.
    alike: share of the best fit that the size of a cell needs, of which the smallest is taken; one after the
        other until cells are even.
    well: from where on a side is drawn well. weakest: over the strongest side of a cell, below which the
        weakest is not drawn. open: share of cells with a side that is drawn well and one that is not, above
        which lines are ruled for columns or rows.
    """

    sides: tuple[int, ...] = (1600, 640)
    first: int = 5
    cells: int = 12
    drawn: float = 0.5
    contrast: float = 1.9
    clear: float = 2.1
    beside_side: float = 0.12
    strength: float = 0.008
    share: float = 0.08
    even: float = 0.03
    few_even: float = 0.016
    uneven: float = 0.055
    clearly: float = 0.045
    faintly_even: float = 0.015
    evenly: float = 0.6
    few: int = 8
    further: int = 8
    of_first: float = 0.12
    cut: float = 0.25
    sizes: int = 2
    leaf: float = 1.6
    alike: tuple[float, ...] = (1.0, 0.97)
    well: float = 0.03
    weakest: float = 0.15
    open: float = 0.4


@dataclass(frozen=True, slots=True, eq=False)
class PageGrid:
    """The printed cells of a page.

    Parameters
    ----------
    cells
        All cells in reading order, each a polygon of four corners from the top left clockwise in pixels of
        the picture. Lattices that stand apart are registers from top to bottom.
    direction
        "horizontal": rows of cells are read from left to right, and such a row counts as a column.
    ink
        (H, W) bool, the writing in the cells without grid, guides and red marks.
    """

    cells: tuple[PageCharacter, ...]
    direction: Direction
    ink: BoolArray


def find_grid(picture: Picture, *, settings: PageGridSettings | None = None) -> PageGrid | None:
    """Find the printed cells of a flat, upright page.

    Parameters
    ----------
    picture
        (H, W, 3) uint8 sRGB, see `flatten_photo`. Lines may lean and bend a little.
    settings
        When a picture shows a grid.

    Returns
    -------
    PageGrid or None
        None where no grid is printed.

    Raises
    ------
    ImageError
        If it is no such picture.
    """
    import cv2

    if picture.ndim != 3 or picture.shape[2] != 3 or picture.dtype != np.uint8 or not picture.size:
        raise ImageError(f"expected a (H, W, 3) uint8 picture, got {picture.shape} {picture.dtype}")
    settings = settings or PageGridSettings()
    longer = max(picture.shape[:2])
    for side in settings.sides:
        scale = min(1.0, side / longer)
        small = (
            cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
            if scale < 1
            else picture
        )
        lattices = find_lattices(small, settings=settings)
        if lattices:
            return _as_grid(small, lattices, picture.shape[:2], settings)
    return None


Placed = list[tuple[int, int, FloatArray, float]]
"""The cells of a lattice: row, column, corners (4, 2), how well it is drawn."""


class FoundLattice(NamedTuple):
    """A lattice with its model. strength: of the best of its cells, as they were found."""

    lattice: Lattice
    model: LatticeModel
    strength: float


def find_lattices(picture: Picture, *, settings: PageGridSettings) -> list[Placed]:
    """The lattices of cells in a reduced picture, from top to bottom.

    What lies outside of the lattices of one size is searched again: a second leaf may lie nearer to the
    camera, so that its cells are of another size.
    """
    lines = PrintedLineSettings()
    if min(picture.shape[:2]) < 4 * lines.pitch:
        return []
    evidence = find_line_evidence(picture, settings=lines)
    for alike in settings.alike:
        found: list[FoundLattice] = []
        for _ in range(settings.sizes):
            known = [one.lattice for one in found]
            if known and not has_room_beside(
                known, picture.shape[:2], count=settings.further, smaller=settings.leaf
            ):
                break
            rest = evidence_beside(evidence, known, lines)
            further = _lattices_of_one_size(rest, found, alike, lines=lines, settings=settings)
            if not further:
                break
            found += further
        found.sort(key=lambda one: float(np.mean([cell[1] for cell in one.lattice.cells.values()])))
        placed = [_place(evidence, one.lattice, one.model, lines=lines) for one in found]
        clear = max((one.strength for one in found), default=0.0) >= settings.clearly
        even = [cells for cells in placed if _is_even(evidence, cells, settings, clear=clear)]
        if even or not found:
            return even
    return []


def _lattices_of_one_size(
    evidence: LineEvidence,
    known: list[FoundLattice],
    alike: float,
    *,
    lines: PrintedLineSettings,
    settings: PageGridSettings,
) -> list[FoundLattice]:
    """The lattices of cells of the likeliest size; beside known ones, of a size like theirs."""
    if len(evidence.frames):
        found = _lattices_of_frames(evidence, known, lines=lines, settings=settings)
        if found:
            return found
    pitch = line_pitch(evidence.down, settings=lines)
    if pitch is None:
        return []
    times, strength = guides_within(evidence, pitch, lines=lines)
    if strength < settings.strength:
        return []

    def of_pitch(pitch: float) -> list[FoundLattice]:
        edges = map_edges(evidence, pitch, reduction=lines.reduction, enough=lines.enough)
        fit, *size = smallest_fitting(best_sizes(edges), alike=alike)
        if fit < settings.strength:
            return []
        enough = max(lines.enough, 2 * strength)
        strengths = map_edges(evidence, pitch, reduction=lines.reduction, enough=enough)
        grown = grow_lattices(edges, (size[0], size[1]), strengths=strengths)
        return _chosen_lattices(edges, evidence, grown, known, settings=settings)

    found = of_pitch(times * pitch)
    if not found:
        return []
    between = lines_to_a_side(evidence, found[0].lattice, times * pitch, lines=lines)
    if between == 1:
        return found
    return of_pitch(between * times * pitch) or found


def _lattices_of_frames(
    evidence: LineEvidence,
    known: list[FoundLattice],
    *,
    lines: PrintedLineSettings,
    settings: PageGridSettings,
) -> list[FoundLattice]:
    """The lattices of cells that stand apart on all sides."""
    pitch = float(np.median(evidence.frames[:, 2:]))
    edges = map_edges(evidence, pitch, reduction=lines.reduction, enough=lines.enough)
    joined = join_frames(evidence.frames, edges)
    return _chosen_lattices(edges, evidence, joined, known, settings=settings)


def _chosen_lattices(
    edges: EdgeMaps,
    evidence: LineEvidence,
    grown: list[Lattice],
    known: list[FoundLattice],
    *,
    settings: PageGridSettings,
) -> list[FoundLattice]:
    """Of lattices that were grown, made whole, those that are grids beside known ones."""
    found: list[FoundLattice] = []
    for lattice in grown:
        if len(lattice.cells) < settings.first or not _stands_out(edges, lattice, settings):
            continue
        filled, model = fill_lattice(edges, evidence, lattice)
        all_found = [one.lattice for one in (*known, *found)]
        if not (_is_grid(filled, settings=settings) and _has_four_sides(edges, filled, settings)) or any(
            _overlap(filled, other) for other in all_found
        ):
            continue
        if all_found and len(filled.cells) < max(
            settings.further, settings.of_first * len(all_found[0].cells)
        ):
            continue
        if known and not _is_of_like_size(filled, known[0].lattice, settings.leaf):
            continue
        found.append(FoundLattice(filled, model, _strength(lattice)))
    return found


def _is_of_like_size(lattice: Lattice, other: Lattice, most: float) -> bool:
    """Whether cells of two lattices are as large but for a factor."""
    sizes = [np.median(np.array(list(one.cells.values()))[:, 2:], axis=0) for one in (lattice, other)]
    return bool(np.abs(np.log(sizes[0] / sizes[1])).max() < np.log(most))


def _place(
    evidence: LineEvidence, lattice: Lattice, model: LatticeModel, *, lines: PrintedLineSettings
) -> Placed:
    quads = place_edges(evidence, lattice, model, reduction=lines.reduction, enough=lines.enough)
    quads = corners_on_frames(quads, evidence.frames)
    cells = [(*place, quad, lattice.fits[place]) for place, quad in zip(lattice.cells, quads, strict=True)]
    return sorted(cells, key=lambda cell: cell[:2])


def _is_even(evidence: LineEvidence, cells: Placed, settings: PageGridSettings, *, clear: bool) -> bool:
    """Whether cells are equally wide or equally high, and faint lines equally dark all along."""
    quads, places = np.array([cell[2] for cell in cells]), np.array([cell[:2] for cell in cells], float)
    few = len(cells) < settings.few
    less, more = uneven_sizes(quads, places, drifting=not few)
    if more > (settings.few_even if few else settings.uneven):
        return False
    if not has_sides_both_ways(evidence, quads, clear=clear):
        return False
    if clear:
        return less <= settings.even
    return less <= settings.faintly_even and evenness_of_lines(evidence, quads) >= settings.evenly


def _stands_out(edges: EdgeMaps, lattice: Lattice, settings: PageGridSettings) -> bool:
    """Whether there is much less between the lines than on them, as in noise and stripes there is not."""
    cells, best = np.array(list(lattice.cells.values())), _strength(lattice)
    if best >= settings.contrast * fit_between(edges, cells):
        return True
    # a quarter into a 回宮格 lies its inner square
    return len(cells) >= settings.cells and best >= settings.clear * fit_between(
        edges, cells, share=settings.beside_side
    )


def _strength(lattice: Lattice) -> float:
    """Mean fit of the best quarter of the cells of a lattice as it was grown."""
    return float(np.sort(list(lattice.fits.values()))[-max(4, len(lattice.fits) // 4) :].mean())


def _is_grid(lattice: Lattice, *, settings: PageGridSettings) -> bool:
    drawn = sum(fit >= settings.drawn for fit in lattice.fits.values())
    enough = len(lattice.cells) >= settings.cells and drawn >= settings.first
    return enough and drawn >= settings.share * len(lattice.fits)


def _has_four_sides(edges: EdgeMaps, lattice: Lattice, settings: PageGridSettings) -> bool:
    """Whether cells have all four sides; lines that are ruled for columns or rows have two."""
    sides = edges_at(edges, np.array(list(lattice.cells.values())))
    strongest = sides.max(axis=1)
    is_open = (strongest > settings.well) & (sides.min(axis=1) < settings.weakest * strongest)
    return bool(is_open.mean() <= settings.open)


def _overlap(lattice: Lattice, other: Lattice) -> bool:
    """Whether many cells of the first lie on cells of the other."""
    cells, others = (np.array(list(one.cells.values())) for one in (lattice, other))
    apart = np.abs(cells[:, None, :2] - others[None, :, :2]) / (
        (cells[:, None, 2:] + others[None, :, 2:]) / 2
    )
    return bool((apart.max(axis=2) < 0.8).any(axis=1).mean() > 0.1)


def _as_grid(
    picture: Picture, lattices: list[Placed], shape: tuple[int, int], settings: PageGridSettings
) -> PageGrid:
    """Corners, order and writing of the cells, in pixels of the whole picture."""
    import cv2

    height, width = picture.shape[:2]
    placed: list[tuple[int, int, int, FloatArray, float]] = []
    for register, lattice in enumerate(lattices):
        for row, column, quad, fit in lattice:
            if _is_whole(quad, (height, width), settings.cut):
                placed.append((register, row, column, np.clip(quad, 0, [width, height]), fit))
    quads = np.array([one[3] for one in placed])
    found = find_cell_ink(picture, quads)
    scale = np.array([shape[1] / width, shape[0] / height])
    cells = tuple(
        PageCharacter(
            polygon=quad * scale,
            register=register,
            column=row,
            row=column,
            certainty=float(np.clip(fit, 0, 1)),
            empty=bool(empty),
        )
        for (register, row, column, quad, fit), empty in zip(placed, found.empty, strict=True)
    )
    ink = cv2.resize(found.ink.astype(np.uint8), shape[::-1], interpolation=cv2.INTER_LINEAR) > 0
    return PageGrid(_numbered(cells), "horizontal", ink)


def _is_whole(quad: FloatArray, shape: tuple[int, int], cut: float) -> bool:
    size = quad.max(axis=0) - quad.min(axis=0)
    beyond = np.maximum(0, -quad.min(axis=0)) + np.maximum(0, quad.max(axis=0) - np.array(shape[::-1]))
    return bool((beyond <= cut * size).all())


def _numbered(cells: tuple[PageCharacter, ...]) -> tuple[PageCharacter, ...]:
    """Columns and rows counted from 0 within each register."""
    first = {
        register: (
            min(c.column for c in cells if c.register == register),
            min(c.row for c in cells if c.register == register),
        )
        for register in {cell.register for cell in cells}
    }
    return tuple(
        replace(cell, column=cell.column - first[cell.register][0], row=cell.row - first[cell.register][1])
        for cell in cells
    )
