"""The thread that takes jobs from the queue and has them run, one at a time."""

from __future__ import annotations

import contextlib
import logging
import threading
from collections.abc import Callable

from sqlalchemy.exc import SQLAlchemyError

from rumu.database.engine import Database
from rumu.database.tables import now
from rumu.errors import DatabaseBusy, DiskFull
from rumu.studio.job_queue import failure_values, requeue, requeue_interrupted, take, update_running

_POLL_INTERVAL = 2.0  # seconds between two looks at the queue when nobody wakes the runner
_log = logging.getLogger(__name__)


class JobRunner:
    """Takes jobs from the queue of a database.

    run_job: runs the job of an id to its end, in a worker. may_run: whether this is still the only server.
    """

    def __init__(
        self,
        database: Database,
        run_job: Callable[[str], None],
        *,
        may_run: Callable[[], bool] = lambda: True,
    ) -> None:
        self._database, self._run_job, self._may_run = database, run_job, may_run
        self._wake, self._stopped = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._loop, name="rumu-jobs", daemon=True)

    def start(self) -> None:
        """Queue again what was interrupted, and start."""
        requeue_interrupted(self._database)
        self._thread.start()

    def wake(self) -> None:
        """Look at the queue now: there is a new job."""
        self._wake.set()

    def stop(self) -> None:
        """Take no more jobs; a running one is interrupted with its process and starts again next time."""
        self._stopped.set()
        self._wake.set()

    def _loop(self) -> None:
        while not self._stopped.is_set():
            try:
                job_id = take(self._database) if self._may_run() else None
                if job_id is None:
                    self._wake.wait(timeout=_POLL_INTERVAL)
                    self._wake.clear()
                else:
                    self._run(job_id)
            except (DatabaseBusy, DiskFull) as error:
                _log.warning("the next job waits: %s", error)
                self._stopped.wait(_POLL_INTERVAL)
            except SQLAlchemyError:
                _log.exception("the queue of jobs cannot be read")
                self._stopped.wait(_POLL_INTERVAL)

    def _run(self, job_id: str) -> None:
        try:
            self._run_job(job_id)
        except DatabaseBusy:
            while not self._stopped.wait(_POLL_INTERVAL):
                with contextlib.suppress(DatabaseBusy):
                    requeue(self._database, job_id)
                    return
        except Exception as error:
            if self._stopped.is_set():
                return
            _log.warning("job %s: %s", job_id, error)
            update_running(self._database, job_id, failure_values(error) | {"changed": now()})
