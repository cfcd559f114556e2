"""Guided walks."""

from __future__ import annotations

import pytest

from rumu.errors import GalleryError
from rumu.gallery.tours import add_tour, change_tour, delete_tour, tour, tours

STEPS = [{"work": "seal-ri", "view": "tilt=90&slant=60", "title_zh": "日"}, {"work": "regular-ri"}]


def test_tours_are_made_changed_and_taken_back(gallery):
    shipped = [one.id for one in tours(gallery)]
    made = add_tour(gallery, {"title_zh": "日", "steps": STEPS})
    assert [one.id for one in tours(gallery)] == [*shipped, made.id]
    kept = tour(gallery, made.id)
    assert [step["work"] for step in kept.steps] == ["seal-ri", "regular-ri"]
    assert kept.steps[0]["view"] == "tilt=90&slant=60" and kept.steps[1]["text_en"] == ""
    change_tour(gallery, made.id, {"steps": STEPS[:1], "title_en": "Sun", "position": -1})
    assert tours(gallery)[0].id == made.id and len(tour(gallery, made.id).steps) == 1
    delete_tour(gallery, made.id)
    with pytest.raises(GalleryError, match="no tour"):
        tour(gallery, made.id)


@pytest.mark.parametrize(
    ("facts", "words"),
    [
        ({"steps": STEPS}, "to have a title"),
        ({"title_zh": "日", "steps": [{"work": "nothing"}]}, "there is no nothing"),
        ({"title_zh": "日", "steps": [{"view": "x"}]}, "expected a step with a work"),
        ({"title_zh": "日", "steps": [{"work": "seal-ri", "stray": 1}]}, "expected a step"),
        ({"title_zh": "日", "steps": [{"work": "seal-ri", "view": "x" * 1001}]}, "at most 1000"),
        ({"title_zh": "日", "steps": "seal-ri"}, "expected steps as a list"),
        ({"title_zh": "日", "steps": [{"work": "seal-ri"}] * 101}, "at most 100"),
        ({"title_zh": "日", "id": "x"}, "expected facts among"),
        ({"title_zh": 5}, "as a text"),
    ],
)
def test_other_facts_are_refused(gallery, facts, words):
    with pytest.raises(GalleryError, match=words):
        add_tour(gallery, facts)
    assert len(tours(gallery)) == 2


def test_a_tour_keeps_its_title(gallery):
    one = tours(gallery)[0]
    with pytest.raises(GalleryError, match="to have a title"):
        change_tour(gallery, one.id, {"title_zh": "", "title_en": " "})
    assert tour(gallery, one.id).title_zh == one.title_zh
