"""Counts of every choice."""

from __future__ import annotations

from rumu.gallery.catalog import change_work, works
from rumu.gallery.filters import Filters, count_facets


def counts(values) -> dict[str, int]:
    return {value.value: value.count for value in values}


def test_each_count_is_what_choosing_it_gives(gallery):
    change_work(gallery, "seal-ri", {"script": "", "hand_zh": "", "hand_en": "", "dynasty": "Tang"})
    found = count_facets(gallery, Filters())
    assert counts(found["script"]) == {
        "none": 1,
        "seal": 5,
        "clerical": 6,
        "regular": 9,
        "running": 10,
        "cursive": 8,
    }
    for name in ("script", "dynasty", "hand", "character", "collection"):
        for value in found[name]:
            assert works(gallery, **{name: value.value}).total == value.count, (name, value)


def test_a_choice_narrows_the_others_but_not_itself(gallery):
    found = count_facets(gallery, Filters(script="seal", query=["shui", "shu", "tian"][0]))
    assert counts(found["script"]) == dict.fromkeys(("seal", "clerical", "regular", "running", "cursive"), 1)
    assert counts(found["character"]) == {"水": 1}
    assert count_facets(gallery, Filters(query="nowhere"))["script"] == ()


def test_choices_are_named_in_both_languages(gallery):
    found = count_facets(gallery, Filters())
    assert {(v.zh, v.en) for v in found["collection"]} == {
        ("入門碑帖", "Starter gallery"),
        ("四家寫「永」「之」", "永 and 之 by four brush hands"),
        ("一塊模擬的碑", "A simulated stele"),
    }
    assert {(v.zh, v.en) for v in found["dynasty"]} == {("當代", "contemporary")}
