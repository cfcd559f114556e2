"""A teacher's own marks as a folder that `rumu calibrate` reads: marks.csv, the copies, the masters."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath

from sqlalchemy import select
from sqlalchemy.orm import Session

from rumu.database.tables import Attempt, TeacherMark, Work
from rumu.gallery.store import Store
from rumu.studio.people import Identity
from rumu.studio.practice import to_csv

COLUMNS = ("image", "reference", "mark")


@dataclass(frozen=True, slots=True)
class GivenMark:
    """A teacher's mark with the attempt and its master."""

    attempt: Attempt
    work: Work
    mark: float

    @property
    def image(self) -> str:
        return f"copies/{self.attempt.id}{PurePosixPath(self.attempt.picture).suffix}"

    @property
    def reference(self) -> str:
        """A file of the zip, or the folder of a measured surface."""
        suffix = "" if self.work.surface else PurePosixPath(self.work.picture).suffix
        return f"masters/{self.work.id}{suffix}"


def given_marks(session: Session, who: Identity, *, task_id: str | None = None) -> list[GivenMark]:
    """Return the marks that this teacher gave, in order of their attempts; of one task if given."""
    wanted = (
        select(Attempt, Work, TeacherMark.mark)
        .join(TeacherMark, TeacherMark.attempt_id == Attempt.id)
        .join(Work, Work.id == Attempt.work_id)
        .where(TeacherMark.teacher_id == who.id)
        .order_by(Attempt.created, Attempt.id)
    )
    if task_id is not None:
        wanted = wanted.where(Attempt.task_id == task_id)
    return [GivenMark(attempt, work, mark) for attempt, work, mark in session.execute(wanted)]


def marks_csv(marks: Sequence[GivenMark]) -> str:
    """Return marks.csv alone; its paths are those of the zip."""
    return to_csv(COLUMNS, ((one.image, one.reference, f"{one.mark:g}") for one in marks))


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
        for key in store.keys(work.surface):
            yield f"{name}/{PurePosixPath(key).relative_to(work.surface)}", key
