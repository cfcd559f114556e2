"""Work spread over all cores and stored under OUT, so that a run goes on where it stopped.

joblib watches the source of the one function that it is given, so the digest of both packages' code is among
the arguments that an answer is stored under: when any code changes, everything is measured anew.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from rumu_lab.experiments.run_settings import RunSettings, code_digest

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from rumu.pipeline import PreparedMaster

Item = TypeVar("Item")
Answer = TypeVar("Answer")

_NEIGHBOURS = 7


def measure_each(
    work: Callable[[Item], Answer], items: Sequence[Item], settings: RunSettings
) -> list[Answer]:
    """Return work(item) of all items, in order; what is stored under OUT is read instead.

    work: a function of a module, or a partial of one, since it is sent to other processes.
    """
    answers: list[Answer] = []
    for answer in spread(with_storage(work, settings), items, executor=settings.executor):
        answers.append(answer)
        settings.progress(len(answers), len(items))
    return answers


def with_storage(work: Callable[[Item], Answer], settings: RunSettings) -> Callable[[Item], Answer]:
    """The work, with its answers stored under OUT as long as the code stays the same."""
    if settings.out is None:
        return work
    stored = settings.memory.cache(_call)
    stored(str, "", "")  # writes down its own source before several processes look for it at once
    return functools.partial(stored, work, code_digest())


def spread(
    work: Callable[[Item], Answer], items: Sequence[Item], *, executor: Executor | None = None
) -> Iterator[Answer]:
    """Yield work(item) in order, on all cores; a process gets a few neighbours, which often share a master.

    executor: takes the work in place of new processes.
    """
    from rumu.executors import cores, in_order

    few = [items[k : k + _NEIGHBOURS] for k in range(0, len(items), _NEIGHBOURS)]
    call, processes = functools.partial(_call_each, work), min(cores(), len(few)) or 1
    for answers in in_order(call, few, processes=processes, executor=executor):
        yield from answers


@functools.lru_cache(maxsize=32)
def master_at(path: Path, character: str | None = None) -> PreparedMaster:
    """The master in a file, prepared once in a process: its copies come in a row.

    character: what is written; None where strokes need no names.
    """
    from rumu import pipeline

    return pipeline.prepare_master(path, character=character)


def _call(work: Callable[[Any], Any], version: str, item: Any) -> Any:
    return work(item)


def _call_each(work: Callable[[Item], Answer], items: Sequence[Item]) -> list[Answer]:
    return [work(item) for item in items]
