"""Photographs of sheets that people sent: stored, with the attempts that their cells became."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sqlalchemy import ColumnElement, func, or_, select, true
from sqlalchemy.orm import Session

from rumu.database.tables import Attempt, Person, SchoolClass, SheetUpload, new_id
from rumu.pages.sheet_layout import LONGEST_PUPIL
from rumu.studio.access import attempts_of
from rumu.studio.attempts import MarkedCopy, add_attempt
from rumu.studio.errors import Missing, NotAllowed
from rumu.studio.people import Identity, name_key

if TYPE_CHECKING:
    from rumu.gallery.store import Gallery
    from rumu.studio.sheet_cells import ReadSheet

Facts = dict[str, Any]


@dataclass(frozen=True, slots=True)
class UploadDetails:
    """An upload with what its pages show beside it.

    person: who sent it. school_class: whose pupils' sheets they are, None for the sender's own. pupils: by
    id, those in whose practice something was kept. attempts: ids of those that are there, and may be seen.
    """

    upload: SheetUpload
    person: Person
    school_class: SchoolClass | None
    pupils: dict[str, Person]
    attempts: frozenset[str]


def keep_sheet(
    gallery: Gallery, read: ReadSheet, copies: Sequence[MarkedCopy], *, person_id: str, photo: str = ""
) -> Facts:
    """Keep the cells of a sheet as attempts of a person; what the upload tells of its photograph.

    copies: in the order of the cells. photo: name of the photograph, for people.
    """
    cells = []
    for cell, copy in zip(read.cells, copies, strict=True):
        attempt = add_attempt(
            gallery, copy, work_id=read.works[cell.character], person_id=person_id, kind="photo"
        )
        place = {"row": cell.row, "column": cell.column, "character": cell.character, "polygon": cell.polygon}
        cells.append(place | told_of_mark(copy.facts) | {"attempt": attempt.id})
    return {"photo": photo, "refused": None, **read.facts, "person": person_id, "cells": cells}


def told_of_mark(facts: Facts) -> Facts:
    """What a list tells of the mark of a cell: the mark itself, and one sentence."""
    told = facts["remarks"][0] if facts["remarks"] else facts["praise"]
    return {
        "score": facts["score"],
        "level_text": facts["level_text"],
        "refused": facts["refused"] and {name: facts["refused"][name] for name in ("code", "zh", "en")},
        "told": told and {"zh": told["zh"], "en": told["en"]},
        "is_fault": bool(facts["remarks"]),
    }


def add_upload(
    gallery: Gallery,
    photos: Sequence[Facts],
    *,
    person_id: str,
    class_id: str | None = None,
    upload_id: str | None = None,
    files: str | None = None,
) -> str:
    """Store an upload and return its id. upload_id: of one that may be there already, and then stays."""
    with gallery.database.writing() as session:
        if upload_id is not None and session.get(SheetUpload, upload_id) is not None:
            return upload_id
        if class_id is not None and session.get(SchoolClass, class_id) is None:
            class_id = None  # deleted while the sheets were marked
        row = SheetUpload(
            id=upload_id or new_id(), person_id=person_id, class_id=class_id, photos=list(photos), files=files
        )
        session.add(row)
        return row.id


def find_upload(session: Session, upload_id: str, *, user: Identity) -> SheetUpload:
    """Return an upload to whoever sent it, to the teacher of its class, and to owners. Raises Missing."""
    row = session.scalar(select(SheetUpload).where(SheetUpload.id == upload_id, _visible(user)))
    if row is None:
        raise Missing(zh="沒有這些照片。", en="There are no such photographs.")
    return row


def list_uploads(
    session: Session, user: Identity, *, class_id: str | None = None, offset: int = 0, limit: int = 30
) -> tuple[list[SheetUpload], int]:
    """Return uploads, newest first, and how many there are: of a class, else those that this person sent."""
    mine = SheetUpload.person_id == user.id
    conditions = [_visible(user), mine if class_id is None else SheetUpload.class_id == class_id]
    total = session.scalar(select(func.count()).select_from(SheetUpload).where(*conditions)) or 0
    newest = select(SheetUpload).where(*conditions).order_by(SheetUpload.created.desc(), SheetUpload.id)
    return list(session.scalars(newest.offset(offset).limit(limit))), total


def upload_details(session: Session, upload: SheetUpload, *, user: Identity) -> UploadDetails:
    """Return what stands beside an upload: people, and which of its attempts are still there."""
    kept = {photo["person"] for photo in upload.photos if photo.get("person")}
    ids = [cell["attempt"] for photo in upload.photos for cell in photo["cells"] if cell.get("attempt")]
    people = {person.id: person for person in session.scalars(select(Person).where(Person.id.in_(kept)))}
    seen = session.scalars(select(Attempt.id).where(Attempt.id.in_(ids), attempts_of(user, simulated=False)))
    school_class = None if upload.class_id is None else session.get(SchoolClass, upload.class_id)
    sender = session.get_one(Person, upload.person_id)
    return UploadDetails(upload, sender, school_class, people, frozenset(seen))


def read_file(gallery: Gallery, upload_id: str, name: str, *, user: Identity) -> bytes:
    """Return a file of a class's sheets. Raises Missing."""
    with gallery.database.reading() as session:
        files = find_upload(session, upload_id, user=user).files
    if files is None or not gallery.store.exists(f"{files}/{name}"):
        raise Missing(zh="沒有這個檔案。", en="There is no such file.")
    return gallery.store.read(f"{files}/{name}")


def read_cell(gallery: Gallery, upload_id: str, place: tuple[int, int, int], *, user: Identity) -> bytes:
    """Return the picture of a cell. place: number of the photograph, row and column. Raises Missing."""
    number, row, column = place
    with gallery.database.reading() as session:
        photos = find_upload(session, upload_id, user=user).photos
    cells = photos[number]["cells"] if number < len(photos) else ()
    keys = [cell.get("picture") for cell in cells if (cell["row"], cell["column"]) == (row, column)]
    if not keys or keys[0] is None:
        raise Missing(zh="沒有這一格。", en="There is no such cell.")
    return read_file(gallery, upload_id, keys[0], user=user)


def delete_upload(gallery: Gallery, upload_id: str, *, user: Identity) -> None:
    """Delete an upload and its files; its attempts stay. Raises Missing; NotAllowed for another's."""
    with gallery.database.writing() as session:
        row = find_upload(session, upload_id, user=user)
        if not (user.owns or row.person_id == user.id):
            raise NotAllowed
        files = row.files
        session.delete(row)
    if files is not None:
        gallery.store.delete(files)


def is_named(person: Person, name: str) -> bool:
    """Whether a name on a sheet is that of a person: sheets hold the first letters of long ones."""
    return bool(name) and name_key(person.name[:LONGEST_PUPIL]) == name_key(name)


def _visible(user: Identity) -> ColumnElement[bool]:
    if user.owns:
        return true()
    sent: ColumnElement[bool] = SheetUpload.person_id == user.id
    if not user.teaches:
        return sent
    return or_(
        sent, SheetUpload.class_id.in_(select(SchoolClass.id).where(SchoolClass.teacher_id == user.id))
    )
