"""The facts of a mark: the matrix that lays the copy on the master, and the residual points."""

from __future__ import annotations

import json

import numpy as np
import pytest
from PIL import Image

from rumu import pipeline
from rumu.gallery.starter import find_work, starter_samples
from rumu.report.overlay import plane_points
from rumu.studio.marking import POINTS, alignment, in_cell, mark_facts, residual_facts


def array(image: Image.Image) -> np.ndarray:
    return np.asarray(image.convert("L"), dtype=np.float32) / 255


@pytest.fixture(scope="module")
def work():
    return find_work("regular-tian")


@pytest.fixture(scope="module")
def master(work):
    return Image.open(work.path)


def laid(matrix, xy):
    a, b, c, d, e, f = matrix
    x, y = np.asarray(xy).T
    return np.column_stack([a * x + c * y + e, b * x + d * y + f])


def test_the_matrix_undoes_what_was_done_to_the_copy(master):
    """Turned by 8 degrees, moved and shrunk, on a sheet of another shape: the matrix takes all of it back."""
    angle, scale = np.deg2rad(8.0), 0.8
    turn = scale * np.array(
        [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    )  # clockwise, y down
    back = np.linalg.inv(turn)
    middle, new_middle = np.array([256.0, 256.0]), np.array([330.0, 270.0])
    offset = middle - back @ new_middle
    copy = master.convert("L").transform(
        (640, 512), Image.Transform.AFFINE, (*back[0], offset[0], *back[1], offset[1]),
        resample=Image.Resampling.BICUBIC, fillcolor=255,
    )  # fmt: skip
    registration = pipeline.assess(array(copy), array(master)).registration
    points = np.array([[150, 200], [256, 256], [340, 300], [300, 180]], float)  # of the master, pixels
    on_copy = ((points - middle) @ turn.T + new_middle) / (640, 512)
    result = laid(alignment(registration), on_copy) * 512
    assert np.abs(result - points).max() < 2.0  # pixels of 512


def test_a_master_lies_on_itself(master):
    registration = pipeline.assess(array(master), array(master)).registration
    assert alignment(registration) == pytest.approx([1, 0, 0, 1, 0, 0], abs=2e-3)
    residuals = residual_facts(registration)
    assert max(r for side in residuals.values() for *_, r in side) < 0.02


def test_the_matrix_agrees_with_the_registration(master):
    sample = starter_samples(work="regular-tian")[2]
    registration = pipeline.assess(sample.path, array(master)).registration
    copy, _ = plane_points(registration)
    reference = registration.reference
    there = copy * reference.radius + reference.centre  # from the middle, y up, in fractions of a square cell
    expected = np.column_stack([there[:, 0] + 0.5, 0.5 - there[:, 1]])
    result = laid(alignment(registration), in_cell(registration.probe))
    assert np.abs(result - expected).max() < 1e-4


def test_points_lie_on_the_ink_and_are_few(master):
    registration = pipeline.assess(array(master), array(master)).registration
    residuals = residual_facts(registration)
    ink = array(master) < 0.5
    for side in residuals.values():
        assert 700 < len(side) <= POINTS
        x, y, r = np.array(side).T
        assert np.mean(ink[(y * 512).astype(int), (x * 512).astype(int)]) > 0.9
        assert r.min() >= 0 and r.max() <= 1


def test_missing_ink_has_the_largest_residuals_of_the_master(master):
    """The master without the end of its last stroke: the points farthest off are there."""
    cut = array(master).copy()
    columns = np.nonzero((cut < 0.5).any(axis=0))[0]
    edge = columns[int(0.85 * len(columns))]
    cut[:, edge:] = 1.0
    residuals = np.array(residual_facts(pipeline.register(cut, array(master)))["master"])
    worst = residuals[np.argsort(-residuals[:, 2])[:25]]
    assert np.mean(worst[:, 0] * 512 >= edge - 5) > 0.8 and worst[:, 2].min() > 0.3


def test_facts_are_json_and_in_both_languages(work):
    sample = starter_samples(work="regular-tian")[3]
    facts = mark_facts(pipeline.assess(sample.path, work.path, script="regular"), seconds=0.1)
    assert json.loads(json.dumps(facts, allow_nan=False)) == facts
    assert {part["name"] for part in facts["parts"]} == {"brushwork", "structure", "ink"}
    assert facts["remarks"] and facts["level_text"]["zh"] in "優良中差"
    for text in (*facts["parts"], *facts["remarks"], facts["source_text"]):
        assert text["zh"] and text["en"] and text["zh"] != text["en"]
    assert facts["source"] == ["inflation", "inflation"] and "not measured" in facts["source_text"]["en"]


def test_a_refusal_has_a_code(work):
    blank = np.full((200, 200), 1.0, np.float32)
    facts = mark_facts(pipeline.assess(blank, work.path), seconds=0.0)
    assert facts["score"] is None and facts["align"] is None and facts["pose"] is None
    assert facts["refused"]["code"] and facts["refused"]["zh"] and facts["refused"]["en"]
    assert not facts["refused"]["en"].startswith(facts["refused"]["code"])
