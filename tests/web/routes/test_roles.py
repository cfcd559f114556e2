"""Every route for every role: the status of its response; no route for other sites, and none to a file."""

from __future__ import annotations

import re

import pytest

from rumu.database.tables import Attempt, Job, SheetUpload, Task, new_id

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
    **dict.fromkeys(
        ("/api/collections/starter", "/api/works/regular-shui/viewer", "/api/tours/{tour}"), OPEN
    ),
    **dict.fromkeys(("/api/invitations/{token}", "/api/characters/永", "/api/home"), OPEN),
    **dict.fromkeys(("/api/works/regular-shui/characters", "/api/characters/永/works"), OPEN),
    "/iiif/works/regular-shui/search?q=永": OPEN,
    "/iiif/works/regular-shui/search/1?q=永": OPEN,
    **dict.fromkeys(("/share/works/regular-shui", "/embed/works/regular-shui"), OPEN),
    "/share/collections/starter": OPEN,
    **dict.fromkeys(
        ("/iiif/works/regular-shui/canvas", "/iiif/collections/starter.json", "/api/invitations/{token}"),
        OPEN,
    ),
    **dict.fromkeys(
        ("/iiif/image/regular-shui/info.json", "/iiif/image/regular-shui/full/64,/0/default.jpg"), OPEN
    ),
    **dict.fromkeys(  # there are none of so small a work
        (
            "/iiif/tiles/albedo/regular-shui/info.json",
            "/iiif/tiles/normals/regular-shui/full/max/0/default.jpg",
        ),
        (404,) * 6,
    ),
    **dict.fromkeys(("/api/attempts", "/api/practice", "/api/practice.csv", "/api/classes"), LOGIN),
    **dict.fromkeys(
        ("/api/practice-sheet?text=水", "/api/practice-sheet.png?text=水", "/api/practice-sheet.pdf?text=水"),
        OPEN,
    ),
    "/api/practice-sheet?works=regular-shui": LOGIN,
    "/api/practice-sheet.pdf?text=水&class={class}": CLASS_TEACH,
    "/api/sheets": LOGIN,
    "/api/sheets/{upload}": OWN,
    **dict.fromkeys(
        ("/api/sheets/{upload}/marks.csv", "/api/sheets/{upload}/cells/0/0/0"), (401, *[404] * 5)
    ),
    "/api/comparisons/next": LOGIN,
    **dict.fromkeys((ATTEMPT, f"{ATTEMPT}/picture", f"{ATTEMPT}/viewer", f"{ATTEMPT}/files/thumb"), OWN),
    f"{ATTEMPT}/strokes": OWN,
    "/api/practice?person={pupil}": OWN,
    "/api/practice.csv?person={pupil}": OWN,
    "/api/practice.pdf?work=regular-tian&person={pupil}": OWN,
    **dict.fromkeys(("/api/jobs/{job}", "/api/jobs/{job}/events"), (401, 404, 200, 404, 404, 200)),
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
    ("PUT", "/api/home", '{"work": null}'): OWNER,
    ("PATCH", "/api/people/{pupil}", '{"language": "en"}'): OWNER,
    ("DELETE", "/api/works/seal-none", ""): (*OWNER[:5], 404),
    ("PATCH", "/api/collections/starter", "{}"): OWNER,
    ("PUT", "/api/collections/starter/order", '{"works": []}'): (*OWNER[:5], 204),
    ("DELETE", "/api/collections/none", ""): (*OWNER[:5], 404),
    ("DELETE", f"{CLASS}/pupils/none", ""): (401, 403, 403, 404, 204, 204),
    ("POST", "/api/comparisons", '{"left": "none", "right": "none", "winner": "left"}'): (401, *[404] * 5),
    ("PATCH", "/api/session", '{"language": "en"}'): LOGIN,
    ("POST", "/api/login", '{"name": "nobody", "password": "wrong password"}'): (401,) * 6,
    ("POST", "/api/password", '{"old": "wrong", "new": "quite another one"}'): (401, *[403] * 5),
    ("POST", "/api/invitations/0123456789ab", '{"name": "a", "password": "tiger bamboo"}'): (404,) * 6,
    ("POST", "/api/works", ""): (401, 403, 403, 422, 422, 422),
    ("POST", "/api/sheets", ""): (401, *[422] * 5),
    ("POST", "/api/photographs", ""): (422,) * 6,
    ("POST", "/api/photographs/cell", ""): (422,) * 6,
    ("POST", f"{CLASS}/sheets", ""): (401, 403, 403, 422, 422, 422),
    ("DELETE", "/api/sheets/none", ""): (401, *[404] * 5),
    ("POST", "/api/imports", ""): (401, 403, 403, 422, 422, 422),
    ("POST", "/api/pages", ""): (401, 403, 403, 422, 422, 422),
    ("POST", "/api/museums", "{}"): (401, 403, 403, 403, 403, 422),
    ("PATCH", "/api/works/regular-shui/annotations/none", "{}"): (*OWNER[:5], 404),
    ("DELETE", "/api/works/regular-shui/annotations/none", ""): (*OWNER[:5], 404),
    ("PATCH", "/api/tours/none", "{}"): (*OWNER[:5], 404),
    ("DELETE", "/api/tours/none", ""): (*OWNER[:5], 404),
    ("POST", "/api/jobs/{job}/cancel", ""): (401, 404, 403, 404, 404, 403),  # it has ended
}  # fmt: skip


