"""Work in processes: answers in order, bounded memory, and one clear error when a process is killed."""

from __future__ import annotations

import itertools
import math
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import BrokenExecutor, ThreadPoolExecutor
from pathlib import Path

import pytest

from rumu.errors import RumuError
from rumu.executors import LOCAL_CLUSTER, by_group, cores, in_order, open_executor


@pytest.mark.parametrize("processes", [1, 2])
def test_answers_come_in_the_order_of_the_items(processes):
    assert list(in_order(math.sqrt, range(50), processes=processes)) == [math.sqrt(n) for n in range(50)]


def test_items_are_read_no_farther_ahead_than_needed():
    """Items of an endless iterator: the number that waits is bounded, so memory is."""
    read = []
    items = (read.append(n) or n for n in itertools.count())
    answers = in_order(math.sqrt, items, processes=2)
    assert list(itertools.islice(answers, 30)) == [math.sqrt(n) for n in range(30)]
    assert len(read) < 60
    answers.close()


def test_one_process_works_in_this_process():
    seen = []
    assert list(in_order(seen.append, range(3), processes=1)) == [None] * 3  # no other process could fill it
    assert seen == [0, 1, 2]


def test_groups_are_worked_on_together_and_answers_say_of_which_item_they_are():
    seen = []
    answers = by_group(
        lambda word: seen.append(word) or word.upper(),
        ["b1", "a1", "b2", "a2"],
        group=lambda word: word[0],
        processes=1,
    )
    assert list(answers) == [(1, "A1"), (3, "A2"), (0, "B1"), (2, "B2")]
    assert seen == ["a1", "a2", "b1", "b2"]


def test_an_error_of_the_work_is_raised_here():
    with pytest.raises(ValueError, match="math domain error"):
        list(in_order(math.sqrt, [4, -1, 9], processes=2))


def test_a_killed_process_raises_one_clear_error():
    with pytest.raises(RumuError, match="ended from outside"):
        list(in_order(os._exit, [3], processes=2))


def test_cores_are_those_that_this_process_may_use():
    assert 1 <= cores() <= (os.cpu_count() or 1)


def test_another_executor_can_take_the_work():
    with ThreadPoolExecutor(2) as executor:
        assert list(in_order(math.sqrt, [1, 4, 9], executor=executor)) == [1, 2, 3]
        assert executor.submit(math.sqrt, 16).result() == 4, "it is not ended"


def is_running(process: int) -> bool:
    """Whether a process exists and is no zombie."""
    try:
        return Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="needs /proc")
def test_workers_end_with_a_parent_that_is_killed(tmp_path):
    script = tmp_path / "parent.py"
    script.write_text(
        "import os, sys, time\n"
        "from rumu.executors import process_executor\n"
        "if __name__ == '__main__':\n"
        "    executor = process_executor(2)\n"
        "    print(executor.submit(os.getpid).result(), *executor._processes, flush=True)\n"
        "    executor.submit(time.sleep, 60)\n"
        "    time.sleep(60)\n"
    )
    with subprocess.Popen([sys.executable, script], stdout=subprocess.PIPE, text=True) as parent:
        workers = {int(word) for word in parent.stdout.readline().split()}
        parent.kill()
    until = time.monotonic() + 60
    while any(map(is_running, workers)) and time.monotonic() < until:
        time.sleep(0.05)
    assert len(workers) == 2
    assert not [worker for worker in workers if is_running(worker)]


def test_work_that_cannot_be_read_by_a_worker_says_so():
    class Unreadable:
        def __reduce__(self):
            return int, ("no number",)

    with pytest.raises(BrokenExecutor, match="un-serialize"):
        list(in_order(str, [Unreadable()], processes=2))


@pytest.fixture(scope="module")
def cluster():
    """A scheduler and two workers of a thread each, processes of their own."""
    import dask
    from distributed import LocalCluster

    # work is given to another worker once, and not three times: starting them again takes most of the time
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 1}),
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
    ):
        yield cluster


def who_am_i(number: int) -> tuple[int, int]:
    time.sleep(0.01)
    return number, os.getpid()


@pytest.mark.parametrize("address", ["given", LOCAL_CLUSTER])
def test_dask_answers_in_order_from_other_processes(cluster, address):
    address = cluster.scheduler_address if address == "given" else address
    with open_executor(2, dask=address) as (executor, processes):
        assert processes == 2
        answers = list(in_order(who_am_i, range(40), executor=executor, processes=processes))
    assert [number for number, _ in answers] == list(range(40))
    workers = {pid for _, pid in answers}
    assert len(workers) == 2 and os.getpid() not in workers


def test_every_answer_of_dask_comes_once_though_a_worker_is_killed(cluster):
    with open_executor(2, dask=cluster.scheduler_address) as (executor, processes):
        answers = in_order(who_am_i, range(300), executor=executor, processes=processes)
        first = list(itertools.islice(answers, 20))
        os.kill(first[-1][1], signal.SIGKILL)
        rest = list(answers)
    assert [number for number, _ in first + rest] == list(range(300))
    assert first[-1][1] not in {pid for _, pid in rest[200:]}


def end_worker(number: int) -> int:
    if number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def test_work_that_ends_every_worker_is_told(cluster):
    with (
        open_executor(2, dask=cluster.scheduler_address) as (executor, processes),
        pytest.raises(RumuError, match="ended every worker that took it"),
    ):
        list(in_order(end_worker, range(6), executor=executor, processes=processes))


def test_a_scheduler_that_is_not_there_is_told(monkeypatch):
    monkeypatch.setattr("rumu.executors._DASK_TIMEOUT", 1)
    with (
        pytest.raises(RumuError, match=r"expected a Dask scheduler at tcp://127\.0\.0\.1:9"),
        open_executor(2, dask="tcp://127.0.0.1:9"),
    ):
        pass


def test_an_executor_of_this_machine_is_ended():
    with open_executor(2) as (executor, processes):
        assert processes == 2
        assert list(in_order(math.sqrt, range(5), executor=executor, processes=2))[4] == 2.0
    with pytest.raises(RuntimeError):
        executor.submit(math.sqrt, 1)
    with open_executor(1) as (executor, processes):
        assert (executor, processes) == (None, 1)
