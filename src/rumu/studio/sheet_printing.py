"""Practice sheets as people ask for them: what may be asked, and the sheet as a PDF or a picture."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from rumu.studio.errors import Missing, Unusable

if TYPE_CHECKING:
    from rumu.database.tables import Work
    from rumu.gallery.sheet_masters import SheetMasters
    from rumu.gallery.store import Gallery
    from rumu.pages.sheet_layout import Grid, Help, Paper, SheetPage

MAX_CHARACTERS = 200
"""Characters of one sheet."""
MAX_WORKS = 60
"""Works that may be chosen as its masters."""
MAX_PRINTED = 120
"""Pages of one PDF, those of all pupils together."""
_PREVIEW_DPI = 92


@dataclass(frozen=True, slots=True)
class SheetRequest:
    """A sheet as somebody asks for it.

    text: its characters. works: ids of works; their characters follow those of the text, and they are the
    masters of their characters. master: of all others: 'strokes', or a script, whose starter works are
    meant. pupils: for each of whom one is printed; none for anybody. paper, grid, model, cell, times,
    strokes: as `SheetPage` has them (model: its help).
    """

    text: str
    works: tuple[str, ...] = ()
    master: str = "strokes"
    paper: Paper = "A4"
    grid: Grid = "mi"
    model: Help = "faint"
    cell: float = 28.0
    times: int = 0
    strokes: bool = True
    pupils: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class SheetPlan:
    """The pages of a sheet, those for one pupil, and its masters."""

    pages: tuple[SheetPage, ...]
    masters: SheetMasters

    @property
    def facts(self) -> dict[str, Any]:
        """What a page shows of it."""
        cells = sum(cell.is_for_writing for page in self.pages for cell in page.cells)
        return {
            "sheet": self.pages[0].sheet,
            "pages": len(self.pages),
            "cells": cells,
            "times": self.pages[0].times,
            "text": "".join(page.text for page in self.pages),
        }


def plan_sheet(gallery: Gallery, request: SheetRequest) -> SheetPlan:
    """The pages of a sheet and its masters.

    Raises Unusable for one that is too long or has characters without a master, Missing for a work that is
    not there, RumuError for what does not fit on a page.
    """
    from rumu.pages.sheet_layout import SheetPage, characters_to_write, lay_out

    works = _chosen_works(gallery, request.works)
    characters = characters_to_write(request.text)
    characters += "".join(work.character for work in works if work.character not in characters)
    if not characters:
        raise Unusable("no_text", zh="請寫下要練的字。", en="Expected characters to write, got none.")
    if len(characters) > MAX_CHARACTERS:
        raise Unusable(
            "too_long",
            zh=f"一張練習紙最多 {MAX_CHARACTERS} 個字，這裡有 {len(characters)} 個。",
            en=f"A sheet has at most {MAX_CHARACTERS} characters, these are {len(characters)}.",
        )
    masters = _find_masters(gallery, characters, works, request.master)
    whole = SheetPage(
        text=characters,
        master=masters.name,
        paper=request.paper,
        cell=request.cell,
        grid=request.grid,
        help=request.model,
        times=request.times,
        strokes=request.strokes,
    )
    return SheetPlan(lay_out(whole), masters)


def print_sheet(gallery: Gallery, request: SheetRequest) -> bytes:
    """The PDF of a sheet, for each pupil one after another. Raises as `plan_sheet`."""
    from rumu.pages.sheet_pdf import sheet_pdf

    plan = plan_sheet(gallery, request)
    pages = [replace(page, pupil=pupil) for pupil in request.pupils or ("",) for page in plan.pages]
    if len(pages) > MAX_PRINTED:
        raise Unusable(
            "too_long",
            zh=f"一次最多印 {MAX_PRINTED} 頁，這裡有 {len(pages)} 頁；請分幾次印。",
            en=f"At most {MAX_PRINTED} pages are printed at a time, these are {len(pages)}; do it in parts.",
        )
    return sheet_pdf(pages, plan.masters.shapes)


def preview_sheet(gallery: Gallery, request: SheetRequest, number: int) -> bytes:
    """A page of the sheet of the first pupil as a PNG. number: from 1. Raises as `plan_sheet`; Missing."""
    from contextlib import closing

    import pypdfium2

    from rumu.pages.sheet_pdf import sheet_pdf

    plan = plan_sheet(gallery, request)
    if number > len(plan.pages):
        raise Missing(zh="這張練習紙沒有這一頁。", en="The sheet has no such page.")
    page = replace(plan.pages[number - 1], pupil=request.pupils[0] if request.pupils else "")
    stream = io.BytesIO()
    with (
        closing(pypdfium2.PdfDocument(sheet_pdf([page], plan.masters.shapes))) as document,
        closing(document[0].render(scale=_PREVIEW_DPI / 72)) as bitmap,
    ):
        bitmap.to_pil().save(stream, "PNG")
    return stream.getvalue()


def _chosen_works(gallery: Gallery, ids: Sequence[str]) -> list[Work]:
    """The works that were chosen as masters. Raises Missing, or Unusable for one that is no character."""
    from sqlalchemy import select

    from rumu.database.tables import Work
    from rumu.studio.classes import check_master

    if len(ids) > MAX_WORKS:
        raise Unusable(
            "too_long",
            zh=f"最多選 {MAX_WORKS} 件作品。",
            en=f"At most {MAX_WORKS} works can be chosen.",
        )
    with gallery.database.reading() as session:
        rows = {row.id: row for row in session.scalars(select(Work).where(Work.id.in_(ids)))}
    if len(rows) < len(set(ids)):
        raise Missing(zh="沒有這件作品。", en="There is no such work.")
    works = [rows[work_id] for work_id in dict.fromkeys(ids)]
    for work in works:
        check_master(work)
        if len(work.character) != 1:
            raise Unusable(
                "no_character",
                zh=f"「{work.character}」不是一個字，不能印成一格。",
                en=f"A cell has room for one character, not for {work.character}.",
            )
    return works


def _find_masters(gallery: Gallery, text: str, works: Sequence[Work], master: str) -> SheetMasters:
    """Chosen works first, then the others of the script or the strokes of copybooks."""
    from functools import partial

    from rumu.gallery.sheet_masters import (
        STROKES,
        FindMasters,
        MissingMasters,
        gather_masters,
        masters_of_starter,
        masters_of_strokes,
        masters_of_works,
    )

    sources: dict[str, FindMasters] = {}
    if works:
        sources["works"] = partial(masters_of_works, works, gallery.store)
    sources[master] = masters_of_strokes if master == STROKES else partial(masters_of_starter, master)
    try:
        return gather_masters(text, sources)
    except MissingMasters as error:
        raise Unusable(
            "no_master",
            zh=f"這裡沒有「{error.characters}」的範字；請選別的範字，或改用字帖筆畫。",
            en=f"There is no master of {error.characters} here; choose other masters, "
            "or the strokes of copybooks.",
        ) from error
