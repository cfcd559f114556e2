"""The service as a person meets it, from the owner's link to the marks of a class."""

from __future__ import annotations

import csv
import io
import threading
import zipfile

import pytest
from PIL import Image
from starlette.testclient import TestClient
from tests.web.conftest import make_settings

from rumu.database.tables import Work
from rumu.studio.errors import Busy
from rumu.studio.job_handlers import add_samples
from rumu.studio.worker_pool import WorkerPool
from rumu.web.app import create_app
from rumu.web.responses import IMMUTABLE


@pytest.mark.parametrize(
    "url",
    [
        "/api/works",
        "/api/facets",
        "/api/collections",
        "/api/works/regular-shui",
        "/api/works/regular-shui/viewer",
        "/api/tours",
        "/iiif/collections/starter.json",
        "/iiif/works/regular-shui/manifest.json",
        "/",
    ],
)
def test_reading_is_open_and_what_is_known_is_not_sent_again(world, url):
    browser = world.browser()
    first = browser("GET", url)
    assert first.status_code == 200
    again = browser("GET", url, headers={"If-None-Match": first.headers["etag"]})
    assert (
        again.status_code == 304 and again.content == b"" and again.headers["etag"] == first.headers["etag"]
    )
    assert browser("GET", url, headers={"If-None-Match": '"other"'}).content == first.content


def test_works_are_found_and_lead_on(world):
    browser = world.browser()
    page = browser("GET", "/api/works?script=regular&character=水").json()
    assert [card["id"] for card in page["items"]] == ["regular-shui"] and page["total"] == 1
    work = browser("GET", "/api/works/regular-shui").json()
    assert work["next"] or work["previous"]
    for url in (*work["files"].values(), work["thumb"], work["thumb_normals"]):
        answer = browser("GET", url)
        assert answer.status_code == 200 and len(answer.content) > 50, url
    viewer = browser("GET", "/api/works/regular-shui/viewer").json()
    heights = browser("GET", viewer["heights"]["url"])
    assert len(heights.content) == 4 * viewer["heights"]["width"] * viewer["heights"]["height"]
    assert heights.headers["content-encoding"] == "gzip" and heights.headers["cache-control"] == IMMUTABLE
    assert viewer["source"] == "inflation" and "not measured" in viewer["source_text"]["en"]


def test_what_is_not_there(world, code_of):
    browser = world.browser()
    missing = (
        "/api/works/none",
        "/api/works/none/viewer",
        "/api/works/none/files/thumb",
        "/api/collections/none",
        "/api/tours/none",
        "/iiif/works/none/manifest.json",
        "/iiif/collections/none.json",
        "/iiif/image/none/info.json",
        "/api/invitations/0123456789ab",
        "/nowhere",
        "/api/nowhere",
    )
    for url in missing:
        assert (browser("GET", url).status_code, code_of(browser("GET", url))) == (404, "not_found"), url
    assert browser("GET", "/api/works/regular-shui/files/lamp-a").status_code == 422
    assert browser("GET", "/api/works?script=gothic").status_code == 422


def test_images_for_viewers_of_other_sites(world):
    browser = world.browser()
    part = "/iiif/image/regular-shui/square/64,/90/gray.png"
    first = browser("GET", part)
    assert first.status_code == 200 and first.headers["access-control-allow-origin"] == "*"
    assert browser("GET", part, headers={"If-None-Match": first.headers["etag"]}).status_code == 304
    assert browser("GET", "/iiif/image/regular-shui").headers["location"].endswith("/info.json")
    assert browser("GET", "/iiif/image/regular-shui/nonsense/max/0/default.jpg").status_code == 400
    facts = browser("GET", "/iiif/works/regular-shui/manifest.json").json()
    assert facts["id"] == "http://testserver/iiif/works/regular-shui/manifest.json"


def test_a_visitor_tries_and_nothing_is_kept(world, copy_of, code_of, tmp_path):
    browser = world.browser()
    answer = browser.marked(copy_of(), keep="false")
    body = answer.json()
    assert answer.status_code == 201 and body["id"] is None and body["picture"] is None
    assert body["mark"]["score"] and len(body["mark"]["residual"]["copy"]) > 500
    assert body["mark"]["align"]["matrix"][:1] != [0]
    assert code_of(browser.marked(copy_of())) == "login"
    assert world.browser("館主")("GET", "/api/attempts").json()["total"] == 0


