"""The sheets of a class that its teacher sends: marked in the background, kept for the pupils whom they name.

What a photograph gives is put aside in files and stored at the end, so that a run that is cancelled leaves
nothing, and one that is done again gives the same attempts.
"""

from __future__ import annotations

import hashlib
import io
import pickle
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sqlalchemy import select

from rumu.database.tables import Attempt, Person, Task
from rumu.studio import classes
from rumu.studio.attempts import MarkedCopy, add_attempt
from rumu.studio.sheet_cells import copy_cell, png_of, work_of_master
from rumu.studio.sheet_inputs import SheetPhoto, sheet_photos
from rumu.studio.sheet_marks import (
    CELLS,
    TABLE,
    CellTask,
    Facts,
    cell_facts,
    mark_photo,
    write_tables,
)
from rumu.studio.sheet_reports import TEACHER, write_reports
from rumu.studio.sheet_uploads import add_upload, is_named, told_of_mark
from rumu.workspaces import temporary_folder

if TYPE_CHECKING:
    from rumu.assessment.calibration import Calibration
    from rumu.gallery.store import Gallery
    from rumu.studio.job_queue import Progress

ARCHIVE = "marks.zip"
MAX_PHOTOS = 500
"""Photographs of one upload; a zip and a PDF hold several."""


@dataclass(frozen=True, slots=True)
class ClassSheets:
    """Whose sheets are marked. upload_id: of the upload that they become. person_id: of who sent them."""

    upload_id: str
    class_id: str
    person_id: str

    @property
    def files(self) -> str:
        """Store key of the folder of tables and PDFs."""
        return f"sheets/{self.upload_id}"

    def attempt_id(self, digest: str, cell: Facts) -> str:
        """The id of the attempt that a cell becomes, the same whenever the work is done."""
        words = f"{self.upload_id} {digest} {cell['row']} {cell['column']}"
        return hashlib.sha256(words.encode()).hexdigest()[:32]


@dataclass(frozen=True, slots=True)
class _MarkedPhoto:
    """One photograph: what the tables tell, its copies in the order of its cells, works by character."""

    facts: Facts
    copies: list[MarkedCopy]
    works: dict[str, str]


def mark_class_sheets(
    gallery: Gallery,
    paths: Sequence[Path],
    names: Sequence[str],
    sheets: ClassSheets,
    *,
    calibration: Calibration | None,
    progress: Progress,
) -> dict[str, Any]:
    """Mark photographs of the sheets of a class and keep them; how many there were, and the upload's id.

    names: of the files, for people.

    Raises Unusable or ImageError when nothing can be read at all.
    """
    with temporary_folder() as folder, sheet_photos(paths, names=names, most=MAX_PHOTOS) as photos:
        out, aside = folder / "marks", folder / "aside"
        out.mkdir()
        aside.mkdir()
        for k, photo in enumerate(photos):
            progress(k, len(photos), "讀照片 Reading")
            found = _mark_photo(gallery, photo, out, calibration)
            (aside / f"{k}").write_bytes(pickle.dumps(found))
        progress(len(photos), len(photos), "存起來 Storing")
        marked = (_read_aside(aside / f"{k}") for k in range(len(photos)))
        return _keep(gallery, sheets, marked, out)


def _mark_photo(
    gallery: Gallery, photo: SheetPhoto, out: Path, calibration: Calibration | None
) -> _MarkedPhoto:
    copies: list[MarkedCopy] = []
    works: dict[str, str] = {}

    def run(tasks: Sequence[CellTask]) -> Iterator[Facts]:
        for task in tasks:
            copy, mark, master = copy_cell(task, png_of(task.picture))
            copies.append(copy)
            if task.character not in works:
                works[task.character] = work_of_master(gallery, master)
            yield cell_facts(mark)

    facts = mark_photo(photo, photo.digest(), out=out, terms={"calibration": calibration}, run=run)
    return _MarkedPhoto(facts, copies if facts["cells"] else [], works)


def _read_aside(path: Path) -> _MarkedPhoto:
    found: _MarkedPhoto = pickle.loads(path.read_bytes())
    return found


