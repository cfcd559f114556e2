"""Classes are renamed and deleted by their teacher or an owner; the copies of their pupils remain."""

from __future__ import annotations

import pytest
from sqlalchemy import func, select

from rumu.database.tables import Attempt, Invitation, Membership, SchoolClass, Task, TeacherMark
from rumu.gallery.catalog import open_gallery
from rumu.studio import attempts, classes, invitations
from rumu.studio.attempts import MarkedCopy
from rumu.studio.errors import Missing, NotAllowed
from rumu.studio.people import create_person, identity
from rumu.studio.pictures import UprightPicture

MARK = {"score": 60.0, "level": "good", "remarks": []}


@pytest.fixture
def gallery(database_url, tmp_path):
    return open_gallery(database=database_url, files=tmp_path / "files")


@pytest.fixture
def marked():
    return MarkedCopy(facts=MARK, residual=None, picture=UprightPicture(b"png", "png", 1, 1))


@pytest.fixture
def school(gallery):
    """(teacher, other teacher, owner, pupil, id of the teacher's class, id of its task)."""
    with gallery.database.writing() as session:
        teacher, other, owner, pupil = (
            identity(create_person(session, name=name, password="a long password", role=role))
            for name, role in (("林", "teacher"), ("陳", "teacher"), ("館主", "owner"), ("吳", "pupil"))
        )
        school_class = classes.create_class(session, teacher, name="三年二班")
        session.add(Membership(class_id=school_class.id, person_id=pupil.id))
        invitations.invite(session, teacher, role="pupil", class_id=school_class.id)
        task = classes.add_task(session, school_class, work_id="regular-tian", title="第一週")
    return teacher, other, owner, pupil, school_class.id, task.id


def delete_class(gallery, class_id, *, user):
    with gallery.database.writing() as session:
        session.delete(classes.find_row(session, SchoolClass, class_id, user=user, require_teacher=True))


def test_only_its_teacher_and_an_owner_may_rename_a_class(gallery, school):
    teacher, other, owner, pupil, class_id, _ = school
    for user, refusal in ((other, Missing), (pupil, NotAllowed)):
        with gallery.database.writing() as session, pytest.raises(refusal):
            classes.find_row(session, SchoolClass, class_id, user=user, require_teacher=True)
    for user, name in ((teacher, "三年三班"), (owner, "四年三班")):
        with gallery.database.writing() as session:
            classes.find_row(session, SchoolClass, class_id, user=user, require_teacher=True).name = name
        with gallery.database.reading() as session:
            assert session.get_one(SchoolClass, class_id).name == name


def test_the_copies_of_pupils_remain_when_their_class_is_deleted(gallery, school, marked):
    teacher, other, _, pupil, class_id, task_id = school
    about = {"work_id": "regular-tian", "person_id": pupil.id, "kind": "photo"}
    attempt = attempts.add_attempt(gallery, marked, task_id=task_id, **about)
    with gallery.database.writing() as session:
        attempts.set_teacher_mark(session, attempt.id, user=teacher, mark=71, note="好")
    for user, refusal in ((other, Missing), (pupil, NotAllowed)):
        with pytest.raises(refusal):
            delete_class(gallery, class_id, user=user)
    delete_class(gallery, class_id, user=teacher)
    with gallery.database.reading() as session:
        for table in (SchoolClass, Task, Membership, Invitation):
            assert session.scalar(select(func.count()).select_from(table)) == 0
        stored = session.get_one(Attempt, attempt.id)
        assert (stored.person_id, stored.task_id, stored.score) == (pupil.id, None, 60.0)
        assert session.get_one(TeacherMark, (attempt.id, teacher.id)).note == "好"
        assert [shown.attempt.id for shown in attempts.list_attempts(session, pupil)[0]] == [attempt.id]
        assert attempts.list_attempts(session, teacher)[1] == 0
    assert gallery.store.exists(attempt.picture)


def test_a_copy_is_stored_when_its_task_is_deleted_while_it_is_marked(gallery, school, marked):
    teacher, _, _, pupil, class_id, task_id = school
    delete_class(gallery, class_id, user=teacher)
    about = {"work_id": "regular-tian", "person_id": pupil.id, "kind": "photo"}
    attempt = attempts.add_attempt(gallery, marked, task_id=task_id, **about)
    with gallery.database.reading() as session:
        assert session.get_one(Attempt, attempt.id).task_id is None
