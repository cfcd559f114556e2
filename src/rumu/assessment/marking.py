"""Features -> the mark, on the terms that a teacher sets: calibration, weights, levels, script."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rumu.assessment.calibration import (
    Calibration,
    Cuts,
    Weights,
    checked_cuts,
    checked_weights,
    level_of,
    load_calibration,
    panel,
)
from rumu.assessment.features import Features
from rumu.assessment.scripts import Note, Script, checked_script, interval_note, widening


@dataclass(frozen=True, slots=True)
class Terms:
    """How a copy is to be marked. None: the calibration that ships with rumu, the weights that were fitted
    with it, the panel's levels, a script that is not known."""

    calibration: Calibration | None = None
    weights: Weights | None = None
    cuts: Cuts | None = None
    script: Script | None = None


def checked_terms(
    *,
    calibration: Calibration | str | Path | None = None,
    weights: Mapping[str, float] | None = None,
    levels: Mapping[str, float] | None = None,
    script: str | None = None,
) -> Terms:
    """Terms as a person gives them. Raises CalibrationError that says what was expected."""
    return Terms(
        calibration=load_calibration(calibration) if isinstance(calibration, str | Path) else calibration,
        weights=None if weights is None else checked_weights(weights, name="weights"),
        cuts=None if levels is None else checked_cuts(levels, name="levels"),
        script=checked_script(script),
    )


def mark_fields(features: Features, *, terms: Terms, highest: float = 100.0) -> dict[str, Any]:
    """Those fields of an Assessment that follow from features and terms: the mark and what it rests on.

    highest: the mark that the copy may reach, 0-100; see `refusal.check_copy`.
    """
    calibration = terms.calibration or panel()
    score = min(calibration.score(features, weights=terms.weights), highest)
    notes = _notes(terms)
    return {
        "score": score,
        "level": level_of(score, cuts=terms.cuts),
        "interval": calibration.interval_of(
            score, widened=1.0 if terms.calibration else widening(terms.script)
        ),
        "parts": calibration.part_scores(features),
        "script": terms.script,
        "weights": terms.weights,
        "calibration": terms.calibration and terms.calibration.provenance,
        "interval_note": " ".join(note.en for note in notes) or None,
        "interval_note_zh": "".join(note.zh for note in notes) or None,
    }


_OWN_CALIBRATION = Note(
    "The interval holds for copies like those whose marks the calibration was fitted to.",
    "區間只適用於與校準所用相近的臨作。",
)
_OWN_WEIGHTS = Note(
    "The interval was measured for the fitted weights; with your own it is only a guide.",
    "區間按擬合的權重測得；換成自定的權重後僅供參考。",
)


def _notes(terms: Terms) -> list[Note]:
    of_script = _OWN_CALIBRATION if terms.calibration else interval_note(terms.script)
    return [note for note in (of_script, _OWN_WEIGHTS if terms.weights else None) if note]
