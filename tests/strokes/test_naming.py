"""What parts of strokes that bend are called, and what kind of stroke the advice for them is."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.characters.stroke_data import find_character
from rumu.strokes.centre_lines import CentreLine
from rumu.strokes.naming import canonical_kind, name_strokes


def line(*points: tuple[float, float], number: int) -> CentreLine:
    """A line through points, x right and y down, of a stroke with this number."""
    xy = np.array(points, dtype=float)
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(xy, axis=0).T))])
    return CentreLine(xy, np.ones(len(xy)), (True, True), np.ones(len(xy), bool), arc, number)


@pytest.mark.parametrize(
    ("character", "number", "legs", "name", "kind"),
    [
        # the right side of 田, which slants inward, is no left-falling stroke
        ("當", 10, [[(0, 0), (1, -0.1)], [(1, -0.1), (0.6, 0.8)]], "第十筆「橫折」的折段", "折"),
        # nor is that of 方, which ends in a hook and not in a tip
        (
            "方",
            3,
            [[(0, 0), (1, 0)], [(1, 0), (0.5, 1)], [(0.5, 1), (0.3, 0.8)]],
            "第三筆「橫折鉤」的折段",
            "折",
        ),
        ("田", 2, [[(0, 0), (1, 0)], [(1, 0), (1, 1)]], "第二筆「橫折」的豎段", "豎"),
        # that of 令 is one
        ("令", 4, [[(0, 0), (1, 0)], [(1, 0), (0.4, 0.6)]], "第四筆「橫撇」的撇段", "撇"),
        # a first part is what its name says, however it slants
        ("令", 4, [[(0, 0), (0.9, 0.5)], [(0.9, 0.5), (0.4, 0.9)]], "第四筆「橫撇」的撇段", "撇"),
    ],
)
def test_a_part_is_called_and_advised_as_what_it_is(
    character: str, number: int, legs: list[list[tuple[float, float]]], name: str, kind: str
) -> None:
    known = find_character(character)
    assert known is not None
    lines = [line(*points, number=number) for points in legs]
    assert name_strokes(lines, known)[1].zh == name
    second = canonical_kind(lines[1], lines, known)
    first = canonical_kind(lines[0], lines, known)
    assert second is not None and second.zh == kind
    assert first is not None and first.zh == "橫"


def test_a_stroke_whose_corner_was_not_seen_is_called_by_its_whole_name() -> None:
    known = find_character("暮")
    assert known is not None
    lines = [line((0, 0), (0.05, 0), number=12), line((0.05, 0), (1, 0.1), (1, 1), number=12)]
    assert name_strokes(lines, known)[1].zh == "第十二筆「橫折」"
    kind = canonical_kind(lines[1], lines, known)
    assert kind is not None and kind.zh == "橫折"  # and not a right-falling stroke, as its chord lies
