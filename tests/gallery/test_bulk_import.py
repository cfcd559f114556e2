"""Folders of labelled pictures: whole, once, and on again after a kill."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from sqlalchemy import func, select
from tests.gallery.conftest import surface

from rumu.database.tables import Work
from rumu.errors import GalleryError
from rumu.gallery import bulk_import
from rumu.gallery.bulk_import import import_folder
from rumu.gallery.catalog import collection, open_gallery, works
from rumu.gallery.labels import SharedMetadata
from rumu.gallery.store import Gallery


def test_every_row_becomes_a_work(gallery, labelled):
    folder = labelled(7)
    told = SharedMetadata({"source": "from a test", "licence": "CC0-1.0"})
    done = import_folder(gallery, folder, shared=told)
    assert (done.added, done.existing, done.left_out, done.collections) == (7, 0, (), ("set",))
    found = works(gallery, collection="set")
    assert [row.origin for row in found.items] == [f"img/{n:05d}.png" for n in range(7)]
    for row in found.items:
        assert gallery.store.read(row.picture) == (folder / row.origin).read_bytes()
        assert (row.width, row.height, row.source, row.licence) == (48, 48, "from a test", "CC0-1.0")
        assert (row.dynasty, row.script, row.hand_en) == ("Tang", "running", "Yu Shinan (attributed)")
    assert works(gallery, query="兰亭序 永").total == 2
    assert collection(gallery, "set").licence == "CC0-1.0"


def test_nothing_is_put_in_twice(gallery, labelled, everything):
    folder = labelled(5)
    import_folder(gallery, folder)
    before = everything(gallery)
    done = import_folder(gallery, folder)
    assert (done.added, done.existing) == (0, 5)
    assert everything(gallery) == before


def test_the_same_picture_under_another_label_is_another_work(bare, labelled):
    folder = labelled(1)
    text = (folder / "labels.csv").read_text(encoding="utf-8")
    row = text.splitlines()[1]
    more = "\n".join([text.strip(), row, row.replace("永", "和")]) + "\n"
    (folder / "labels.csv").write_text(more, encoding="utf-8")
    done = import_folder(bare, folder)
    assert (done.added, done.existing) == (2, 1)
    assert len(list(bare.store.keys("pictures"))) == 1


def test_pictures_that_cannot_be_read_are_left_out_and_named(bare, labelled, tmp_path):
    folder = labelled(6)
    (folder / "img" / "00001.png").unlink()
    (folder / "img" / "00002.png").write_bytes((folder / "img" / "00000.png").read_bytes()[:60])
    (folder / "img" / "00003.png").write_text("words")
    (tmp_path / "secret.png").write_bytes((folder / "img" / "00000.png").read_bytes())
    (folder / "img" / "00004.png").unlink()
    (folder / "img" / "00004.png").symlink_to(tmp_path / "secret.png")
    with (folder / "labels.csv").open("a", encoding="utf-8") as labels:
        labels.write("../secret.png,永,,,,,\n")
    done = import_folder(bare, folder)
    assert done.added == 2
    reasons = {file: reason.en for file, reason in done.left_out}
    assert all(reason.zh for _, reason in done.left_out)
    assert set(reasons) == {*(f"img/{n:05d}.png" for n in (1, 2, 3, 4)), "../secret.png"}
    assert "within the folder" in reasons["../secret.png"] and "within" in reasons["img/00004.png"]


def test_a_folder_without_one_readable_picture_is_refused(bare, labelled):
    folder = labelled(2)
    for picture in (folder / "img").iterdir():
        picture.write_text("words")
    with pytest.raises(GalleryError, match="none of 2 pictures can be read"):
        import_folder(bare, folder)
    with pytest.raises(GalleryError, match=r"expected a folder with labels\.csv"):
        import_folder(bare, folder / "img")


def test_progress_counts_what_is_safe(bare, labelled, monkeypatch):
    monkeypatch.setattr(bulk_import, "BATCH", 4)
    told = []

    def progress(done: int, total: int) -> None:
        told.append((done, total, works(bare).total))

    import_folder(bare, labelled(10), progress=progress)
    assert told == [(4, 10, 4), (8, 10, 8), (10, 10, 10)]


def test_a_batch_that_fails_leaves_the_batches_before_it(bare, labelled, monkeypatch):
    monkeypatch.setattr(bulk_import, "BATCH", 4)
    folder, put = labelled(10), bulk_import.insert_works
    calls = []

    def fails(session, collection, rows):
        calls.append(1)
        added = put(session, collection, rows)
        if len(calls) == 2:
            raise RuntimeError("the machine fails")
        return added

    monkeypatch.setattr(bulk_import, "insert_works", fails)
    with pytest.raises(RuntimeError):
        import_folder(bare, folder)
    assert works(bare).total == 4
    monkeypatch.setattr(bulk_import, "insert_works", put)
    assert import_folder(bare, folder).added == 6


_RUN = """
import sys
from rumu.gallery import bulk_import
from rumu.gallery.catalog import open_gallery
bulk_import.BATCH = 20
gallery = open_gallery(database=sys.argv[2], files=sys.argv[3], starter=False)
bulk_import.import_folder(gallery, sys.argv[1], progress=lambda done, total: print(done, flush=True))
"""


def _killed(folder: Path, database_url: str, files: Path, *, after: int) -> int:
    """Import in another process, kill -9 it once so many works were confirmed; how many were."""
    command = [sys.executable, "-c", _RUN, folder, database_url, files]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        confirmed = 0
        for line in process.stdout:
            confirmed = int(line)
            if confirmed >= after:
                time.sleep(0.012)  # somewhere within the next batch
                os.kill(process.pid, signal.SIGKILL)
                break
        rest = [int(line) for line in process.stdout.read().split()]
        assert process.wait(60) == -signal.SIGKILL
    return max([confirmed, *rest])


def test_kill_9_loses_nothing_confirmed_and_leaves_no_half_work(labelled, database_url, tmp_path, everything):
    folder, files = labelled(400), tmp_path / "killed"
    for after in (20, 160):
        confirmed = _killed(folder, database_url, files, after=after)
        there = open_gallery(database=database_url, files=files, starter=False)
        found = works(there, limit=1000)
        assert confirmed <= found.total < 400
        for row in found.items:
            assert there.store.read(row.picture) == (folder / row.origin).read_bytes()
        there.database.close()
    there = open_gallery(database=database_url, files=files, starter=False)
    done = import_folder(there, folder)
    assert done.added + done.existing == 400 and done.added > 0
    whole = Gallery(there.database, there.store)
    with whole.database.reading() as session:
        assert session.scalar(select(func.count(func.distinct(Work.origin)))) == 400
    from rumu.gallery.assets import delete_orphans

    delete_orphans(whole, older_than=-1)
    assert {row["picture"] for row in everything(whole)["works"]} == set(whole.store.keys("pictures"))
    there.database.close()


@pytest.mark.parametrize(
    ("name", "polarity"),
    [("regular", "1-bit"), ("running-lantingxu", "rubbing"), ("cursive", "light_on_dark")],
)
def test_real_sets_go_in_with_their_own_columns(bare, data, tmp_path, name, polarity):
    """The first rows of each, and a few that are white on black."""
    source = data / "masters" / name
    lines = (source / "labels.csv").read_text(encoding="utf-8-sig").splitlines()
    chosen = [lines[1], lines[2], *[line for line in lines if polarity in line][:2]]
    folder = tmp_path / name
    folder.mkdir()
    for line in dict.fromkeys(chosen):
        file = folder / line.split(",")[0]
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes((source / line.split(",")[0]).read_bytes())
    (folder / "labels.csv").write_text("\n".join([lines[0], *dict.fromkeys(chosen)]) + "\n", encoding="utf-8")
    done = import_folder(bare, folder)
    assert done.added == len(set(chosen)) and done.left_out == ()
    for row in works(bare).items:
        assert row.licence == "none stated" and row.hand_zh and row.character
        relief = surface(bare, row.id)
        assert 0.005 < relief.mask.mean() < 0.7, "the strokes are the ink, not the ground"
