"""Jobs over HTTP: an import is sent, its progress is streamed, and it can be cancelled."""

from __future__ import annotations

import io
import json
import threading
import time
import zipfile

import pytest

from rumu.gallery.starter import starter_works
from rumu.studio import job_handlers


def make_zip(files):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return stream.getvalue()


@pytest.fixture
def archive():
    """A zip with labels.csv and two pictures that the gallery does not have under these labels."""
    works = starter_works(script="regular")[:2]
    labels = "file,character,script,work\n" + "".join(
        f"{w.id}.png,{w.character},regular,新收\n" for w in works
    )
    return make_zip({"labels.csv": labels} | {f"{w.id}.png": w.path.read_bytes() for w in works})


def events(browser, job_id):
    updates = []
    with browser.client.stream("GET", f"/api/jobs/{job_id}/events") as stream:
        assert stream.headers["content-type"].startswith("text/event-stream")
        for line in stream.iter_lines():
            if line.startswith("data: "):
                updates.append(json.loads(line.removeprefix("data: ")))
    return updates


def send_zip(browser, data, **facts):
    return browser("POST", "/api/imports", data=facts, files={"zip": ("a.zip", data)})


def test_an_import_is_a_job_that_tells_how_far_it_is(new_world, archive):
    teacher = new_world().browser("林")
    before = teacher("GET", "/api/works").json()["total"]
    answer = send_zip(teacher, archive)
    assert answer.status_code == 202, answer.text
    updates = events(teacher, answer.json()["job"]["id"])
    assert (
        updates[-1]["state"] == "done"
        and updates[-1]["result"]["added"] == 2
        and updates[-1]["error"] is None
    )
    assert updates[0]["state"] in ("queued", "running", "done")
    assert all(one["id"] == updates[0]["id"] for one in updates)
    assert teacher("GET", "/api/works").json()["total"] == before + 2
    again = events(teacher, send_zip(teacher, archive).json()["job"]["id"])
    assert again[-1]["result"]["added"] == 0 and again[-1]["result"]["there"] == 2


@pytest.mark.parametrize(("facts", "collection"), [({"collection": "Class 3"}, "class-3"), ({}, "a")])
def test_an_import_goes_where_it_was_told_else_by_the_name_of_its_zip(new_world, archive, facts, collection):
    teacher = new_world().browser("林")
    updates = events(teacher, send_zip(teacher, archive, **facts).json()["job"]["id"])
    assert updates[-1]["result"]["collections"] == [collection]
    assert teacher("GET", f"/api/works?collection={collection}").json()["total"] == 2


@pytest.mark.parametrize(
    ("data", "word"),
    [(make_zip({"../out": b"1"}), "leads out"), (make_zip({"a": b""}), ""), (b"PK\x03\x04nonsense", "zip")],
)
def test_a_zip_that_will_not_do_fails_with_its_reason_and_is_forgotten(new_world, data, word, tmp_path):
    teacher = new_world().browser("林")
    updates = events(teacher, send_zip(teacher, data).json()["job"]["id"])
    assert updates[-1]["state"] == "failed" and word in updates[-1]["error"]["en"]
    assert updates[-1]["error"]["zh"] != updates[-1]["error"]["en"]
    until = time.monotonic() + 5
    while any(p.is_file() for p in (tmp_path / "files" / "uploads").rglob("*")) and time.monotonic() < until:
        time.sleep(0.05)
    assert not any(p.is_file() for p in (tmp_path / "files" / "uploads").rglob("*"))


def test_what_is_no_zip_is_refused_at_once(new_world, code_of):
    assert code_of(send_zip(new_world().browser("林"), b"no zip")) == "no_zip"


def test_a_job_is_told_step_by_step_and_can_be_stopped(new_world, archive, monkeypatch):
    world = new_world()
    teacher, other, owner = world.browser("林"), world.browser("陳"), world.browser("館主")
    going = threading.Event()

    def slow(gallery, payload, progress, storage):
        for k in range(1000):
            progress.reported = 0.0
            progress(k, 1000, f"step {k}")
            going.set()
            time.sleep(0.02)
        return {}

    monkeypatch.setitem(job_handlers.HANDLERS, "import", slow)
    job_id = send_zip(teacher, archive).json()["job"]["id"]
    updates = []
    listener = threading.Thread(target=lambda: updates.extend(events(owner, job_id)))
    listener.start()
    assert going.wait(20), owner("GET", f"/api/jobs/{job_id}").json()
    time.sleep(0.8)
    assert other("POST", f"/api/jobs/{job_id}/cancel").status_code == 404
    assert other("GET", f"/api/jobs/{job_id}/events").status_code == 404
    assert teacher("POST", f"/api/jobs/{job_id}/cancel").json()["state"] == "cancelled"
    listener.join(20)
    assert updates[-1]["state"] == "cancelled" and len({one["done"] for one in updates}) >= 2
    assert teacher("POST", f"/api/jobs/{job_id}/cancel").status_code == 403
