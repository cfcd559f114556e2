"""Which character a master shows, where nobody has said it: asked of the characters whose strokes are known.

The outline's description finds the six that are most like it, the strokes of each are laid on the ink, and
the one that is like it, leaves little over and lies evenly is the answer. It is certain only when it stands
clear of the other five: a name that is wrong costs more than one that is not given.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.characters.stroke_data import CanonicalCharacter, find_character
from rumu.registration.descriptor import describe_canvas
from rumu.registration.points import Canvas
from rumu.strokes.canonical import lay_character
from rumu.strokes.centre_lines import FramedInk
from rumu.strokes.recognition_model import recognition_model


@dataclass(frozen=True, slots=True)
class RecognitionSettings:
    """How a character is recognised.

    candidates: how many of the most alike are laid on the ink. left_over, unevenness: what a laid character
        loses for what it leaves over and for lying unevenly, see `LaidCharacter`, in units of likeness.
    clear: by how much the best must stand clear of the next to be certain.
    """

    candidates: int = 6
    left_over: float = 1.0
    unevenness: float = 2.0
    clear: float = 0.12


RECOGNITION = RecognitionSettings()


@dataclass(frozen=True, slots=True)
class RecognisedCharacter:
    """The best answer. lead: by how much it stands clear of the next. fits: its strokes lie well."""

    character: CanonicalCharacter
    lead: float
    fits: bool

    @property
    def is_certain(self) -> bool:
        """Whether it may be named."""
        return self.fits and self.lead >= RECOGNITION.clear


def recognise(canvas: Canvas, framed: FramedInk) -> RecognisedCharacter | None:
    """The character that a master's ink shows; None where none was found.

    canvas, framed: the ink on the common canvas and in the common frame.
    """
    model = recognition_model()
    vector = model.project(describe_canvas(canvas.ink))
    likeness = model.vectors @ vector
    best = np.argpartition(-likeness, RECOGNITION.candidates)[: RECOGNITION.candidates]
    rated = []
    for k in best.tolist():
        known = find_character(chr(model.code_points[k]))
        if known is None:  # the stroke data were built from another edition than the model
            continue
        laid = lay_character(known, framed)
        lost = RECOGNITION.left_over * laid.left_over + RECOGNITION.unevenness * laid.unevenness
        rated.append((float(likeness[k]) - lost, laid))
    if len(rated) < 2:
        return None
    rated.sort(key=lambda pair: -pair[0])
    (first, laid), (second, _) = rated[:2]
    return RecognisedCharacter(laid.character, first - second, laid.is_confident)
