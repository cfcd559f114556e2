"""Jobs run in order, report their progress, and run again when the server ended before they did."""

from __future__ import annotations

import math
import threading
import time

import pytest
from sqlalchemy import select

from rumu.database.engine import open_database
from rumu.database.tables import Job
from rumu.errors import CaptureError, GalleryError
from rumu.studio import job_handlers, job_queue, worker_tasks
from rumu.studio.errors import Missing, NotAllowed, Unusable
from rumu.studio.job_runner import JobRunner
from rumu.studio.storage import Storage
from rumu.studio.worker_pool import WorkerPool


@pytest.fixture
def handler(monkeypatch):
    def put(work):
        monkeypatch.setitem(job_handlers.HANDLERS, "test", work)

    return put


@pytest.fixture
def queued(gallery):
    def put(payload=None, person_id=None):
        with gallery.database.writing() as session:
            return job_queue.add(session, "test", payload or {}, person_id=person_id).id

    return put


def row(gallery, job_id) -> Job:
    with gallery.database.reading() as session:
        return session.get_one(Job, job_id)


def run(gallery, storage, work_id):
    assert job_queue.take(gallery.database) == work_id
    job_handlers.run_job(gallery, work_id, storage=storage)
    return row(gallery, work_id)


def test_a_job_records_its_result(gallery, storage, handler, queued):
    handler(lambda gallery, payload, progress, storage: (progress(1, 2), {"twice": 2 * payload["n"]})[1])
    job = run(gallery, storage, queued({"n": 21}))
    assert (job.state, job.result, job.tries, job.done, job.total) == ("done", {"twice": 42}, 1, 2, 2)
    assert job_queue.take(gallery.database) is None


@pytest.mark.parametrize(
    "failure",
    [
        (Unusable(zh="壞", en="bad"), ("壞", "bad")),
        (GalleryError("no\n works"), ("無法完成：no works", "no works")),
        (CaptureError("no lamps", zh="沒有燈"), ("沒有燈", "no lamps")),
        (
            ZeroDivisionError(),
            (
                "伺服器出了意外（ZeroDivisionError）。",
                "Something unexpected happened on the server (ZeroDivisionError).",
            ),
        ),
    ],
)
def test_a_failed_job_records_why_and_the_next_runs(gallery, storage, handler, queued, failure):
    error, sentences = failure

    def fails(*_):
        raise error

    handler(fails)
    first, second = queued(), queued()
    job = run(gallery, storage, first)
    assert (job.state, (job.error_zh, job.error_en)) == ("failed", sentences)
    handler(lambda *_: {})
    assert run(gallery, storage, second).state == "done"


def test_an_interrupted_job_runs_again_a_limited_number_of_times(gallery, storage, handler, queued):
    job_id = queued()
    for _ in range(job_queue.MAX_TRIES):
        assert job_queue.take(gallery.database) == job_id  # and the server dies
        job_queue.requeue_interrupted(gallery.database)
    assert row(gallery, job_id).state == "failed" and "interrupted too many" in row(gallery, job_id).error_en
    handler(lambda *_: {"whole": True})
    job_id = queued()
    job_queue.take(gallery.database)
    assert job_queue.requeue_interrupted(gallery.database) == 1
    assert run(gallery, storage, job_id).result == {"whole": True}


def test_a_cancelled_job_stops_at_its_next_step(gallery, storage, handler, queued, person):
    owner = person("館主", "owner")
    steps = []

    def long(gallery, payload, progress, storage):
        for k in range(100):
            steps.append(k)
            if k == 3:
                with gallery.database.writing() as session:
                    job_queue.cancel(session, job_id, user=owner)
                progress.reported = 0.0
            progress(k, 100)
        return {}

    handler(long)
    job_id = queued()
    job = run(gallery, storage, job_id)
    assert job.state == "cancelled" and len(steps) == 4
    with gallery.database.writing() as session, pytest.raises(NotAllowed):
        job_queue.cancel(session, job_id, user=owner)


def test_only_the_person_who_queued_a_job_and_an_owner_see_it(gallery, queued, person):
    lin, wu, owner = person("林", "teacher"), person("吳", "teacher"), person("館主", "owner")
    job_id = queued(person_id=lin.id)
    with gallery.database.reading() as session:
        assert (
            job_queue.find_job(session, job_id, user=lin).id
            == job_queue.find_job(session, job_id, user=owner).id
        )
        with pytest.raises(Missing):
            job_queue.find_job(session, job_id, user=wu)


def test_the_runner_works_through_the_queue_when_woken(gallery, storage: Storage, handler, queued):
    handler(lambda *_: {"thread": threading.current_thread().name})
    workers = WorkerPool(storage, processes=0)
    runner = JobRunner(
        gallery.database, lambda job_id: workers.call(worker_tasks.run_job, job_id=job_id, timeout=math.inf)
    )
    runner.start()
    try:
        ids = [queued() for _ in range(3)]
        runner.wake()
        until = time.monotonic() + 60
        while any(row(gallery, one).state != "done" for one in ids):
            assert time.monotonic() < until
            time.sleep(0.02)
    finally:
        runner.stop()
        workers.stop()


def test_an_empty_queue_is_seen_while_another_writes(gallery):
    with gallery.database.writing() as session:
        session.execute(select(Job.id))  # takes the lock
        assert job_queue.take(gallery.database) is None


def test_a_job_waits_for_a_locked_database_without_a_fault_in_the_log(tmp_path, caplog):
    mine, other = (open_database(tmp_path / "rumu.sqlite", wait=0.05) for _ in range(2))
    with mine.writing() as session:
        one = job_queue.add(session, "test", {}, person_id=None).id
    ran = threading.Event()
    locked = threading.Event()
    runner = JobRunner(mine, lambda _: ran.set(), may_run=locked.is_set)
    runner.start()
    with other.writing() as session:
        session.execute(select(Job.id))  # takes the lock
        locked.set()
        until = time.monotonic() + 60
        while "the next job waits" not in caplog.text:
            assert time.monotonic() < until
            time.sleep(0.02)
        assert not ran.is_set()
    try:
        assert ran.wait(60)
        with mine.reading() as session:
            assert session.get_one(Job, one).state == "running"
        assert "Traceback" not in caplog.text
    finally:
        runner.stop()
        mine.close()
        other.close()
