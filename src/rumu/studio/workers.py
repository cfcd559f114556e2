"""A pool of worker processes that is there before the first request, mends itself, and says when it is
full."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any, TypeVar

from rumu.errors import RumuError
from rumu.executors import cores
from rumu.studio import worker
from rumu.studio.errors import Busy
from rumu.studio.place import Place

Answer = TypeVar("Answer")

_PATIENCE = 120.0  # seconds for one piece of work


class Workers:
    """processes: how many; 0 works in threads of this process. waiting: how many may be asked at a time."""

    def __init__(self, place: Place, *, processes: int | None = None, waiting: int = 64) -> None:
        self.place = place
        self._processes = min(cores(), 4) if processes is None else processes
        self._places = threading.BoundedSemaphore(waiting)
        self._lock = threading.Lock()
        self._pool: Executor | None = None
        self._over = False

    def start(self) -> None:
        """Start all processes and have each load what a mark needs; threads, where processes cannot be
        had."""
        pool = self._running()
        try:
            wait([self._submitted(pool, worker.ready, {}) for _ in range(max(self._processes, 1))])
        except (BrokenProcessPool, OSError):
            self._processes = 0
            self._broken(pool)

    def stop(self) -> None:
        """End all processes, in the midst of what they do, for good: who asks afterwards gets Busy."""
        with self._lock:  # a process made after this would be waited for when the program ends
            self._over = True
            pool, self._pool = self._pool, None
        if isinstance(pool, ProcessPoolExecutor):
            # half an answer is known for an end once nobody is left who could write the rest
            pool._result_queue._writer.close()  # type: ignore[attr-defined]
            for process in list((pool._processes or {}).values()):
                process.kill()  # a long job would else hold the exit up; it is begun again
            pool.shutdown(cancel_futures=True)
        elif pool is not None:
            pool.shutdown(wait=False, cancel_futures=True)  # a thread cannot be cut off

    def ask(self, work: Callable[..., Answer], *, patience: float | None = _PATIENCE, **terms: Any) -> Answer:
        """`work(place, **terms)` in a process. A process that dies under it is replaced, and it is tried
        once more.

        patience: seconds to wait for the answer, None for ever. Raises Busy when too many wait or after
        `stop`, RumuError when the process died twice, and what `work` raises.
        """
        if not self._places.acquire(blocking=False):
            raise Busy
        try:
            for _ in range(2):
                pool = self._running()
                try:
                    return self._submitted(pool, work, terms).result(timeout=patience)
                except BrokenProcessPool:
                    self._broken(pool)
                except TimeoutError as error:
                    raise Busy from error
            raise RumuError("the process that did this work ended before it was done (out of memory?)")
        finally:
            self._places.release()

    def _submitted(self, pool: Executor, work: Callable[..., Answer], terms: Any) -> Future[Answer]:
        with self._lock:  # to hand work over may start a process, and `stop` must know of it
            if self._pool is not pool:
                raise BrokenProcessPool("shut down meanwhile")
            return pool.submit(worker.answered, work, self.place, terms)

    def _running(self) -> Executor:
        with self._lock:
            if self._over:
                raise Busy
            if self._pool is None:
                self._pool = self._made()
            return self._pool

    def _broken(self, pool: Executor) -> None:
        with self._lock:
            if self._pool is pool:
                self._pool = None
        pool.shutdown(wait=False, cancel_futures=True)

    def _made(self) -> Executor:
        if self._processes == 0:
            return ThreadPoolExecutor(2, thread_name_prefix="rumu-worker")
        import multiprocessing

        for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
            os.environ.setdefault(name, "1")  # one thread a process, read when numpy is loaded over there
        # not fork: this process has threads, whose locks a fork would copy
        method = "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
        context = multiprocessing.get_context(method)
        if method == "forkserver":
            context.set_forkserver_preload(["rumu.pipeline"])
        return ProcessPoolExecutor(self._processes, mp_context=context, initializer=worker.begin)
