"""The marks that a teacher gave, as `rumu calibrate` reads them: marks.csv, the copies, the masters."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath

from sqlalchemy import select
from sqlalchemy.orm import Session

from rumu.csv_tables import csv_text
from rumu.database.tables import Attempt, TeacherMark, Work
from rumu.gallery.assets import surface_files
from rumu.gallery.store import Store
from rumu.studio.people import Identity

COLUMNS = ("image", "reference", "mark")


@dataclass(frozen=True, slots=True)
class GivenMark:
    """A teacher's mark with the attempt and its master.

    image, reference: their paths in the zip; that of a measured surface is a folder.
    """

    attempt: Attempt
    work: Work
    mark: float
    image: str
    reference: str


def given_marks(session: Session, user: Identity, *, task_id: str | None = None) -> list[GivenMark]:
    """Return the marks that this teacher gave, in order of their attempts; of one task if given."""
    wanted = (
        select(Attempt, Work, TeacherMark.mark)
        .join(TeacherMark, TeacherMark.attempt_id == Attempt.id)
        .join(Work, Work.id == Attempt.work_id)
        .where(TeacherMark.teacher_id == user.id)
        .order_by(Attempt.created, Attempt.id)
    )
    if task_id is not None:
        wanted = wanted.where(Attempt.task_id == task_id)
    marks = []
    for attempt, work, mark in session.execute(wanted):
        image = f"copies/{attempt.id}{PurePosixPath(attempt.picture).suffix}"
        suffix = "" if work.surface else PurePosixPath(work.picture).suffix
        marks.append(GivenMark(attempt, work, mark, image, f"masters/{work.id}{suffix}"))
    return marks


def marks_csv(marks: Sequence[GivenMark]) -> str:
    """Return marks.csv alone; its paths are those of the zip."""
    return csv_text(COLUMNS, ((one.image, one.reference, f"{one.mark:g}") for one in marks))


def marks_zip(store: Store, marks: Sequence[GivenMark]) -> bytes:
    """Return a zip of marks.csv with every picture that it names."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_STORED) as packed:  # pictures are compressed already
        packed.writestr("marks.csv", marks_csv(marks))
        for one in marks:
            packed.writestr(one.image, store.read(one.attempt.picture))
        for name, key in _masters(store, marks):
            packed.writestr(name, store.read(key))
    return stream.getvalue()


def _masters(store: Store, marks: Sequence[GivenMark]) -> Iterator[tuple[str, str]]:
    """Yield (name in the zip, key in the store), each master once."""
    for name, work in {one.reference: one.work for one in marks}.items():
        if work.surface is None:
            yield name, work.picture
            continue
        for key in surface_files(store, work):
            yield f"{name}/{PurePosixPath(key).relative_to(work.surface)}", key
