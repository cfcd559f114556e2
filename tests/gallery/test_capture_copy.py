"""Photographs of the card as works of the gallery: by the command line and as an upload."""

from __future__ import annotations

import zipfile

import numpy as np
import pytest
from PIL import Image
from tests.card import conftest as phone

from rumu.card.capture import read_card_capture
from rumu.card.finding import shows_card
from rumu.errors import CaptureError
from rumu.gallery.add_work import add_capture
from rumu.gallery.assets import assets_of
from rumu.gallery.catalog import open_gallery, work
from rumu.gallery.metadata import WorkMetadata
from rumu.pipeline import reconstruct
from rumu.studio.errors import Unusable
from rumu.studio.uploads import import_zip
from rumu.values import Bilingual

printed, sheet, shoot, taken = phone.printed, phone.sheet, phone.shoot, phone.taken  # fixtures


@pytest.fixture
def empty(tmp_path, monkeypatch):
    """A gallery without works."""
    monkeypatch.setenv("RUMU_HOME", str(tmp_path / "home"))
    return open_gallery()


def packed(folder, path, *, within=""):
    with zipfile.ZipFile(path, "w") as archive:
        for file in sorted(folder.iterdir()):
            archive.write(file, f"{within}{file.name}")
    return path


def quiet(*_):
    return None


def test_a_card_becomes_a_work_with_its_lamps_and_scale(empty, taken):
    folder, _ = taken
    made = read_card_capture(folder)
    added = add_capture(empty, folder, metadata=WorkMetadata(title=Bilingual("紙", "paper")), card=True)
    row = work(empty, added.id)
    assert row.spacing == pytest.approx(made.pixel_mm) and row.height_source == "photometric"
    assert any("the lamps were told by the ball" in note.en for note in added.notes)
    files = assets_of(empty.store, row)
    again = files.capture()
    np.testing.assert_allclose(again.positions, made.capture.positions, rtol=1e-6)
    np.testing.assert_allclose(again.strengths, made.capture.strengths, rtol=1e-6)
    assert again.spacing == pytest.approx(made.pixel_mm)
    inside = (made.capture.images < 0.99).all(axis=(0, 3)) if made.capture.images.ndim == 4 else slice(None)
    assert np.abs(again.images - made.capture.images)[:, inside].max() < 0.01
    wanted = reconstruct(made.capture)
    off = phone.angles(wanted.normals, files.surface().normals)[wanted.mask & files.surface().mask]
    assert off.mean() < 0.6


@pytest.mark.parametrize("facts", [{}, {"lamps": "card"}])
def test_an_upload_of_the_card_is_recognised(empty, taken, tmp_path, facts):
    folder, _ = taken
    done = import_zip(
        empty, packed(folder, tmp_path / "a.zip", within="IMG/"), facts | {"title_zh": "紙"}, progress=quiet
    )
    assert done["added"] == 1 and work(empty, done["work"]).spacing is not None
    assert any("lamps were told" in note["en"] for note in done["notes"])


def test_other_pictures_are_told_what_is_missing(empty, taken, tmp_path):
    others = tmp_path / "others"
    others.mkdir()
    for number in range(3):
        gray = np.random.default_rng(number).integers(90, 255, (300, 400)).astype(np.uint8)
        Image.fromarray(gray).save(others / f"{number}.png")
    sent = packed(others, tmp_path / "b.zip")
    with pytest.raises(Unusable, match="lay the printed card beside the sheet") as caught:
        import_zip(empty, sent, {}, progress=quiet)
    assert "拍攝卡" in caught.value.zh
    with pytest.raises(CaptureError, match=r"0\.png: expected the capture card") as told:
        import_zip(empty, sent, {"lamps": "card"}, progress=quiet)
    assert "找不到拍攝卡" in told.value.zh
    folder, _ = taken
    assert shows_card(sorted(folder.iterdir())[0]) and not shows_card(others / "0.png")
    assert not shows_card(sent)
