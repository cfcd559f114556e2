"""Classes: their teacher and pupils, their tasks, and the results."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, TypeVar

from sqlalchemy import ColumnElement, delete, func, select
from sqlalchemy.orm import Session

from rumu.database.tables import Attempt, Membership, Person, SchoolClass, Task, TeacherMark, Work
from rumu.studio.access import attempts_of, classes_of, tasks_of
from rumu.studio.errors import Missing, NotAllowed
from rumu.studio.people import Identity

ClassOrTask = TypeVar("ClassOrTask", SchoolClass, Task)
_CONDITIONS: dict[type[Any], tuple[Callable[[Identity], ColumnElement[bool]], str, str]] = {
    SchoolClass: (classes_of, "個班", "class"),
    Task: (tasks_of, "項作業", "task"),
}


@dataclass(frozen=True, slots=True)
class PupilRow:
    """One pupil in the table of a task.

    attempts: how many; best, last: scores, None where none was marked; last_id: the newest attempt;
    teacher_mark: the teacher's newest mark of this pupil's attempts.
    """

    person: Person
    attempts: int
    best: float | None
    last: float | None
    last_id: str | None
    teacher_mark: float | None


@dataclass(frozen=True, slots=True)
class CommonRemark:
    """A kind of remark, and in how many pupils' latest attempts it stands."""

    kind: str
    count: int


def create_class(session: Session, who: Identity, *, name: str) -> SchoolClass:
    """Add a class of this teacher. Raises NotAllowed for a pupil."""
    if not who.teaches:
        raise NotAllowed()
    school_class = SchoolClass(name=name, teacher_id=who.id)
    session.add(school_class)
    session.flush()
    return school_class


def classes(session: Session, who: Identity) -> list[SchoolClass]:
    """Return the classes in which this person teaches or learns."""
    return list(session.scalars(select(SchoolClass).where(classes_of(who)).order_by(SchoolClass.created)))


def find_row(
    session: Session, table: type[ClassOrTask], row_id: str, *, who: Identity, to_teach: bool = False
) -> ClassOrTask:
    """Return a class or a task.

    Raises Missing where there is none that this person may see, NotAllowed for a pupil where `to_teach`.
    """
    seen, zh, en = _CONDITIONS[table]
    row = session.scalar(select(table).where(table.id == row_id, seen(who)))
    if row is None:
        raise Missing(zh=f"沒有這{zh}。", en=f"There is no such {en}.")
    if to_teach and not who.teaches:
        raise NotAllowed()
    return row


def rename_class(session: Session, class_id: str, *, who: Identity, name: str) -> None:
    """Rename a class (by its teacher or an owner). Raises Missing, NotAllowed for a pupil."""
    find_row(session, SchoolClass, class_id, who=who, to_teach=True).name = name


def delete_class(session: Session, class_id: str, *, who: Identity) -> None:
    """Delete a class with its tasks, its list of pupils and its invitations.

    What pupils wrote stays theirs, with every mark given to it, but belongs to no task any more. Raises
    Missing, NotAllowed for a pupil.
    """
    school_class = find_row(session, SchoolClass, class_id, who=who, to_teach=True)
    session.delete(school_class)  # foreign keys delete the rest


def pupils(session: Session, class_id: str) -> list[Person]:
    """Return the pupils of a class, by name."""
    members = select(Membership.person_id).where(Membership.class_id == class_id)
    return list(session.scalars(select(Person).where(Person.id.in_(members)).order_by(Person.name_key)))


def remove_pupil(session: Session, class_id: str, person_id: str) -> None:
    """Remove a pupil from a class; what they wrote stays theirs."""
    session.execute(
        delete(Membership).where(Membership.class_id == class_id, Membership.person_id == person_id)
    )


def tasks(session: Session, class_id: str) -> list[Task]:
    """Return the tasks of a class, newest first."""
    return list(session.scalars(select(Task).where(Task.class_id == class_id).order_by(Task.created.desc())))


def add_task(
    session: Session,
    school_class: SchoolClass,
    *,
    work_id: str,
    title: str,
    note: str = "",
    due: datetime | None = None,
) -> Task:
    """Add a task to a class. Raises Missing for an unknown work."""
    if session.get(Work, work_id) is None:
        raise Missing(zh="沒有這件作品。", en="There is no such work.")
    task = Task(class_id=school_class.id, work_id=work_id, title=title, note=note, due=due)
    session.add(task)
    session.flush()
    return task


def attempts_at(session: Session, task: Task, *, who: Identity) -> list[Attempt]:
    """Return the attempts at a task that this person may see, oldest first."""
    wanted = select(Attempt).where(Attempt.task_id == task.id, attempts_of(who, simulated=False))
    return list(session.scalars(wanted.order_by(Attempt.created)))


def task_table(session: Session, task: Task, *, who: Identity) -> list[PupilRow]:
    """Return one row for each pupil of a task; to a pupil only their own."""
    people = [p for p in pupils(session, task.class_id) if who.teaches or p.id == who.id]
    attempts = attempts_at(session, task, who=who)
    here = {person.id for person in people}
    gone = {a.person_id for a in attempts if a.person_id is not None} - here
    people += list(session.scalars(select(Person).where(Person.id.in_(gone)))) if gone else []
    ids = [attempt.id for attempt in attempts]
    given = select(TeacherMark).where(TeacherMark.attempt_id.in_(ids)).order_by(TeacherMark.created)
    marks = {mark.attempt_id: mark for mark in session.scalars(given)}
    return [_row(person, [a for a in attempts if a.person_id == person.id], marks) for person in people]


def _row(person: Person, attempts: Sequence[Attempt], marks: dict[str, TeacherMark]) -> PupilRow:
    scores = [attempt.score for attempt in attempts if attempt.score is not None]
    given = sorted((marks[a.id] for a in attempts if a.id in marks), key=lambda mark: mark.created)
    return PupilRow(
        person=person,
        attempts=len(attempts),
        best=max(scores, default=None),
        last=scores[-1] if scores else None,
        last_id=attempts[-1].id if attempts else None,
        teacher_mark=given[-1].mark if given else None,
    )


def common_remarks(session: Session, task: Task, *, who: Identity) -> list[CommonRemark]:
    """Count the kinds of remarks in each pupil's latest attempt, the most frequent first."""
    latest = {attempt.person_id: attempt for attempt in attempts_at(session, task, who=who)}
    kinds: Counter[str] = Counter()
    for attempt in latest.values():
        kinds.update({remark["kind"] for remark in attempt.mark.get("remarks", ())})
    return [CommonRemark(kind, count) for kind, count in kinds.most_common()]


def count_members(session: Session, class_ids: Sequence[str]) -> dict[str, tuple[int, int]]:
    """Return (number of pupils, number of tasks) of each class."""
    members = select(Membership.class_id, func.count()).where(Membership.class_id.in_(class_ids))
    given = select(Task.class_id, func.count()).where(Task.class_id.in_(class_ids))
    many = dict(session.execute(members.group_by(Membership.class_id)).all())  # type: ignore[arg-type]
    tasks_in = dict(session.execute(given.group_by(Task.class_id)).all())  # type: ignore[arg-type]
    return {one: (many.get(one, 0), tasks_in.get(one, 0)) for one in class_ids}
