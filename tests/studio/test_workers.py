"""The pool: there at once, mended when a process dies, honest when it is full."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from pathlib import Path

import pytest

from rumu.errors import RefusedImage, RumuError
from rumu.gallery.catalog import work
from rumu.studio import worker
from rumu.studio.errors import Busy, Unusable
from rumu.studio.workers import Workers


def own_id(place):
    return os.getpid()


def dies_once(place, *, mark):
    if not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return "lived"


def dies(place):
    os.kill(os.getpid(), signal.SIGKILL)


def waits(place, *, mark):
    while not mark.exists():
        time.sleep(0.01)


@pytest.fixture
def workers(place, gallery):
    pool = Workers(place, processes=1, waiting=2)
    yield pool
    pool.stop()


def test_a_mark_comes_from_another_process_within_a_second(workers, gallery, copy_of):
    workers.start()
    row = work(gallery, "regular-tian")
    terms = {"data": copy_of(), "work_id": row.id, "digest": row.digest, "script": row.script}
    first = workers.ask(worker.mark, **terms)
    started = time.perf_counter()
    second = workers.ask(worker.mark, **terms)
    assert time.perf_counter() - started < 1.0
    assert first.facts["score"] == second.facts["score"] and workers.ask(own_id) != os.getpid()
    with pytest.raises(Unusable):
        workers.ask(worker.mark, **terms | {"data": b"no picture"})


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


def refuses(place):
    raise RefusedImage("expected writing, got nothing", reason="blank")


def test_errors_come_back_as_they_were(workers):
    with pytest.raises(RefusedImage, match="got nothing") as refused:
        workers.ask(refuses)
    assert refused.value.reason == "blank"


def begins(place, *, mark):
    with mark.open("a") as file:
        file.write("x")
    time.sleep(60)


def test_what_is_cut_off_by_the_end_is_not_begun_anew(workers, tmp_path):
    """A process that is made after the end would hold up the exit of the program, for ever at worst."""
    mark, ended = tmp_path / "mark", []
    others = set(multiprocessing.active_children())

    def ask():
        try:
            workers.ask(begins, patience=None, mark=mark)
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


def test_threads_do_where_processes_are_not_wanted(place, gallery):
    pool = Workers(place, processes=0)
    assert pool.ask(own_id) == os.getpid()
    pool.stop()


def test_processes_end_with_their_parent_however_it_ends(place, gallery, tmp_path):
    """A server that is killed outright leaves no process behind."""
    import subprocess
    import sys

    script = (
        "import sys, time\n"
        "from pathlib import Path\n"
        "from rumu.studio.place import Place\n"
        "from rumu.studio.workers import Workers\n"
        "from rumu.studio import worker\n"
        "if __name__ == '__main__':\n"
        f"    pool = Workers(Place({place.database!r}, {place.files!r}), processes=1)\n"
        "    print(pool.ask(worker.ready), flush=True)\n"
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