def test_pictures_that_are_none_and_copies_that_are_refused(world, copy_of, code_of):
    browser = world.browser()
    assert code_of(browser.marked(b"no picture", keep="false")) == "no_picture"
    assert code_of(browser.marked(copy_of()[:3000], keep="false")) == "no_picture"
    assert code_of(browser.marked(copy_of(), keep="false", work="none")) == "not_found"
    body = browser.marked(copy_of(work="regular-shui"), keep="false", work="seal-tian").json()["mark"]
    assert body["refused"] is None or body["refused"]["zh"]
    import numpy as np

    blank = io.BytesIO()
    Image.fromarray(np.full((200, 200), 255, np.uint8)).save(blank, "PNG")
    body = browser.marked(blank.getvalue(), keep="false").json()["mark"]
    assert body["score"] is None and body["refused"]["code"] and body["refused"]["zh"]
    assert body["refused"]["turned_by"] is None


def test_a_photograph_on_its_side_is_refused_with_the_degrees_that_turn_it(world, copy_of):
    from PIL import Image

    with Image.open(io.BytesIO(copy_of(work="regular-shui"))) as page:
        on_its_side = io.BytesIO()
        page.transpose(Image.Transpose.ROTATE_90).save(on_its_side, "PNG")  # anticlockwise
    browser = world.browser("館主")
    attempt = browser.marked(on_its_side.getvalue(), work="regular-shui").json()
    assert attempt["mark"]["score"] is None and attempt["mark"]["refused"]["turned_by"] == 90
    assert attempt["mark"]["refused"]["code"] == "turned left" and "90" in attempt["mark"]["refused"]["en"]
    kept = browser("GET", f"/api/attempts/{attempt['id']}").json()
    assert kept["mark"]["refused"]["turned_by"] == 90


def test_a_copy_that_cannot_be_marked_is_kept_unless_the_request_says_no(new_world):
    world = new_world()
    pupil = world.browser("吳")
    blank = io.BytesIO()
    Image.new("L", (200, 200), 255).save(blank, "PNG")
    before = pupil("GET", "/api/attempts").json()["total"]
    answer = pupil.marked(blank.getvalue(), keep_unmarked="false").json()
    assert answer["id"] is None and answer["mark"]["refused"]["code"]
    assert pupil("GET", "/api/attempts").json()["total"] == before
    answer = pupil.marked(blank.getvalue()).json()
    assert answer["id"] and pupil("GET", "/api/attempts").json()["total"] == before + 1


