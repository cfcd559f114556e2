"""Every route for every role: the status of its response."""

from __future__ import annotations

import pytest

from rumu.database.tables import Attempt, Job, Task, new_id

ROLES = ("visitor", "周", "吳", "陳", "林", "館主")
"""Nobody; a pupil of another class; the pupil whose things these are; another teacher; theirs; the owner."""

OPEN = (200,) * 6
LOGIN = (401, 200, 200, 200, 200, 200)
OWN = (401, 404, 200, 404, 200, 200)  # what one pupil wrote
TEACH = (401, 403, 403, 200, 200, 200)
CLASS_TEACH = (401, 403, 403, 404, 200, 200)
OWNER = (401, 403, 403, 403, 403, 200)

ATTEMPT, TASK, CLASS = "/api/attempts/{attempt}", "/api/tasks/{task}", "/api/classes/{class}"

READING = {
    **dict.fromkeys(
        ("/", "/api/session", "/api/works", "/api/facets", "/api/collections", "/api/tours"), OPEN
    ),
    **dict.fromkeys(
        ("/api/works/regular-shui", "/api/works/regular-shui/files/thumb", "/api/openapi.json"), OPEN
    ),
    **dict.fromkeys(
        ("/api/docs", "/iiif/works/regular-shui/manifest.json", "/api/works/regular-shui/annotations"), OPEN
    ),
    **dict.fromkeys(("/api/attempts", "/api/practice", "/api/practice.csv", "/api/classes"), LOGIN),
    "/api/comparisons/next": LOGIN,
    **dict.fromkeys((ATTEMPT, f"{ATTEMPT}/picture", f"{ATTEMPT}/viewer", f"{ATTEMPT}/files/thumb"), OWN),
    "/api/practice?person={pupil}": OWN,
    "/api/practice.csv?person={pupil}": OWN,
    "/api/practice.pdf?work=regular-tian&person={pupil}": OWN,
    "/api/jobs/{job}": (401, 404, 200, 404, 404, 200),
    CLASS: OWN,
    TASK: OWN,
    f"{TASK}/marks.csv": (401, 403, 403, 404, 200, 200),
    f"{TASK}/marks.zip": (401, 403, 403, 404, 200, 200),
    "/api/marks.zip": TEACH,
    "/api/comparisons.csv": TEACH,
    "/api/people": OWNER,
}

CHANGING = {
    ("POST", "/api/classes", '{"name": "a"}'): (401, 403, 403, 201, 201, 201),
    ("POST", "/api/invitations", '{"role": "teacher"}'): (401, 403, 403, 403, 403, 201),
    ("POST", "/api/invitations", '{"role": "pupil", "class_id": "{class}"}'): (401, 403, 403, 404, 201, 201),
    ("POST", f"{CLASS}/tasks", '{"work": "regular-shui"}'): (401, 403, 403, 404, 201, 201),
    ("PATCH", CLASS, '{"name": "三年三班"}'): CLASS_TEACH,
    ("PUT", f"{ATTEMPT}/mark", '{"mark": 50}'): (401, 403, 403, 404, 200, 200),
    ("POST", "/api/works/regular-shui/annotations", '{"x": 0, "y": 0, "title": {"zh": "a"}}'): (
        *(*OWNER[:5], 201),
    ),
    ("POST", "/api/tours", '{"title": {"zh": "a"}, "steps": []}'): (*OWNER[:5], 201),
    ("PATCH", "/api/works/regular-shui", "{}"): OWNER,
    ("PATCH", "/api/people/{pupil}", '{"language": "en"}'): OWNER,
    ("DELETE", "/api/works/seal-none", ""): (*OWNER[:5], 404),
    ("PATCH", "/api/collections/starter", "{}"): OWNER,
    ("DELETE", "/api/collections/none", ""): (*OWNER[:5], 404),
    ("DELETE", f"{CLASS}/pupils/none", ""): (401, 403, 403, 404, 204, 204),
    ("POST", "/api/comparisons", '{"left": "none", "right": "none", "winner": "left"}'): (401, *[404] * 5),
    ("PATCH", "/api/session", '{"language": "en"}'): LOGIN,
}  # fmt: skip


