from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from rumu.errors import GalleryError
from rumu.gallery.add_work import add_picture
from rumu.gallery.catalog import open_gallery
from rumu.gallery.metadata import WorkMetadata
from rumu.gallery.sheet_masters import SIDE, choose_masters, masters_file, open_masters
from rumu.gallery.starter import find_work
from rumu.values import Bilingual


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("RUMU_HOME", str(tmp_path / "home"))


def test_strokes_and_starter_works_need_nothing_but_the_package():
    for name, script in (("strokes", "regular"), ("seal", "seal")):
        masters = choose_masters("天人", (name,) if name != "strokes" else ())
        assert masters.name == name
        again = open_masters(name, "天人")
        for character, master in masters.by_character.items():
            assert master.script == script and master.picture.shape == (SIDE, SIDE)
            assert np.array_equal(master.picture, again.by_character[character].picture)


def test_a_master_stands_in_the_middle_of_its_cell_sized_as_others(tmp_path):
    picture = np.full((300, 420), 230, np.uint8)
    picture[60:100, 20:160] = picture[60:200, 80:100] = 20  # 丁, in a corner of its picture
    Image.fromarray(picture).save(tmp_path / "a.png")
    ink = choose_masters("丁", (str(tmp_path / "a.png"),)).by_character["丁"].ink > 0.5
    rows, columns = np.nonzero(ink)
    assert abs(rows.min() + rows.max() - SIDE + 1) <= 3 and abs(columns.min() + columns.max() - SIDE + 1) <= 3
    assert np.ptp(columns) == pytest.approx(0.65 * SIDE, rel=0.25)


def test_the_first_source_with_a_character_counts_and_the_masters_are_kept(tmp_path):
    masters = choose_masters("永天", ("regular", "strokes"))
    assert masters.name.startswith("#") and masters_file(masters.name).is_file()
    assert choose_masters("永天", ("regular", "strokes")).name == masters.name
    kept = open_masters(masters.name, "永天").by_character
    for character, master in masters.by_character.items():
        assert np.array_equal(kept[character].picture, master.picture)
        assert kept[character].script == master.script
    assert set(open_masters(masters.name, "永").by_character) == {"永"}  # no other picture is decoded
    regular = choose_masters("天", ("regular",)).by_character["天"]
    assert np.array_equal(masters.by_character["天"].picture, regular.picture)


def test_a_folder_names_its_characters_and_a_work_is_found_by_its_id(tmp_path):
    for character, work in (("天", "running-tian"), ("人", "running-ren")):
        Image.open(find_work(work).path).save(tmp_path / f"{character}.png")
    folder = choose_masters("人天", (str(tmp_path),))
    assert set(folder.by_character) == {"天", "人"}
    assert choose_masters("水", ("cursive-shui",)).by_character["水"].script == "cursive"


@pytest.mark.parametrize("sources", [("seal",), ("seal", "clerical"), ("strokes",)])
def test_what_no_source_has_is_named(sources):
    with pytest.raises(GalleryError, match=r"no master of 〇㐂") as caught:
        choose_masters("天〇㐂", sources)
    assert "〇㐂" in str(caught.value.zh)


def test_masters_of_another_machine_are_told():
    for name, message in (("#00ff", "not on this machine"), ("#../../x", "got"), ("x", "got")):
        with pytest.raises(GalleryError, match=message):
            open_masters(name, "天")


def test_a_damaged_file_of_masters_is_told(tmp_path):
    masters = choose_masters("永天", ("regular", "strokes"))
    path: Path = masters_file(masters.name)
    path.write_bytes(path.read_bytes()[:200])
    with pytest.raises(GalleryError, match="cannot read them"):
        open_masters(masters.name, "永天")


def test_a_work_is_read_upright_and_in_all_its_bits(tmp_path):
    picture = np.full((300, 420), 60000, np.uint16)
    picture[60:100, 20:160] = picture[60:200, 80:100] = 1500  # 丁, in a corner of its picture
    cv2.imwrite(str(tmp_path / "ding.png"), picture)
    turned, exif = Image.fromarray((np.rot90(picture) // 257).astype(np.uint8)), Image.Exif()
    exif[0x0112] = 6  # shown turned by 90 degrees clockwise, which undoes rot90
    turned.save(tmp_path / "turned.jpg", exif=exif, quality=95)
    wanted = choose_masters("丁", (str(tmp_path / "ding.png"),)).by_character["丁"]
    gallery = open_gallery()
    for name in ("ding.png", "turned.jpg"):
        metadata = WorkMetadata(title=Bilingual("丁", "ding"), character="丁")
        added = add_picture(gallery, tmp_path / name, metadata=metadata)
        found = choose_masters("丁", (added.id,)).by_character["丁"]
        assert np.abs(found.ink - wanted.ink).mean() < 0.01, name
        assert found.in_work == pytest.approx(wanted.in_work, abs=0.01), name
