"""Schemas of photographs of practice sheets: what was read in them, cell by cell."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from pydantic import Field, model_validator

from rumu.studio.sheet_uploads import UploadDetails, is_named
from rumu.web.addresses import service_url
from rumu.web.schemas import BilingualText, Reference, Schema
from rumu.web.studio_schemas import Point


class SheetRefusalRead(BilingualText):
    """Why a photograph was not read, or a cell has no mark."""

    code: str = Field(examples=["blurred"])


class SheetCellRead(Schema):
    """A cell with writing.

    row, column: on the sheet, from 0. polygon: its corners in the photograph, in pixels.
    told: the worst remark (is_fault), else what is good of it. attempt: the copy that it was kept as; null
    where it belongs to no account, or was deleted.
    """

    row: int
    column: int
    character: str = Field(examples=["永"])
    polygon: list[Point]
    score: float | None
    level_text: BilingualText | None
    refused: SheetRefusalRead | None
    told: BilingualText | None
    is_fault: bool
    attempt: str | None
    picture: str | None


class SheetPhotoRead(Schema):
    """A photograph of one sheet.

    pupil: whom its code names. person: in whose practice its cells were kept; null where nobody was found by
    that name. is_of_another: whether the code names somebody else than that person. empty: cells without
    writing.
    """

    photo: str
    refused: SheetRefusalRead | None
    sheet: str | None = None
    number: int | None = None
    count: int | None = None
    pupil: str = ""
    person: Reference | None = None
    is_of_another: bool = False
    empty: int = 0
    mean: float | None = None
    cells: list[SheetCellRead]


class SheetUploadSummary(Schema):
    """Photographs of sheets in a list. cells: with writing. mean: of their marks."""

    id: str
    created: datetime
    photos: int
    unread: int
    cells: int
    mean: float | None
    characters: str

    @model_validator(mode="before")
    @classmethod
    def _count(cls, upload: Any) -> Any:
        cells = [cell for photo in upload.photos for cell in photo["cells"]]
        return {
            "id": upload.id,
            "created": upload.created,
            "photos": len(upload.photos),
            "unread": sum(photo["refused"] is not None for photo in upload.photos),
            "cells": len(cells),
            "mean": mean_score(cells),
            "characters": "".join(dict.fromkeys(cell["character"] for cell in cells)),
        }


class SheetUploadPage(Schema):
    """A part of all uploads, newest first. total: how many there are."""

    total: int
    items: list[SheetUploadSummary]


class SheetUploadRead(Schema):
    """Photographs of sheets, and what was read in them.

    school_class: whose pupils wrote them; null for the sender's own. table, teacher, archive, and pdf of
    pupils: addresses of a class's files, as `rumu page` writes them; null for one's own.
    """

    id: str
    created: datetime
    person: Reference
    school_class: Reference | None
    photos: list[SheetPhotoRead]
    table: str | None = None
    teacher: str | None = None
    archive: str | None = None

    @model_validator(mode="before")
    @classmethod
    def _flatten(cls, shown: UploadDetails) -> Any:
        upload = shown.upload
        url = service_url(f"/api/sheets/{upload.id}")
        names = {"table": "marks.csv", "teacher": "teacher.pdf", "archive": "marks.zip"}
        files = {name: f"{url}/{file}" if upload.files else None for name, file in names.items()}
        return {
            "id": upload.id,
            "created": upload.created,
            "person": shown.person,
            "school_class": shown.school_class,
            "photos": [_photo(photo, k, shown) for k, photo in enumerate(upload.photos)],
            **files,
        }


def _photo(photo: dict[str, Any], number: int, shown: UploadDetails) -> dict[str, Any]:
    names = ("photo", "refused", "sheet", "number", "count")
    person = shown.pupils.get(photo.get("person") or "")
    pupil = photo.get("pupil") or ""
    return {name: photo.get(name) for name in names} | {
        "pupil": pupil,
        "person": person,
        "is_of_another": person is not None and pupil != "" and not is_named(person, pupil),
        "empty": photo.get("empty", 0),
        "mean": mean_score(photo["cells"]),
        "cells": [_cell(cell, number, shown) for cell in photo["cells"]],
    }


def _cell(cell: dict[str, Any], number: int, shown: UploadDetails) -> dict[str, Any]:
    attempt = cell.get("attempt")
    kept = attempt if attempt in shown.attempts else None
    picture = f"/api/attempts/{kept}/picture" if kept else None
    if picture is None and shown.upload.files and cell.get("picture"):
        picture = f"/api/sheets/{shown.upload.id}/cells/{number}/{cell['row']}/{cell['column']}"
    return {name: value for name, value in cell.items() if name in SheetCellRead.model_fields} | {
        "attempt": kept,
        "picture": picture and service_url(picture),
    }


def mean_score(cells: list[dict[str, Any]]) -> float | None:
    """The mean mark of cells; None where none has one."""
    scores = [cell["score"] for cell in cells if cell["score"] is not None]
    return round(sum(scores) / len(scores), 2) if scores else None
