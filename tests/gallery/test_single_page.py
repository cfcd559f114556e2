"""One work as one page."""

from __future__ import annotations

import base64
import gzip
import json
import re

import numpy as np
import pytest
from tests.gallery.conftest import surface

from rumu.errors import GalleryError
from rumu.gallery.annotations import add_annotation
from rumu.gallery.catalog import change_work
from rumu.gallery.seed import add_starter_works
from rumu.gallery.single_page import LARGEST, page_facts, single_page, write_page


@pytest.fixture
def gallery(bare):
    add_starter_works(bare)
    return bare


@pytest.fixture
def static(tmp_path):
    folder = tmp_path / "static"
    folder.mkdir()
    (folder / "standalone.js").write_text("const a = '</script><!--{}';", encoding="utf-8")
    (folder / "standalone.css").write_text("body{color:red}", encoding="utf-8")
    return folder


def told(page: str) -> dict:
    (text,) = re.findall(r'<script type="application/json" id="rumu-work">(.*?)</script>', page)
    return json.loads(text)


def test_a_page_holds_everything_and_asks_for_nothing(gallery, static):
    page = single_page(gallery, "regular-shui", static=static).decode()
    facts = told(page)
    viewer = facts["viewer"]
    for address in (viewer["heights"]["url"], *(viewer[n] for n in ("normals", "albedo", "picture", "mask"))):
        assert address.startswith("data:")
    assert not re.findall(r"""(?:src|href)=["']""", page)
    assert "://" not in page.split('id="rumu-work">')[0]
    assert len(page) < LARGEST / 2
    assert (viewer["width"], viewer["height"], viewer["source"]) == (512, 512, "inflation")
    heights = gzip.decompress(base64.b64decode(viewer["heights"]["url"].partition(",")[2]))
    assert np.array_equal(
        np.frombuffer(heights, "<f4").reshape(512, 512), surface(gallery, "regular-shui").height
    )


def test_texts_cannot_break_out_of_the_page(gallery, static):
    evil = "</script><script>alert(1)</script><!-- 'x' \"y\" &amp; {z}"
    change_work(gallery, "seal-ri", {"title_zh": evil, "title_en": evil, "source": evil})
    add_annotation(gallery, "seal-ri", {"x": 0.5, "y": 0.5, "text_zh": evil, "title_en": evil[:200]})
    page = single_page(gallery, "seal-ri", static=static).decode()
    assert told(page)["work"]["title"]["zh"] == evil
    assert told(page)["work"]["annotations"][-1]["text"]["zh"] == evil
    assert page.count("</script>") == 2 and "alert(1)</script>" not in page
    assert "<title>&lt;/script&gt;" in page


def test_the_facts_are_those_of_the_service(gallery):
    facts = page_facts(gallery, "regular-shui")
    assert {"id", "title", "hand", "licence", "attribution", "annotations", "collection_title"} <= set(
        facts["work"]
    )
    assert len(facts["work"]["annotations"]) == 4
    assert {"width", "height", "unit", "spacing", "heights", "normals", "three_lamps"} <= set(facts["viewer"])


def test_a_front_end_that_was_not_built_is_said(gallery, tmp_path):
    with pytest.raises(GalleryError, match=r"standalone\.js: expected the built front end.*npm"):
        single_page(gallery, "regular-shui", static=tmp_path)


def test_a_page_is_written_whole(gallery, static, tmp_path):
    size = write_page(gallery, "seal-ri", tmp_path / "page.html", static=static)
    assert (tmp_path / "page.html").stat().st_size == size
    with pytest.raises(GalleryError, match="no work"):
        write_page(gallery, "nothing", tmp_path / "none.html", static=static)
    assert not (tmp_path / "none.html").exists()
