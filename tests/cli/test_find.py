"""rumu find: names masters, best first; what is missing is said in one line."""

from __future__ import annotations

import shutil

import pytest

from rumu.gallery.starter import starter_works


@pytest.fixture
def masters(tmp_path, monkeypatch):
    monkeypatch.setenv("RUMU_HOME", str(tmp_path / "home"))
    folder = tmp_path / "masters"
    folder.mkdir()
    for work in starter_works(script="regular"):
        shutil.copy(work.path, folder / f"{work.id}.png")
    (folder / "labels.csv").write_text(
        "file,character\n"
        + "".join(f"{w.id}.png,{w.character}\n" for w in starter_works(script="regular"))
        + "gone.png,無\n",
        encoding="utf-8",
    )
    return folder


def test_the_best_comes_first(rumu, masters):
    ended = rumu("find", masters / "regular-shui.png", "--masters", masters, "--top", 3, "--json")
    assert (ended.code, ended.err) == (0, "")
    assert ended.facts["masters"] == 6
    assert ended.facts["matches"][0]["character"] == "水"
    assert len(ended.facts["matches"]) == 3
    assert ended.facts["matches"][0]["file"].endswith("regular-shui.png")
    assert [left["file"].rsplit("/", 1)[-1] for left in ended.facts["left_out"]] == ["gone.png"]


def test_a_person_reads_character_and_file(rumu, masters):
    ended = rumu("find", masters / "regular-ri.png", "--masters", masters / "labels.csv")
    assert ended.code == 0
    heading, first, *_ = ended.out.splitlines()
    assert "among 6 masters (1 more hold no writing)" in heading
    assert "日" in first and first.strip().startswith("1.00") and "regular-ri.png" in first


def test_what_is_missing_is_said(rumu, masters, tmp_path):
    rumu("find", masters / "regular-ri.png", "--masters", tmp_path / "nowhere").failed_with(
        "nowhere", "labels.csv"
    )
    rumu("find", tmp_path / "gone.png", "--masters", masters).failed_with("gone.png")
    assert rumu("find", masters / "regular-ri.png").code == 2
