"""Make the model by which unknown characters are recognised: `python scripts/fit_recognition.py [DATA]`.

Draws every character whose strokes are known and describes its outline. How descriptions of one character
differ from hand to hand is taken from the steles of RUMU_DATA (masters/regular): what differs between hands
counts for less. How often characters are used is counted in the words of pypinyin. Writes
src/rumu/strokes/recognition.npz. No copy and no page is read.
"""

from __future__ import annotations

import csv
import os
import sys
from collections import Counter
from pathlib import Path

import cv2
import numpy as np
from pypinyin.phrases_dict import phrases_dict

from rumu.characters.stroke_data import find_character, known_characters
from rumu.registration.descriptor import describe_canvas
from rumu.registration.points import canvas_of
from rumu.strokes.recognition_model import fit_model
from rumu.values import BoolArray, FloatArray

ROOT = Path(__file__).parents[1]
SIDE, MARGIN, AXES = 160, 10, 160
FEWEST = 50  # pixels of ink of a stele's character


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


def written_by_hands(folder: Path, characters: str) -> tuple[FloatArray, list[int]]:
    """(m, L) descriptions of labelled pictures, and which of the characters each shows."""
    number = {character: k for k, character in enumerate(characters)}
    vectors, which = [], []
    with (folder / "labels.csv").open(encoding="utf-8", newline="") as stream:
        for row in csv.DictReader(stream):
            picture = cv2.imread(str(folder / row["file"]), cv2.IMREAD_GRAYSCALE)
            if row["character"] not in number or picture is None:
                continue
            dark = picture < 128
            ink = ~dark if dark.mean() > 0.5 else dark
            if np.count_nonzero(ink) >= FEWEST:
                vectors.append(describe_canvas(canvas_of(ink).ink))
                which.append(number[row["character"]])
    return np.array(vectors), which


def simplified_of() -> dict[str, str]:
    """Traditional characters with their simplified ones."""
    pairs = "".join((ROOT / "src/rumu/gallery/variants.txt").read_text(encoding="utf-8").split())
    return dict(zip(pairs[::2], pairs[1::2], strict=True))


def usage(characters: str, simplified: dict[str, str]) -> FloatArray:
    """(n,): logarithm of how often each stands in common words, also in its simplified form."""
    times = Counter(character for word in phrases_dict for character in word)
    both = [times[one] + times[simplified.get(one, "")] for one in characters]
    return np.log1p(both)


if __name__ == "__main__":
    data = Path(sys.argv[1] if len(sys.argv) > 1 else os.environ.get("RUMU_DATA", "../shared/data"))
    every, simplified = known_characters(), simplified_of()
    model = fit_model(
        described(every),
        *written_by_hands(data / "masters" / "regular", every),
        code_points=np.array([ord(one) for one in every], np.uint32),
        axes=AXES,
    )
    only_simplified = set(simplified.values()) - set(simplified)
    kinds = [2 if one in only_simplified else int(one in simplified) for one in every]
    model["usage"] = usage(every, simplified).astype(np.float16)
    model["reform"] = np.array(kinds, np.uint8)
    np.savez_compressed(ROOT / "src/rumu/strokes/recognition.npz", **model)
