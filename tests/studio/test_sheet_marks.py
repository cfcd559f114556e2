import csv
import io
import json
import zipfile
from pathlib import Path

import cv2
import numpy as np
import pypdfium2
import pytest
from PIL import Image
from pypdf import PdfReader

from rumu.errors import ImageError, OutputError
from rumu.gallery.sheet_masters import choose_masters
from rumu.pages.sheet_layout import SheetPage, lay_out
from rumu.pages.sheet_pdf import sheet_pdf
from rumu.studio import sheet_marks
from rumu.studio.sheet_inputs import read_photo, sheet_photos
from rumu.studio.sheet_marks import FACTS, TABLE, mark_sheets, surface_of_cell
from rumu.studio.sheet_reports import by_pupil, write_reports
from rumu_lab.simulation.camera import Conditions, take_photograph

WRITTEN = ((0, 1), (1, 0))
DPI = 150


def print_and_write(pupil: str) -> np.ndarray:
    """A sheet of 人水 with the master, leaning, in two of its cells."""
    masters = choose_masters("人水")
    (page,) = lay_out(SheetPage("人水", "strokes", cell=45, times=3, strokes=False, pupil=pupil))
    document = pypdfium2.PdfDocument(sheet_pdf([page], masters.shapes))
    flat = np.asarray(document[0].render(scale=DPI / 72).to_pil().convert("RGB")).astype(np.float32)
    for cell in page.cells:
        if (cell.row, cell.column) in WRITTEN:
            left, top, side = (round(v * DPI / 25.4) for v in (cell.box.left, cell.box.top, cell.box.width))
            turned = cv2.warpAffine(
                masters.by_character[cell.character].ink,
                cv2.getRotationMatrix2D((256, 256), -5, 0.92),
                (512, 512),
            )
            ink = cv2.resize(turned, (side, side), interpolation=cv2.INTER_AREA)
            flat[top : top + side, left : left + side] *= 1 - 0.9 * ink[..., None]
    return np.clip(flat, 0, 255).astype(np.uint8)


@pytest.fixture(scope="module")
def photos(tmp_path_factory) -> Path:
    """王小明's sheet from aside, 李小華's upside down, and a picture that is none."""
    folder = tmp_path_factory.mktemp("class")
    for name, turn in (("王小明", 10.0), ("李小華", 180.0)):
        conditions = Conditions(tilt=20, towards=40, turn=turn, megapixels=3, blur=0.8, noise=2, light=0.3)
        Image.fromarray(take_photograph(print_and_write(name), conditions).picture).save(
            folder / f"{name}.png"
        )
    Image.new("RGB", (600, 800), (120, 90, 60)).save(folder / "desk.png")
    return folder


@pytest.fixture(scope="module")
def marked(photos, tmp_path_factory):
    out = tmp_path_factory.mktemp("marks") / "out"
    return mark_sheets([photos], out, jobs=1), out


def test_every_written_cell_gets_a_mark_and_nothing_else_does(marked):
    found, out = marked
    by_name = {facts["photo"]: facts for facts in found}
    for name in ("王小明", "李小華"):
        facts = by_name[f"{name}.png"]
        assert facts["pupil"] == name and facts["refused"] is None and facts["empty"] == 4
        assert [(c["row"], c["column"], c["character"]) for c in facts["cells"]] == [
            (0, 1, "人"),
            (1, 0, "水"),
        ]
        for cell in facts["cells"]:
            assert cell["score"] > 70 and cell["refused"] is None
            assert "lean" in [remark["kind"] for remark in cell["remarks"]]  # the cell is a frame
            assert (out / cell["picture"]).is_file()
    assert by_name["desk.png"]["refused"].startswith("no sheet") and by_name["desk.png"]["refused_zh"]


def test_marks_stand_in_a_table_and_in_json(marked):
    found, out = marked
    assert json.loads((out / FACTS).read_text(encoding="utf-8"))["photos"] == json.loads(json.dumps(found))
    rows = list(csv.DictReader(io.StringIO((out / TABLE).read_text(encoding="utf-8-sig"))))
    assert [row["character"] for row in rows] == ["", "人", "水", "人", "水"]
    assert [bool(row["refused"]) for row in rows] == [True, False, False, False, False]
    assert all(float(row["low"]) <= float(row["score"]) <= float(row["high"]) for row in rows[1:])
    assert not (out / f"{FACTS}.unfinished").exists()


def test_pdfs_tell_each_pupil_and_the_teacher(marked):
    found, out = marked
    reports = write_reports(found, out)
    assert {path.name for path in reports} == {"王小明.pdf", "李小華.pdf", "teacher.pdf"}
    assert [pupil.name for pupil in by_pupil(found)] == ["李小華", "王小明"]
    for path in reports:
        reader = PdfReader(path)
        scores = [f"{c['score']:.0f}" for p in by_pupil(found) if p.name == path.stem for c in p.cells]
        text = "".join(page.extract_text() for page in reader.pages)
        assert len(reader.pages) == 1 and all(score in text for score in scores)
    assert "desk.png" in PdfReader(reports[-1]).pages[0].extract_text()
    english = write_reports(found, out, language="en")[-1]
    assert "not read" in PdfReader(english).pages[0].extract_text()


