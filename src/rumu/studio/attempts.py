"""Attempts: copies that people wrote, stored with their marks."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from rumu import __version__
from rumu.database.tables import Attempt, Membership, Person, Task, TeacherMark, Work, new_id, now
from rumu.gallery.assets import derived_folder, picture_assets
from rumu.gallery.store import Gallery, Store
from rumu.inputs import parse_json
from rumu.studio.access import attempts_of, find_visible_attempt
from rumu.studio.classes import find_row
from rumu.studio.errors import NotAllowed, Unusable
from rumu.studio.people import Identity
from rumu.studio.pictures import UprightPicture

KINDS = ("pen", "photo")
GRIDS = ("", "mi", "jiu", "tian")
MAX_STROKES = 2**20  # characters of JSON


@dataclass(frozen=True, slots=True)
class MarkedCopy:
    """A copy as it is stored.

    facts: see `mark_facts`. residual: JSON of `residual_facts`, None when refused; it is thousands of numbers
    that the service only stores and sends.
    """

    picture: UprightPicture
    facts: dict[str, Any]
    residual: bytes | None


@dataclass(frozen=True, slots=True)
class AttemptDetails:
    """An attempt with its work, its writer (None for a simulated one) and its teachers' marks."""

    attempt: Attempt
    work: Work
    person: Person | None
    teacher_marks: tuple[tuple[Person, TeacherMark], ...]


def check_strokes(text: str) -> str:
    """Return the pen's path as it will be stored: a list of strokes, each a list of points of 2 to 6 numbers.

    Raises Unusable.
    """
    try:
        parsed = parse_json(text)
        strokes = parsed["strokes"] if isinstance(parsed, dict) else parsed
        lines: list[Any] = [
            stroke.get("points") if isinstance(stroke, dict) else stroke for stroke in strokes
        ]
        valid = isinstance(strokes, list) and all(isinstance(line, list) for line in lines)
        valid = valid and all(_is_point(point) for line in lines for point in line)
    except (ValueError, KeyError, RecursionError, TypeError):
        valid = False
    if not valid or len(text) > MAX_STROKES:
        raise Unusable("strokes", zh="筆跡的格式不對。", en="Expected strokes as a list of lists of points.")
    return json.dumps(parsed, separators=(",", ":"), allow_nan=False)


def _is_point(point: Any) -> bool:
    numbers = list(point.values()) if isinstance(point, dict) else point
    return (
        isinstance(numbers, list)
        and 2 <= len(numbers) <= 6
        and all(isinstance(n, int | float) and not isinstance(n, bool) and abs(n) < 1e12 for n in numbers)
    )


def task_for(session: Session, task_id: str, *, user: Identity, work_id: str) -> Task:
    """Return the task that an attempt is for.

    Raises Missing, NotAllowed for somebody outside of the class, Unusable for another work than the task's.
    """
    task = find_row(session, Task, task_id, user=user)
    if session.get(Membership, (task.class_id, user.id)) is None:
        raise NotAllowed(zh="這項作業是給班上學生的。", en="This task is for the pupils of the class.")
    if task.work_id != work_id:
        raise Unusable("task", zh="這項作業臨的是另一件作品。", en="This task is about another work.")
    return task


def add_attempt(
    gallery: Gallery,
    copy: MarkedCopy,
    *,
    work_id: str,
    person_id: str | None,
    kind: str,
    grid: str = "",
    strokes: str | None = None,
    task_id: str | None = None,
    attempt_id: str | None = None,
) -> Attempt:
    """Store an attempt: its files first, then its row, so that a listed attempt is complete."""
    attempt_id = attempt_id or new_id()
    folder = f"attempts/{attempt_id}"
    picture = f"{folder}/picture.{copy.picture.ending}"
    attempt = Attempt(
        id=attempt_id,
        person_id=person_id,
        work_id=work_id,
        task_id=task_id,
        kind=kind,
        grid=grid,
        picture=picture,
        strokes=None if strokes is None else f"{folder}/strokes.json",
        score=copy.facts["score"],
        level=copy.facts["level"],
        mark=copy.facts,
        version=__version__,
        created=now(),
    )
    with gallery.store.whole_folder(folder), gallery.database.writing() as session:
        gallery.store.write(picture, copy.picture.data)
        if copy.residual is not None:
            gallery.store.write(f"{folder}/residual.json", copy.residual)
        if strokes is not None:
            gallery.store.write(f"{folder}/strokes.json", strokes.encode())
        # PostgreSQL locks the task until the end of this transaction
        lock = {"read": True, "key_share": True}
        if task_id is not None and session.get(Task, task_id, with_for_update=lock) is None:
            attempt.task_id = None  # deleted while the copy was marked: it stays its writer's
        session.add(attempt)
    return attempt


