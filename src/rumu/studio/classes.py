"""Classes: their teacher and pupils, their tasks, and the results."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any, TypeVar

from sqlalchemy import delete, func, select
from sqlalchemy.orm import Session

from rumu.database.tables import Attempt, Membership, Person, SchoolClass, Task, TeacherMark, Work
from rumu.studio.access import attempts_of, classes_of
from rumu.studio.errors import Missing, NotAllowed, Unusable
from rumu.studio.people import Identity

ClassOrTask = TypeVar("ClassOrTask", SchoolClass, Task)
_NAMES: dict[type[Any], tuple[Any, str, str]] = {  # the column with the id of the class, and the names
    SchoolClass: (SchoolClass.id, "個班", "class"),
    Task: (Task.class_id, "項作業", "task"),
}


@dataclass(frozen=True, slots=True)
class PupilRow:
    """One pupil in the table of a task.

    attempts: how many. best, last: scores, None where none was marked. last_id: the newest attempt.
    teacher_mark: the newest mark that a teacher gave to this pupil's attempts.
    """

    person: Person
    attempts: int
    best: float | None
    last: float | None
    last_id: str | None
    teacher_mark: float | None


@dataclass(frozen=True, slots=True)
class CommonRemark:
    """A kind of remark. count: the pupils whose latest attempt has a remark of this kind."""

    kind: str
    count: int


def create_class(session: Session, user: Identity, *, name: str) -> SchoolClass:
    """Add a class of this teacher. Raises NotAllowed for a pupil."""
    if not user.teaches:
        raise NotAllowed()
    school_class = SchoolClass(name=name, teacher_id=user.id)
    session.add(school_class)
    session.flush()
    return school_class


def list_classes(session: Session, user: Identity) -> list[tuple[SchoolClass, int, int]]:
    """Return (class, number of pupils, number of tasks) where this person teaches or learns; an owner all."""
    pupils_in = select(func.count()).where(Membership.class_id == SchoolClass.id).scalar_subquery()
    tasks_in = select(func.count()).where(Task.class_id == SchoolClass.id).scalar_subquery()
    wanted = select(SchoolClass, pupils_in, tasks_in).where(classes_of(user)).order_by(SchoolClass.created)
    return [(row, pupils, tasks) for row, pupils, tasks in session.execute(wanted)]


def find_row(
    session: Session, table: type[ClassOrTask], row_id: str, *, user: Identity, require_teacher: bool = False
) -> ClassOrTask:
    """Return a class or a task.

    Raises Missing where there is none that this person may see, NotAllowed for a pupil if `require_teacher`.
    """
    class_id, zh, en = _NAMES[table]
    visible = select(SchoolClass.id).where(classes_of(user))
    row = session.scalar(select(table).where(table.id == row_id, class_id.in_(visible)))
    if row is None:
        raise Missing(zh=f"沒有這{zh}。", en=f"There is no such {en}.")
    if require_teacher and not user.teaches:
        raise NotAllowed()
    return row


def pupils(session: Session, class_id: str) -> list[Person]:
    """Return the pupils of a class, by name."""
    members = select(Membership.person_id).where(Membership.class_id == class_id)
    return list(session.scalars(select(Person).where(Person.id.in_(members)).order_by(Person.name_key)))


def remove_pupil(session: Session, class_id: str, person_id: str) -> None:
    """Remove a pupil from a class; their attempts stay."""
    session.execute(
        delete(Membership).where(Membership.class_id == class_id, Membership.person_id == person_id)
    )


def check_master(work: Work) -> None:
    """Raise Unusable for a work that is no character, which nobody can copy and be marked."""
    if not work.character.strip():
        raise Unusable(
            "no_character",
            zh="這件作品不是一個字，不能臨寫評分。如果它是，請館主在作品資料裡填上是哪個字。",
            en="This work is no character that could be copied and marked. If it is one, ask the owner to "
            "fill in which on the work's page.",
        )


def add_task(
    session: Session,
    school_class: SchoolClass,
    *,
    work_id: str,
    title: str,
    note: str = "",
    due: datetime | None = None,
) -> Task:
    """Add a task to a class. Raises Missing for an unknown work, Unusable for one that is no character."""
    work = session.get(Work, work_id)
    if work is None:
        raise Missing(zh="沒有這件作品。", en="There is no such work.")
    check_master(work)
    task = Task(class_id=school_class.id, work_id=work_id, title=title, note=note, due=due)
    session.add(task)
    session.flush()
    return task


def summarise_task(
    session: Session, task: Task, *, user: Identity
) -> tuple[list[PupilRow], list[CommonRemark]]:
    """Return a row for each pupil of a task, and remarks by how many pupils' latest attempts have them.

    A pupil gets only their own row, and the remarks on their own attempt.
    """
    wanted = select(Attempt).where(Attempt.task_id == task.id, attempts_of(user, simulated=False))
    attempts = session.scalars(wanted.order_by(Attempt.created)).all()
    people = [p for p in pupils(session, task.class_id) if user.teaches or p.id == user.id]
    former = {a.person_id for a in attempts} - {person.id for person in people}
    people += session.scalars(select(Person).where(Person.id.in_(former)))
    given = select(TeacherMark).where(TeacherMark.attempt_id.in_([attempt.id for attempt in attempts]))
    marks = {mark.attempt_id: mark for mark in session.scalars(given.order_by(TeacherMark.created))}
    rows = [_row(person, [a for a in attempts if a.person_id == person.id], marks) for person in people]
    kinds: Counter[str] = Counter()
    for attempt in {attempt.person_id: attempt for attempt in attempts}.values():
        kinds.update({remark["kind"] for remark in attempt.mark.get("remarks", ())})
    return rows, [CommonRemark(kind, count) for kind, count in kinds.most_common()]


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
