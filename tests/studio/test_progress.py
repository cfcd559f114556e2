"""The attempt before, and what changed since, from marks as they are stored."""

from __future__ import annotations

import json

import pytest

from rumu.database.tables import Work
from rumu.studio import attempts, worker_tasks
from rumu.studio.progress import StoredMark, previous_attempt, progress_facts, progress_of


@pytest.fixture
def add_copy(storage, gallery, copy_of):
    def add(user, degree="good", work="regular-tian"):
        with gallery.database.reading() as session:
            row = session.get_one(Work, work)
        marked = worker_tasks.mark(
            storage, data=copy_of(work, degree), work_id=row.id, digest=row.digest, script=row.script
        )
        return attempts.add_attempt(gallery, marked, work_id=work, person_id=user.id, kind="photo")

    return add


def test_a_later_attempt_is_compared_with_the_one_before(gallery, add_copy, person):
    lin, other = person("林"), person("王")
    bad = add_copy(lin, "bad")
    add_copy(other, "medium")
    good = add_copy(lin, "excellent")
    with gallery.database.reading() as session:
        work = session.get_one(Work, "regular-tian")
        assert progress_of(session, bad, person_id=lin.id, work=work) is None, "the first one"
        assert previous_attempt(session, good, person_id=lin.id, work_id=work.id).id == bad.id
        facts = progress_of(session, good, person_id=lin.id, work=work)
        assert progress_of(session, good, person_id=None, work=work) is None
    assert facts["previous"]["id"] == bad.id
    assert facts["mark"]["change"] == "better" and facts["mark"]["en"].startswith("Better")
    assert "gone" in {fault["status"] for fault in facts["faults"]}
    assert not {"larger", "new", "turned"} & {fault["status"] for fault in facts["faults"]}
    back = progress_facts(good, bad, character="天")
    assert back["mark"]["change"] == "worse"
    for fault in back["faults"]:
        if fault["remark"] is not None:
            assert bad.mark["remarks"][fault["remark"]]["kind"] == fault["kind"]


def test_the_same_copy_once_more_has_changed_in_nothing(gallery, add_copy, person):
    lin = person("林")
    once, again = add_copy(lin, "medium"), add_copy(lin, "medium")
    facts = progress_facts(once, again, character="天")
    assert facts["mark"]["change"] == "same"
    assert {fault["status"] for fault in facts["faults"]} == {"same"}
    assert [fault["remark"] for fault in facts["faults"]] == list(range(len(again.mark["remarks"])))


def test_marks_of_older_versions_are_read(gallery, add_copy, person):
    lin = person("林")
    old, new = add_copy(lin, "bad"), add_copy(lin, "excellent")
    facts = json.loads(json.dumps(old.mark))
    del facts["untold"]
    for remark in facts["remarks"]:
        del remark["master_outline"], remark["stroke"]
    assert StoredMark.of(facts).untold is None
    assert StoredMark.of({}).score is None
    old.mark = facts
    assert progress_facts(old, new, character="天")["mark"]["change"] == "better"
    assert not [f for f in progress_facts(new, old, character="天")["faults"] if f["status"] == "gone"]


def test_a_refused_attempt_is_not_compared(gallery, add_copy, person):
    lin = person("林")
    kept = add_copy(lin)
    kept.mark = {"score": None}
    assert progress_facts(kept, kept, character="天") is None