def read_residual(store: Store, attempt: Attempt) -> bytes | None:
    """Return the residual points of an attempt (see `MarkedCopy`); None when it was refused."""
    key = f"attempts/{attempt.id}/residual.json"
    return store.read(key) if store.exists(key) else None


def list_attempts(
    session: Session,
    user: Identity,
    *,
    work_id: str | None = None,
    person_id: str | None = None,
    task_id: str | None = None,
    offset: int = 0,
    limit: int = 60,
) -> tuple[list[AttemptDetails], int]:
    """Return the attempts of people that this person may see, newest first, and how many there are."""
    conditions = [attempts_of(user, simulated=False)]
    for column, value in (
        (Attempt.work_id, work_id),
        (Attempt.person_id, person_id),
        (Attempt.task_id, task_id),
    ):
        if value is not None:
            conditions.append(column == value)
    total = session.scalar(select(func.count()).select_from(Attempt).where(*conditions)) or 0
    wanted = select(Attempt).where(*conditions).order_by(Attempt.created.desc(), Attempt.id)
    return attempt_details(session, session.scalars(wanted.offset(offset).limit(limit)).all()), total


def attempt_details(session: Session, attempts: Sequence[Attempt]) -> list[AttemptDetails]:
    """Return attempts with their works, writers and teachers' marks, by few queries."""
    ids = [attempt.id for attempt in attempts]
    marks = session.execute(
        select(TeacherMark, Person)
        .join(Person, Person.id == TeacherMark.teacher_id)
        .where(TeacherMark.attempt_id.in_(ids))
        .order_by(TeacherMark.created)
    ).all()
    works_asked = select(Work).where(Work.id.in_({attempt.work_id for attempt in attempts}))
    works = {work.id: work for work in session.scalars(works_asked)}
    writers = select(Person).where(Person.id.in_({attempt.person_id for attempt in attempts}))
    people = {person.id: person for person in session.scalars(writers)}
    return [
        AttemptDetails(
            attempt,
            works[attempt.work_id],
            people.get(attempt.person_id or ""),
            tuple((person, mark) for mark, person in marks if mark.attempt_id == attempt.id),
        )
        for attempt in attempts
    ]


def delete(gallery: Gallery, attempt_id: str, *, user: Identity) -> None:
    """Delete an attempt (by its writer or an owner). Raises Missing; NotAllowed for a simulated one."""
    with gallery.database.writing() as session:
        attempt = find_visible_attempt(session, attempt_id, user=user)
        if attempt.kind == "simulated" or not (user.owns or attempt.person_id == user.id):
            raise NotAllowed()
        session.delete(attempt)
    gallery.store.delete(f"attempts/{attempt_id}")
    gallery.store.delete(derived_folder(picture_assets(gallery.store, attempt.picture).digest))


def set_teacher_mark(
    session: Session, attempt_id: str, *, user: Identity, mark: float, note: str
) -> TeacherMark:
    """Set the mark of a teacher. Raises Missing, or NotAllowed for a pupil or a simulated attempt."""
    attempt = find_visible_attempt(session, attempt_id, user=user)
    if not user.teaches or attempt.kind == "simulated":
        raise NotAllowed()
    row = session.get(TeacherMark, (attempt_id, user.id))
    if row is None:
        row = TeacherMark(attempt_id=attempt_id, teacher_id=user.id, mark=mark, note=note)
        session.add(row)
    else:
        row.mark, row.note = mark, note
    session.flush()
    return row
