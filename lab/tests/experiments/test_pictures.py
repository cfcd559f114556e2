"""Figures 4 to 6: which copies are shown is a rule, and what is shown is said."""

from __future__ import annotations

from pathlib import Path

import pytest
from PIL import Image

from rumu.errors import OutputError
from rumu_lab.experiments import pictures
from rumu_lab.experiments.marked_copies import Copy

CUTS = {"excellent": 69.0, "good": 56.0, "medium": 41.0}


def copies(character, *marks):
    return [
        Copy(Path(f"{character}{m}.png"), Path(f"{character}.png"), character, float(m), (1.0,))
        for m in marks
    ]


def test_the_character_with_most_copies_that_has_all_levels():
    many = copies("甲", *range(42, 69, 2))
    some = copies("乙", 75, 71, 90, 60, 50, 30, 10)
    few = copies("丙", 75, 60, 50, 30)
    template, examples = pictures.four_levels([*many, *few, *some], CUTS)
    assert template == Path("乙.png")
    assert [(e.level, e.mark) for e in examples] == [
        *(("excellent", 75), ("good", 60), ("medium", 50), ("bad", 30))
    ]


def test_no_character_with_all_levels():
    assert pictures.four_levels(copies("甲", 75, 60, 50), CUTS) is None
    assert pictures.four_levels([], CUTS) is None


def test_without_data_the_copies_are_simulated_and_said_to_be(quick):
    found = pictures.run(quick)
    captions = [figure["en"] for figure in found.facts["figures"]]
    assert "starter work" in captions[0] and "nobody wrote" in captions[2]
    for figure in found.facts["figures"]:
        with Image.open(quick.out / figure["file"]) as picture:
            assert min(picture.size) > 250


def test_they_need_a_place(quick):
    from dataclasses import replace

    with pytest.raises(OutputError, match="-o"):
        pictures.run(replace(quick, out=None))
