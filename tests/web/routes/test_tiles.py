"""The routes of tiles: what is sent, how long it may be kept, and what there is none of."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image
from tests.gallery.pages import draw_page, packed

WORK = "/api/works"


@pytest.fixture(scope="module")
def page() -> bytes:
    """A drawn page, twice as large."""
    return packed(Image.fromarray(np.asarray(draw_page()).repeat(2, axis=0).repeat(2, axis=1)))


@pytest.fixture
def sent(world, page):
    """(a visitor, the id of a page of more than 1024 pixels)."""
    answer = world.browser("林")("POST", WORK, data={"title_zh": "卷"}, files={"picture": ("a.png", page)})
    assert answer.status_code == 201, answer.text
    return world.browser(), answer.json()["id"]


def test_the_viewer_is_told_of_the_tiles_and_they_come(sent, page):
    browser, work_id = sent
    tiles = browser("GET", f"{WORK}/{work_id}/viewer").json()["tiles"]
    for name, kind in (("albedo", "jpg"), ("normals", "png")):
        answer = browser("GET", f"{tiles[name]}/info.json?v={tiles['version']}")
        assert answer.headers["content-type"].startswith("application/ld+json")
        info = answer.json()
        assert info["id"].endswith(f"/iiif/tiles/{name}/{work_id}") and info["profile"] == "level0"
        assert (info["width"], info["height"]) == Image.open(io.BytesIO(page)).size
        url = f"{tiles[name]}/0,0,512,512/512,512/0/default.{kind}"
        answer = browser("GET", f"{url}?v={tiles['version']}")
        assert Image.open(io.BytesIO(answer.content)).size == (512, 512)
        assert (
            "immutable" in answer.headers["cache-control"] and answer.headers["access-control-allow-origin"]
        )
        assert browser("GET", url).headers["cache-control"] == "public, max-age=86400"
        again = browser("GET", url, headers={"If-None-Match": answer.headers["etag"]})
        assert again.status_code == 304 and not again.content


def test_viewers_that_know_jpeg_alone_get_the_whole_of_every_map(sent):
    browser, work_id = sent
    for name in ("albedo", "normals"):
        info = browser("GET", f"/iiif/tiles/{name}/{work_id}/info.json").json()
        whole = Image.open(
            io.BytesIO(browser("GET", f"/iiif/tiles/{name}/{work_id}/full/max/0/default.jpg").content)
        )
        assert whole.format == "JPEG" and whole.size == tuple(info["sizes"][0].values())
    assert browser("GET", f"/iiif/tiles/albedo/{work_id}").headers["location"].endswith("info.json")


def test_the_image_service_sends_the_same_tiles_once_they_are_made(sent):
    browser, work_id = sent
    name = "512,0,512,512/512,512/0/default.jpg"
    assert browser("GET", f"/iiif/image/{work_id}/{name}").status_code == 200  # made of the picture
    tile = browser("GET", f"/iiif/tiles/albedo/{work_id}/{name}").content
    assert browser("GET", f"/iiif/image/{work_id}/{name}").content == tile
    turned = browser("GET", f"/iiif/image/{work_id}/512,0,512,512/512,512/90/gray.png")
    assert Image.open(io.BytesIO(turned.content)).mode == "L"


@pytest.mark.parametrize(
    "name",
    [
        "0,0,512,512/511,512/0/default.jpg",
        "9,0,512,512/512,512/0/default.jpg",
        "0,0,512,512/512,512/90/default.jpg",
        "0,0,512,512/512,512/0/default.gif",
        "0,0,512,512/512,512/0/書.jpg",
        "info.json/a/0/default.jpg",
    ],
)
def test_what_is_no_tile_is_not_found(sent, name, code_of):
    browser, work_id = sent
    answer = browser("GET", f"/iiif/tiles/albedo/{work_id}/{name}")
    assert answer.status_code == 404 and code_of(answer) == "not_found"


@pytest.mark.parametrize("work_id", ["none", "regular-shui"])
def test_no_work_and_a_small_work_have_no_tiles(world, work_id, code_of):
    browser = world.browser()
    answer = browser("GET", f"/iiif/tiles/normals/{work_id}/info.json")
    assert answer.status_code == 404 and code_of(answer) == "not_found"
    assert browser("GET", f"/iiif/tiles/slopes/{work_id}/info.json").status_code == 422
    if work_id != "none":
        assert browser("GET", f"{WORK}/{work_id}/viewer").json()["tiles"] is None


def test_a_picture_has_no_photographs_in_tiles(sent, code_of):
    browser, work_id = sent
    tiles = browser("GET", f"{WORK}/{work_id}/viewer").json()["tiles"]
    assert set(tiles) == {"albedo", "normals", "heights", "version"}
    for name in ("picture", "lamp-a"):
        answer = browser("GET", f"/iiif/tiles/{name}/{work_id}/info.json")
        assert answer.status_code in (404, 422), answer.text
        assert "photographs" in answer.json()["error"]["en"]
