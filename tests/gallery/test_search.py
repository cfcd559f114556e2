"""A copy is found among masters; what is kept of them is used, renewed and never half written."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path

import numpy as np
import pytest

import rumu
from rumu.errors import GalleryError, RefusedImage
from rumu.gallery import search
from rumu.gallery.search import MasterIndex, find, index_masters
from rumu.gallery.starter import find_work, starter_works

CHARACTERS = "下令傳十合寧式當得德手方益讀銘非風"


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch) -> Path:
    monkeypatch.setenv("RUMU_HOME", str(tmp_path / "home"))
    return tmp_path / "home"


@pytest.fixture
def folder(tmp_path) -> Path:
    """The regular and seal starter works with a labels.csv."""
    place = tmp_path / "masters"
    place.mkdir()
    works = [w for w in starter_works() if w.script in ("regular", "seal")]
    with (place / "labels.csv").open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["file", "character", "calligrapher_zh", "work"])
        for work in works:
            shutil.copy(work.path, place / f"{work.id}.png")
            writer.writerow([f"{work.id}.png", work.character, work.hand.zh, ""])
    return place


def described(monkeypatch) -> list[str]:
    """Names of the files that are described from now on."""
    names: list[str] = []
    row = search._describe_master

    def noted(path: str):
        names.append(Path(path).name)
        return row(path)

    monkeypatch.setattr(search, "_describe_master", noted)
    return names


def test_a_master_finds_itself_first(folder):
    best, *others = rumu.find(folder / "seal-shui.png", folder, top=5)
    assert best.master.path.name == "seal-shui.png"
    assert best.master.character == "水" and best.master.hand and best.master.work is None
    assert best.likeness == pytest.approx(1.0, abs=0.01)
    assert len(others) == 4
    assert all(a.likeness >= b.likeness for a, b in zip([best, *others], others, strict=False))
    assert others[0].likeness < 0.8


@pytest.mark.parametrize("name", ["ren", "ri", "shu", "shui", "tian", "yue"])
def test_another_hand_finds_its_character(folder, name):
    found = find(find_work(f"running-{name}").path, folder, top=2)
    assert find_work(f"running-{name}").character in {match.master.character for match in found}


def test_a_folder_without_labels_will_do(folder):
    (folder / "labels.csv").unlink()
    (folder / "notes.txt").write_text("not a picture")
    (folder / "more").mkdir()
    shutil.move(folder / "seal-ri.png", folder / "more" / "seal-ri.png")
    index = index_masters(folder)
    assert len(index.masters) == 12
    assert find(folder / "more" / "seal-ri.png", index, top=1)[0].master.path.name == "seal-ri.png"
    assert index.masters[0].character is None


def test_several_places_are_one_set(folder, tmp_path):
    other = tmp_path / "other"
    other.mkdir()
    shutil.copy(find_work("clerical-yue").path, other / "yue.png")
    index = index_masters([folder / "labels.csv", other, folder])
    assert len(index.masters) == 13
    assert find(other / "yue.png", index, top=1)[0].master.path == other / "yue.png"


def test_masters_are_described_once(folder, monkeypatch, home):
    names = described(monkeypatch)
    steps = []
    first = index_masters(folder, progress=lambda done, total: steps.append((done, total)))
    assert steps == [(k, 12) for k in range(1, 13)]
    assert len(names) == 12
    again = index_masters(folder)
    assert len(names) == 12
    np.testing.assert_array_equal(again.vectors, first.vectors)
    assert [p.suffix for p in home.rglob("*") if p.is_file()] == [".npz"]


def test_only_what_changed_is_described_anew(folder, monkeypatch):
    index_masters(folder)
    names = described(monkeypatch)
    same = (folder / "seal-ren.png").read_bytes()
    (folder / "seal-ren.png").unlink()
    (folder / "seal-ren.png").write_bytes(same)  # another time, the same content
    shutil.copy(find_work("cursive-ri").path, folder / "seal-ri.png")
    index = index_masters(folder)
    assert names == ["seal-ri.png"]
    assert find(find_work("cursive-ri").path, index, top=1)[0].master.path.name == "seal-ri.png"


def test_what_was_kept_and_is_cut_short_is_made_anew(folder, home):
    before = index_masters(folder)
    (file,) = [p for p in home.rglob("*.npz")]
    file.write_bytes(file.read_bytes()[:2000])
    np.testing.assert_array_equal(index_masters(folder).vectors, before.vectors)
    file.write_text("no archive at all")
    np.testing.assert_array_equal(index_masters(folder).vectors, before.vectors)


def test_another_version_is_not_used(folder, monkeypatch):
    index_masters(folder)
    names = described(monkeypatch)
    monkeypatch.setattr(search, "VERSION", search.VERSION + 1)
    index_masters(folder)
    assert len(names) == 12


def test_a_home_that_cannot_be_written_costs_only_time(folder, monkeypatch, tmp_path):
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("RUMU_HOME", str(tmp_path / "file"))
    with pytest.warns(UserWarning, match="not kept"):
        index = index_masters(folder)
    assert len(index.masters) == 12


def test_masters_without_writing_are_left_out_with_their_reason(folder):
    (folder / "seal-ri.png").write_bytes(b"no picture")
    (folder / "seal-ren.png").unlink()
    index = index_masters(folder)
    assert len(index.masters) == 10
    assert {m.path.name for m, _ in index.left_out} == {"seal-ri.png", "seal-ren.png"}
    assert all(reason for _, reason in index.left_out)


def test_what_is_no_place_of_masters_is_named(folder, tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "table.csv").write_text("picture,character\na.png,b\n")
    for place, words in (
        (tmp_path / "gone", "expected a folder of pictures or a labels.csv"),
        (tmp_path / "empty", "expected pictures of masters"),
        (tmp_path / "table.csv", "expected a column 'file', found picture, character"),
        ([], "expected pictures of masters in nothing"),
    ):
        with pytest.raises(GalleryError, match=words):
            index_masters(place)
    with pytest.raises(GalleryError, match="top: expected 1 or more, got 0"):
        find(folder / "seal-ri.png", folder, top=0)
    with pytest.raises(RefusedImage):
        find(np.full((200, 200), 250, np.uint8), folder)


def test_an_index_is_checked():
    with pytest.raises(GalleryError, match="expected descriptions of"):
        MasterIndex((), np.zeros((3, 5), np.uint8))


def test_learners_copies_find_their_character_among_masters(data, monkeypatch):
    """A subset of what `python benchmarks/find.py` measures in full."""
    regular = data / "masters" / "regular" / "labels.csv"
    with regular.open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    wanted = {r["file"] for r in rows if r["character"] in CHARACTERS} | {r["file"] for r in rows[::23]}
    masters = tuple(
        m for m in search.read_masters(regular) if str(m.path.relative_to(regular.parent)) in wanted
    )
    monkeypatch.setattr(search, "read_masters", lambda places: masters)
    index = index_masters(regular)
    assert len(index.masters) > 400
    with (data / "e3c" / "scores.csv").open(encoding="utf-8-sig") as stream:
        copies = list(csv.DictReader(stream))[::13]
    hits = [
        row["character"] in {match.master.character for match in find(data / "e3c" / row["image"], index)}
        for row in copies
    ]
    assert np.mean(hits) >= 0.96, (sum(hits), len(hits))
