from dataclasses import replace

import numpy as np
import pytest

from rumu.errors import RumuError
from rumu.pages.sheet_layout import (
    CLEAR,
    GRIDS,
    HELPS,
    MARGIN,
    PAPERS,
    Box,
    SheetPage,
    lay_out,
    marker_boxes,
)


def overlap(a: Box, b: Box) -> bool:
    return (
        min(a.left + a.width, b.left + b.width) - max(a.left, b.left) > 1e-6
        and min(a.top + a.height, b.top + b.height) - max(a.top, b.top) > 1e-6
    )


@pytest.mark.parametrize("paper", PAPERS)
@pytest.mark.parametrize("cell", [12.0, 28.0, 45.0, 160.0])
@pytest.mark.parametrize("help_", HELPS)
def test_nothing_on_a_page_lies_over_anything_else(paper, cell, help_):
    times = 1 if cell == 160 and help_ in ("faint", "outlined", "none") else 0
    if cell == 160 and not times:
        pytest.skip("two such cells do not fit")
    for page in lay_out(
        SheetPage("永天人水書日月", "strokes", paper=paper, cell=cell, help=help_, times=times)
    ):
        markers = [
            Box(b.left - CLEAR, b.top - CLEAR, b.width + 2 * CLEAR, b.height + 2 * CLEAR)
            for b in marker_boxes(paper).values()
        ]
        boxes = [cell.box for cell in page.cells] + [box for _, box in page.labels]
        boxes += [page.code_box, page.name_box]
        for k, box in enumerate(boxes):
            assert not any(overlap(box, other) for other in [*boxes[k + 1 :], *markers])
            low, high = box.corners[0], box.corners[2]
            assert (low >= MARGIN - 1e-9).all() and (high <= np.array(page.size) - MARGIN + 1e-9).all()


def test_markers_stand_within_what_printers_can_print():
    for paper, size in PAPERS.items():
        corners = np.concatenate([box.corners for box in marker_boxes(paper).values()])
        assert corners.min() == MARGIN
        assert np.allclose(corners.max(axis=0), np.array(size) - MARGIN)
        assert MARGIN >= 6.35 and len(marker_boxes(paper)) == 12


def test_a_long_text_flows_over_pages_and_none_of_it_is_lost():
    text = "".join(chr(0x4E00 + k) for k in range(300))
    pages = lay_out(SheetPage(text, "strokes", times=2, cell=18, help="beside"))
    assert "".join(page.text for page in pages) == text
    assert [page.number for page in pages] == list(range(1, len(pages) + 1))
    assert {page.count for page in pages} == {len(pages)} and len({page.sheet for page in pages}) == 1
    for page in pages:
        assert all(
            sum(c.is_for_writing for c in page.cells[k : k + 3]) == 2 for k in range(0, len(page.cells), 3)
        )


def test_help_shrinks_from_the_full_master_to_none():
    (page,) = lay_out(SheetPage("永", "strokes", help="shrinking", times=6))
    assert [c.model for c in page.cells] == ["full", "faint", "faint", "dots", "dots", "none", "none"]
    assert [c.is_for_writing for c in page.cells] == [False] + 6 * [True]


def test_a_short_text_fills_the_page():
    (page,) = lay_out(SheetPage("永", "strokes"))
    assert len(page.cells) == page.rows * page.columns


def test_the_number_of_a_sheet_tells_texts_masters_and_layouts_apart_but_not_pupils():
    whole = SheetPage("永天", "strokes")
    others = [replace(whole, text="永人"), replace(whole, master="regular"), replace(whole, grid="tian")]
    numbers = {lay_out(one)[0].sheet for one in (whole, *others)}
    assert len(numbers) == 4
    assert lay_out(replace(whole, pupil="王小明"))[0].sheet == lay_out(whole)[0].sheet


@pytest.mark.parametrize(
    "wrong",
    [
        {"cell": 5},
        {"paper": "A3"},
        {"grid": "x"},
        {"help": "x"},
        {"text": ""},
        {"text": "a b"},
        {"pupil": 25 * "王"},
    ],
)
def test_a_page_that_cannot_be_is_refused(wrong):
    with pytest.raises(RumuError, match="expected"):
        SheetPage(**({"text": "永", "master": "strokes"} | wrong))


def test_cells_that_do_not_fit_are_refused():
    with pytest.raises(RumuError, match="fit on A4"):
        lay_out(SheetPage("永", "strokes", cell=150, times=40))


def test_all_grids_are_known():
    assert set(GRIDS) == {"mi", "nine", "tian", "hui", "none"}