def test_from_the_owner_s_link_to_the_marks_of_a_class(new_world, copy_of):
    world = new_world(people=False)
    token = world.service.owner_link().rsplit("/", 1)[1]
    owner = world.browser()
    assert not owner.facts["owner_exists"]
    assert owner("GET", f"/api/invitations/{token}").json()["role"] == "owner"

    def joins(browser, link, name):
        credentials = {"name": name, "password": "a long password"}
        answer = browser("POST", f"/api/invitations/{link.rsplit('/', 1)[-1]}", json=credentials)
        assert answer.status_code == 201, answer.text
        browser.facts = answer.json()
        return browser

    joins(owner, token, "館主")
    assert world.service.owner_link() is None and owner.facts["person"]["role"] == "owner"
    link = owner("POST", "/api/invitations", json={"role": "teacher"}).json()["link"]
    teacher = joins(world.browser(), link, "林")
    class_id = teacher("POST", "/api/classes", json={"name": "三年二班"}).json()["id"]
    link = teacher("POST", "/api/invitations", json={"role": "pupil", "class_id": class_id}).json()["link"]
    assert (
        world.browser()("GET", f"/api/invitations/{link.rsplit('/', 1)[1]}").json()["class"]["name"]
        == "三年二班"
    )
    pupil = joins(world.browser(), link, "吳")
    order = {"work": "regular-tian", "title": "天", "due": "2030-01-01T00:00:00+08:00"}
    task = teacher("POST", f"/api/classes/{class_id}/tasks", json=order).json()["id"]
    marks = [
        pupil.marked(copy_of(degree=degree), task=task, kind="pen", strokes="[[[1,2,0.5]]]", grid="mi").json()
        for degree in ("good", "bad")
    ]
    assert [mark["task"] for mark in marks] == [task, task]
    table = teacher("GET", f"/api/tasks/{task}").json()
    (row,) = table["rows"]
    assert (row["person"]["name"], row["attempts"], row["last"]) == ("吳", 2, marks[1]["mark"]["score"])
    assert (
        row["best"] == marks[0]["mark"]["score"] > row["last"]
        and table["common"][0]["count"] == 1
        and table["common"][0]["zh"]
    )
    given = teacher("PUT", f"/api/attempts/{marks[1]['id']}/mark", json={"mark": 77, "note": "好"})
    assert given.status_code == 200
    attempt = pupil("GET", f"/api/attempts/{marks[1]['id']}").json()
    assert attempt["teacher_marks"] == [{"teacher": "林", "mark": 77.0, "note": "好"}]
    assert attempt["mark"]["residual"]["master"]
    rows = list(
        csv.DictReader(
            io.StringIO(teacher("GET", f"/api/tasks/{task}/marks.csv").content.decode("utf-8-sig"))
        )
    )
    assert [(r["mark"], r["image"]) for r in rows] == [("77", f"copies/{marks[1]['id']}.png")]
    with zipfile.ZipFile(io.BytesIO(teacher("GET", f"/api/tasks/{task}/marks.zip").content)) as packed:
        assert set(packed.namelist()) == {"marks.csv", rows[0]["image"], rows[0]["reference"]}
    practice = pupil("GET", "/api/practice").json()
    assert practice["works"][0]["count"] == 2 and len(practice["works"][0]["curve"]) == 2
    assert teacher("GET", f"/api/practice?person={pupil.facts['person']['id']}").json()["works"]
    assert pupil("GET", "/api/practice.pdf?work=regular-tian").content[:5] == b"%PDF-"
    assert pupil("GET", "/api/practice.csv").text.count("\n") == 3
    for name in ("picture", "strokes", "viewer", "files/normals"):
        assert pupil("GET", f"/api/attempts/{marks[1]['id']}/{name}").status_code == 200
    assert pupil("DELETE", f"/api/attempts/{marks[0]['id']}").status_code == 204
    assert pupil("GET", "/api/attempts").json()["total"] == 1


def test_the_simulated_samples_are_judged(new_world):
    world = new_world()
    add_samples(world.service.gallery, storage=world.service.settings.storage)
    pupil = world.browser("吳")
    pair = pupil("GET", "/api/comparisons/next").json()
    assert pair["left"]["simulated"] and pair["right"]["kind"] == "simulated" and pair["left_over"] == 12
    verdict = {"left": pair["left"]["id"], "right": pair["right"]["id"], "winner": "left", "seconds": 3.5}
    assert pupil("POST", "/api/comparisons", json=verdict).status_code == 201
    assert pupil("POST", "/api/comparisons", json=verdict).status_code == 409
    table = world.browser("林")("GET", "/api/comparisons.csv").content.decode("utf-8-sig")
    (row,) = csv.DictReader(io.StringIO(table))
    assert (row["judge"], row["winner"], row["seconds"]) == (world.ids["吳"], "left", "3.5")
    assert (row["left"], row["right"], row["work"]) == (verdict["left"], verdict["right"], pair["work"]["id"])


def test_the_owner_changes_the_gallery(new_world):
    world = new_world()
    owner = world.browser("館主")
    body = {
        "x": 0.2,
        "y": 0.4,
        "title": {"zh": "起筆", "en": "Entry"},
        "text": {"zh": "逆鋒", "en": "against"},
    }
    annotation = owner("POST", "/api/works/regular-shui/annotations", json=body).json()
    url = f"/api/works/regular-shui/annotations/{annotation['id']}"
    assert owner("PATCH", url, json={"x": 0.5}).json()["title"]["zh"] == "起筆"
    assert owner("GET", "/api/works/regular-shui").json()["annotations"][-1]["x"] == 0.5
    assert owner("DELETE", url).status_code == 204
    step = {"work": "regular-shui", "view": "mode=sheet&tilt=45", "text": {"zh": "看", "en": "look"}}
    tour = owner("POST", "/api/tours", json={"title": {"zh": "遊", "en": "Walk"}, "steps": [step]}).json()
    assert tour["steps"][0]["view"] == step["view"] and tour["steps"][0]["text"]["zh"] == "看"
    assert owner("PATCH", f"/api/tours/{tour['id']}", json={"title": {"zh": "二", "en": "Two"}}).json()[
        "steps"
    ]
    assert owner("DELETE", f"/api/tours/{tour['id']}").status_code == 204
    changed = owner("PATCH", "/api/works/regular-shui", json={"title": {"zh": "水字", "en": "Water"}}).json()
    assert changed["title"] == {"zh": "水字", "en": "Water"}
    before = owner("GET", "/api/works").json()["total"]
    assert owner("DELETE", "/api/works/seal-tian").status_code == 204
    assert owner("GET", "/api/works").json()["total"] == before - 1


