"""Work spread over processes: answers come in the order of the questions, and few are in flight at a time."""

from __future__ import annotations

import os
import signal
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, TypeVar

from rumu.errors import RumuError

if TYPE_CHECKING:
    from concurrent.futures import Future, ProcessPoolExecutor

Item = TypeVar("Item")
Answer = TypeVar("Answer")

_AHEAD = 8  # items handed to each process before its answers are awaited


def cores() -> int:
    """The cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_order(
    work: Callable[[Item], Answer], items: Iterable[Item], *, processes: int | None = None
) -> Iterator[Answer]:
    """`work` of each item, in order, as they come; items are read no farther ahead than needed.

    work: a function of a module, or a partial of one: it is pickled. processes: all cores by default; 1 does
    the work here. Raises RumuError when a process is ended from outside; what `work` raises is raised here.
    """
    processes = processes or cores()
    if processes == 1:
        yield from map(work, items)
        return
    from concurrent.futures.process import BrokenProcessPool

    pool = _pool(processes, work)
    waiting: deque[Future[Answer]] = deque()
    try:
        for item in items:
            waiting.append(pool.submit(work, item))
            if len(waiting) >= _AHEAD * processes:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    except BrokenProcessPool as error:
        raise RumuError("a process was ended from outside (out of memory?); try fewer --jobs") from error
    finally:
        pool.shutdown(cancel_futures=True)


def by_group(
    work: Callable[[Item], Answer],
    items: Sequence[Item],
    *,
    group: Callable[[Item], str],
    processes: int | None = None,
    advance: Callable[[], object] = lambda: None,
) -> list[Answer]:
    """`work` of each item, in order, but worked on group by group: what a group shares is then loaded once.

    advance: called after each. Raises as `in_order` does.
    """
    order = sorted(range(len(items)), key=lambda k: group(items[k]))
    answers: dict[int, Answer] = {}
    worked = in_order(work, (items[k] for k in order), processes=processes)
    for k, answer in zip(order, worked, strict=True):
        answers[k] = answer
        advance()
    return [answers[k] for k in range(len(items))]


def _pool(processes: int, work: Callable[..., object]) -> ProcessPoolExecutor:
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor

    # One thread a process: the processes already fill the cores. Read when numpy is loaded over there.
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    # Not fork: a progress bar runs in a thread, and a fork would copy its locks.
    method = "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
    context = multiprocessing.get_context(method)
    if method == "forkserver":
        # What every process would import for itself is imported once, before they part.
        home = str(getattr(work, "func", work).__module__)  # of a partial, the function's
        context.set_forkserver_preload(["rumu.pipeline", "cv2", "PIL.Image", "skimage.morphology", home])
    return ProcessPoolExecutor(processes, mp_context=context, initializer=_alone)


def _alone() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is answered by the parent alone
    import cv2

    cv2.setNumThreads(1)
