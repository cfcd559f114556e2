"""Cells of sheets as copies of works: the same marks as those of the command, at the work's own places."""

from __future__ import annotations

import dataclasses
import json

import cv2
import numpy as np
import pytest
from tests.written_sheets import encoded, photograph, written_sheet

from rumu.errors import RumuError
from rumu.gallery.sheet_masters import SAME_PLACE, choose_masters
from rumu.gallery.starter import find_work
from rumu.pages.sheet_reading import locate_sheet, read_cells
from rumu.studio.errors import Unusable
from rumu.studio.pictures import UprightPicture
from rumu.studio.sheet_cells import mark_cells, marked_copy, png_of, read_sheet, work_of_master
from rumu.studio.sheet_marks import CellTask, assess_cell, cell_facts


@pytest.fixture(scope="module")
def written():
    """人 and 水 of the starter works, each in one cell."""
    sheet = locate_sheet(photograph(written_sheet(sources=("regular",))))
    return read_cells(sheet, choose_masters("人水", ("regular",)).shapes)


def test_marks_are_those_of_the_command(written):
    for cell in written:
        (copy,) = mark_cells("regular", cell.cell.character, [png_of(cell.picture)], calibration=None)
        mark, _ = assess_cell(CellTask(cell.picture, "regular", cell.cell.character, {}))
        told = cell_facts(mark)
        assert copy.facts["score"] == told["score"] and copy.facts["framed"] == "printed"
        assert [one["zh"] for one in copy.facts["remarks"]] == [one["zh"] for one in told["remarks"]]


def test_places_in_the_master_are_those_in_the_work(written, tmp_path, monkeypatch):
    """A work whose picture is wide, with the character small in a corner: points lie on its ink there."""
    monkeypatch.setenv("RUMU_HOME", str(tmp_path))
    shown = np.full((700, 900), 255, np.uint8)
    small = cv2.resize(cv2.imread(str(find_work("regular-shui").path), cv2.IMREAD_GRAYSCALE), (380, 380))
    shown[60:440, 150:530] = small
    cv2.imwrite(str(tmp_path / "水.png"), shown)
    master = choose_masters("水", (str(tmp_path / "水.png"),)).by_character["水"]
    cell = next(cell for cell in written if cell.cell.character == "水")
    without_a_stroke = cell.picture.copy()
    without_a_stroke[:, : round(0.42 * len(cell.picture))] = 255
    mark, _ = assess_cell(CellTask(without_a_stroke, "regular", "水", {}))
    picture = UprightPicture(b"", "png", *cell.picture.shape)
    moved = marked_copy(picture, mark, master, seconds=0)
    points = np.array([point[:2] for point in json.loads(moved.residual)["master"]])
    near = cv2.erode(shown, np.ones((9, 9), np.uint8))
    at = np.round(points * [900, 700]).astype(int)
    assert np.mean(near[at[:, 1], at[:, 0]] < 128) > 0.97
    told = (*moved.facts["remarks"], *moved.facts["untold"])
    lines = [point for one in told for line in one["master_outline"] for point in line]
    at = np.round(np.array(lines) * [900, 700]).astype(int)
    assert len(lines) > 10 and np.mean(near[at[:, 1], at[:, 0]] < 128) > 0.8
    same = dataclasses.replace(master, in_work=SAME_PLACE)
    unmoved = marked_copy(picture, mark, same, seconds=0)
    (sx, sy, tx, ty), matrix = master.in_work, unmoved.facts["align"]["matrix"]
    for x, y in ((0.2, 0.3), (0.7, 0.9)):
        a, b, c, d, e, f = matrix
        there = np.array([a * x + c * y + e, b * x + d * y + f]) * [sx, sy] + [tx, ty]
        a, b, c, d, e, f = moved.facts["align"]["matrix"]
        assert [a * x + c * y + e, b * x + d * y + f] == pytest.approx(there, abs=1e-4)


def test_a_refused_cell_is_a_copy_without_a_mark():
    (copy,) = mark_cells("strokes", "永", [png_of(np.full((200, 200), 255, np.uint8))], calibration=None)
    assert copy.facts["score"] is None and copy.facts["refused"]["code"] == "blank" and copy.residual is None


def test_what_is_no_sheet_says_so(tmp_path):
    from rumu.gallery.catalog import open_gallery

    gallery = open_gallery(database=tmp_path / "a.sqlite", files=tmp_path / "files", starter=False)
    with pytest.raises(Unusable) as refused:
        read_sheet(gallery, encoded(np.full((700, 600, 3), 230, np.uint8)))
    assert refused.value.code == "no_sheet" and "黑色方塊" in refused.value.zh
    found = read_sheet(gallery, encoded(written_sheet("永", cells=((0, 1),)), "PNG"))
    assert [cell.character for cell in found.cells] == ["永"] and found.facts["empty"] == 2
    master = choose_masters("永").by_character["永"]
    assert work_of_master(gallery, master) == found.works["永"]
    with pytest.raises(RumuError):
        work_of_master(gallery, dataclasses.replace(master, picture=np.full((512, 512), 255, np.uint8)))
