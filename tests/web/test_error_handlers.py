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
    monkeypatch.setattr("rumu.web.service.WRITE_WAIT", 6.0)
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
    for url in ("/api/works?limit=1", "/api/classes", "/api/session", "/api/works/regular-shui/files/thumb"):
        assert owner("GET", url).status_code == 200
    assert any(thread.is_alive() for thread in threads), "reading waited for them"
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


def damaged_zips(picture: bytes) -> dict[str, bytes]:
    """Zips whose import fails, or leaves something out, by the name of what is wrong."""
    contents = {
        "empty": {},
        "no labels": {"a.png": b"no picture"},
        "a label without its picture": {"labels.csv": "file,character\nx.png,一\n".encode()},
        "a broken picture": {"labels.csv": "file,character\na.png,一\n".encode(), "a.png": picture[:500]},
        "a damaged table": {"labels.csv": b"\xff\xfe\x00,\n\x00", "a.png": picture},
        "damaged lamps": {"lights.txt": b"x y z\n", "a.png": picture, "b.png": picture[:900]},
        "a manifest that is none": {"works.jsonl": b"{", "collection.json": b"[1", "gallery.json": b"{"},
        "a name that leads out": {"../../etc/x.png": picture, "labels.csv": b"file\n../x.png\n"},
    }
    packed = {"no zip": b"PK no zip"}
    for name, files in contents.items():
        stream = io.BytesIO()
        with zipfile.ZipFile(stream, "w") as archive:
            for file, data in files.items():
                archive.writestr(file, data)
        packed[name] = stream.getvalue()
    return packed


def wait_for_end(browser, job_id):
    until = time.monotonic() + 60
    while (job := browser("GET", f"/api/jobs/{job_id}").json())["state"] in ("queued", "running"):
        assert time.monotonic() < until
        time.sleep(0.05)
    return job


def test_no_answer_tells_where_files_lie(new_world, copy_of, tmp_path):
    """Many errors: of pictures, zips, files that are gone, a store that cannot be written."""
    import rumu

    world = new_world()
    owner, pupil = world.browser("館主"), world.browser("吳")
    attempt = pupil.marked(copy_of(), kind="pen", strokes="[[[1,2,0.5]]]").json()["id"]
    answers = [
        owner("POST", "/api/works", files={"picture": ("a.png", data)}, data=facts)
        for data in (b"", b"x", copy_of()[:2000], b"\x89PNG\r\n\x1a\n" + b"x" * 99)
        for facts in ({}, {"method": "none"}, {"collection": "../x"})
    ]
    answers += [pupil.marked(data) for data in (b"x", copy_of()[:900])]
    for data in damaged_zips(copy_of()).values():
        answer = owner("POST", "/api/imports", files={"zip": ("課堂 一.zip", data)})
        answers.append(answer)
        if answer.status_code == 202:
            job = wait_for_end(owner, answer.json()["job"]["id"])
            answers.append(owner("GET", f"/api/jobs/{job['id']}"))
    files = tmp_path / "files"
    for path in [*files.rglob("*.png"), *files.rglob("*.json"), *files.rglob("*.jpg")]:
        path.unlink()
    answers += [
        owner("GET", f"/api/works/regular-shui/files/{kind}")
        for kind in ("thumb", "picture", "glb", "stl", "heights", "lamp-a")
    ]
    of_attempt = ("", "/picture", "/strokes", "/viewer", "/files/thumb")
    answers += [pupil("GET", f"/api/attempts/{attempt}{part}") for part in of_attempt]
    answers += [
        owner("GET", "/iiif/image/regular-shui/full/max/0/default.jpg"),
        owner("GET", "/api/works/regular-shui/viewer"),
        owner("GET", "/api/works/regular-shui/export.html"),
        pupil("GET", "/api/practice.pdf?work=regular-tian"),
        world.browser("林")("GET", "/api/marks.zip"),
        pupil.marked(copy_of()),
    ]
    for path in files.iterdir():  # from here on nothing can be stored
        path.rename(tmp_path / f"gone-{path.name}")
    files.rmdir()
    files.write_text("no folder")
    answers += [pupil.marked(copy_of()), owner("POST", "/api/works", files={"picture": ("a.png", copy_of())})]
    assert sum(answer.status_code >= 400 for answer in answers) > 25
    hidden = (str(tmp_path), "/tmp/", str(Path(rumu.__file__).parent), str(Path.home()) + "/", "Traceback")
    for answer in answers:
        text = answer.content.decode("utf-8", "replace")
        assert not [place for place in hidden if place in text], (str(answer.url), text[:300])
