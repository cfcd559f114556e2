"""`rumu calibrate` reads the zip of the marks that a teacher gave."""

from __future__ import annotations

import csv
import io
import json
import subprocess
import sys
import zipfile

import pytest

from rumu.database.tables import Membership, TeacherMark, Work
from rumu.gallery.starter import starter_samples
from rumu.studio import attempts, worker_tasks
from rumu.studio.classes import create_class
from rumu.studio.marks_export import given_marks, marks_csv, marks_zip

MARKS = {"excellent": 95, "good": 80, "medium": 60, "bad": 30}


@pytest.fixture
def teacher(gallery, storage, person):
    """A teacher with marks for the eight samples, sent by a pupil."""
    who, pupil = person("師", "teacher"), person("林")
    for sample in starter_samples():
        with gallery.database.reading() as session:
            row = session.get_one(Work, sample.work)
        marked = worker_tasks.mark(
            storage, data=sample.path.read_bytes(), work_id=row.id, digest=row.digest, script=row.script
        )
        attempt = attempts.add_attempt(gallery, marked, work_id=row.id, person_id=pupil.id, kind="photo")
        with gallery.database.writing() as session:
            session.add(TeacherMark(attempt_id=attempt.id, teacher_id=who.id, mark=MARKS[sample.degree]))
    with gallery.database.writing() as session:
        session.add(Membership(class_id=create_class(session, who, name="a").id, person_id=pupil.id))
    return who


def test_calibrate_reads_the_zip_of_a_teacher_s_marks(gallery, teacher, person, tmp_path):
    with gallery.database.reading() as session:
        marks = given_marks(session, teacher)
    with zipfile.ZipFile(io.BytesIO(marks_zip(gallery.store, marks))) as packed:
        packed.extractall(tmp_path / "marks")
    command = (sys.executable, "-m", "rumu.cli", "calibrate", tmp_path / "marks" / "marks.csv", "-o")
    ended = subprocess.run(
        [*command, tmp_path / "calibration.json", "--jobs", "1", "--json"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr
    facts = json.loads(ended.stdout)
    assert facts["marks"] == 8 and facts["masters"] == 2 and facts["left_out"] == []
    other = person("師二", "teacher")
    with gallery.database.reading() as session:
        assert given_marks(session, other) == []
        assert given_marks(session, teacher, task_id="none") == []
    rows = list(csv.DictReader(io.StringIO(marks_csv(marks))))
    assert sorted(float(row["mark"]) for row in rows) == sorted(2 * list(MARKS.values()))
    assert {row["reference"] for row in rows} == {"masters/regular-tian.png", "masters/regular-shui.png"}
