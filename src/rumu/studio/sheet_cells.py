"""A photograph of a practice sheet that somebody sent -> its cells, and each as a marked copy of a work.

A copy is kept of a work. The masters of sheets are works of the gallery, or become some: the strokes of
copybooks, the drawings of fonts. A printed cell shows its master at a size of its own, so what a mark says of
places in the master is moved to where they are in the work.
"""

from __future__ import annotations

import io
import time
from collections.abc import Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from rumu.errors import ImageError, RefusedImage
from rumu.studio.errors import Unusable
from rumu.studio.pictures import UprightPicture, check_picture

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rumu.assessment.calibration import Calibration
    from rumu.gallery.sheet_masters import Place, SheetMaster
    from rumu.gallery.store import Gallery
    from rumu.pages.sheet_reading import LocatedSheet, WrittenCell
    from rumu.studio.attempts import MarkedCopy
    from rumu.studio.sheet_marks import CellTask
    from rumu.values import Assessment

MAX_BYTES = 30 * 2**20
MAX_PIXELS = 64_000_000
MASTERS = "sheet-masters"
"""Id of the collection of works that were masters of sheets and no works before."""
PRINTED = "printed"
"""How an attempt's mark says that its picture is the cell of a sheet (`framed`)."""


@dataclass(frozen=True, slots=True)
class SheetCellPicture:
    """A cell with writing. row, column: from 0. polygon: its corners in the photograph. picture: a PNG."""

    row: int
    column: int
    character: str
    polygon: list[list[float]]
    picture: bytes


@dataclass(frozen=True, slots=True)
class ReadSheet:
    """What a photograph of a sheet shows.

    facts: of its page: sheet, number, count, pupil, master, empty (cells). cells: those with writing. works:
    ids of the works that the masters are, by character.
    """

    facts: dict[str, Any]
    cells: tuple[SheetCellPicture, ...]
    works: dict[str, str]


def read_sheet(gallery: Gallery, data: bytes) -> ReadSheet:
    """Find the sheet in an encoded picture, and the writing in its cells.

    Raises Unusable when it is no picture, or no sheet is found in it, with the reason as its code.
    """
    from rumu.gallery.assets import picture_file
    from rumu.gallery.sheet_masters import open_masters
    from rumu.pages.sheet_reading import locate_sheet, read_cells
    from rumu.studio.sheet_inputs import SheetPhoto, read_photo

    check_picture(data, max_bytes=MAX_BYTES, max_pixels=MAX_PIXELS)
    with _unusable():
        with picture_file(data) as path:
            picture = read_photo(SheetPhoto("photo", path))
        sheet = locate_sheet(picture)
        masters = open_masters(sheet.page.master, sheet.page.text)
        written = read_cells(sheet, masters.shapes)
    cells = tuple(map(_cell_picture, written))
    characters = dict.fromkeys(cell.character for cell in cells)
    works = {c: work_of_master(gallery, masters.by_character[c]) for c in characters}
    return ReadSheet(page_facts(sheet, len(written)), cells, works)


def page_facts(sheet: LocatedSheet, written: int) -> dict[str, Any]:
    """What is told of a sheet's page. written: how many of its cells have writing."""
    page = sheet.page
    names = ("sheet", "number", "count", "pupil", "master", "text")
    empty = sum(cell.is_for_writing for cell in page.cells) - written
    return {name: getattr(page, name) for name in names} | {"empty": empty}


def mark_cells(
    masters: str, character: str, pictures: Sequence[bytes], *, calibration: Calibration | None
) -> list[MarkedCopy]:
    """Mark pictures of cells of one character, of a sheet whose code names these masters."""
    import numpy as np
    from PIL import Image

    from rumu.studio.sheet_marks import CellTask

    copies = []
    for data in pictures:
        with Image.open(io.BytesIO(data), formats=["PNG"]) as opened:
            picture = np.asarray(opened.convert("L"))
        copy, _, _ = copy_cell(CellTask(picture, masters, character, {"calibration": calibration}), data)
        copies.append(copy)
    return copies


