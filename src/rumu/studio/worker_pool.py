"""A pool of worker processes: started before the first request, replaced when one dies, and bounded."""

from __future__ import annotations

import math
import pickle
import threading
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass
from typing import Any, TypeVar

from rumu.errors import RumuError
from rumu.executors import cores, end_executor, process_executor, submit
from rumu.studio.errors import Busy
from rumu.studio.storage import Storage

Answer = TypeVar("Answer")

_THREADS = 2  # that work where there are no processes


@dataclass(frozen=True, slots=True)
class PoolSettings:
    """How a pool works.

    max_requests: those that may wait or run at a time. timeout: seconds that one may wait for a free worker,
    and that it may run. niceness: by how much the priority of the workers is lowered, so that readers are
    answered before copies are marked.
    """

    max_requests: int = 64
    timeout: float = 120.0
    niceness: int = 15


class WorkerPool:
    """Runs functions of (storage, **arguments) in worker processes.

    make_executor: starts the workers: by default processes, or two threads where `processes` is 0; any other
    Executor (such as a Dask client's) can be given.
    """

    def __init__(
        self,
        storage: Storage,
        *,
        processes: int | None = None,
        make_executor: Callable[[], Executor] | None = None,
        settings: PoolSettings | None = None,
    ) -> None:
        self.storage = storage
        self._settings = settings or PoolSettings()
        self._processes = min(cores(), 4) if processes is None else processes
        self._make_executor = make_executor or self._default_executor
        self._slots = threading.BoundedSemaphore(self._settings.max_requests)
        self._free_workers = threading.BoundedSemaphore(self._processes or _THREADS)
        self._lock = threading.Lock()
        self._executor: Executor | None = None
        self._stopped = False

    @property
    def processes(self) -> int:
        """How many pieces of work run at a time."""
        return self._processes or _THREADS

    def start(self, warm_up: Callable[[Storage], object]) -> None:
        """Start all workers and run `warm_up` in each; use threads where processes cannot be started."""
        executor = self._running_executor()
        try:
            wait([self._submit(executor, warm_up, {}) for _ in range(max(self._processes, 1))])
        except (BrokenExecutor, OSError):
            self._processes = 0
            self._discard(executor)

    def stop(self) -> None:
        """End all workers for good, even while they work; later requests raise Busy."""
        with self._lock:
            self._stopped = True
            executor, self._executor = self._executor, None
        if executor is not None:
            end_executor(executor, kill=True)

    def call(self, work: Callable[..., Answer], *, timeout: float | None = None, **arguments: Any) -> Answer:
        """Return `work(storage, **arguments)` of a worker; work whose worker died is tried once more.

        timeout: seconds to wait for a free worker and then for its answer, `math.inf` for ever, the
        settings' by default; a worker that takes longer is ended. Raises Busy for both, when too many wait
        and after `stop`; RumuError when the worker died twice; and what `work` raises.
        """
        seconds = self._settings.timeout if timeout is None else timeout
        limit = None if seconds == math.inf else seconds
        if not self._slots.acquire(blocking=False):
            raise Busy
        try:
            # Work is submitted when a worker is free, so the timeout of its answer counts running time only.
            if not self._free_workers.acquire(timeout=limit):
                raise Busy
            try:
                return self._run(work, arguments, timeout=limit)
            finally:
                self._free_workers.release()
        finally:
            self._slots.release()

    def _run(
        self, work: Callable[..., Answer], arguments: dict[str, Any], *, timeout: float | None
    ) -> Answer:
        for _ in range(2):
            executor = self._running_executor()
            try:
                future = self._submit(executor, work, arguments)
                return future.result(timeout=timeout)
            except Exception as error:
                if isinstance(error, TimeoutError) and not future.done():
                    self._discard(executor)  # a worker that hangs would hang for ever
                    raise Busy from error
                if not isinstance(error, BrokenExecutor) and executor is self._executor:
                    raise
                self._discard(executor)  # its worker died, or it was ended because of other work
        raise RumuError("the process that did this work ended before it was done (out of memory?)")

    def _submit(
        self, executor: Executor, work: Callable[..., Answer], arguments: dict[str, Any]
    ) -> Future[Answer]:
        with self._lock:  # to submit may start a process, and `stop` must know of it
            if self._executor is not executor:
                raise BrokenExecutor("shut down meanwhile")
            return submit(executor, _call_in_worker, work, self.storage, arguments)

    def _running_executor(self) -> Executor:
        with self._lock:
            if self._stopped:
                raise Busy
            if self._executor is None:
                self._executor = self._make_executor()
            return self._executor

    def _discard(self, executor: Executor) -> None:
        """End an executor that is broken or hangs; the next request gets a new one."""
        with self._lock:
            if self._executor is not executor:
                return
            self._executor = None
        end_executor(executor, kill=True)

    def _default_executor(self) -> Executor:
        if self._processes == 0:
            return ThreadPoolExecutor(_THREADS, thread_name_prefix="rumu-worker")
        return process_executor(self._processes, niceness=self._settings.niceness)


def _call_in_worker(work: Callable[..., Any], storage: Storage, arguments: dict[str, Any]) -> Any:
    """Call the work, in the worker; an error that cannot be pickled becomes a RumuError with its text."""
    try:
        return work(storage, **arguments)
    except Exception as error:
        try:
            pickle.loads(pickle.dumps(error))
        except Exception:
            raise RumuError(f"{type(error).__name__}: {error}") from None
        raise
