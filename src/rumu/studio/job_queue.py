"""The queue of long work, in the database: add, look up, cancel, take, and report progress.

A job's progress stands in its row, so that every process reads the same. Handlers can be repeated: a job that
was interrupted starts again from its payload, at most MAX_TRIES times.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

from sqlalchemy import select, update
from sqlalchemy.orm import Session

from rumu.database.engine import Database
from rumu.database.tables import Job, new_id, now
from rumu.errors import DiskFull, RumuError
from rumu.outputs import is_full
from rumu.studio.errors import Missing, NotAllowed, StudioError, without_folders
from rumu.studio.people import Identity

MAX_TRIES = 3
FINISHED = frozenset({"done", "failed", "cancelled"})
_PROGRESS_INTERVAL = 0.2  # seconds between two updates of a row


class CancelledError(Exception):
    """Raised inside a handler when somebody cancelled its job."""


@dataclass(slots=True)
class Progress:
    """Reports a handler's progress; raises CancelledError when the job was cancelled."""

    database: Database
    job_id: str
    reported: float = 0.0

    def __call__(self, done: int, total: int, message: str = "") -> None:
        if time.monotonic() - self.reported < _PROGRESS_INTERVAL and done < total:
            return
        self.reported = time.monotonic()
        values = {"done": done, "total": total, "changed": now()} | ({"message": message} if message else {})
        if not update_running(self.database, self.job_id, values):
            raise CancelledError


def add(
    session: Session, kind: str, payload: dict[str, Any], *, person_id: str | None, job_id: str | None = None
) -> Job:
    """Queue a job; it is stored once the transaction is committed."""
    job = Job(id=job_id or new_id(), kind=kind, payload=payload, person_id=person_id)
    session.add(job)
    session.flush()
    return job


def find_job(session: Session, job_id: str, *, user: Identity) -> Job:
    """Return a job to the person who queued it or to an owner. Raises Missing."""
    job = session.get(Job, job_id)
    if job is None or not (user.owns or job.person_id == user.id):
        raise Missing(zh="沒有這項工作。", en="There is no such job.")
    return job


def cancel(session: Session, job_id: str, *, user: Identity) -> Job:
    """Cancel an unfinished job; a running one stops at its next step. Raises Missing, NotAllowed."""
    job = find_job(session, job_id, user=user)
    if job.state in FINISHED:
        raise NotAllowed(zh="這項工作已經結束了。", en="This job has ended.")
    job.state, job.changed = "cancelled", now()
    session.flush()
    return job


def requeue_interrupted(database: Database) -> int:
    """Queue again what ran when the last server ended, and return how many jobs wait.

    Called at the start of a server; one server works on a database at a time.
    """
    with database.writing() as session:
        interrupted = Job.state == "running"
        failed = _failure("被打斷太多次。", "The job was interrupted too many times.") | {"changed": now()}
        session.execute(update(Job).where(interrupted, Job.tries >= MAX_TRIES).values(failed))
        session.execute(update(Job).where(interrupted, Job.tries < MAX_TRIES).values(state="queued"))
        return len(session.scalars(select(Job.id).where(Job.state == "queued")).all())


def take(database: Database) -> str | None:
    """Set the oldest queued job running and return its id; None when there is none. Raises DatabaseBusy."""
    queued = select(Job).where(Job.state == "queued").order_by(Job.created).limit(1)
    with database.reading() as session:  # an empty queue is seen without waiting for those who write
        if session.scalar(queued) is None:
            return None
    with database.writing() as session:
        job = session.scalar(queued)
        if job is None:
            return None
        job.state, job.tries, job.changed = "running", job.tries + 1, now()
        return job.id


def requeue(database: Database, job_id: str) -> None:
    """Queue a running job again, or end it as failed after MAX_TRIES. Raises DatabaseBusy."""
    with database.writing() as session:
        running = update(Job).where(Job.id == job_id, Job.state == "running")
        session.execute(running.where(Job.tries < MAX_TRIES).values(state="queued", changed=now()))
        busy = _failure("資料庫一直被鎖住。", "The database was locked at every try.")
        session.execute(running.where(Job.tries >= MAX_TRIES).values(busy | {"changed": now()}))


def failure_values(error: Exception) -> dict[str, Any]:
    """Return the values of the row of a job that raised this error."""
    if isinstance(error, StudioError):
        return _failure(error.zh, error.en)
    if isinstance(error, RumuError):  # some errors of lower packages are in English only
        text = without_folders(" ".join(str(error).split()))
        return _failure(without_folders(error.zh or f"無法完成：{text}"), text)
    if is_full(error):
        return failure_values(DiskFull("files"))
    name = type(error).__name__
    return _failure(f"伺服器出了意外（{name}）。", f"Something unexpected happened on the server ({name}).")


def _failure(zh: str, en: str) -> dict[str, Any]:
    return {"state": "failed", "error_zh": zh, "error_en": en}


def update_running(database: Database, job_id: str, values: dict[str, Any]) -> bool:
    """Write into the row of a running job; return whether it is still running."""
    with database.writing() as session:
        running = update(Job).where(Job.id == job_id, Job.state == "running")
        return bool(session.execute(running.values(values)).rowcount)  # type: ignore[attr-defined]