def test_the_size_of_a_pixel_is_given_and_taken_back(new_world, code_of):
    world = new_world()
    owner, url = world.browser("館主"), "/api/works/regular-shui"
    assert owner("GET", f"{url}/viewer").json()["unit"] == "px"
    assert owner("PATCH", url, json={"spacing": 0.25}).json()["spacing"] == 0.25
    assert owner("PATCH", url, json={"title": {"zh": "水", "en": "Water"}}).json()["spacing"] == 0.25
    assert owner("GET", f"{url}/viewer").json()["unit"] == "mm"
    assert owner("PATCH", url, json={"spacing": None}).json()["spacing"] is None
    assert owner("GET", f"{url}/viewer").json()["unit"] == "px"
    with world.service.gallery.database.writing() as session:
        session.get_one(Work, "regular-shui").kind = "capture"
    assert code_of(owner("PATCH", url, json={"spacing": 0.25})) == "spacing"
    assert owner("PATCH", url, json={"spacing": None}).status_code == 200  # as it is


def test_a_teacher_adds_a_work(new_world, copy_of):
    world = new_world()
    teacher = world.browser("林")
    facts = {"title_zh": "我的天", "character": "天", "script": "regular", "collection": "課堂"}
    answer = teacher("POST", "/api/works", data=facts, files={"picture": ("x", copy_of())})
    assert answer.status_code == 201, answer.text
    work = answer.json()
    assert work["title"] == {"zh": "我的天", "en": "我的天"} and work["collection_title"]["zh"] == "課堂"
    assert teacher("GET", work["thumb"]).status_code == 200
    assert teacher("POST", "/api/works", data=facts, files={"picture": ("x", b"<svg/>")}).status_code == 422
    assert (
        teacher("POST", "/api/works", data=facts, files={"picture": ("x.png", _blank())}).status_code == 422
    )


def _blank() -> bytes:
    import numpy as np

    stream = io.BytesIO()
    Image.fromarray(np.full((80, 80), 255, np.uint8)).save(stream, "PNG")
    return stream.getvalue()


def test_the_first_pages_come_while_the_workers_are_still_starting(tmp_path, monkeypatch):
    """A new gallery's first visitor waits neither for the workers nor for what a first page shows."""
    loaded = threading.Event()
    monkeypatch.setattr(WorkerPool, "start", lambda self, warm_up: loaded.wait(60))
    app = create_app(make_settings(tmp_path))
    with TestClient(app) as client:
        assert client.get("/").status_code == 200
        cover = client.get("/api/home").json()["cover"]
        found = client.get("/api/works?q=永").json()["items"]
        gathered = client.get("/api/characters/永/works").json()
        assert found and gathered
        monkeypatch.setattr(WorkerPool, "call", lambda *_, **__: pytest.fail("a worker was asked"))
        files = [cover["picture"], cover["normals"], *(card["thumb"] for card in found)]
        assert all(client.get(url).status_code == 200 for url in files)
        assert not loaded.is_set()
        loaded.set()


def test_a_service_that_ends_while_it_starts_runs_no_jobs(tmp_path, monkeypatch):
    begun = threading.Event()

    def start(pool, warm_up):
        begun.set()
        with pytest.raises(Busy):
            while True:
                pool.call(lambda storage: None)

    monkeypatch.setattr(WorkerPool, "start", start)
    app = create_app(make_settings(tmp_path))
    monkeypatch.setattr(app.state.service.runner, "start", lambda: pytest.fail("jobs were started"))
    with TestClient(app):
        assert begun.wait(60)
