from itertools import combinations

import numpy as np
import pytest

from rumu.card.layout import GRAYS, MARKERS, CardLayout
from rumu.pages.sheet_layout import PAPERS, marker_boxes


@pytest.mark.parametrize("paper", PAPERS)
def test_nothing_stands_on_anything_else_nor_beyond_the_paper(paper):
    layout = CardLayout(paper)
    (width, height), boxes = layout.size, layout.printed
    assert all(box.left >= 5 and box.top >= 5 for box in boxes)
    assert all(box.left + box.width <= width - 5 and box.top + box.height <= height - 5 for box in boxes)
    for one, other in combinations(boxes, 2):
        apart_x = max(one.left, other.left) - min(one.left + one.width, other.left + other.width)
        apart_y = max(one.top, other.top) - min(one.top + one.height, other.top + other.height)
        assert max(apart_x, apart_y) >= 0, (one, other)


def test_numbers_tell_cards_and_sheets_apart():
    cards = [set(CardLayout(paper).markers) for paper in PAPERS]
    assert all(len(one) == MARKERS for one in cards)
    assert not cards[0] & cards[1] and not (cards[0] | cards[1]) & set(marker_boxes("A4"))
    assert max(cards[0] | cards[1]) < 50  # of the dictionary


def test_every_gray_stands_twice_and_white_is_blank():
    layout = CardLayout("A4")
    assert sorted(patch.level for patch in layout.patches) == sorted([*range(len(GRAYS))] * 2)
    points = np.array([(4.0, 148.0), (22.0, 148.0), (13.5, 13.5), (105.0, 148.0), (1.0, 148.0)])
    assert layout.is_white(points).tolist() == [True, True, False, False, False]