def copy_cell(task: CellTask, data: bytes) -> tuple[MarkedCopy, Assessment, SheetMaster]:
    """A cell as a marked copy, its mark, and the master that was printed there. data: its picture, a PNG."""
    from rumu.studio.sheet_marks import assess_cell

    started = time.perf_counter()
    mark, master = assess_cell(task)
    height, width = task.picture.shape
    picture = UprightPicture(data, "png", width, height)
    return marked_copy(picture, mark, master, seconds=time.perf_counter() - started), mark, master


def marked_copy(
    picture: UprightPicture, mark: Assessment, master: SheetMaster, *, seconds: float
) -> MarkedCopy:
    """A cell as a copy of the work that its master is."""
    from rumu.studio.attempts import MarkedCopy
    from rumu.studio.marking import encode_residual, mark_facts, residual_facts

    residual = None if mark.registration is None else residual_facts(mark.registration)
    facts = mark_facts(mark, seconds=seconds) | {"framed": PRINTED}
    if residual is not None:
        residual["master"] = [[*_moved(x, y, master.in_work), r] for x, y, r in residual["master"]]
    for told in (*facts["remarks"], *facts["untold"]):
        told["master_outline"] = [
            [_moved(x, y, master.in_work) for x, y in line] for line in told["master_outline"]
        ]
    if facts["align"] is not None:
        a, b, c, d, e, f = facts["align"]["matrix"]
        sx, sy, tx, ty = master.in_work
        moved = (sx * a, sy * b, sx * c, sy * d, sx * e + tx, sy * f + ty)
        facts["align"]["matrix"] = [round(value, 6) for value in moved]
    return MarkedCopy(picture, facts, None if residual is None else encode_residual(residual))


def work_of_master(gallery: Gallery, master: SheetMaster) -> str:
    """The id of the work that a master is; where it is of none, it becomes one."""
    from PIL import Image
    from sqlalchemy import select

    from rumu.database.tables import Work
    from rumu.gallery.add_work import add_picture
    from rumu.gallery.metadata import CollectionMetadata, WorkMetadata
    from rumu.values import Bilingual
    from rumu.workspaces import temporary_folder

    if master.work:
        with gallery.database.reading() as session:
            if session.scalar(select(Work.id).where(Work.id == master.work)) is not None:
                return master.work
    character = master.character
    metadata = WorkMetadata(
        title=Bilingual(f"練習紙「{character}」", f"{character}, of a practice sheet"),
        character=character,
        script=master.script or "",
        material=Bilingual("練習紙上印的範字", "as it is printed on practice sheets"),
    )
    collection = CollectionMetadata(
        id=MASTERS,
        title=Bilingual("練習紙的範字", "Masters of practice sheets"),
        note=Bilingual(
            "交來的練習紙上印的範字，每字一件，收在這裡，臨作才有範字可比。",
            "The masters that are printed on sheets that were sent in, so that copies of them can be kept.",
        ),
    )
    with temporary_folder() as folder:
        path = folder / f"{ord(character):x}.png"
        Image.fromarray(master.picture).save(path)
        return add_picture(gallery, path, metadata=metadata, collection=collection).id


def png_of(picture: Any) -> bytes:
    """A picture (h, w) or (h, w, 3) uint8 as a PNG."""
    from PIL import Image

    stream = io.BytesIO()
    Image.fromarray(picture).save(stream, "PNG", compress_level=3)
    return stream.getvalue()


def _cell_picture(written: WrittenCell) -> SheetCellPicture:
    cell = written.cell
    polygon = written.polygon.round(2).tolist()
    return SheetCellPicture(cell.row, cell.column, cell.character, polygon, png_of(written.picture))


def _moved(x: float, y: float, place: Place) -> list[float]:
    sx, sy, tx, ty = place
    return [round(sx * x + tx, 4), round(sy * y + ty, 4)]


@contextmanager
def _unusable() -> Iterator[None]:
    """Raise why a picture is refused as Unusable, with the reason as its code."""
    try:
        yield
    except RefusedImage as error:
        code = error.reason.replace(" ", "_")
        raise Unusable(code, zh=error.zh, en=f"{error.en[:1].upper()}{error.en[1:]}.") from error
    except ImageError as error:
        raise Unusable("no_picture", zh=error.zh, en=f"{error.en[:1].upper()}{error.en[1:]}.") from error
