"""Whole works in the service: a page sent with its text, its characters, and one character by all hands."""

from __future__ import annotations

import io

import pytest
from PIL import Image
from tests.gallery.museum import open_museum
from tests.gallery.pages import COLUMNS, ROWS, draw_page, packed, page_text

from rumu.gallery.iiif_import import import_manifest
from rumu.gallery.museum_web import FetchSettings, MuseumWeb

FACTS = {"title_zh": "習字卷", "script": "regular", "hand_zh": "書者", "dynasty": "Tang"}


def ended(browser, answer):
    """The job of an answer, once it has ended."""
    assert answer.status_code == 202, answer.text
    url = f"/api/jobs/{answer.json()['job']['id']}"
    with browser.client.stream("GET", f"{url}/events") as stream:
        for _ in stream.iter_lines():
            pass
    return browser("GET", url).json()


@pytest.fixture(scope="module")
def page(world):
    """The id of a page that a teacher sent."""
    teacher = world.browser("林")
    files = {"picture": ("leaf.png", packed(draw_page()))}
    answer = teacher("POST", "/api/pages", data=FACTS | {"text": page_text()}, files=files)
    job = ended(teacher, answer)
    assert job["state"] == "done", job
    assert job["result"]["added"] == 1 and str(ROWS * COLUMNS) in job["result"]["notes"][0]["en"]
    assert list(world.service.gallery.store.keys("uploads")) == []
    return job["result"]["work"]


def test_a_page_says_its_text_and_its_characters(world, page):
    visitor = world.browser()
    work = visitor("GET", f"/api/works/{page}").json()
    assert (work["characters"], work["text"]) == (ROWS * COLUMNS, page_text())
    assert (work["parent"], work["within"], work["record"]) == (None, None, None)
    found = visitor("GET", f"/api/works/{page}/characters").json()
    assert "".join(one["character"] for one in found) == page_text().replace("\n", "")
    assert [one["place"]["row"] for one in found[:ROWS]] == list(range(ROWS))
    assert all(0 <= value <= 1 for one in found for point in one["place"]["polygon"] for value in point)
    assert visitor("GET", "/api/works/regular-shui/characters").json() == []
    assert visitor("GET", "/api/home").json()["works"] == visitor("GET", "/api/works").json()["total"] == 40
    assert visitor("GET", "/api/works/none/characters").status_code == 404


def test_a_character_says_where_it_stands_and_is_a_work_as_others_are(world, page):
    visitor = world.browser()
    found = visitor("GET", f"/api/works/{page}/characters").json()
    third = visitor("GET", f"/api/works/{found[2]['id']}").json()
    same = [one["id"] for one in found if one["character"] == "水"]
    assert third["within"]["id"] == page and third["within"]["same"] == same
    assert third["within"]["place"] == found[2]["place"]
    assert (third["previous"], third["next"]) == (found[1]["id"], found[3]["id"])
    assert visitor("GET", f"/api/works/{third['id']}/viewer").status_code == 200
    thumb = Image.open(io.BytesIO(visitor("GET", third["thumb"]).content))
    assert max(thumb.size) <= 256


def test_a_character_of_a_page_is_a_master(world, page, copy_of):
    pupil = world.browser("吳")
    work = world.browser()("GET", f"/api/works?within={page}&character=水").json()["items"][0]["id"]
    marked = pupil.marked(copy_of("regular-shui"), work=work)
    assert marked.status_code == 201 and marked.json()["mark"]["score"] is not None


def test_a_list_says_how_many_characters_a_whole_work_has(world, page):
    listed = world.browser()("GET", "/api/works?q=習字卷").json()["items"]
    assert [(one["id"], one["characters"]) for one in listed] == [(page, ROWS * COLUMNS)]


def test_one_character_by_all_hands(world, page):
    found = world.browser()("GET", "/api/characters/水/works").json()
    assert [one["script"] for one in found["scripts"]] == [
        "seal",
        "clerical",
        "regular",
        "running",
        "cursive",
    ]
    regular = found["scripts"][2]["hands"]
    assert [(hand["time"]["zh"], hand["hand"]["zh"] == "書者") for hand in regular] == [
        ("唐", True),
        ("當代", False),
    ]
    assert len(regular[0]["works"]) == page_text().count("水")
    assert found["total"] == page_text().count("水") + 5
    assert world.browser()("GET", "/api/characters/龘/works").json()["total"] == 0


