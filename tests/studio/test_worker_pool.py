"""The pool: there at once, mended when a process dies, honest when it is full."""

from __future__ import annotations

import math
import multiprocessing
import os
import signal
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from rumu.errors import RefusedImage, RumuError
from rumu.gallery.catalog import work
from rumu.studio import worker_tasks
from rumu.studio.errors import Busy, Unusable
from rumu.studio.worker_pool import PoolSettings, WorkerPool


def own_id(storage):
    return os.getpid()


def dies_once(storage, *, mark):
    if not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return "lived"


def dies(storage):
    os.kill(os.getpid(), signal.SIGKILL)


def waits(storage, *, mark):
    while not mark.exists():
        time.sleep(0.01)


@pytest.fixture
def workers(storage, gallery):
    pool = WorkerPool(storage, processes=1, settings=PoolSettings(waiting=2))
    yield pool
    pool.stop()


def test_a_mark_comes_from_another_process_that_stays(workers, gallery, copy_of):
    workers.start(worker_tasks.warm_up)
    row = work(gallery, "regular-tian")
    terms = {"data": copy_of(), "work_id": row.id, "digest": row.digest, "script": row.script}
    first = workers.ask(worker_tasks.mark, **terms)
    process = workers.ask(own_id)
    second = workers.ask(worker_tasks.mark, **terms)
    assert first.facts["score"] == second.facts["score"]
    assert process == workers.ask(own_id) != os.getpid()
    with pytest.raises(Unusable):
        workers.ask(worker_tasks.mark, **terms | {"data": b"no picture"})


def test_a_process_that_dies_is_replaced_and_asked_again(workers, tmp_path):
    assert workers.ask(dies_once, mark=tmp_path / "mark") == "lived"
    with pytest.raises(RumuError, match="ended before"):
        workers.ask(dies)
    assert workers.ask(own_id) > 0


def test_too_many_are_told_at_once(workers, tmp_path):
    mark = tmp_path / "mark"
    threads = [threading.Thread(target=workers.ask, args=(waits,), kwargs={"mark": mark}) for _ in range(2)]
    for thread in threads:
        thread.start()
    time.sleep(0.3)
    with pytest.raises(Busy):
        workers.ask(own_id)
    mark.touch()
    for thread in threads:
        thread.join(20)
    assert workers.ask(own_id) > 0


def refuses(storage):
    raise RefusedImage("expected writing, got nothing", reason="blank")


def test_errors_come_back_as_they_were(workers):
    with pytest.raises(RefusedImage, match="got nothing") as refused:
        workers.ask(refuses)
    assert refused.value.reason == "blank"


def begins(storage, *, mark):
    with mark.open("a") as file:
        file.write("x")
    time.sleep(60)


def test_what_is_cut_off_by_the_end_is_not_begun_anew(workers, tmp_path):
    """A process that is made after the end would hold up the exit of the program, for ever at worst."""
    mark, ended = tmp_path / "mark", []
    others = set(multiprocessing.active_children())

    def ask():
        try:
            workers.ask(begins, patience=math.inf, mark=mark)
        except Busy as error:
            ended.append(error)

    asking = threading.Thread(target=ask)
    asking.start()
    until = time.monotonic() + 60
    while not (mark.exists() and mark.read_text()) and time.monotonic() < until:
        time.sleep(0.01)
    workers.stop()
    asking.join(20)
    assert len(ended) == 1 and mark.read_text() == "x"
    assert set(multiprocessing.active_children()) <= others
    with pytest.raises(Busy):
        workers.ask(own_id)


def test_a_worker_that_hangs_is_ended(workers, tmp_path):
    mark = tmp_path / "mark"
    hung = workers.ask(own_id)
    with pytest.raises(Busy):
        workers.ask(waits, mark=mark, patience=0.5)
    assert workers.ask(own_id) != hung
    with pytest.raises(ProcessLookupError):
        os.kill(hung, 0)


def takes(storage, *, seconds):
    time.sleep(seconds)
    return os.getpid()


def test_a_queue_that_is_too_long_ends_no_worker(storage, gallery):
    """A class that hands in at once makes some wait too long; the worker is busy and does not hang."""
    pool = WorkerPool(storage, processes=1)
    worker, answers, busy = pool.ask(own_id), [], []

    def ask():
        try:
            answers.append(pool.ask(takes, seconds=0.7, patience=1.6))
        except Busy as error:
            busy.append(error)

    threads = [threading.Thread(target=ask) for _ in range(5)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(20)
    assert len(answers) + len(busy) == 5 and busy
    assert set(answers) == {worker} == {pool.ask(own_id)}
    pool.stop()


def test_another_executor_can_stand_in_its_place(storage, gallery):
    pool = WorkerPool(storage, make_executor=lambda: ThreadPoolExecutor(1))
    assert pool.ask(own_id) == os.getpid()
    pool.stop()
    with pytest.raises(Busy):
        pool.ask(own_id)


def test_threads_do_where_processes_are_not_wanted(storage, gallery):
    pool = WorkerPool(storage, processes=0)
    assert pool.ask(own_id) == os.getpid()
    pool.stop()


def test_processes_end_with_their_parent_however_it_ends(storage, gallery, tmp_path):
    """A server that is killed outright leaves no process behind."""
    import subprocess
    import sys

    script = (
        "import sys, time\n"
        "from pathlib import Path\n"
        "from rumu.studio.storage import Storage\n"
        "from rumu.studio.worker_pool import PoolSettings, WorkerPool\n"
        "from rumu.studio import worker_tasks\n"
        "if __name__ == '__main__':\n"
        f"    pool = WorkerPool(Storage({storage.database!r}, {storage.files!r}), processes=1)\n"
        "    print(pool.ask(worker_tasks.warm_up), flush=True)\n"
        "    time.sleep(60)\n"
    )
    file = tmp_path / "server.py"
    file.write_text(script)
    with subprocess.Popen([sys.executable, file], stdout=subprocess.PIPE, text=True) as server:
        child = int(server.stdout.readline())
        server.kill()
    until = time.monotonic() + 10
    while time.monotonic() < until:
        try:
            os.kill(child, 0)
        except ProcessLookupError:
            return
        if Path(f"/proc/{child}/stat").read_text().split()[2] == "Z":
            return
        time.sleep(0.05)
    pytest.fail("the worker outlived its server")
