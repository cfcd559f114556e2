"""A server that is killed and started again: what it confirmed is there, and what it began is finished."""

from __future__ import annotations

import contextlib
import io
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import zipfile
from datetime import date
from pathlib import Path

import httpx
import pytest
from PIL import Image, ImageDraw

from conftest import copy_home, first_start
from rumu.database.tables import Job
from rumu.errors import RumuError
from rumu.gallery.catalog import open_gallery
from rumu.studio import job_queue
from rumu.studio.people import create_person
from rumu.studio.storage import Storage
from rumu.web.server import is_loopback, listen, serve
from rumu.web.settings import ServiceSettings

PASSWORD = "a long password"
COUNT = 600  # works of the zip: more than two batches of an import


class Server:
    """`rumu serve` in a process of its own, and one browser."""

    def __init__(self, database: str, files: Path) -> None:
        arguments = (
            "serve",
            "--port",
            "0",
            "--json",
            "--processes",
            "1",
            "--database",
            database,
            "--files",
            files,
        )
        self.process = subprocess.Popen(
            [sys.executable, "-m", "rumu.cli", *map(str, arguments)],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        self.facts = json.loads(self.process.stdout.readline())
        self.client = httpx.Client(base_url=self.facts["url"], timeout=180, trust_env=False)
        self.token = self.client.get("/api/session").json()["csrf"]

    def post(self, url, **more):
        return self.client.post(url, headers={"X-CSRF-Token": self.token}, **more)

    def log_in(self):
        answer = self.post("/api/login", json={"name": "館主", "password": PASSWORD})
        assert answer.status_code == 200, answer.text
        self.token = answer.json()["csrf"]

    def end(self, number=signal.SIGKILL):
        self.client.close()
        self.process.send_signal(number)
        self.process.wait(30)
        self.process.stdout.close()


@pytest.fixture(scope="module")
def postgresql_template(postgresql, started_home):
    """The name of a database of the server whose URL `postgresql` is, as after a first start."""
    import psycopg

    with psycopg.connect(f"{postgresql}/postgres", autocommit=True) as server:
        server.execute("CREATE DATABASE started")
    first_start(f"{postgresql}/started", started_home / "files")
    return "started"


@pytest.fixture(params=["sqlite", "postgresql"])
def database_url(request, tmp_path, started_home):
    """A database as after a first start, of each kind in turn."""
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'rumu.sqlite'}"
    return request.getfixturevalue("new_postgresql")(request.getfixturevalue("postgresql_template"))


@pytest.fixture
def start(tmp_path, database_url, started_home):
    """Start a server, whose first start is over; every start uses the same database and store."""
    started = []
    copy_home(started_home, tmp_path, link=True)
    gallery = open_gallery(database=database_url, files=tmp_path / "files")
    with gallery.database.writing() as session:
        create_person(session, name="館主", password=PASSWORD, role="owner")

    def start_server():
        server = Server(database_url, tmp_path / "files")
        started.append(server)
        server.log_in()
        return server

    start_server.gallery, start_server.database = gallery, database_url
    yield start_server
    for server in started:
        if server.process.poll() is None:
            server.end()
    gallery.database.close()


