"""Recipes: what they make, that nuisances leave the writing where it is, and that they travel."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from rumu.gallery.starter import find_work
from rumu_lab.experiments.protocol import declared
from rumu_lab.experiments.simulated_copies import AtDegree, Disturbed, Faulty, Written

MASTER = find_work("regular-tian").path
COPY = Faulty(MASTER, "lean", 2, 11)
KINDS = declared().plain["nuisances"]["kinds"]


def dark(picture):
    gray = picture if picture.ndim == 2 else picture.mean(axis=2)
    return gray < 90


def test_recipes_travel_and_repeat_themselves():
    for recipe in (Written(MASTER), COPY, AtDegree(MASTER, "good", 11), Disturbed(COPY, "blur", 1.0)):
        assert pickle.loads(pickle.dumps(recipe)) == recipe
    np.testing.assert_array_equal(COPY.picture(), pickle.loads(pickle.dumps(COPY)).picture())


def test_a_written_copy_is_its_file():
    assert Written(MASTER).picture() == MASTER


@pytest.mark.parametrize("kind", KINDS, ids=[kind["name"] for kind in KINDS])
def test_a_nuisance_changes_the_picture_and_not_the_writing(kind):
    amount = tuple(kind["amount"]) if isinstance(kind["amount"], list) else kind["amount"]
    still = np.repeat(COPY.picture()[..., None], 3, axis=2)
    picture = Disturbed(COPY, kind["kind"], amount, 11).picture()
    assert picture.dtype == np.uint8 and picture.shape[2] == 3
    if kind["kind"] == "resolution":
        assert picture.shape[0] == amount
        assert dark(picture).mean() == pytest.approx(dark(still).mean(), rel=0.05)
        return
    assert (picture != still).any()
    both = (dark(picture) & dark(still)).sum() / (dark(picture) | dark(still)).sum()
    assert both > 0.9
