"""Whole works out to IIIF viewers: their text as annotations, a range for each character, a search."""

from __future__ import annotations

import json
import re

import pytest
from iiif_prezi3 import AnnotationPage, Manifest
from tests.gallery.pages import COLUMNS, ROWS, draw_page, page_text

from rumu.gallery.add_page import add_page
from rumu.gallery.iiif import collection_manifest, manifest
from rumu.gallery.iiif_text import search_text, search_text_1
from rumu.gallery.metadata import WorkMetadata
from rumu.gallery.whole_works import characters_within
from rumu.values import Bilingual

BASE = "https://example.org"


@pytest.fixture
def scroll(bare, tmp_path):
    draw_page().save(tmp_path / "leaf.png")
    metadata = WorkMetadata(title=Bilingual("習字卷", "Practice scroll"), script="regular")
    return add_page(bare, tmp_path / "leaf.png", text=page_text(), metadata=metadata).id


def box_of(target):
    """(canvas, x, y, width, height) of a target."""
    canvas, numbers = re.fullmatch(r"(.+)#xywh=([\d,]+)", target).groups()
    return canvas, *map(int, numbers.split(","))


def test_a_manifest_has_a_range_for_each_column_and_in_it_for_each_character(bare, scroll):
    found = manifest(bare, scroll, base=BASE)
    Manifest(**json.loads(json.dumps(found)))  # valid by the library
    (contents,) = found["structures"]
    assert [column["label"]["zh-Hant"][0] for column in contents["items"]] == page_text().splitlines()
    within = characters_within(bare, scroll)
    ranges = [one for column in contents["items"] for one in column["items"]]
    assert [one["label"]["zh-Hant"][0] for one in ranges] == [one.character for one in within]
    canvas = found["items"][0]
    for one in ranges:
        of, x, y, width, height = box_of(one["items"][0]["id"])
        assert of == canvas["id"] and min(width, height) > 20
        assert x + width <= canvas["width"] + 1 and y + height <= canvas["height"] + 1


def test_the_text_stands_as_annotations_on_its_places(bare, scroll):
    found = manifest(bare, scroll, base=BASE)
    (page,) = found["items"][0]["annotations"]
    assert "".join(one["body"]["value"] for one in page["items"]) == page_text().replace("\n", "")
    assert {one["motivation"] for one in page["items"]} == {"supplementing"}
    ids = [one["id"] for one in page["items"]]
    assert len(set(ids)) == COLUMNS * ROWS and all(name.startswith(f"{BASE}/iiif/works/") for name in ids)


def test_a_character_is_part_of_its_page_and_no_member_of_its_collection(bare, scroll):
    one = characters_within(bare, scroll)[0].id
    part_of = [part["id"] for part in manifest(bare, one, base=BASE)["partOf"]]
    assert part_of[0] == f"{BASE}/iiif/works/{scroll}/manifest.json"
    members = collection_manifest(bare, "own", base=BASE)["items"]
    assert [member["id"] for member in members] == [f"{BASE}/iiif/works/{scroll}/manifest.json"]
    assert "structures" not in manifest(bare, one, base=BASE)


def test_a_search_finds_words_also_across_columns(bare, scroll):
    found = search_text(bare, scroll, "水書日月天", base=BASE)
    AnnotationPage(
        **{name: value for name, value in json.loads(json.dumps(found)).items() if name != "@context"}
    )
    assert found["@context"] == "http://iiif.io/api/search/2/context.json"
    whole = page_text().replace("\n", "")
    count = len(re.findall("(?=水書日月天)", whole))
    contexts = found["annotations"][0]["items"]
    assert len(contexts) == count
    selector = contexts[0]["target"]["selector"][0]
    assert (selector["exact"], selector["prefix"], selector["suffix"]) == ("水書日月天", "天人", whole[7:15])
    assert [one["body"]["value"] for one in found["items"][:1]] == ["水書日月天"]  # within the first column
    parts = [one["body"]["value"] for one in found["items"]]
    assert "".join(parts) == "水書日月天" * count and len(parts) > count  # others go on in the next column
    sources = {one["id"] for one in found["items"]}
    assert {context["target"]["source"] for context in contexts} <= sources


def test_a_search_takes_other_forms_and_several_words(bare, scroll):
    texts = [one["body"]["value"] for one in search_text(bare, scroll, "书 月", base=BASE)["items"]]
    assert texts == ["書"] * page_text().count("書") + ["月"] * page_text().count("月")
    for nothing in ("", "  ，", "龍", "水水"):
        found = search_text(bare, scroll, nothing, base=BASE)
        assert found["items"] == [] and "annotations" not in found


def test_version_1_of_the_search_finds_the_same(bare, scroll):
    query = "水書日月天 月"
    found, old = (search(bare, scroll, query, base=BASE) for search in (search_text, search_text_1))
    assert [(one["@id"], one["resource"]["chars"], one["on"]) for one in old["resources"]] == [
        (one["id"], one["body"]["value"], one["target"]) for one in found["items"]
    ]
    assert old["within"]["total"] == len(old["resources"]) > len(old["hits"])
    selectors = [one["target"]["selector"][0] for one in found["annotations"][0]["items"]]
    assert [(hit["before"], hit["match"], hit["after"]) for hit in old["hits"]] == [
        (one["prefix"], one["exact"], one["suffix"]) for one in selectors
    ]
    named = [name for hit in old["hits"] for name in hit["annotations"]]
    assert named == [one["@id"] for one in old["resources"]]
    nothing = search_text_1(bare, scroll, "龍", base=BASE)
    assert nothing["resources"] == nothing["hits"] == [] and nothing["within"]["total"] == 0
