"""Classes, what they are to write, and how it went."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Response
from sqlalchemy import select
from sqlalchemy.orm import Session

from rumu.database.tables import Invitation, Person, SchoolClass, Task, Work, now
from rumu.report.wording import kind_name
from rumu.studio import classes
from rumu.studio.errors import NotAllowed, Unusable
from rumu.studio.people import Identity
from rumu.studio.teacher_table import given_marks, marks_csv, marks_zip
from rumu.web.cards import person_facts, task_facts, writer
from rumu.web.dependencies import CurrentUser, PathId, ServiceDep, TeacherUser
from rumu.web.routes.practice import csv_answer
from rumu.web.studio_schemas import ClassCreate, ClassRead, ClassSummary, TaskCreate, TaskRead, TaskTable

router = APIRouter(tags=["classes"])


@router.get("/api/classes", response_model=list[ClassSummary])
def listed(service: ServiceDep, user: CurrentUser) -> list[dict[str, Any]]:
    """Those that one teaches or learns in; to an owner all."""
    with service.gallery.database.reading() as session:
        found = classes.classes(session, user)
        counts = classes.counts(session, [one.id for one in found])
    return [
        {
            "id": one.id,
            "name": one.name,
            "created": one.created,
            "pupils": counts[one.id][0],
            "tasks": counts[one.id][1],
        }
        for one in found
    ]


@router.post("/api/classes", response_model=ClassRead, status_code=201)
def add(service: ServiceDep, user: TeacherUser, told: ClassCreate) -> dict[str, Any]:
    """A class of one's own."""
    with service.gallery.database.writing() as session:
        class_id = classes.create_class(session, user, name=told.name).id
    return school_class(service, user, class_id)


@router.get("/api/classes/{class_id}", response_model=ClassRead)
def school_class(service: ServiceDep, user: CurrentUser, class_id: PathId) -> dict[str, Any]:
    """A class: its pupils to its teacher, its tasks to all in it."""
    with service.gallery.database.reading() as session:
        found = classes.found(session, SchoolClass, class_id, who=user)
        invited = Invitation.class_id == class_id, Invitation.used.is_(None), Invitation.expires > now()
        links = session.scalars(select(Invitation).where(*invited).order_by(Invitation.created)).all()
        return {
            "id": found.id,
            "name": found.name,
            "teacher": writer(session.get(Person, found.teacher_id)),
            "pupils": [person_facts(p) for p in classes.pupils(session, class_id)] if user.teaches else [],
            "tasks": [_task(session, task) for task in classes.tasks(session, class_id)],
            "invitations": [
                {"expires": link.expires, "created": link.created} for link in links if user.teaches
            ],
        }


@router.patch("/api/classes/{class_id}", response_model=ClassRead)
def rename(service: ServiceDep, user: TeacherUser, class_id: PathId, told: ClassCreate) -> dict[str, Any]:
    """Another name for a class."""
    with service.gallery.database.writing() as session:
        classes.rename_class(session, class_id, who=user, name=told.name)
    return school_class(service, user, class_id)


@router.delete("/api/classes/{class_id}", status_code=204)
def delete(service: ServiceDep, user: TeacherUser, class_id: PathId) -> None:
    """Forget a class with its tasks, its list of pupils and its links; what pupils wrote stays theirs, with
    its marks."""
    with service.gallery.database.writing() as session:
        classes.delete_class(session, class_id, who=user)


@router.delete("/api/classes/{class_id}/pupils/{person_id}", status_code=204)
def take_out(service: ServiceDep, user: TeacherUser, class_id: PathId, person_id: PathId) -> None:
    """A pupil leaves a class."""
    with service.gallery.database.writing() as session:
        classes.found(session, SchoolClass, class_id, who=user, to_teach=True)
        classes.take_out(session, class_id, person_id)


@router.post("/api/classes/{class_id}/tasks", response_model=TaskRead, status_code=201)
def add_task(service: ServiceDep, user: TeacherUser, class_id: PathId, told: TaskCreate) -> dict[str, Any]:
    """Something to write."""
    if told.due is not None and told.due.tzinfo is None:
        raise Unusable("due", zh="期限要帶時區。", en="Expected the day with its time zone.")
    with service.gallery.database.writing() as session:
        found = classes.found(session, SchoolClass, class_id, who=user, to_teach=True)
        task = classes.add_task(
            session, found, work_id=told.work, title=told.title, note=told.note, due=told.due
        )
        return _task(session, task)


@router.delete("/api/tasks/{task_id}", status_code=204)
def delete_task(service: ServiceDep, user: TeacherUser, task_id: PathId) -> None:
    """Take a task back; what was written for it stays."""
    with service.gallery.database.writing() as session:
        session.delete(classes.found(session, Task, task_id, who=user, to_teach=True))


@router.get("/api/tasks/{task_id}", response_model=TaskTable)
def table(service: ServiceDep, user: CurrentUser, task_id: PathId) -> dict[str, Any]:
    """How it went: a row a pupil, and what many got wrong; to a pupil their own row."""
    with service.gallery.database.reading() as session:
        task = classes.found(session, Task, task_id, who=user)
        rows = [_row(row) for row in classes.table(session, task, who=user)]
        common = classes.common_remarks(session, task, who=user)
        return {"task": _task(session, task), "rows": rows, "common": [_common(one) for one in common]}


@router.get("/api/tasks/{task_id}/marks.csv", response_class=Response)
def task_marks_csv(service: ServiceDep, user: TeacherUser, task_id: PathId) -> Response:
    """One's own marks of a task: image, reference, mark. The paths are those of marks.zip."""
    with service.gallery.database.reading() as session:
        classes.found(session, Task, task_id, who=user, to_teach=True)
        text = marks_csv(given_marks(session, user, task_id=task_id))
    return csv_answer(text, "marks.csv")


@router.get("/api/tasks/{task_id}/marks.zip", response_class=Response)
def task_marks_zip(service: ServiceDep, user: TeacherUser, task_id: PathId) -> Response:
    """marks.csv with the pictures that it names, as `rumu calibrate` reads it."""
    with service.gallery.database.reading() as session:
        classes.found(session, Task, task_id, who=user, to_teach=True)
    return _zip(service, user, task_id)


@router.get("/api/marks.zip", response_class=Response)
def all_marks_zip(service: ServiceDep, user: TeacherUser) -> Response:
    """All marks that one gave, with the pictures, as `rumu calibrate` reads them."""
    return _zip(service, user, None)


def _zip(service: ServiceDep, user: Identity, task_id: str | None) -> Response:
    with service.gallery.database.reading() as session:
        marks = given_marks(session, user, task_id=task_id)
    if len(marks) > 5000:
        raise NotAllowed("分數太多，請按作業分別下載。", "There are too many marks; fetch them task by task.")
    headers = {"Content-Disposition": 'attachment; filename="marks.zip"', "Cache-Control": "no-store"}
    return Response(marks_zip(service.gallery.store, marks), media_type="application/zip", headers=headers)


def _task(session: Session, task: Task) -> dict[str, Any]:
    return task_facts(task, session.get_one(Work, task.work_id))


def _row(row: classes.Row) -> dict[str, Any]:
    return {
        "person": writer(row.person),
        "attempts": row.attempts,
        "best": row.best,
        "last": row.last,
        "last_attempt": row.last_id,
        "teacher_mark": row.teacher_mark,
    }


def _common(one: classes.CommonRemark) -> dict[str, Any]:
    return {"kind": one.kind, "count": one.count} | kind_name(one.kind)._asdict()
