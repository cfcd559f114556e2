"""The pool replaces workers that die or hang, and refuses requests when too many wait."""

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


def process_id(storage):
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
    pool = WorkerPool(storage, processes=1, settings=PoolSettings(max_requests=2))
    yield pool
    pool.stop()


def test_a_mark_comes_from_another_process_that_stays(workers, gallery, copy_of):
    workers.start(worker_tasks.warm_up)
    row = work(gallery, "regular-tian")
    terms = {"data": copy_of(), "work_id": row.id, "digest": row.digest, "script": row.script}
    first = workers.call(worker_tasks.mark, **terms)
    process = workers.call(process_id)
    second = workers.call(worker_tasks.mark, **terms)
    assert first.facts["score"] == second.facts["score"]
    assert process == workers.call(process_id) != os.getpid()
    with pytest.raises(Unusable):
        workers.call(worker_tasks.mark, **terms | {"data": b"no picture"})


def test_a_process_that_dies_is_replaced_and_its_work_done_again(workers, tmp_path):
    assert workers.call(dies_once, mark=tmp_path / "mark") == "lived"
    with pytest.raises(RumuError, match="ended before"):
        workers.call(dies)
    assert workers.call(process_id) > 0


def test_one_request_too_many_is_refused_at_once(storage, gallery):
    pool = WorkerPool(
        storage, make_executor=lambda: ThreadPoolExecutor(2), settings=PoolSettings(max_requests=2)
    )
    started, release = threading.Semaphore(0), threading.Event()

    def wait_for_release(storage):
        started.release()
        release.wait()

    threads = [threading.Thread(target=pool.call, args=(wait_for_release,)) for _ in range(2)]
    for thread in threads:
        thread.start()
        started.acquire()
    with pytest.raises(Busy):
        pool.call(process_id)
    release.set()
    for thread in threads:
        thread.join()
    assert pool.call(process_id) == os.getpid()
    pool.stop()


def refuses(storage):
    raise RefusedImage("expected writing, got nothing", reason="blank", zh="沒有字")


def test_errors_are_raised_with_their_fields(workers):
    with pytest.raises(RefusedImage, match="got nothing") as refused:
        workers.call(refuses)
    assert (refused.value.reason, refused.value.zh) == ("blank", "沒有字")


def starts(storage, *, mark):
    with mark.open("a") as file:
        file.write("x")
    time.sleep(60)


def test_work_interrupted_by_the_end_does_not_start_again(workers, tmp_path):
    """A process started after the end could keep the program from exiting."""
    mark, ended = tmp_path / "mark", []
    others = set(multiprocessing.active_children())

    def ask():
        try:
            workers.call(starts, timeout=math.inf, mark=mark)
        except Busy as error:
            ended.append(error)

    asking = threading.Thread(target=ask)
    asking.start()
    while not (mark.exists() and mark.read_text()):
        time.sleep(0.01)
    workers.stop()
    asking.join(20)
    assert len(ended) == 1 and mark.read_text() == "x"
    assert set(multiprocessing.active_children()) <= others
    with pytest.raises(Busy):
        workers.call(process_id)


def test_a_worker_that_hangs_is_ended(workers, tmp_path):
    mark = tmp_path / "mark"
    hung = workers.call(process_id)
    with pytest.raises(Busy):
        workers.call(waits, mark=mark, timeout=0.5)
    assert workers.call(process_id) != hung
    with pytest.raises(ProcessLookupError):
        os.kill(hung, 0)


def works_until_released(storage, *, started, release):
    started.touch()
    waits(storage, mark=release)
    return os.getpid()


def test_a_request_that_waits_too_long_in_the_queue_ends_no_worker(workers, tmp_path):
    """The worker is busy with another request and does not hang."""
    started, release, answers = tmp_path / "started", tmp_path / "release", []
    worker = workers.call(process_id)
    terms = {"started": started, "release": release, "timeout": math.inf}
    first = threading.Thread(target=lambda: answers.append(workers.call(works_until_released, **terms)))
    first.start()
    while not started.exists():
        time.sleep(0.01)
    with pytest.raises(Busy):
        workers.call(process_id, timeout=0.1)
    release.touch()
    first.join()
    assert answers == [worker] == [workers.call(process_id)]


def test_another_executor_can_be_given(storage, gallery):
    pool = WorkerPool(storage, make_executor=lambda: ThreadPoolExecutor(1))
    assert pool.call(process_id) == os.getpid()
    pool.stop()
    with pytest.raises(Busy):
        pool.call(process_id)


def test_threads_replace_processes_where_none_are_wanted(storage, gallery):
    pool = WorkerPool(storage, processes=0)
    assert pool.call(process_id) == os.getpid()
    pool.stop()


def test_workers_end_with_a_server_that_is_killed(storage, gallery, tmp_path):
    """A server that is killed leaves no process behind."""
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
        "    print(pool.call(worker_tasks.warm_up), flush=True)\n"
        "    time.sleep(60)\n"
    )
    file = tmp_path / "server.py"
    file.write_text(script)
    with subprocess.Popen([sys.executable, file], stdout=subprocess.PIPE, text=True) as server:
        child = int(server.stdout.readline())
        server.kill()
    until = time.monotonic() + 60
    while time.monotonic() < until:
        try:
            os.kill(child, 0)
        except ProcessLookupError:
            return
        if Path(f"/proc/{child}/stat").read_text().split()[2] == "Z":
            return
        time.sleep(0.05)
    pytest.fail("the worker outlived its server")
