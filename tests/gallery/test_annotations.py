"""What is said of points of a work."""

from __future__ import annotations

import pytest

from rumu.errors import GalleryError
from rumu.gallery.annotations import add_annotation, annotations_of, change_annotation, delete_annotation

WORK = "seal-ri"


def test_annotations_are_said_changed_and_taken_back(gallery):
    first = add_annotation(gallery, WORK, {"x": 0.25, "y": 0.5, "title_zh": "起筆", "text_en": "begins here"})
    second = add_annotation(gallery, WORK, {"x": 0, "y": 1, "text_zh": "收筆"})
    assert [one.id for one in annotations_of(gallery, WORK)] == [first.id, second.id]
    change_annotation(gallery, second.id, {"x": 0.5, "position": -1}, of=WORK)
    assert [(one.id, one.x) for one in annotations_of(gallery, WORK)] == [(second.id, 0.5), (first.id, 0.25)]
    delete_annotation(gallery, first.id)
    assert [one.id for one in annotations_of(gallery, WORK)] == [second.id]


@pytest.mark.parametrize(
    ("facts", "words"),
    [
        ({"y": 0.5, "text_zh": "x"}, "expected x and y"),
        ({"x": 1.01, "y": 0.5, "text_zh": "x"}, "fraction of the picture"),
        ({"x": float("nan"), "y": 0.5, "text_zh": "x"}, "expected x as a number"),
        ({"x": True, "y": 0.5, "text_zh": "x"}, "expected x as a number"),
        ({"x": "0.5", "y": 0.5, "text_zh": "x"}, "expected x as a number"),
        ({"x": 0, "y": 0}, "to say something"),
        ({"x": 0, "y": 0, "text_zh": "  "}, "to say something"),
        ({"x": 0, "y": 0, "text_zh": "x" * 5001}, "at most 5000 characters, got 5001"),
        ({"x": 0, "y": 0, "text_zh": None}, "expected text_zh as a text"),
        ({"x": 0, "y": 0, "text_zh": "x", "work_id": "y"}, "expected facts among"),
        ({"x": 0, "y": 0, "text_zh": "x", "position": "1"}, "whole number"),
    ],
)
def test_other_facts_are_refused(gallery, facts, words):
    before = len(annotations_of(gallery, WORK))
    with pytest.raises(GalleryError, match=words):
        add_annotation(gallery, WORK, facts)
    assert len(annotations_of(gallery, WORK)) == before


def test_annotations_belong_to_their_work(gallery):
    one = add_annotation(gallery, WORK, {"x": 0, "y": 0, "text_zh": "x"})
    for act in (
        lambda: change_annotation(gallery, one.id, {"x": 1}, of="seal-tian"),
        lambda: delete_annotation(gallery, one.id, of="seal-tian"),
        lambda: change_annotation(gallery, "nothing", {"x": 1}),
        lambda: delete_annotation(gallery, "nothing"),
    ):
        with pytest.raises(GalleryError, match="no annotation"):
            act()
    for act in (
        lambda: annotations_of(gallery, "nothing"),
        lambda: add_annotation(gallery, "no", {"x": 0, "y": 0, "text_zh": "x"}),
    ):
        with pytest.raises(GalleryError, match="no work"):
            act()
    with pytest.raises(GalleryError, match="to say something"):
        change_annotation(gallery, one.id, {"text_zh": ""})
    assert annotations_of(gallery, WORK)[-1].text_zh == "x"