def zip_of_pictures(count: int = COUNT) -> bytes:
    """A zip of `count` pictures with labels.csv."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        lines = ["file,character,script,work"]
        for k in range(count):
            page = Image.new("L", (48, 48), 255)
            ImageDraw.Draw(page).rectangle((10, 20 + k % 7, 38, 26 + k % 7), fill=k % 50)
            packed = io.BytesIO()
            page.save(packed, "PNG")
            archive.writestr(f"{k}.png", packed.getvalue())
            lines.append(f"{k}.png,一,regular,第{k}號")
        archive.writestr("labels.csv", "\n".join(lines) + "\n")
    return stream.getvalue()


def read_job(gallery, job_id) -> Job:
    with gallery.database.reading() as session:
        return session.get_one(Job, job_id)


def wait_for_job(gallery, job_id, *, state="done", seconds=240) -> Job:
    until = time.monotonic() + seconds
    while (job := read_job(gallery, job_id)).state != state:
        assert job.state in ("queued", "running") and time.monotonic() < until, (job.state, job.error_en)
        time.sleep(0.05)
    return job


def test_an_import_that_was_cut_off_is_finished_by_the_next_server(start):
    """The server is killed during an import: no work is lost, none is there twice, all are imported."""
    first = start()
    answer = first.post("/api/imports", files={"zip": ("a.zip", zip_of_pictures())})
    assert answer.status_code == 202
    job_id = answer.json()["job"]["id"]
    until = time.monotonic() + 240
    while read_job(start.gallery, job_id).state == "queued" and time.monotonic() < until:
        time.sleep(0.005)
    first.end()
    assert read_job(start.gallery, job_id).state in ("running", "done")
    second = start()
    job = wait_for_job(start.gallery, job_id)
    assert job.result["added"] + job.result["there"] == COUNT
    assert second.client.get("/api/works?q=號&limit=1").json()["total"] == COUNT


def test_what_was_answered_for_is_there_after_a_kill(start, copy_of):
    """The server is killed while copies are sent: every attempt that it confirmed is stored, whole."""
    server = start()
    confirmed: list[str] = []

    def send():
        with contextlib.suppress(httpx.HTTPError):
            while True:
                answer = server.post(
                    "/api/marks", data={"work": "regular-tian"}, files={"picture": ("a.png", copy_of())}
                )
                if answer.status_code != 201:
                    return
                confirmed.append(answer.json()["id"])

    sender = threading.Thread(target=send)
    sender.start()
    until = time.monotonic() + 240
    while len(confirmed) < 4 and time.monotonic() < until:
        time.sleep(0.01)
    server.process.kill()
    sender.join(30)
    server.end()
    again = start()
    stored = {one["id"] for one in again.client.get("/api/attempts?limit=200").json()["items"]}
    assert len(confirmed) >= 4 and set(confirmed) <= stored
    for one in stored:  # also one that was stored but not confirmed
        assert again.client.get(f"/api/attempts/{one}").json()["mark"]["residual"]["copy"]
        assert again.client.get(f"/api/attempts/{one}/picture").status_code == 200


def test_an_upload_that_was_cut_off_leaves_nothing(start, tmp_path):
    server = start()
    data = zip_of_pictures(50)

    def half():
        yield b'--x\r\nContent-Disposition: form-data; name="zip"; filename="a.zip"\r\n\r\n'
        yield data[: len(data) // 2]
        server.process.send_signal(signal.SIGKILL)
        time.sleep(0.3)
        yield data[len(data) // 2 :] + b"\r\n--x--\r\n"

    with pytest.raises(httpx.HTTPError):
        server.client.post(
            "/api/imports",
            content=half(),
            headers={"X-CSRF-Token": server.token, "Content-Type": "multipart/form-data; boundary=x"},
        )
    server.end()
    again = start()
    assert again.client.get("/api/works?q=號").json()["total"] == 0
    with start.gallery.database.reading() as session:
        assert session.query(Job).where(Job.kind == "import").count() == 0
    assert not any((tmp_path / "files").rglob("uploads/*/*"))


def test_a_queued_job_waits_for_the_next_server_which_ends_with_all_its_processes(start):
    with start.gallery.database.writing() as session:
        job_id = job_queue.add(session, "prepare", {}, person_id=None).id
    server = start()
    assert wait_for_job(start.gallery, job_id, seconds=200).result["works"] >= 30
    children = _children(server.process.pid)
    server.end(signal.SIGTERM)
    assert server.process.returncode in (0, 143, -signal.SIGTERM)
    until = time.monotonic() + 15
    while any(_alive(pid) for pid in children) and time.monotonic() < until:
        time.sleep(0.05)
    assert children and not [pid for pid in children if _alive(pid)]


def test_others_reach_nothing_that_nobody_owns(tmp_path):
    settings = ServiceSettings(Storage(str(tmp_path / "a.sqlite"), str(tmp_path / "files")), processes=0)
    with pytest.raises(RumuError, match="until the service has an owner"):
        serve(settings, host="0.0.0.0", port=0, on_listen=lambda address: pytest.fail("it listens"))


def test_small_answers_are_sent_at_once():
    """Without its protocol, asyncio would leave Nagle's delay of 40 ms on every connection."""
    with contextlib.closing(listen("127.0.0.1", 0)) as listening:
        assert listening.proto == socket.IPPROTO_TCP


def test_a_port_that_is_taken_is_said(tmp_path):
    with (
        contextlib.closing(listen("127.0.0.1", 0)) as taken,
        pytest.raises(RumuError, match="another --port"),
    ):
        listen("127.0.0.1", taken.getsockname()[1])


@pytest.mark.parametrize(
    ("host", "own"),
    [
        *((own, True) for own in ("127.0.0.1", "127.9.9.9", "::1", "localhost")),
        *((open_to_all, False) for open_to_all in ("0.0.0.0", "::", "192.168.1.2", "example.org")),
    ],
)
def test_what_only_this_machine_reaches(host, own):
    assert is_loopback(host) is own


def serve_again(start, tmp_path):
    """A second `rumu serve` on the same database, which is expected to end at once."""
    return subprocess.run(
        [
            *(sys.executable, "-m", "rumu.cli", "serve", "--port", "0"),
            *("--database", start.database, "--files", str(tmp_path / "files")),
        ],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )


def test_beside_a_server_a_second_one_is_refused_and_commands_work(start, tmp_path):
    first = start()
    second = serve_again(start, tmp_path)
    assert second.returncode == 1 and second.stdout == "" and second.stderr.count("\n") == 1
    for word in ("another rumu serve", "另一個 rumu serve", f"pid {first.process.pid}", socket.gethostname()):
        assert word in second.stderr, second.stderr
    assert f"since {date.today():%Y}" in second.stderr
    assert first.client.get("/api/works").status_code == 200
    folder = tmp_path / "more"
    folder.mkdir()
    with zipfile.ZipFile(io.BytesIO(zip_of_pictures(3))) as archive:
        archive.extractall(folder)
    environment = os.environ | {"RUMU_DATABASE": start.database, "RUMU_FILES": str(tmp_path / "files")}
    for words in (["gallery", "list"], ["gallery", "import", str(folder)]):
        ended = subprocess.run(
            [sys.executable, "-m", "rumu.cli", *words, "--json"],
            env=environment,
            capture_output=True,
            text=True,
            check=False,
            timeout=120,
        )
        assert ended.returncode == 0, ended.stderr
    time.sleep(1.1)  # seconds that a list is kept
    assert first.client.get("/api/works?q=號").json()["total"] == 3
    first.end(signal.SIGKILL)
    again = start()  # what a killed server left stands in nobody's way
    assert again.client.get("/api/works").status_code == 200


def _children(pid: int) -> list[int]:
    children = []
    for task in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            fields = task.read_text().rsplit(")", 1)[1].split()
            if int(fields[1]) == pid:
                children += [int(task.parent.name), *_children(int(task.parent.name))]
    return children


def _alive(pid: int) -> bool:
    with contextlib.suppress(OSError):
        os.kill(pid, 0)
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    return False
