"""Trouble of the machine: a locked database, a full disk; and no answer that tells where files lie."""

from __future__ import annotations

import errno
import io
import sqlite3
import threading
import time
import zipfile
from pathlib import Path

import pytest
from sqlalchemy.exc import OperationalError

from rumu.database.tables import Attempt, Job


@pytest.fixture
def lock_database(tmp_path):
    """Lock the database of the service, as another program may."""
    holder = sqlite3.connect(tmp_path / "rumu.sqlite", isolation_level=None, timeout=30)

    def lock():
        holder.execute("BEGIN EXCLUSIVE")
        return holder

    yield lock
    holder.close()


def test_a_locked_database_is_told_and_reading_goes_on(new_world, monkeypatch, lock_database, code_of):
    monkeypatch.setattr("rumu.web.service.WRITE_WAIT", 2.0)
    world = new_world()
    owner = world.browser("館主")
    writers = [world.browser("林") for _ in range(16)]
    holder = lock_database()
    answers, threads = [], []

    def write(browser):
        answers.append(browser("POST", "/api/classes", json={"name": "a"}))

    for browser in writers:
        work = threading.Thread(target=write, args=(browser,))
        work.start()
        threads.append(work)
    time.sleep(0.3)
    start = time.monotonic()
    for url in ("/api/works?limit=1", "/api/classes", "/api/session", "/api/works/regular-shui/files/thumb"):
        assert owner("GET", url).status_code == 200
    assert any(thread.is_alive() for thread in threads), "they were not waiting meanwhile"
    assert time.monotonic() - start < 2.0
    for thread in threads:
        thread.join(30)
    assert [answer.status_code for answer in answers] == [503] * 16
    assert {code_of(answer) for answer in answers} == {"database_busy"}
    assert all(int(answer.headers["retry-after"]) > 0 for answer in answers)
    holder.execute("ROLLBACK")
    assert owner("POST", "/api/classes", json={"name": "a"}).status_code == 201
    assert len(owner("GET", "/api/classes").json()) == 3  # of 林, of 陳, and this one


class FullFile(io.FileIO):
    """A file on a disk that is full after some bytes."""

    room, error = 1000, errno.ENOSPC

    def write(self, data):
        if self.tell() + len(data) > self.room:
            super().write(bytes(data)[: self.room])
            raise OSError(self.error, "No space left on device", str(self.name))
        return super().write(data)


@pytest.fixture(params=[errno.ENOSPC, errno.EDQUOT])
def full_disk(request, monkeypatch, tmp_path):
    """From now on, no file of the service takes more than 1000 bytes."""
    plain = Path.open

    def open_file(path, mode="r", *arguments, **more):
        if mode in ("wb", "xb") and path.is_relative_to(tmp_path):
            return FullFile(path, mode.replace("b", ""))
        return plain(path, mode, *arguments, **more)

    def fill():
        monkeypatch.setattr(FullFile, "error", request.param)
        monkeypatch.setattr(Path, "open", open_file)

    return fill


def files_in(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def told_of_full_disk(answer, tmp_path):
    error = answer.json()["error"]
    assert (answer.status_code, error["code"]) == (507, "disk_full")
    assert "MB" in error["en"] and "MB" in error["zh"] and str(tmp_path) not in answer.text


def test_a_copy_on_a_full_disk_leaves_nothing(new_world, full_disk, copy_of, tmp_path):
    world = new_world()
    pupil = world.browser("吳")
    assert pupil.marked(copy_of()).status_code == 201
    before = files_in(tmp_path / "files")
    full_disk()
    told_of_full_disk(pupil.marked(copy_of()), tmp_path)
    assert files_in(tmp_path / "files") == before
    assert pupil("GET", "/api/attempts").json()["total"] == 1
    assert pupil.marked(copy_of(), keep="false").status_code == 201  # nothing is stored for this one


def test_a_work_and_a_zip_on_a_full_disk_leave_nothing(new_world, full_disk, copy_of, tmp_path):
    world = new_world()
    teacher = world.browser("林")
    before = files_in(tmp_path / "files")
    full_disk()
    picture = {"picture": ("a.png", copy_of())}
    told_of_full_disk(teacher("POST", "/api/works", data={"title_zh": "新"}, files=picture), tmp_path)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("a.png", copy_of())
    answer = teacher("POST", "/api/imports", files={"zip": ("a.zip", packed.getvalue())})
    told_of_full_disk(answer, tmp_path)
    assert files_in(tmp_path / "files") == before
    with world.service.gallery.database.reading() as session:
        assert session.query(Job).where(Job.kind == "import").count() == 0


def test_a_database_without_space_is_told(new_world, monkeypatch, copy_of, tmp_path):
    world = new_world()
    pupil = world.browser("吳")
    before = files_in(tmp_path / "files")
    full = sqlite3.OperationalError("database or disk is full")
    full.sqlite_errorname = "SQLITE_FULL"

    def flush(session, *_):
        if any(isinstance(one, Attempt) for one in session.new):
            raise OperationalError("INSERT", {}, full)

    monkeypatch.setattr("sqlalchemy.orm.Session.flush", flush)
    answer = pupil.marked(copy_of())
    assert (answer.status_code, answer.json()["error"]["code"]) == (507, "disk_full")
    assert str(tmp_path) not in answer.text
    assert files_in(tmp_path / "files") == before


def test_an_upload_that_cannot_be_held_is_told(new_world, monkeypatch, copy_of, code_of):
    """Large uploads are spooled to the folder for temporary files, which may be full, too."""
    world = new_world()
    teacher = world.browser("林")

    def write(*_):
        raise OSError(errno.ENOSPC, "No space left on device", "/tmp/x")

    monkeypatch.setattr("starlette.datastructures.UploadFile.write", write)
    answer = teacher("POST", "/api/works", files={"picture": ("a.png", copy_of())})
    assert (answer.status_code, code_of(answer)) == (507, "disk_full") and "/tmp" not in answer.text
