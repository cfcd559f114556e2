"""The same table of pairs by one process pool and by a local Dask cluster of which one worker is killed.

`python benchmarks/cluster.py [--rows N] [--workers K]` marks N rows of E3C copies, again and again the same
ones, each way in one run. Printed: rows a second of each, their ratio, and how many rows were lost or came
twice. The start of the processes is counted on both sides.
"""

from __future__ import annotations

import argparse
import collections
import functools
import itertools
import os
import signal
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from rumu.cli.pairs import PairRow, mark_row
from rumu.executors import LOCAL_CLUSTER, by_group, open_executor
from rumu_lab.experiments.marked_copies import read_copies

DATA = Path(os.environ.get("RUMU_DATA", Path(__file__).parents[2] / "shared" / "data"))


def mark_and_tell(pair: PairRow, *, root: Path) -> tuple[str, int]:
    """What came of a row, and in which process."""
    row = mark_row(pair, root=root, terms={"remarks": False})
    return row["refused"] or str(row["score"]), os.getpid()


def run(
    rows: Sequence[PairRow],
    *,
    workers: int,
    dask: str | None,
    when: Callable[[int, int], object] = lambda _number, _pid: None,
) -> tuple[float, collections.Counter[int]]:
    """Rows a second, and how often each row came; `when` is called with the count and the process of each."""
    began = time.perf_counter()
    came: collections.Counter[int] = collections.Counter()
    with open_executor(workers, dask=dask) as (executor, processes):
        answers = by_group(
            functools.partial(mark_and_tell, root=DATA),
            rows,
            group=lambda pair: pair.reference or "",
            executor=executor,
            processes=processes,
        )
        for count, (k, (_, pid)) in enumerate(answers):
            came[k] += 1
            when(count, pid)
    return len(rows) / (time.perf_counter() - began), came


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rows", type=int, default=1000)
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    copies = itertools.islice(itertools.cycle(read_copies(DATA)), asked.rows)
    rows = [PairRow(str(copy.image), str(copy.template)) for copy in copies]

    def kill_one(count: int, pid: int) -> None:
        if count == len(rows) // 3:
            os.kill(pid, signal.SIGKILL)

    pool, _ = run(rows, workers=asked.workers, dask=None)
    dask, came = run(rows, workers=asked.workers, dask=LOCAL_CLUSTER, when=kill_one)
    lost = len(rows) - len(came)
    twice = sum(times > 1 for times in came.values())
    print(f"{len(rows)} rows, {asked.workers} workers")
    print(f"process pool              {pool:6.1f} rows/s")
    print(
        f"Dask, one worker killed   {dask:6.1f} rows/s, {dask / pool:.2f} of it; {lost} lost, {twice} twice"
    )


if __name__ == "__main__":
    main()
