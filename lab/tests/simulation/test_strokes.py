"""Strokes of glyphs that are drawn here, so that it is known how many there are and where."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.errors import SurfaceError
from rumu.gallery.starter import find_work
from rumu_lab.simulation.ink import brush_depth
from rumu_lab.simulation.strokes import separate


def drawn(*strokes: tuple[tuple[float, float], tuple[float, float]], radius: float = 9.0) -> np.ndarray:
    """Straight strokes, each from one (row, column) to another, on a sheet of 200 x 200."""
    mask = np.zeros((200, 200), dtype=bool)
    for start, end in strokes:
        path = np.linspace(start, end, 300)
        mask |= brush_depth(mask.shape, path, np.full(300, radius)) > 0
    return mask


HORIZONTAL = ((100.0, 30.0), (100.0, 170.0))
VERTICAL = ((30.0, 100.0), (170.0, 100.0))


def test_a_cross_is_two_strokes_that_share_its_middle() -> None:
    strokes = separate(drawn(HORIZONTAL, VERTICAL))
    assert len(strokes) == 2
    lying, standing = sorted(strokes, key=lambda stroke: np.ptp(stroke.points[:, 0]))
    for stroke, line in ((lying, HORIZONTAL), (standing, VERTICAL)):
        alone = drawn(line)
        assert (stroke.ink & alone).sum() > 0.97 * alone.sum(), "a stroke keeps its ink through the crossing"
        assert (stroke.ink & ~alone).sum() < 0.05 * alone.sum()
        assert stroke.free == (True, True)
        assert np.median(stroke.radius) == pytest.approx(9.0, abs=1.0)


def test_a_stroke_that_ends_on_another_is_free_at_one_end_alone() -> None:
    strokes = separate(drawn(HORIZONTAL, ((100.0, 100.0), (180.0, 100.0))))
    assert len(strokes) == 2
    through, ending = strokes
    assert through.free == (True, True)
    assert sorted(ending.free) == [False, True]


def test_a_slanting_crossing_is_continued_straight() -> None:
    falling, rising = ((40.0, 30.0), (160.0, 170.0)), ((160.0, 30.0), (40.0, 170.0))
    strokes = separate(drawn(falling, rising))
    assert len(strokes) == 2
    slopes = [np.polyfit(s.points[:, 1], s.points[:, 0], 1)[0] for s in strokes]
    np.testing.assert_allclose(sorted(slopes), [-120 / 140, 120 / 140], atol=0.08)


def test_a_turning_is_two_strokes_and_a_gentle_curve_is_one() -> None:
    corner = separate(drawn(((40.0, 30.0), (40.0, 160.0)), ((40.0, 160.0), (170.0, 160.0))))
    assert len(corner) == 2
    t = np.linspace(0.0, np.pi / 2, 300)
    arc = np.stack([40 + 120 * np.sin(t), 40 + 120 * (1 - np.cos(t))], axis=1)
    mask = brush_depth((200, 200), arc, np.full(300, 8.0)) > 0
    assert len(separate(mask)) == 1


@pytest.mark.parametrize(
    ("work", "count"),
    [("seal-shui", 5), ("clerical-tian", 4), ("clerical-ren", 2), ("clerical-shui", 5), ("seal-ren", 2)],
)
def test_works_have_the_strokes_that_a_reader_counts(work: str, count: int) -> None:
    from PIL import Image

    mask = np.asarray(Image.open(find_work(work).path)) < 128
    strokes = separate(mask)
    large = [s for s in strokes if s.ink.sum() > 0.025 * mask.sum()]
    assert len(large) == count


def test_every_pixel_of_ink_belongs_to_a_stroke_and_no_paper_does() -> None:
    from PIL import Image

    mask = np.asarray(Image.open(find_work("running-shu").path).resize((256, 256))) < 128
    union = np.logical_or.reduce([s.ink for s in separate(mask)])
    np.testing.assert_array_equal(union, mask)


def test_ink_at_the_edge_and_a_single_dot_are_strokes_too() -> None:
    mask = np.zeros((60, 60), dtype=bool)
    mask[0:60, 20:32] = True
    assert len(separate(mask)) == 1
    dot = np.zeros((60, 60), dtype=bool)
    dot[30, 30] = True
    assert separate(dot)[0].ink.sum() == 1


def test_a_blank_sheet_has_no_strokes_to_find() -> None:
    with pytest.raises(SurfaceError, match="holds ink"):
        separate(np.zeros((20, 20), dtype=bool))