@pytest.fixture(scope="module")
def browsers_and_ids(world, copy_of):
    """(a browser for each role, ids of a pupil's things)."""
    pupil = world.browser("吳")
    attempt = pupil.marked(copy_of()).json()["id"]
    ids = {
        "attempt": attempt,
        "class": world.ids["林班"],
        "pupil": world.ids["吳"],
        "task": new_id(),
        "job": new_id(),
    }
    with world.service.gallery.database.writing() as session:
        session.add(Task(id=ids["task"], class_id=ids["class"], work_id="regular-tian"))
        session.add(Job(id=ids["job"], kind="test", state="done", person_id=ids["pupil"]))
    return {role: world.browser(None if role == "visitor" else role) for role in ROLES}, ids


def fill(text, ids):
    for name, value in ids.items():
        text = text.replace(f"{{{name}}}", value)
    return text


@pytest.mark.parametrize("url", READING)
def test_reading(browsers_and_ids, url):
    browsers, ids = browsers_and_ids
    statuses = tuple(browsers[role]("GET", fill(url, ids)).status_code for role in ROLES)
    assert statuses == READING[url]


@pytest.mark.parametrize("change", CHANGING, ids=lambda change: " ".join(change[:2]))
def test_changing(browsers_and_ids, change):
    browsers, ids = browsers_and_ids
    method, url, body = change
    more = {"content": fill(body, ids), "headers": {"Content-Type": "application/json"}} if body else {}
    statuses = tuple(browsers[role](method, fill(url, ids), **more).status_code for role in ROLES)
    assert statuses == CHANGING[change]


def test_deleting_an_attempt(browsers_and_ids, world, copy_of):
    browsers, _ = browsers_and_ids
    url = f"/api/attempts/{browsers['吳'].marked(copy_of()).json()['id']}"
    statuses = [browsers[role]("DELETE", url).status_code for role in ("visitor", "周", "陳", "林", "吳")]
    assert statuses == [401, 404, 404, 403, 204]


def test_deleting_a_class(browsers_and_ids, world):
    browsers, _ = browsers_and_ids
    url = f"/api/classes/{browsers['林']('POST', '/api/classes', json={'name': 'a'}).json()['id']}"
    statuses = [
        browsers[role]("DELETE", url).status_code for role in ("visitor", "周", "吳", "陳", "林", "林")
    ]
    assert statuses == [401, 403, 403, 404, 204, 404]
    assert browsers["林"]("PATCH", url, json={"name": " "}).status_code == 422


def test_lists_hold_what_one_may_see_and_no_more(browsers_and_ids, world):
    browsers, ids = browsers_and_ids
    with world.service.gallery.database.reading() as session:
        assert session.query(Attempt).count() == 1
    statuses = [browsers[role]("GET", "/api/attempts").json()["total"] for role in ROLES[1:]]
    assert statuses == [0, 1, 0, 1, 1]
    classes = [len(browsers[role]("GET", "/api/classes").json()) for role in ("周", "吳")]
    assert classes == [1, 1]
    assert browsers["周"]("GET", f"/api/attempts?person={ids['pupil']}").json()["total"] == 0


def test_every_route_is_in_one_of_these_lists(world):
    """A new route must say who may use it."""
    import re

    listed = {re.sub(r"\?.*", "", url) for url in READING} | {url for _, url, _ in CHANGING}
    known = {
        re.sub(r"regular-shui|seal-none", "{work}", re.sub(r"\{\w+\}|none", "{x}", url)) for url in listed
    }
    plain = {re.sub(r"\{\w+\}", "{x}", url) for url in known}
    elsewhere = {  # in test_app, test_jobs and test_security
        *("/api/login", "/api/logout", "/api/password", "/api/invitations/{x}", "/api/marks", "/api/imports"),
        *(
            "/api/collections/{x}",
            "/api/works/{x}/viewer",
            "/api/works/{x}/annotations/{x}",
            "/api/tours/{x}",
        ),
        *(
            "/api/attempts/{x}/strokes",
            "/api/jobs/{x}/cancel",
            "/api/jobs/{x}/events",
            "/iiif/image/{x}/info.json",
        ),
        "/iiif/works/{x}/{x}",
        *("/iiif/collections/{x}.json", "/iiif/image/{x}/{x}/{x}/{x}/{x}", "/api/works/{x}/export.html"),
    }
    files = {"/api/works/{x}/files/{x}", "/api/attempts/{x}/files/{x}"}
    routes = {re.sub(r"\{\w+\}", "{x}", path) for path in world.app.openapi()["paths"]}
    plain = {re.sub(r"files/thumb$", "files/{x}", url) for url in plain}
    assert routes - plain - elsewhere - files == set()