@pytest.mark.parametrize("text", ["", "  \n ", "永" * 20_001, "永\x00"])
def test_a_page_without_a_text_is_refused_at_once(world, text, code_of):
    teacher = world.browser("林")
    files = {"picture": ("leaf.png", packed(draw_page()))}
    answer = teacher("POST", "/api/pages", data={"text": text}, files=files)
    assert answer.status_code == 422
    assert list(world.service.gallery.store.keys("uploads")) == []


def test_a_picture_without_writing_fails_with_a_reason(world):
    teacher = world.browser("林")
    files = {"picture": ("blank.png", packed(Image.new("RGB", (400, 300), (240, 235, 220))))}
    job = ended(teacher, teacher("POST", "/api/pages", data={"text": "永"}, files=files))
    assert job["state"] == "failed" and job["error"]["zh"] and job["error"]["en"]


def test_an_owner_brings_in_nothing_from_the_inner_network(world):
    with open_museum(3) as museum:
        owner = world.browser("館主")
        for url in (f"{museum.base}/manifest.json", "http://169.254.169.254/latest/meta-data"):
            job = ended(owner, owner("POST", "/api/museums", json={"url": url}))
            assert job["state"] == "failed" and "inner network" in job["error"]["en"] and job["error"]["zh"]
        assert museum.asked.total() == 0
    for url in ("file:///etc/passwd", "manifest.json", "", "https://a.example/\x00"):
        assert owner("POST", "/api/museums", json={"url": url}).status_code == 422


def test_a_museums_work_says_where_it_is_from(world, tmp_path):
    gallery = world.service.gallery
    with open_museum(2) as museum:
        web = MuseumWeb(tmp_path, FetchSettings(pause=0.0, private=True), sleep=lambda seconds: None)
        done = import_manifest(gallery, f"{museum.base}/manifest.json", web=web)
        visitor = world.browser()
        listed = visitor("GET", f"/api/works?collection={done.collections[0]}").json()["items"]
        work = visitor("GET", f"/api/works/{listed[0]['id']}").json()
        assert work["record"]["label"]["zh-Hant"] == ["蘭亭帖"]
        assert work["record"]["canvas"] == museum.canvas_id(0)
        manifest = visitor("GET", f"/iiif/works/{work['id']}/manifest.json").json()
        assert manifest["provider"][0]["label"] == {"en": ["A Museum"]}
        assert manifest["rights"] == "http://creativecommons.org/publicdomain/zero/1.0/"


def test_the_text_of_a_page_can_be_searched_from_any_site(world, page):
    visitor = world.browser()
    url = f"/iiif/works/{page}/search"
    found = visitor("GET", f"{url}?q=水書", headers={"Origin": "https://mirador.example"})
    assert found.headers["access-control-allow-origin"] == "*"
    assert 'profile="http://iiif.io/api/search/2/context.json"' in found.headers["content-type"]
    assert [one["body"]["value"] for one in found.json()["items"]][:1] == ["水書"]
    assert visitor("HEAD", f"{url}?q=水").status_code == 200
    asked = visitor("OPTIONS", url, headers={"Origin": "https://a.example"})
    assert asked.status_code == 204 and "GET" in asked.headers["allow"]
    manifest = visitor("GET", f"/iiif/works/{page}/manifest.json").json()
    newer, older = manifest["service"]
    assert newer == {"id": f"http://testserver{url}", "type": "SearchService2"}
    assert older["@id"] == f"http://testserver{url}/1" and older["@type"] == "SearchService1"
    old = visitor("GET", f"{url}/1?q=水書", headers={"Origin": "https://mirador.example"})
    assert old.headers["access-control-allow-origin"] == "*"
    assert 'profile="http://iiif.io/api/search/1/context.json"' in old.headers["content-type"]
    assert old.json()["resources"][0]["resource"]["chars"] == "水書"
    part = manifest["structures"][0]["items"][0]["items"][0]["id"].removeprefix("http://testserver")
    assert visitor("GET", part).json()["label"] == {"zh-Hant": ["天"]}
    for name in ("search", "search/1"):
        assert visitor("GET", f"/iiif/works/none/{name}?q=a").status_code == 404
