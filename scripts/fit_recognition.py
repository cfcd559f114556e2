"""Make the model by which an unknown character is recognised: `python scripts/fit_recognition.py`.

Draws every character whose strokes are known, describes its outline, and writes the descriptions on their
principal axes to src/rumu/strokes/recognition.npz. No master and no copy is read.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from rumu.characters.stroke_data import find_character, known_characters
from rumu.registration.descriptor import describe_canvas
from rumu.registration.points import canvas_of
from rumu.strokes.recognition import fit_model
from rumu.values import BoolArray, FloatArray

ROOT = Path(__file__).parents[1]
SIDE, MARGIN, AXES = 160, 10, 96


def drawn(character: str) -> BoolArray:
    """(SIDE, SIDE) bool: a character as copybooks print it."""
    known = find_character(character)
    assert known is not None
    ink = np.zeros((SIDE, SIDE), np.uint8)
    for stroke in known.strokes:
        outline = stroke.polygon() * (SIDE - 2 * MARGIN) + MARGIN
        cv2.fillPoly(ink, [np.round(16 * outline).astype(np.int32)], 1, cv2.LINE_8, 4)
    return ink > 0


def described(characters: str) -> FloatArray:
    """(n, L) descriptions."""
    return np.array([describe_canvas(canvas_of(drawn(one)).ink) for one in characters])


if __name__ == "__main__":
    every = known_characters()
    code_points = np.array([ord(one) for one in every], np.uint32)
    model = fit_model(described(every), code_points, axes=AXES)
    np.savez_compressed(ROOT / "src/rumu/strokes/recognition.npz", **model)
