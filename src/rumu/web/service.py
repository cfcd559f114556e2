"""The running service: its gallery, its workers, its queue of jobs, and what it keeps in memory."""

from __future__ import annotations

import contextlib
import math
import threading
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from anyio import CapacityLimiter
from sqlalchemy import select

from rumu.database.server_lock import ServerLock
from rumu.database.tables import Attempt, Job, Work
from rumu.gallery.catalog import open_gallery
from rumu.studio import job_queue, worker_tasks
from rumu.studio.errors import Busy
from rumu.studio.invitations import invite_first_owner
from rumu.studio.job_runner import JobRunner
from rumu.studio.people import Identity, identify_session, owner_exists
from rumu.studio.tickets import Ticket, open_tickets
from rumu.studio.worker_pool import WorkerPool
from rumu.web.files import DerivedFiles
from rumu.web.rate_limits import RateLimiter
from rumu.web.settings import ServiceSettings

WRITE_WAIT = 5.0  # seconds that a request waits for SQLite's write lock, before it is told to come back
MAX_MARKING_THREADS = 48  # threads that wait for marks; further requests wait without a thread
MAX_LOGIN_THREADS = 4  # threads that wait for passwords to be hashed, two at a time


@dataclass(frozen=True, slots=True)
class CurrentSession:
    """The session of a request by a person who is logged in."""

    ticket: Ticket
    user: Identity


class Service:
    """Opens the gallery when it is made; `start` and `stop` are called with the server's."""

    def __init__(self, settings: ServiceSettings, *, lock: ServerLock | None = None) -> None:
        storage = settings.storage
        self.settings = settings
        self.gallery = open_gallery(database=storage.database, files=storage.files, wait=WRITE_WAIT)
        self.tickets = open_tickets(self.gallery.database)
        self.rate_limiter = RateLimiter()
        self.workers = WorkerPool(storage, processes=settings.processes)
        self.job_workers = WorkerPool(storage, processes=0 if settings.processes == 0 else 1)
        self.files = DerivedFiles(self.gallery, self.workers)
        self.stopping = False
        self._starting = threading.Thread(target=self._start_work, name="rumu-start", daemon=True)
        self.marking_limiter = CapacityLimiter(MAX_MARKING_THREADS)
        self.login_limiter = CapacityLimiter(MAX_LOGIN_THREADS)
        self.runner = JobRunner(self.gallery.database, self._run_job, may_run=(lock or ServerLock()).is_held)

    def start(self) -> None:
        """Have the workers and then the queue of jobs started, while pages are sent already."""
        self._starting.start()

    def wait_until_started(self) -> None:
        """Return when the workers and the queue run, or when the service was stopped."""
        self._starting.join()

    def _start_work(self) -> None:
        """Start the workers, so that the first mark is as quick as the others, and the queue of jobs."""
        with contextlib.suppress(Busy):  # the service was stopped meanwhile
            self.workers.start(worker_tasks.warm_up)
        if self.stopping:
            return
        self.runner.start()
        if self.settings.prepare:
            self.prepare()

    def stop(self) -> None:
        """Stop everything at once; jobs that are running begin again at the next start."""
        self.stopping = True
        self.workers.stop()
        if self._starting.is_alive():
            self._starting.join()
        self.runner.stop()
        self.job_workers.stop()
        self.gallery.database.close()

    def _run_job(self, job_id: str) -> None:
        self.job_workers.call(worker_tasks.run_job, job_id=job_id, timeout=math.inf)

    def prepare(self) -> str | None:
        """Queue the job that makes thumbnails and samples, once for a gallery.

        Returns the job's id, None if it was done before or there are no works.
        """
        with self.gallery.database.writing() as session:
            sample = session.scalar(select(Attempt.id).where(Attempt.kind == "simulated").limit(1))
            queued = session.scalar(
                select(Job.id).where(Job.kind == "prepare", Job.state.in_(("queued", "running")))
            )
            if queued is not None or sample is not None or session.scalar(select(Work.id).limit(1)) is None:
                return queued
            job_id = job_queue.add(session, "prepare", {}, person_id=None).id
        self.runner.wake()
        return job_id

    def start_job(
        self, kind: str, payload: dict[str, Any], *, person_id: str, job_id: str | None = None
    ) -> Job:
        """Queue a job and have it run; what it reads of the store must lie there."""
        with self.gallery.database.writing() as session:
            job = job_queue.add(session, kind, payload, person_id=person_id, job_id=job_id)
        self.runner.wake()
        return job

    def identify(self, tickets: Iterable[Ticket]) -> CurrentSession | None:
        """The first session among tickets that has not ended; None for visitors."""
        with self.gallery.database.reading() as session:
            for ticket in tickets:
                user = None if ticket.person_id is None else identify_session(session, ticket)
                if user is not None:
                    return CurrentSession(ticket, user)
        return None

    def has_owner(self) -> bool:
        """Whether somebody owns this service."""
        with self.gallery.database.reading() as session:
            return owner_exists(session)

    def owner_link(self) -> str | None:
        """The path of a link for the first owner; None when there is one."""
        if self.has_owner():
            return None
        with self.gallery.database.writing() as session:
            token = invite_first_owner(session)
        return None if token is None else f"/#/join/{token}"
