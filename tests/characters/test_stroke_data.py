"""Strokes of characters as copybooks print them: order, names, shape, and how parts are arranged."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from rumu.characters import stroke_data
from rumu.characters.stroke_data import find_character, known_characters
from rumu.errors import RumuError


def names(character: str) -> list[str]:
    return [stroke.name.zh for stroke in find_character(character).strokes]


@pytest.mark.parametrize(
    ("character", "expected"),
    [
        ("永", "點 橫折鉤 橫撇 撇 捺"),
        ("人", "撇 捺"),
        ("方", "點 橫 橫折鉤 撇"),
        ("心", "點 臥鉤 點 點"),
        ("書", "橫折 橫 橫 橫 豎 橫 豎 橫折 橫 橫"),  # traditional: named by the shape of its strokes
        ("當", "豎 點 撇 點 橫鉤 豎 橫折 橫 豎 橫折 橫 豎 橫"),
        ("寧", "點 點 橫鉤 點 臥鉤 點 點 豎 橫折 豎 撇 橫 橫 豎鉤"),
        ("九", "撇 橫折彎鉤"),
        ("四", "豎 橫折 撇 豎彎 橫"),
        ("山", "豎 豎折 豎"),
        ("陳", "橫撇彎鉤 豎 橫 豎 橫折 橫 橫 豎 撇 捺"),
        ("乃", "橫折折折鉤 撇"),
        ("傳", "撇 豎 橫 豎 橫折 橫 橫 豎 提 點 橫 豎鉤 點"),  # a vertical that was called a horizontal
        ("黃", "橫 豎 豎 橫 橫 豎 橫折 橫 豎 橫 撇 點"),  # and the other way round
        ("說", "點 橫 橫 橫 豎 橫折 橫 點 撇 豎 橫折 橫 撇 豎彎鉤"),  # a horizontal that was said to rise
        ("地", "橫 豎 提 橫折鉤 豎 豎彎鉤"),  # one that does rise
        ("銘", "撇 點 橫 橫 豎 點 撇 提 撇 橫撇 點 豎 橫折 橫"),  # the side of a box that was called a dot
        ("會", "撇 捺 橫 豎 橫折 豎 點 撇 橫 豎 橫折 橫 橫"),  # a straight stroke that was said to bend
    ],
)
def test_strokes_are_named_in_the_order_of_writing(character, expected):
    assert " ".join(names(character)) == expected


def test_no_straight_stroke_is_named_against_its_direction():
    wrong = []
    for character in known_characters()[::23]:
        for stroke in find_character(character).strokes:
            right, down = stroke.centre_line[-1] - stroke.centre_line[0]
            length = np.hypot(*np.diff(stroke.centre_line, axis=0).T).sum()
            if np.hypot(right, down) < 0.95 * length:
                continue
            if {"橫": abs(down) > right, "豎": down < abs(right)}.get(stroke.name.zh, False):
                wrong.append((character, stroke.name.zh))
    assert not wrong


@pytest.mark.parametrize(
    ("character", "structure"),
    [
        ("水", "single"),
        ("明", "left-right"),
        ("銘", "left-right"),
        ("寧", "top-bottom"),
        ("風", "half-enclosed"),
        ("国", "enclosed"),
        ("街", "left-middle-right"),
        ("後", "left-right"),  # though 后, which stands for it, encloses
        ("東", None),  # 东 tells nothing of it
    ],
)
def test_the_arrangement_of_parts_is_known(character, structure):
    assert find_character(character).structure == structure


@pytest.mark.parametrize(
    ("character", "border"),
    [("銘", 8), ("寧", 3), ("暮", 10), ("想", 9), ("行", None), ("聞", 8), ("哀", None)],
)
def test_it_is_known_where_the_radical_ends_or_begins(character, border):
    assert find_character(character).radical_border == border


def test_at_least_nine_thousand_are_known_in_both_forms():
    known = known_characters()
    assert len(known) >= 9000
    assert set("永書书當当寧宁風风得德傳传銘铭說说") <= set(known)


@pytest.mark.parametrize("text", ["", "a", "永天", "🖌", "\ufffd", "\U0003134a"])
def test_of_anything_else_nothing_is_known(text):
    assert find_character(text) is None


def test_a_hundred_characters_lie_in_their_square_and_their_lines_within_their_outlines():
    off = []
    for character in known_characters()[::97]:
        found = find_character(character)
        assert found.strokes
        for stroke in found.strokes:
            polygon = stroke.polygon()
            assert len(stroke.centre_line) >= 2
            assert min(polygon.min(), stroke.centre_line.min()) > -0.1
            assert max(polygon.max(), stroke.centre_line.max()) < 1.1
            edge = (1000 * polygon).astype(np.float32)
            off += [
                cv2.pointPolygonTest(edge, (float(1000 * x), float(1000 * y)), True)
                for x, y in stroke.centre_line[1:-1]
            ]
    assert np.mean(np.array(off) > -8) > 0.99  # thousandths of the square


def test_the_first_horizontal_runs_to_the_right_and_the_vertical_down():
    horizontal, vertical = (s.centre_line[-1] - s.centre_line[0] for s in find_character("十").strokes)
    assert horizontal[0] > 0.5
    assert abs(horizontal[1]) < 0.15
    assert vertical[1] > 0.5
    assert abs(vertical[0]) < 0.1


def test_an_outline_is_a_closed_path():
    path = find_character("一").strokes[0].svg_path(side=100)
    assert path.startswith("M ")
    assert path.rstrip().endswith("Z")
    assert {word for word in path.split() if word.isalpha()} <= set("MLQCZ")


def test_a_package_that_was_not_built_says_so(monkeypatch, tmp_path):
    monkeypatch.setattr(stroke_data, "files", lambda package: tmp_path)
    stroke_data._read_index.cache_clear()
    with pytest.raises(RumuError, match="scripts/install"):
        find_character("永")
    (tmp_path / "strokes.bin").write_bytes(b"something else")
    with pytest.raises(RumuError, match="got another file"):
        find_character("永")
    monkeypatch.undo()
    stroke_data._read_index.cache_clear()
