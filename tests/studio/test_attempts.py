"""Attempts are stored whole, visible to those who may see them, and gone when they are deleted."""

from __future__ import annotations

import json

import pytest

from rumu.database.tables import Attempt, Membership, SchoolClass, Work
from rumu.studio import attempts, worker_tasks
from rumu.studio.access import find_visible_attempt
from rumu.studio.classes import add_task, create_class, find_row
from rumu.studio.errors import Missing, NotAllowed, Unusable


@pytest.fixture
def marked(storage, gallery, copy_of):
    with gallery.database.reading() as session:
        row = session.get_one(Work, "regular-tian")
    return worker_tasks.mark(storage, data=copy_of(), work_id=row.id, digest=row.digest, script=row.script)


@pytest.fixture
def add_copy(gallery, marked):
    def add(user, **more):
        return attempts.add_attempt(
            gallery, marked, work_id="regular-tian", person_id=user and user.id, kind="photo", **more
        )

    return add


def find_attempt(gallery, attempt, user):
    with gallery.database.reading() as session:
        return find_visible_attempt(session, attempt.id, user=user)


def test_an_attempt_is_stored_whole(gallery, add_copy, marked, person):
    attempt = add_copy(person("林"), strokes="[[[0,0,1]]]", grid="mi")
    assert gallery.store.read(attempt.picture) == marked.picture.data
    assert json.loads(gallery.store.read(attempt.strokes)) == [[[0, 0, 1]]]
    assert attempts.read_residual(gallery.store, attempt) == marked.residual
    assert attempt.score == marked.facts["score"] and attempt.mark["parts"]


def test_a_deleted_attempt_leaves_no_file(gallery, add_copy, person, tmp_path):
    from rumu.gallery.assets import picture_assets
    from rumu.gallery.derived import derived_of

    lin = person("林")
    before = {p for p in (tmp_path / "files").rglob("*") if p.is_file()}
    attempt = add_copy(lin, strokes="[]")
    derived_of(gallery.store, picture_assets(gallery.store, attempt.picture), "thumb")
    attempts.delete(gallery, attempt.id, user=lin)
    assert {p for p in (tmp_path / "files").rglob("*") if p.is_file()} == before
    with pytest.raises(Missing):
        find_attempt(gallery, attempt, lin)


def test_who_may_see_and_delete_an_attempt(gallery, add_copy, person):
    lin, wu, owner = person("林"), person("吳"), person("館主", "owner")
    teacher, other = person("師", "teacher"), person("師二", "teacher")
    with gallery.database.writing() as session:
        school_class = create_class(session, teacher, name="a")
        session.add(Membership(class_id=school_class.id, person_id=lin.id))
    attempt = add_copy(lin)
    for user in (lin, teacher, owner):
        assert find_attempt(gallery, attempt, user).id == attempt.id
    for user in (wu, other, None):
        with pytest.raises(Missing):
            find_attempt(gallery, attempt, user)
    with pytest.raises(NotAllowed):
        attempts.delete(gallery, attempt.id, user=teacher)
    with gallery.database.reading() as session:
        listed = {
            user.name: attempts.list_attempts(session, user)[1] for user in (lin, wu, teacher, other, owner)
        }
    assert listed == {"林": 1, "吳": 0, "師": 1, "師二": 0, "館主": 1}


def test_all_may_see_a_simulated_copy_and_nobody_may_delete_it(gallery, add_copy, person):
    attempt = add_copy(None)
    with gallery.database.writing() as session:
        session.get_one(Attempt, attempt.id).kind = "simulated"
    owner = person("館主", "owner")
    for user in (None, person("林"), owner):
        assert find_attempt(gallery, attempt, user).kind == "simulated"
    with pytest.raises(NotAllowed):
        attempts.delete(gallery, attempt.id, user=owner)


def test_a_teacher_s_mark_replaces_their_own_and_stands_beside_another_s(gallery, add_copy, person):
    lin, one, two = person("林"), person("師", "teacher"), person("館主", "owner")
    with gallery.database.writing() as session:
        session.add(Membership(class_id=create_class(session, one, name="a").id, person_id=lin.id))
    attempt = add_copy(lin)
    with gallery.database.writing() as session:
        for user, mark in ((one, 50), (one, 60), (two, 80)):
            attempts.set_teacher_mark(session, attempt.id, user=user, mark=mark, note="")
        (shown,) = attempts.attempt_details(session, [attempt])
        assert sorted((p.name, m.mark) for p, m in shown.teacher_marks) == [("師", 60), ("館主", 80)]
        with pytest.raises(NotAllowed):
            attempts.set_teacher_mark(session, attempt.id, user=lin, mark=100, note="")


def test_a_task_is_for_its_class_and_its_work(gallery, person):
    teacher, lin, wu = person("師", "teacher"), person("林"), person("吳")
    with gallery.database.writing() as session:
        class_id = create_class(session, teacher, name="a").id
        session.add(Membership(class_id=class_id, person_id=lin.id))
        session.flush()
        taught = find_row(session, SchoolClass, class_id, user=teacher)
        task = add_task(session, taught, work_id="regular-tian", title="")
        assert attempts.task_for(session, task.id, user=lin, work_id="regular-tian").id == task.id
        for user, work, refusal in (
            (lin, "regular-shui", Unusable),
            (wu, "regular-tian", Missing),
            (teacher, "regular-tian", NotAllowed),
        ):
            with pytest.raises(refusal):
                attempts.task_for(session, task.id, user=user, work_id=work)


@pytest.mark.parametrize(
    "text", ["[]", "[[]]", '[{"points":[[1,2,0.5,0]],"tool":"pen"}]', '{"strokes":[[[1,2]]]}']
)
def test_valid_strokes(text):
    assert json.loads(attempts.check_strokes(text)) == json.loads(text)


@pytest.mark.parametrize(
    "text",
    ["", "x", "{}", "1", "[1]", "[[1]]", '[[["a",1]]]', "[[[NaN,1]]]", "[[[1]]]", "[" * 100_000, "null"],
)
def test_invalid_strokes(text):
    with pytest.raises(Unusable):
        attempts.check_strokes(text)
