"""Photographs of one character through the service: what they show, and their cells without perspective."""

from __future__ import annotations

import io
import json

import cv2
import numpy as np
import pytest
from PIL import Image
from tests.written_sheets import encoded, written_sheet

CORNERS = [[140.0, 90.0], [480.0, 120.0], [520.0, 500.0], [100.0, 450.0]]


@pytest.fixture(scope="module")
def picture() -> bytes:
    """A printed cell from aside, its upper half dark within."""
    cell = np.full((300, 300, 3), 245, np.uint8)
    cell[60:150, 60:240] = 20
    cv2.rectangle(cell, (0, 0), (299, 299), (200, 60, 50), 4)
    square = np.array([[0, 0], [300, 0], [300, 300], [0, 300]], np.float32)
    matrix = cv2.getPerspectiveTransform(square, np.array(CORNERS, np.float32))
    desk = np.full((640, 640, 3), 235, np.uint8)
    return encoded(
        cv2.warpPerspective(cell, matrix, (640, 640), dst=desk, borderMode=cv2.BORDER_TRANSPARENT), "PNG"
    )


def asked(browser, url, picture, corners=None, **data):
    if corners is not None:
        data["corners"] = corners if isinstance(corners, str) else json.dumps(corners)
    return browser("POST", url, data=data, files={"picture": ("a.png", picture)})


def test_the_cell_is_flattened(world, picture):
    answer = asked(world.browser(), "/api/photographs/cell", picture, CORNERS)
    assert answer.status_code == 200 and answer.headers["content-type"] == "image/png"
    flat = np.asarray(Image.open(io.BytesIO(answer.content)).convert("L").resize((300, 300)))
    assert flat[70:140, 70:230].max() < 60 and flat[160:280, 20:280].min() > 200


def test_the_printed_cell_near_a_square_is_found(world, picture):
    square = [[100, 90], [510, 90], [510, 490], [100, 490]]
    found = asked(world.browser(), "/api/photographs", picture, square).json()
    assert found["sheet"] is False
    assert np.abs(np.array(found["cell"]) - CORNERS).max() < 8
    assert asked(world.browser(), "/api/photographs", picture).json() == {"sheet": False, "cell": None}
    square = [[220, 200], [400, 200], [400, 380], [220, 380]]  # around the writing
    for around, told in (("false", None), ("true", found["cell"])):
        again = asked(world.browser(), "/api/photographs", picture, square, around=around).json()
        assert (again["cell"] is None) == (told is None)
        assert told is None or np.abs(np.array(again["cell"]) - CORNERS).max() < 8


def test_a_practice_sheet_is_recognised(world):
    found = asked(world.browser(), "/api/photographs", encoded(written_sheet()), CORNERS).json()
    assert found == {"sheet": True, "cell": None}


@pytest.mark.parametrize(
    ("corners", "code"),
    [
        ("", "invalid"),
        ("[]", "corners"),
        ("x" * 300, "corners"),
        ("[" * 300, "corners"),
        ("[[0,0],[1e9,0],[9,9],[0,9]]", "corners"),
        ("[[0,0],[NaN,0],[90,90],[0,90]]", "corners"),
        ([[0, 0], [0, 200], [200, 200], [200, 0]], "unusable"),
    ],
)
def test_corners_that_are_none_are_told_in_both_languages(world, code_of, picture, corners, code):
    answer = asked(world.browser(), "/api/photographs/cell", picture, corners)
    assert answer.status_code == 422 and code_of(answer) == code
