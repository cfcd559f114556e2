"""Routes of classes, of their tasks, and of the marks that teachers give."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Response
from sqlalchemy import select
from sqlalchemy.orm import Session

from rumu.database.tables import Invitation, Person, SchoolClass, Task, Work, now
from rumu.report.wording import kind_name
from rumu.studio import classes
from rumu.studio.errors import NotAllowed
from rumu.studio.marks_export import given_marks, marks_csv, marks_zip
from rumu.studio.people import Identity
from rumu.web.dependencies import CurrentUser, PathId, ServiceDep, TeacherUser
from rumu.web.responses import csv_response, download_response
from rumu.web.schemas import Extended
from rumu.web.studio_schemas import ClassCreate, ClassRead, ClassSummary, TaskCreate, TaskRead, TaskTable

router = APIRouter(tags=["classes"])
_MAX_MARKS = 5000  # in one zip, which is made in memory


@router.get("/api/classes", response_model=list[ClassSummary])
def list_classes(service: ServiceDep, user: CurrentUser) -> list[Extended]:
    """The classes that the user teaches or learns in; for an owner all."""
    with service.gallery.database.reading() as session:
        rows = classes.list_classes(session, user)
    return [Extended(row, pupils=pupils, tasks=tasks) for row, pupils, tasks in rows]


@router.post("/api/classes", response_model=ClassRead, status_code=201)
def add_class(service: ServiceDep, user: TeacherUser, school_class: ClassCreate) -> Extended:
    """Add a class of one's own."""
    with service.gallery.database.writing() as session:
        class_id = classes.create_class(session, user, name=school_class.name).id
    return get_class(service, user, class_id)


@router.get("/api/classes/{class_id}", response_model=ClassRead)
def get_class(service: ServiceDep, user: CurrentUser, class_id: PathId) -> Extended:
    """A class: its pupils for its teacher, its tasks for all in it."""
    with service.gallery.database.reading() as session:
        row = classes.find_row(session, SchoolClass, class_id, user=user)
        unused = Invitation.class_id == class_id, Invitation.used.is_(None), Invitation.expires > now()
        tasks = select(Task).where(Task.class_id == class_id).order_by(Task.created.desc())
        links = session.scalars(select(Invitation).where(*unused).order_by(Invitation.created)).all()
        return Extended(
            row,
            teacher=session.get(Person, row.teacher_id),
            pupils=classes.pupils(session, class_id) if user.teaches else [],
            tasks=[_with_work(session, task) for task in session.scalars(tasks)],
            invitations=links if user.teaches else [],
        )


@router.patch("/api/classes/{class_id}", response_model=ClassRead)
def rename_class(service: ServiceDep, user: TeacherUser, class_id: PathId, changes: ClassCreate) -> Extended:
    """Give a class another name."""
    with service.gallery.database.writing() as session:
        classes.find_row(session, SchoolClass, class_id, user=user, require_teacher=True).name = changes.name
    return get_class(service, user, class_id)


@router.delete("/api/classes/{class_id}", status_code=204)
def delete_class(service: ServiceDep, user: TeacherUser, class_id: PathId) -> None:
    """Delete a class with its tasks, its list of pupils and its links; attempts and their marks stay."""
    with service.gallery.database.writing() as session:
        row = classes.find_row(session, SchoolClass, class_id, user=user, require_teacher=True)
        session.delete(row)  # foreign keys delete the rest


@router.delete("/api/classes/{class_id}/pupils/{person_id}", status_code=204)
def remove_pupil(service: ServiceDep, user: TeacherUser, class_id: PathId, person_id: PathId) -> None:
    """Take a pupil out of a class."""
    with service.gallery.database.writing() as session:
        classes.find_row(session, SchoolClass, class_id, user=user, require_teacher=True)
        classes.remove_pupil(session, class_id, person_id)


@router.post("/api/classes/{class_id}/tasks", response_model=TaskRead, status_code=201)
def add_task(service: ServiceDep, user: TeacherUser, class_id: PathId, task: TaskCreate) -> Extended:
    """Give a class something to write."""
    with service.gallery.database.writing() as session:
        school_class = classes.find_row(session, SchoolClass, class_id, user=user, require_teacher=True)
        row = classes.add_task(
            session, school_class, work_id=task.work, title=task.title, note=task.note, due=task.due
        )
        return _with_work(session, row)


@router.delete("/api/tasks/{task_id}", status_code=204)
def delete_task(service: ServiceDep, user: TeacherUser, task_id: PathId) -> None:
    """Delete a task; the attempts at it stay."""
    with service.gallery.database.writing() as session:
        session.delete(classes.find_row(session, Task, task_id, user=user, require_teacher=True))


@router.get("/api/tasks/{task_id}", response_model=TaskTable)
def get_task(service: ServiceDep, user: CurrentUser, task_id: PathId) -> dict[str, Any]:
    """The results of a task: a row for each pupil, and common remarks; for a pupil their own row."""
    with service.gallery.database.reading() as session:
        task = classes.find_row(session, Task, task_id, user=user)
        rows, remarks = classes.summarise_task(session, task, user=user)
        return {
            "task": _with_work(session, task),
            "rows": rows,
            "common": [Extended(remark, **kind_name(remark.kind)._asdict()) for remark in remarks],
        }


@router.get("/api/tasks/{task_id}/marks.csv", response_class=Response)
def get_task_marks_csv(service: ServiceDep, user: TeacherUser, task_id: PathId) -> Response:
    """The teacher's own marks of a task: image, reference, mark. The paths are those of marks.zip."""
    with service.gallery.database.reading() as session:
        classes.find_row(session, Task, task_id, user=user, require_teacher=True)
        text = marks_csv(given_marks(session, user, task_id=task_id))
    return csv_response(text, "marks.csv")


@router.get("/api/tasks/{task_id}/marks.zip", response_class=Response)
def get_task_marks_zip(service: ServiceDep, user: TeacherUser, task_id: PathId) -> Response:
    """marks.csv with the pictures that it names, as `rumu calibrate` reads it."""
    with service.gallery.database.reading() as session:
        classes.find_row(session, Task, task_id, user=user, require_teacher=True)
    return _marks_zip(service, user, task_id)


@router.get("/api/marks.zip", response_class=Response)
def get_marks_zip(service: ServiceDep, user: TeacherUser) -> Response:
    """All marks that the teacher gave, with the pictures, as `rumu calibrate` reads them."""
    return _marks_zip(service, user, None)


def _marks_zip(service: ServiceDep, user: Identity, task_id: str | None) -> Response:
    with service.gallery.database.reading() as session:
        marks = given_marks(session, user, task_id=task_id)
    if len(marks) > _MAX_MARKS:
        raise NotAllowed(
            zh="分數太多，請按作業分別下載。", en="There are too many marks; fetch them task by task."
        )
    data = marks_zip(service.gallery.store, marks)
    return download_response(data, media_type="application/zip", filename="marks.zip")


def _with_work(session: Session, task: Task) -> Extended:
    return Extended(task, work=session.get_one(Work, task.work_id))
