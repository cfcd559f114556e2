"""Spread work over processes, behind one interface: `concurrent.futures.Executor`.

The executor is loky's, which notices a killed worker, or that of a Dask client, whose workers may run on
other machines and whose work is done again when one of them is killed. Answers come in the order of the
items.
"""

from __future__ import annotations

import contextlib
import logging
import os
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor, Future
from typing import Any, TypeVar

from rumu.errors import RumuError

Item = TypeVar("Item")
Answer = TypeVar("Answer")

LOCAL_CLUSTER = "local"
"""In place of a Dask scheduler's address: a cluster on this machine, for as long as the work lasts."""
_AHEAD = 8  # items handed to each process before its answers are awaited
_PARENT_CHECK = 0.5  # seconds between two looks at whether the parent process still runs
_DASK_TIMEOUT = 20  # seconds within which a scheduler answers
_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def process_executor(processes: int, *, niceness: int = 0) -> Executor:
    """Return an executor of worker processes, each of one thread, that end with this process.

    Work is pickled: a function of a module, or a partial of one. When a worker is killed, all that is in
    flight raises BrokenExecutor. niceness: by how much the workers' priority is lowered. End it with
    `end_executor`.
    """
    from loky import ProcessPoolExecutor

    executor: Executor = ProcessPoolExecutor(
        processes, env=_ONE_THREAD, initializer=_set_up_worker, initargs=(niceness, os.getpid())
    )
    return executor


@contextlib.contextmanager
def open_executor(processes: int, *, dask: str | None = None) -> Iterator[tuple[Executor | None, int]]:
    """Yield an executor and how many items it works on at once; it is ended afterwards.

    processes: of this machine; with one of them the executor is None, and the work is done in this process.
    dask: `LOCAL_CLUSTER`, or the address of a scheduler (tcp://HOST:8786), whose workers need this version of
    rumu and see files under the same paths. Raises RumuError when the scheduler is not there or has no
    worker, or dask.distributed is not installed.
    """
    if dask is not None:
        with _dask_client(dask, processes) as client:
            yield _DaskExecutor(client), sum(client.ncores().values())
        return
    if processes == 1:
        yield None, 1
        return
    executor, finished = process_executor(processes), False
    try:
        yield executor, processes
        finished = True
    finally:
        end_executor(executor, kill=not finished)


class _DaskExecutor(Executor):
    """Work on a Dask cluster; an answer that a killed worker took along is computed again.

    The client's own executor copies each answer into another future, and fails where the worker is killed
    while it does so.
    """

    def __init__(self, client: Any) -> None:
        self._client = client

    def submit(self, fn: Callable[..., Answer], /, *args: Any, **kwargs: Any) -> Future[Answer]:
        future: Future[Answer] = self._client.submit(fn, *args, pure=False, **kwargs)
        return future


@contextlib.contextmanager
def _dask_client(address: str, processes: int) -> Iterator[Any]:
    try:
        from distributed import Client, LocalCluster
    except ImportError as error:
        raise RumuError(
            "--dask needs dask.distributed, which is not installed: pip install 'rumu[dask]'"
        ) from error
    with contextlib.ExitStack() as stack:
        try:
            if address == LOCAL_CLUSTER:
                cluster = LocalCluster(  # type: ignore[no-untyped-call]
                    n_workers=processes,
                    threads_per_worker=1,
                    dashboard_address=None,
                    silence_logs=logging.ERROR,
                )
                address = stack.enter_context(cluster).scheduler_address
            client = stack.enter_context(Client(address, timeout=_DASK_TIMEOUT))  # type: ignore[no-untyped-call]
        except (OSError, ValueError) as error:
            raise RumuError(
                f"expected a Dask scheduler at {address}, such as tcp://HOST:8786, found none ({error})"
            ) from error
        if not client.ncores():
            raise RumuError(f"expected a worker at the Dask scheduler {address}, found none; start one")
        client.register_plugin(_one_thread())
        yield client


def _one_thread() -> Any:
    """What each worker of a Dask cluster does when it starts: OpenCV works in one thread."""
    from distributed import WorkerPlugin

    class OneThread(WorkerPlugin):
        name = "rumu-one-thread"

        def setup(self, worker: Any) -> None:
            import cv2

            cv2.setNumThreads(1)

    return OneThread()


def submit(executor: Executor, work: Callable[..., Answer], *arguments: Any) -> Future[Answer]:
    """Submit work; a worker that starts for it does not receive Ctrl-C, which the parent alone answers."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        return executor.submit(work, *arguments)
    from multiprocessing import resource_tracker

    resource_tracker.ensure_running()  # which would unblock the signal if the executor started it
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # a new process inherits the mask
    try:
        return executor.submit(work, *arguments)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def end_executor(executor: Executor, *, kill: bool = False) -> None:
    """End an executor after what is in flight; kill: at once where possible, even while it works."""
    try:
        executor.shutdown(wait=True, kill_workers=kill)  # type: ignore[call-arg]
    except TypeError:  # an executor other than loky's
        executor.shutdown(wait=not kill, cancel_futures=True)


def in_order(
    work: Callable[[Item], Answer],
    items: Iterable[Item],
    *,
    processes: int | None = None,
    executor: Executor | None = None,
) -> Iterator[Answer]:
    """Yield `work` of each item, in order, as they come; items are read no farther ahead than needed.

    processes: all cores by default; 1 does the work in this process. executor: takes the work in place of new
    processes, and is not ended. Raises RumuError when a worker is killed; what `work` raises is raised here.
    """
    processes = processes or cores()
    if executor is None and processes == 1:
        yield from map(work, items)
        return
    from concurrent.futures import BrokenExecutor

    chosen = process_executor(processes) if executor is None else executor
    waiting: deque[Future[Answer]] = deque()
    finished = False
    try:
        for item in items:
            waiting.append(submit(chosen, work, item))
            if len(waiting) >= _AHEAD * processes:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
        finished = True
    except BrokenExecutor as error:
        if error.__cause__ is not None:
            raise  # work or a result that cannot be pickled
        raise RumuError("a process was ended from outside (out of memory?); try fewer --jobs") from error
    except Exception as error:
        if type(error).__name__ == "KilledWorker":  # Dask's, after it tried again on other workers
            raise RumuError("one piece of work ended every worker that took it (out of memory?)") from error
        raise
    finally:
        if executor is None:
            end_executor(chosen, kill=not finished)
        elif not type(executor).__module__.startswith("loky."):  # loky fails to end with cancelled work
            for future in waiting:
                future.cancel()


def by_group(
    work: Callable[[Item], Answer],
    items: Sequence[Item],
    *,
    group: Callable[[Item], str],
    processes: int | None = None,
    executor: Executor | None = None,
) -> Iterator[tuple[int, Answer]]:
    """Yield number and `work` of each item, group by group: what a group shares is loaded once.

    Groups come in the order of their names, and the items of one in their own order. processes, executor,
    errors: as in `in_order`.
    """
    order = sorted(range(len(items)), key=lambda k: group(items[k]))
    answers = in_order(work, (items[k] for k in order), processes=processes, executor=executor)
    return zip(order, answers, strict=True)


def _set_up_worker(niceness: int, parent: int) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with contextlib.suppress(ImportError):
        import cv2

        cv2.setNumThreads(1)
    if niceness and hasattr(os, "nice"):
        os.nice(niceness)
    if os.name == "posix":  # a parent that is killed cannot end its workers
        threading.Thread(target=_end_with_parent, args=(parent,), daemon=True).start()


def _end_with_parent(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(_PARENT_CHECK)
    os._exit(1)