def _keep(gallery: Gallery, sheets: ClassSheets, marked: Iterator[_MarkedPhoto], out: Path) -> dict[str, Any]:
    """Store tables, PDFs and attempts, then the row that names them."""
    with gallery.database.reading() as session:
        pupils = classes.pupils(session, sheets.class_id)
        sender = session.get_one(Person, sheets.person_id)
        tasks = {
            task.work_id: task.id
            for task in session.scalars(
                select(Task).where(Task.class_id == sheets.class_id).order_by(Task.created)
            )
        }
    photos, found = [], []
    for one in marked:
        found.append(one.facts)
        person = _named_pupil(pupils, one.facts.get("pupil", ""))
        attempts = [] if person is None else _add_attempts(gallery, sheets, one, person.id, tasks)
        photos.append(_told_of_photo(one, person, attempts))
    write_tables(found, out)
    write_reports(found, out, language="en" if sender.language == "en" else "zh")
    _store_files(gallery, sheets.files, out)
    upload_id = add_upload(
        gallery,
        photos,
        person_id=sheets.person_id,
        class_id=sheets.class_id,
        upload_id=sheets.upload_id,
        files=sheets.files,
    )
    unread = sum(facts["refused"] is not None for facts in found)
    return {"upload": upload_id, "photos": len(found), "unread": unread}


def _named_pupil(pupils: Sequence[Person], name: str) -> Person | None:
    """The one pupil whom a sheet names; None where there is none, or more than one."""
    named = [person for person in pupils if is_named(person, name)]
    return named[0] if len(named) == 1 else None


def _add_attempts(
    gallery: Gallery, sheets: ClassSheets, marked: _MarkedPhoto, person_id: str, tasks: Mapping[str, str]
) -> list[str]:
    """Keep the cells of a photograph as attempts of a pupil, also for a task of their class; their ids."""
    ids = []
    for cell, copy in zip(marked.facts["cells"], marked.copies, strict=True):
        attempt_id = sheets.attempt_id(marked.facts["digest"], cell)
        work_id = marked.works[cell["character"]]
        with gallery.database.reading() as session:
            there = session.get(Attempt, attempt_id) is not None
        if not there:
            add_attempt(
                gallery,
                copy,
                work_id=work_id,
                person_id=person_id,
                kind="photo",
                task_id=tasks.get(work_id),
                attempt_id=attempt_id,
            )
        ids.append(attempt_id)
    return ids


def _told_of_photo(marked: _MarkedPhoto, person: Person | None, attempts: Sequence[str]) -> Facts:
    """What the upload tells of a photograph, see `sheet_uploads`."""
    facts = marked.facts
    told = {name: facts.get(name) for name in ("photo", "sheet", "number", "count", "pupil")}
    refused = None
    if facts["refused"] is not None:
        code, _, sentence = facts["refused"].rpartition(": ")
        zh = facts["refused_zh"] or sentence
        refused = {"code": code.replace(" ", "_") or "unreadable", "zh": zh, "en": sentence}
    cells = [
        {name: cell[name] for name in ("row", "column", "character", "polygon", "picture")}
        | told_of_mark(copy.facts)
        | {"attempt": attempts[k] if attempts else None}
        for k, (cell, copy) in enumerate(zip(facts["cells"], marked.copies, strict=True))
    ]
    return told | {
        "refused": refused,
        "person": person and person.id,
        "empty": facts.get("empty", 0),
        "cells": cells,
    }


def _store_files(gallery: Gallery, key: str, out: Path) -> None:
    """Store the table, the teacher's PDF and the pictures of cells, and all that was written as a zip."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(path for path in out.rglob("*") if path.is_file()):
            archive.write(path, path.relative_to(out).as_posix())
    with gallery.store.whole_folder(key):
        gallery.store.write(f"{key}/{ARCHIVE}", packed.getvalue())
        for path in (out / TABLE, out / TEACHER, *sorted((out / CELLS).rglob("*.png"))):
            gallery.store.write(f"{key}/{path.relative_to(out).as_posix()}", path.read_bytes())
