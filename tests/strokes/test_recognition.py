"""Which character a master shows: certain answers are right, and the rest are none."""

from __future__ import annotations

import csv
import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

import rumu
from rumu import pipeline
from rumu.gallery.starter import starter_works
from rumu.registration.points import canvas_of, ink_mask
from rumu.strokes.recognition import recognise
from rumu.strokes.recognition_model import recognition_model


def answer(surface):
    return pipeline.PreparedMaster(surface, recognised=True).canonical


@pytest.fixture(scope="module")
def script():
    path = Path(__file__).parents[2] / "scripts" / "fit_recognition.py"
    spec = importlib.util.spec_from_file_location("fit_recognition", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules["fit_recognition"] = module
    spec.loader.exec_module(module)
    return module


def test_most_starter_works_in_regular_script_are_known_and_none_is_wrong():
    works = [work for work in starter_works() if work.script == "regular"]
    answers = {work.character: answer(rumu.relief(work.path)) for work in works}
    right = [one for one, found in answers.items() if found is not None and found.character == one]
    assert [one for one, found in answers.items() if found is not None and found.character != one] == []
    assert len(right) >= 0.5 * len(works)


def test_certain_answers_on_steles_are_right(data):
    """Characters that took no part in choosing the settings; a variant form counts as the form it has."""
    folder = data / "masters" / "regular"
    with (folder / "labels.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    certain = right = 0
    for k in np.random.default_rng(20261129).choice(len(rows), 24, replace=False):
        found = answer(rumu.relief(folder / rows[k]["file"]))
        certain += found is not None
        right += found is not None and found.character == rows[k]["character"]
    assert certain >= 9 and right >= certain - 1


def test_what_is_no_character_is_not_named():
    rng = np.random.default_rng(0)
    picture = np.full((300, 300), 240, np.uint8)
    for _ in range(7):
        x, y = rng.integers(40, 240, 2)
        picture[y : y + rng.integers(8, 50), x : x + rng.integers(8, 50)] = 20
    assert answer(rumu.relief(picture)) is None


def test_a_given_character_is_not_asked_for(monkeypatch):
    monkeypatch.setattr(pipeline, "recognise", lambda *_: pytest.fail("asked"))
    work = next(work for work in starter_works() if work.id == "regular-shui")
    assert pipeline.prepare_master(work.path, character="水").canonical.character == "水"
    for script in (None, "seal", "clerical", "cursive"):
        assert pipeline.prepare_master(work.path, script=script).canonical is None
    assert pipeline.assess(work.path, work.path, remarks=False).character is None


def test_the_mark_says_what_the_master_is_taken_for():
    work = next(work for work in starter_works() if work.id == "regular-shui")
    assert rumu.assess(work.path, work.path, script="regular").character == "水"
    for script in (None, "seal"):
        assert rumu.assess(work.path, work.path, script=script).character is None


def test_characters_as_copybooks_print_them_are_found(script):
    """Also fails when descriptions were changed and `scripts/fit_recognition.py` was not run."""
    model = recognition_model()
    for one in "永天人水龍鬱凹飛":
        vector = model.project(script.described(one)[0])
        assert chr(model.code_points[(model.vectors @ vector).argmax()]) == one


def test_an_answer_has_a_lead_over_the_next():
    surface = rumu.relief(next(work for work in starter_works() if work.id == "regular-shui").path)
    master = pipeline.PreparedMaster(surface)
    found = recognise(canvas_of(ink_mask(surface)), master.stroke_model.framed)
    assert found.character.character == "水" and found.lead > 0 and found.is_certain
