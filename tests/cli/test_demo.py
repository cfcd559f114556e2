"""demo: the whole system on what comes with the package."""

from __future__ import annotations

import json
import re

import pytest

from rumu.gallery.works import starter_samples

SAMPLES = starter_samples()


@pytest.fixture
def no_browser(monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    return opened


def test_the_demo_marks_every_sample_and_shows_every_work(rumu, tmp_path, no_browser, monkeypatch):
    monkeypatch.setenv("DISPLAY", ":0")
    ended = rumu("demo", "-o", tmp_path / "demo")
    assert ended.code == 0 and "index.html" in ended.out and "nobody wrote them" in ended.out
    assert len(no_browser) == 1 and no_browser[0].endswith("/demo/index.html")
    marks = json.loads((tmp_path / "demo" / "marks.json").read_text(encoding="utf-8"))
    assert len(marks["samples"]) == len(SAMPLES) >= 4
    assert all(sample["simulated"] for sample in marks["samples"])
    index = (tmp_path / "demo" / "index.html").read_text(encoding="utf-8")
    assert index.count('<figure id="') == 30
    for href in re.findall(r'href="([^"#]+\.html)"', index):
        assert "not written by a person" in (tmp_path / "demo" / href).read_text(encoding="utf-8")


def test_a_script_gets_one_object_and_no_browser(rumu, tmp_path, no_browser, monkeypatch):
    """Marks fall with the degree of the fault that was put in; nothing is opened."""
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.chdir(tmp_path)
    facts = rumu("demo", "--json").facts
    assert not no_browser and facts["index"] == "rumu-demo/index.html"
    by_degree = {}
    for sample in facts["samples"]:
        by_degree.setdefault(sample["degree"], []).append(sample["score"] or 0.0)
    means = [sum(by_degree[d]) / len(by_degree[d]) for d in ("excellent", "good", "medium", "bad")]
    assert means == sorted(means, reverse=True)


def test_a_place_that_cannot_be_written(rumu, desk, no_browser):
    rumu("demo", "-o", desk / "file.txt" / "demo", "--no-open").failed_with("cannot be written")
    rumu("demo", "-o", desk, "--no-open").failed_with("it holds other things")
    assert not no_browser
