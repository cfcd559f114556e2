"""One thing that is good is said first, and it is true."""

from __future__ import annotations

import re

import pytest

from rumu.assessment.remarks import write_remarks
from rumu.strokes.correspondence import CopyStrokes
from rumu_lab.simulation.faults import FAULTS

WORK = "regular-shui"


@pytest.fixture(scope="session")
def praised(measured):
    def write(copy, master, **options):
        m = measured(copy, master)
        return write_remarks(CopyStrokes(m.copy, m.registration, m.master.stroke_model), **options)

    return write


def test_a_perfect_copy_is_praised_and_not_blamed(praised, mask):
    review = praised(mask(WORK), mask(WORK), framed=True)
    assert review.praise is not None
    assert review.remarks == review.untold == ()


@pytest.mark.parametrize("name", FAULTS)
def test_a_praise_is_a_sentence_in_both_languages(praised, fault, mask, name):
    praise = praised(fault(WORK, name, 5).mask, mask(WORK), framed=True).praise
    if praise is not None:
        assert re.search("[一-鿿]", praise.zh) and praise.zh.endswith("。")
        assert re.fullmatch(r"[ -~]+\.", praise.en)


@pytest.mark.parametrize(
    ("name", "never"), [("thick", "weight"), ("wobble", "edges"), ("small", "size"), ("off_centre", "size")]
)
def test_what_is_at_fault_is_not_praised(praised, fault, mask, name, never):
    praise = praised(fault(WORK, name, 5).mask, mask(WORK), framed=True).praise
    assert praise is None or never not in praise.en.lower()


def test_size_and_place_are_not_praised_of_a_free_photograph(praised, mask):
    praise = praised(mask(WORK), mask(WORK), framed=False).praise
    assert praise is not None and "size" not in praise.en.lower()
