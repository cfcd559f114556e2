"""The same table of pairs by one process pool and by a local Dask cluster of which one worker is killed.

`python benchmarks/cluster.py [--rows N] [--workers K]` marks N rows of E3C copies, again and again the same
ones, both ways in one run, some rows by turns, so that other work on the machine slows both alike. Printed:
rows a second of each, their ratio, and how many rows were lost, came twice or came with another mark. The
start of the processes is counted on both sides.
"""

from __future__ import annotations

import argparse
import contextlib
import functools
import itertools
import os
import signal
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rumu.cli.pairs import PairRow, mark_row
from rumu.executors import LOCAL_CLUSTER, by_group, open_executor
from rumu_lab.experiments.marked_copies import read_copies

DATA = Path(os.environ.get("RUMU_DATA", Path(__file__).parents[2] / "shared" / "data"))
Answers = Iterator[tuple[int, tuple[str, int]]]
"""Number of a row, what came of it, and in which process."""


@dataclass
class Side:
    """What one way of spreading the work has done. came: how often each row. marks: what came of it."""

    seconds: float = 0.0
    came: Counter[int] = field(default_factory=Counter)
    marks: dict[int, str] = field(default_factory=dict)
    process: int = 0

    def take(self, answers: Answers, count: int) -> None:
        """Wait for so many rows."""
        began = time.perf_counter()
        for k, (mark, self.process) in itertools.islice(answers, count):
            self.came[k] += 1
            self.marks[k] = mark
        self.seconds += time.perf_counter() - began


def mark_and_tell(pair: PairRow, *, root: Path) -> tuple[str, int]:
    """What came of a row, and in which process."""
    row = mark_row(pair, root=root, terms={"remarks": False})
    return row["refused"] or str(row["score"]), os.getpid()


@contextlib.contextmanager
def answers_of(rows: Sequence[PairRow], side: Side, *, workers: int, dask: str | None) -> Iterator[Answers]:
    """The answers of one way, as they come; the start of its processes counts."""
    began = time.perf_counter()
    with open_executor(workers, dask=dask) as (executor, processes):
        side.seconds += time.perf_counter() - began
        work = functools.partial(mark_and_tell, root=DATA)
        yield by_group(
            work, rows, group=lambda pair: pair.reference or "", executor=executor, processes=processes
        )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rows", type=int, default=1000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--turn", type=int, default=200, help="rows of one way before the other's turn")
    asked = parser.parse_args()
    copies = itertools.islice(itertools.cycle(read_copies(DATA)), asked.rows)
    rows = [PairRow(str(copy.image), str(copy.template)) for copy in copies]
    pool, dask, killed = Side(), Side(), False
    with (
        answers_of(rows, pool, workers=asked.workers, dask=None) as of_pool,
        answers_of(rows, dask, workers=asked.workers, dask=LOCAL_CLUSTER) as of_dask,
    ):
        for done in range(0, len(rows), asked.turn):
            pool.take(of_pool, asked.turn)
            if not killed and done >= len(rows) // 3:
                dask.take(of_dask, 1)  # an answer tells a worker, which works on the next
                os.kill(dask.process, signal.SIGKILL)
                killed = True
            dask.take(of_dask, asked.turn)
        dask.take(of_dask, len(rows))  # there should be none left
    rates = [len(rows) / side.seconds for side in (pool, dask)]
    lost = len(rows) - len(dask.came)
    twice = sum(times > 1 for times in dask.came.values())
    other = sum(mark != pool.marks[k] for k, mark in dask.marks.items())
    print(f"{len(rows)} rows, {asked.workers} workers")
    print(f"process pool              {rates[0]:6.1f} rows/s")
    print(
        f"Dask, one worker killed   {rates[1]:6.1f} rows/s, {rates[1] / rates[0]:.2f} of it; "
        f"{lost} lost, {twice} twice, {other} with another mark"
    )


if __name__ == "__main__":
    main()