@pytest.fixture(scope="module")
def browsers_and_ids(world, copy_of):
    """(a browser for each role, ids of a pupil's things)."""
    pupil = world.browser("吳")
    attempt = pupil.marked(copy_of(), kind="pen", strokes="[[[1,2,0.5]]]").json()["id"]
    owner = world.browser("館主")
    tour = owner("POST", "/api/tours", json={"title": {"zh": "a"}, "steps": []}).json()["id"]
    token = owner("POST", "/api/invitations", json={"role": "teacher"}).json()["token"]
    ids = {
        "attempt": attempt,
        "class": world.ids["林班"],
        "pupil": world.ids["吳"],
        "task": new_id(),
        "job": new_id(),
        "tour": tour,
        "token": token,
        "upload": new_id(),
    }
    with world.service.gallery.database.writing() as session:
        session.add(Task(id=ids["task"], class_id=ids["class"], work_id="regular-tian"))
        session.add(
            SheetUpload(id=ids["upload"], person_id=ids["pupil"], class_id=ids["class"], files="sheets/none")
        )
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


def test_deleting_a_task(browsers_and_ids):
    browsers, ids = browsers_and_ids
    body = {"work": "regular-shui"}
    task = browsers["林"]("POST", f"/api/classes/{ids['class']}/tasks", json=body).json()["id"]
    url = f"/api/tasks/{task}"
    assert [browsers[role]("DELETE", url).status_code for role in ROLES] == [401, 403, 403, 404, 204, 404]


def test_having_a_copy_marked_and_kept(browsers_and_ids, copy_of):
    browsers, _ = browsers_and_ids
    kept = [browsers[role].marked(copy_of()) for role in ROLES]
    assert [answer.status_code for answer in kept] == [401, *[201] * 5]
    for role, answer in zip(ROLES[1:], kept[1:], strict=True):
        assert browsers[role]("DELETE", f"/api/attempts/{answer.json()['id']}").status_code == 204


def test_logging_out(world):
    for name in (None, *ROLES[1:]):
        assert world.browser(name)("POST", "/api/logout").status_code == 200


def test_exporting_a_page(browsers_and_ids):
    """For everybody; what comes depends on whether the viewer is built."""
    browsers, _ = browsers_and_ids
    statuses = {browsers[role]("GET", "/api/works/regular-shui/export.html").status_code for role in ROLES}
    assert len(statuses) == 1 and not statuses & {401, 403}


