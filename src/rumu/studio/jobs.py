"""Long work: queued in the database, done one after another in a process of its own, taken up again after a
restart.

A job says how far it is in its row, so whoever asks, in whichever process, sees the same. Handlers can be
repeated: one that was cut off is begun again from its payload, at most MOST_TRIES times.
"""

from __future__ import annotations

import logging
import threading
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sqlalchemy import select, update
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import Session

from rumu.database.engine import Database
from rumu.database.tables import Job, new_id, now
from rumu.errors import RumuError
from rumu.gallery.gallery import Gallery
from rumu.studio.errors import Missing, NotAllowed, StudioError
from rumu.studio.people import Identity

if TYPE_CHECKING:
    from rumu.studio.place import Place
    from rumu.studio.workers import Workers

MOST_TRIES = 3
FINISHED = frozenset({"done", "failed", "cancelled"})
_OFTEN = 0.2  # seconds between two notes of progress
_log = logging.getLogger(__name__)


class CancelledError(Exception):
    """Raised inside a handler when somebody cancelled its job."""


@dataclass(slots=True)
class Progress:
    """How a handler says how far it is; raises CancelledError when nobody wants the result any more."""

    database: Database
    job_id: str
    told: float = 0.0

    def __call__(self, done: int, total: int, message: str = "") -> None:
        if time.monotonic() - self.told < _OFTEN and done < total:
            return
        self.told = time.monotonic()
        values = {"done": done, "total": total, "changed": now()} | ({"message": message} if message else {})
        if not _noted(self.database, self.job_id, values):
            raise CancelledError


def add(
    session: Session, kind: str, payload: dict[str, Any], *, person_id: str | None, job_id: str | None = None
) -> Job:
    """Queue a job; it is safe once the transaction is."""
    job = Job(id=job_id or new_id(), kind=kind, payload=payload, person_id=person_id)
    session.add(job)
    session.flush()
    return job


def found(session: Session, job_id: str, *, who: Identity) -> Job:
    """The job, for who asked for it and for owners. Raises Missing."""
    job = session.get(Job, job_id)
    if job is None or not (who.owns or job.person_id == who.id):
        raise Missing("沒有這項工作。", "There is no such job.")
    return job


def cancel(session: Session, job_id: str, *, who: Identity) -> Job:
    """Stop a job that has not finished; one that runs stops at its next step. Raises Missing, NotAllowed."""
    job = found(session, job_id, who=who)
    if job.state in FINISHED:
        raise NotAllowed("這項工作已經結束了。", "This job has ended.")
    job.state, job.changed = "cancelled", now()
    session.flush()
    return job


def take_up(database: Database) -> int:
    """At the start of a server: what ran when the last one ended is queued again; how many jobs wait.

    One server works on a database at a time.
    """
    with database.writing() as session:
        cut_off = Job.state == "running"
        failed = _failed("被打斷太多次。", "It was cut off too often.") | {"changed": now()}
        session.execute(update(Job).where(cut_off, Job.tries >= MOST_TRIES).values(failed))
        session.execute(update(Job).where(cut_off, Job.tries < MOST_TRIES).values(state="queued"))
        return len(session.scalars(select(Job.id).where(Job.state == "queued")).all())


def take(database: Database) -> str | None:
    """The id of the oldest queued job, now running; None when there is none."""
    with database.writing() as session:
        job = session.scalar(select(Job).where(Job.state == "queued").order_by(Job.created).limit(1))
        if job is None:
            return None
        job.state, job.tries, job.changed = "running", job.tries + 1, now()
        return job.id


def perform(gallery: Gallery, job_id: str, *, place: Place) -> None:
    """Do a job that was taken, and write down how it ended. Raises nothing that a handler raises."""
    from rumu.studio.handlers import HANDLERS, clear

    database = gallery.database
    with database.reading() as session:
        job = session.get(Job, job_id)
    if job is None:
        return
    try:
        result = HANDLERS[job.kind](gallery, job.payload, Progress(database, job_id), place)
    except CancelledError:
        ended: dict[str, Any] = {"state": "cancelled"}
    except Exception as error:  # a job that fails must not take the queue with it
        if not isinstance(error, RumuError):
            _log.exception("job %s of kind %s failed", job_id, job.kind)
        ended = _why(error)
    else:
        ended = {"state": "done", "result": result, "done": Job.total}
    _noted(database, job_id, ended | {"changed": now()})
    clear(gallery, job_id)


def _why(error: Exception) -> dict[str, Any]:
    """How a job ended that raised this."""
    if isinstance(error, StudioError):
        return _failed(error.zh, error.en)
    if isinstance(error, RumuError):  # said in English alone by the rooms below
        told = " ".join(str(error).split())
        return _failed(f"無法完成：{told}", told)
    name = type(error).__name__
    return _failed(f"伺服器出了意外（{name}）。", f"Something unexpected happened on the server ({name}).")


def _failed(zh: str, en: str) -> dict[str, Any]:
    return {"state": "failed", "error_zh": zh, "error_en": en}


def _noted(database: Database, job_id: str, values: dict[str, Any]) -> bool:
    """Write into the row of a running job; whether it is still running."""
    with database.writing() as session:
        running = update(Job).where(Job.id == job_id, Job.state == "running")
        return bool(session.execute(running.values(values)).rowcount)  # type: ignore[attr-defined]


class Runner:
    """The thread that takes jobs and has them done, one at a time."""

    def __init__(self, database: Database, workers: Workers) -> None:
        self._database, self._workers = database, workers
        self._wake, self._over = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, name="rumu-jobs", daemon=True)

    def start(self) -> None:
        """Take up what was cut off, and begin."""
        take_up(self._database)
        self._thread.start()

    def wake(self) -> None:
        """There is a new job."""
        self._wake.set()

    def stop(self) -> None:
        """Take no more; what runs is cut off with its process and begun again at the next start."""
        self._over.set()
        self._wake.set()

    def _run(self) -> None:
        while not self._over.is_set():
            try:
                job_id = take(self._database)
                if job_id is None:
                    self._wake.wait(timeout=2.0)
                    self._wake.clear()
                else:
                    self._do(job_id)
            except SQLAlchemyError:
                _log.exception("the queue of jobs cannot be read")
                self._over.wait(2.0)

    def _do(self, job_id: str) -> None:
        from rumu.studio import worker

        try:
            self._workers.ask(worker.job, job_id=job_id, patience=None)
        except Exception as error:
            if self._over.is_set():
                return
            _log.warning("job %s: %s", job_id, error)
            _noted(self._database, job_id, _why(error) | {"changed": now()})
