"""demo: the whole system on what comes with the package."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys

import httpx
import pytest

from rumu.gallery.starter import starter_samples

SAMPLES = starter_samples()


@pytest.fixture
def no_browser(monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    return opened


def test_the_demo_marks_every_sample_and_shows_every_work(rumu, tmp_path, no_browser, monkeypatch):
    monkeypatch.setenv("DISPLAY", ":0")
    ended = rumu("demo", "-o", tmp_path / "demo", "--no-serve")
    assert ended.code == 0 and "index.html" in ended.out and "nobody wrote them" in ended.out
    assert not no_browser
    marks = json.loads((tmp_path / "demo" / "marks.json").read_text(encoding="utf-8"))
    assert len(marks["samples"]) == len(SAMPLES) >= 4
    assert all(sample["simulated"] for sample in marks["samples"])
    index = (tmp_path / "demo" / "index.html").read_text(encoding="utf-8")
    assert index.count('<figure id="') == 30
    for href in re.findall(r'href="([^"#]+\.html)"', index):
        assert "not written by a person" in (tmp_path / "demo" / href).read_text(encoding="utf-8")


def test_a_script_gets_one_object_no_pages_and_no_server(rumu, tmp_path, no_browser, monkeypatch, own_home):
    """Marks fall with the degree of the fault that was put in; nothing is opened, written or kept."""
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.chdir(tmp_path)
    facts = rumu("demo", "--json").facts
    assert (
        not no_browser and facts["index"] is None and not list(tmp_path.iterdir()) and not own_home.exists()
    )
    by_degree = {}
    for sample in facts["samples"]:
        by_degree.setdefault(sample["degree"], []).append(sample["score"] or 0.0)
    means = [sum(by_degree[d]) / len(by_degree[d]) for d in ("excellent", "good", "medium", "bad")]
    assert means == sorted(means, reverse=True)


def test_a_place_that_cannot_be_written(rumu, desk, no_browser):
    rumu("demo", "-o", desk / "file.txt" / "demo", "--no-serve").failed_with("cannot be written")
    rumu("demo", "-o", desk, "--no-serve").failed_with("it holds other things")
    assert not no_browser


def heed_ctrl_c():
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def test_the_demo_ends_in_a_gallery_that_is_ready(tmp_path, own_home):
    """The table, then a server whose first page has its thumbnails, and a link for the owner; Ctrl-C ends
    it."""
    command = [sys.executable, "-m", "rumu.cli", "demo", "--no-open", "--port", "0"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    # tests that run in the background (nohup) ignore Ctrl-C, and so would what they start
    with subprocess.Popen(command, preexec_fn=heed_ctrl_c, **pipes) as demo:  # noqa: PLW1509
        try:
            lines = []
            while not (lines and "/#/join/" in lines[-1]):
                lines.append(demo.stdout.readline())
                assert lines[-1], demo.stderr.read()
            said = "".join(lines)
            url = re.search(r"http://127\.0\.0\.1:\d+/", said)[0]
            with httpx.Client(base_url=url, trust_env=False, timeout=60) as client:
                works = client.get("/api/works").json()
                assert works["total"] == 39 and client.get(works["items"][0]["thumb"]).status_code == 200
            thumbs = list((own_home / "files" / "derived").rglob("*thumb*"))
            demo.send_signal(signal.SIGINT)
            assert demo.wait(120) == 130  # on a busy machine its workers end slowly
        finally:
            demo.kill()
    assert "nobody wrote them" in said and len(thumbs) == 78