def test_a_zip_and_a_scanners_pdf_hold_photographs_too(photos, tmp_path):
    with zipfile.ZipFile(tmp_path / "class.zip", "w") as archive:
        for path in sorted(photos.iterdir()):
            archive.write(path, f"三年一班/{path.name}")
    with Image.open(photos / "李小華.png") as one, Image.open(photos / "王小明.png") as other:
        one.convert("RGB").save(tmp_path / "scan.pdf", save_all=True, append_images=[other.convert("RGB")])
    with sheet_photos([tmp_path / "class.zip", tmp_path / "scan.pdf"]) as found:
        assert [photo.name for photo in found] == [
            *("三年一班/desk.png", "三年一班/李小華.png", "三年一班/王小明.png", "scan.pdf 1", "scan.pdf 2")
        ]
        assert len({photo.digest() for photo in found}) == 5
        assert all(read_photo(photo).shape[2] == 3 for photo in found)
    (facts,) = mark_sheets([tmp_path / "scan.pdf"], tmp_path / "out", jobs=1)[:1]
    assert facts["pupil"] == "李小華" and len(facts["cells"]) == 2


def test_pictures_of_a_folder_are_read_whatever_a_phone_calls_them(tmp_path):
    pictures = [f"{k}{suffix}" for k, suffix in enumerate((".MPO", ".jfif", ".jpe", ".HEIC", ".tif"))]
    for name in (*pictures, "marks.csv", ".hidden.jpg"):
        (tmp_path / name).write_bytes(b"\xff\xd8\xff")
    with sheet_photos([tmp_path]) as found:
        assert [photo.name for photo in found] == pictures


def test_a_run_that_was_ended_goes_on(photos, tmp_path, monkeypatch):
    seen, real = [], sheet_marks.mark_photo

    def interrupted(photo, *arguments, **options):
        seen.append(photo.name)
        if len(seen) == 2:
            raise KeyboardInterrupt
        return real(photo, *arguments, **options)

    monkeypatch.setattr(sheet_marks, "mark_photo", interrupted)
    with pytest.raises(KeyboardInterrupt):
        mark_sheets([photos], tmp_path / "out", jobs=1)
    assert not (tmp_path / "out" / TABLE).exists()
    found = mark_sheets([photos], tmp_path / "out", jobs=1)
    assert len(seen) == 4 and seen[1:2] == seen[2:3]  # the first is not read again, the second is
    assert sum(len(facts["cells"]) for facts in found) == 4


def test_what_cannot_be_read_costs_the_others_nothing(photos, tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "王小明.png").write_bytes((photos / "王小明.png").read_bytes())
    (tmp_path / "in" / "broken.jpg").write_bytes(b"\xff\xd8\xff no picture")
    (tmp_path / "in" / "broken.pdf").write_bytes(b"%PDF-1.4 no document")
    found = mark_sheets([tmp_path / "in"], tmp_path / "out", jobs=1)
    assert [bool(facts["refused"]) for facts in found] == [True, True, False]
    assert not any(f"{facts['photo']}:" in facts["refused"] for facts in found[:2])  # its row names it


def test_a_folder_with_other_things_is_left_alone(photos, tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("dear")
    with pytest.raises(OutputError, match="holds other things"):
        mark_sheets([photos], tmp_path / "mine", jobs=1)
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["letter.txt"]


def test_nothing_to_read_is_told(tmp_path):
    (tmp_path / "empty").mkdir()
    with pytest.raises(ImageError, match="found none"):
        mark_sheets([tmp_path / "empty"], tmp_path / "out", jobs=1)


def test_a_sheet_whose_masters_are_elsewhere_is_told(photos, tmp_path, monkeypatch):
    monkeypatch.setenv("RUMU_HOME", str(tmp_path / "home"))
    masters = choose_masters("天永", ("regular", "strokes"))
    (page,) = lay_out(SheetPage("天永", masters.name, cell=45, times=3))
    document = pypdfium2.PdfDocument(sheet_pdf([page], masters.shapes))
    Image.fromarray(np.asarray(document[0].render(scale=2).to_pil().convert("RGB"))).save(tmp_path / "a.png")
    monkeypatch.setenv("RUMU_HOME", str(tmp_path / "another"))
    (facts,) = mark_sheets([tmp_path / "a.png"], tmp_path / "out", jobs=1)
    assert "not on this machine" in facts["refused"] and facts["cells"] == []


def test_soft_strokes_of_a_small_cell_are_writing_and_a_shade_is_none():
    # blur of .4 mm in a cell of 12 mm that is enlarged to 320 pixels, after what sharpening gives back
    cell = np.full((320, 320), 255, np.uint8)
    cv2.line(cell, (70, 60), (250, 260), 0, 26)
    cv2.line(cell, (250, 60), (70, 260), 0, 26)
    surface = surface_of_cell(cv2.GaussianBlur(cell, (0, 0), 4.0))
    assert not isinstance(surface, np.ndarray)
    assert np.mean(surface.mask) == pytest.approx(np.mean(cell < 128), rel=0.05)
    shade = cv2.GaussianBlur(cell, (0, 0), 20.0)
    assert surface_of_cell(shade) is shade
