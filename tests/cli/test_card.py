import json

import numpy as np
import pypdfium2
import pytest
from PIL import Image
from pypdf import PdfReader

from rumu_lab.simulation.phone import (
    CardScene,
    HandLamp,
    PhoneCamera,
    reflectance_of_print,
    take_card_photograph,
    wavy_sheet,
)


def test_a_card_is_printed_and_its_photographs_reconstructed(rumu, tmp_path):
    done = rumu("card", "-o", tmp_path / "card.pdf", "--json")
    assert done.facts["paper"] == "A4" and done.facts["window_mm"] == [158, 207]
    page = pypdfium2.PdfDocument(tmp_path / "card.pdf")[0]
    printed = reflectance_of_print(np.asarray(page.render(scale=2.5).to_pil().convert("L")))
    scene = CardScene(printed, (210, 297), sheet=wavy_sheet(spacing=0.3), ball=(-42, -121.5, 9))
    folder = tmp_path / "photographs"
    folder.mkdir()
    lamps = [(250, 30, 300), (-100, 240, 280), (-140, -220, 300)]
    for number, lamp in enumerate(lamps):
        data = take_card_photograph(scene, PhoneCamera(size=(960, 1280), blur=0.5), HandLamp(lamp))
        (folder / f"{number}.jpg").write_bytes(data)
    out = tmp_path / "out"
    options = ("--card", "--write", "normals", "--capture-report", "en", "--by", "A. Writer")
    ended = rumu("reconstruct", folder, "-o", out, *options, "--json")
    card = ended.facts["card"]
    assert ended.facts["unit"] == "mm" and len(card["lamps"]) == 3 and 8 < card["ball_mm"] < 10
    assert ended.facts["spacing"] == pytest.approx(card["pixel_mm"])
    stored = json.loads((out / "surface.json").read_text("utf-8"))
    record = stored["processing"]
    assert record["settings"]["card"] is True and record["lamps"]["from"] == "the capture card"
    assert set(record["lamps"]["directions"]) == {"0.jpg", "1.jpg", "2.jpg"}
    assert record["photographs"]["0.jpg"]["camera"] == "Simulated Phone 1"
    text = "".join(page.extract_text() for page in PdfReader(out / "capture-report.pdf").pages)
    assert "Simulated Phone 1" in text and "the capture card" in text and "A. Writer" in text
    assert len((out / "lamps.lp").read_text().splitlines()) == 4
    again = rumu("reconstruct", "--again", out / "surface.json", "-o", tmp_path / "again", "--json")
    assert again.facts["again"]["same"]


def test_letter_and_wrong_names(rumu, tmp_path):
    rumu("card", "-o", tmp_path / "card.pdf", "--paper", "Letter")
    box = PdfReader(tmp_path / "card.pdf").pages[0].mediabox
    assert np.allclose([float(v) for v in box[2:]], (612, 792), atol=0.1)
    assert rumu("card", "-o", tmp_path / "card.png").code == 2


def test_what_the_card_tells_is_not_told_twice(rumu, tmp_path):
    folder = tmp_path / "photographs"
    folder.mkdir()
    Image.new("RGB", (64, 64)).save(folder / "a.jpg")
    assert rumu("reconstruct", folder, "-o", tmp_path / "o", "--card", "--sphere", "auto").code == 2
    rumu("reconstruct", folder, "-o", tmp_path / "o", "--card").failed_with("at least 3", "got 1")
