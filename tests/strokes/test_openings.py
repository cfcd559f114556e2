"""Boxes that the master closes and a copy leaves open."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

import rumu
from rumu.strokes.correspondence import CopyStrokes, match_strokes
from rumu.strokes.naming import direction_of
from rumu.strokes.openings import boxes_of, find_openings


def cut(mask, *, across, at=0.6):
    """日 with a gap in its lowest stroke; across: in pixels; at: its middle, as a share of the width."""
    left = mask.copy()
    rows, columns = np.nonzero(mask)
    middle = round(columns.min() + at * np.ptp(columns))
    left[int(rows.max() - 0.25 * np.ptp(rows)) :, middle - across // 2 : middle + across // 2] = False
    return left


@pytest.fixture(scope="module")
def openings(measured, mask):
    """What is open in a copy of 日, of which the character is known or not."""

    def find(copy, written="日"):
        m = measured(copy, mask("regular-ri"), written)
        model = m.master.stroke_model
        return find_openings(match_strokes(CopyStrokes(m.copy, m.registration, model)), model.whites)

    return find


def test_a_box_with_a_gap_is_open_by_the_width_of_the_gap(openings, mask):
    wide, narrow = (openings(cut(mask("regular-ri"), across=across)) for across in (48, 24))
    assert len(wide) == len(narrow) == 1
    assert wide[0].gap == pytest.approx(2 * narrow[0].gap, rel=0.15)
    assert 0.5 < wide[0].gap < 1.5
    columns = np.flatnonzero(mask("regular-ri").any(axis=0))
    assert wide[0].at[0] * 512 == pytest.approx(columns.min() + 0.6 * np.ptp(columns), abs=12)
    assert direction_of(wide[0].towards).zh in ("下", "右下")
    assert np.ptp(wide[0].outline * 512, axis=0) == pytest.approx(48, abs=14)


def test_a_closed_box_is_not_open(openings, mask):
    assert openings(mask("regular-ri")) == ()


def test_of_an_unknown_character_nothing_is_a_box(openings, mask):
    assert openings(cut(mask("regular-ri"), across=48), written="〇") == ()


def test_a_side_that_is_not_there_is_no_gap(openings, mask):
    assert openings(cut(mask("regular-ri"), across=300, at=0.5)) == ()


@pytest.mark.parametrize(
    ("character", "boxes"), [("口", [{1, 2, 3}]), ("合", [{4, 5, 6}]), ("令", []), ("人", []), ("〇", [])]
)
def test_boxes_are_those_that_a_copybooks_strokes_enclose(character, boxes):
    assert [set(box) for box in boxes_of(character)] == boxes


def test_an_open_box_is_told(tmp_path, mask):
    paths = tmp_path / "master.png", tmp_path / "copy.png"
    for path, ink in zip(paths, (mask("regular-ri"), cut(mask("regular-ri"), across=48)), strict=True):
        Image.fromarray(np.where(ink, 0, 255).astype(np.uint8)).save(path)
    remarks = rumu.assess(paths[1], paths[0], character="日").remarks
    (told,) = [remark for remark in remarks if remark.kind == "open"]
    assert "沒有封口" in told.zh and "is not closed" in told.en
    assert 0.05 < told.size < 0.14 and told.unit == "of the cell"