ELSEWHERE = {  # in the functions above
    ("DELETE", "/api/attempts/{attempt_id}"),
    ("DELETE", "/api/classes/{class_id}"),
    ("DELETE", "/api/tasks/{task_id}"),
    ("POST", "/api/marks"),
    ("POST", "/api/logout"),
    ("GET", "/api/works/{work_id}/export.html"),
}


def operations(world):
    """(method, path) of every route in the OpenAPI document."""
    paths = world.app.openapi()["paths"]
    return {(method.upper(), path) for path, methods in paths.items() for method in methods}


def operation_of(world, method, url):
    """The route of a URL: the one with the fewest parameters."""
    path = url.partition("?")[0]
    fits = [
        known
        for verb, known in operations(world)
        if verb == method and re.fullmatch(re.sub(r"\\{\w+\\}", "[^/]+", re.escape(known)), path)
    ]
    return (method, min(fits, key=lambda known: known.count("{")))


def test_every_route_says_who_may_use_it(world):
    """A new route fails here until it stands in one of these lists."""
    pages = {"/", "/api/docs", "/api/openapi.json"}
    read = {operation_of(world, "GET", re.sub(r"[{}]", "", url)) for url in READING if url not in pages}
    changed = {operation_of(world, method, re.sub(r"[{}]", "", url)) for method, url, _ in CHANGING}
    assert operations(world) - read - changed - ELSEWHERE == set()
    assert operations(world) >= ELSEWHERE


# --- every route that the OpenAPI document names -----------------------------------------------------


def filled(path, value="none"):
    return re.sub(r"\{\w+\}", value, path)


def test_no_route_takes_changes_from_another_site(world, code_of):
    unsafe = [one for one in sorted(operations(world)) if one[0] != "GET"]
    owner = world.browser("館主")
    for method, path in unsafe:
        for headers in (
            {"Origin": "https://evil.example"},
            {"Origin": "null"},
            {"Sec-Fetch-Site": "cross-site"},
            {"Referer": "https://evil.example/", "Origin": "http://testserver.evil.example"},
        ):
            answer = owner(method, filled(path), headers=headers)
            assert (answer.status_code, code_of(answer)) == (403, "origin"), (method, path, headers)
        answer = owner.client.request(method, filled(path))
        assert (answer.status_code, code_of(answer)) == (403, "csrf"), (method, path)
    assert len(unsafe) > 25


TRAVERSALS = (  # without bare '..', which the client itself would resolve
    *("..%2f", "..%2f..%2f..%2f..%2fetc%2fpasswd", "%2e%2e%2f%2e%2e%2fetc%2fpasswd", "..%5c..%5cwindows"),
    *("%2fetc%2fpasswd", "%252e%252e%252fetc%252fpasswd", "....%2f%2fetc%2fpasswd", "~root%2f.ssh"),
    *("file:%2f%2f%2fetc%2fpasswd", "x%00.png", "C:%5cwindows", "%c0%ae%c0%ae%2fetc%2fpasswd"),
)


def test_no_path_leads_to_a_file(world):
    owner = world.browser("館主")
    asked = 0
    for method, path in sorted(operations(world)):
        names = re.findall(r"\{(\w+)\}", path)
        for name in names:
            for traversal in TRAVERSALS:
                url = path.replace(f"{{{name}}}", traversal).replace("{work_id}", "regular-shui")
                answer = owner(method, filled(url, "full"))
                assert 400 <= answer.status_code < 500, (method, url, answer.status_code)
                assert "root:" not in answer.text and "/etc/passwd" not in answer.text, (method, url)
                asked += 1
    assert asked > 400


@pytest.mark.parametrize("folder", ["", "assets/", "api/", "iiif/"])
@pytest.mark.parametrize("traversal", TRAVERSALS)
def test_no_page_leads_to_a_file(world, folder, traversal):
    answer = world.browser()("GET", f"/{folder}{traversal}")
    assert answer.status_code == 404 and "root:" not in answer.text
