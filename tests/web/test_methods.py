"""HEAD and OPTIONS, and CORS of what is open to other sites, errors too."""

from __future__ import annotations

import pytest

from rumu.web.settings import RateLimitSettings

MANIFEST = "/iiif/works/regular-shui/manifest.json"
OPEN = [
    MANIFEST,
    "/iiif/works/regular-shui/canvas",
    "/iiif/works/regular-shui/canvas/page",
    "/iiif/collections/starter.json",
    "/iiif/image/regular-shui/info.json",
    "/iiif/image/regular-shui/full/max/0/default.jpg",
    "/api/works/regular-shui/files/glb",
    "/api/works/regular-shui/files/thumb",
]
OF_THIS_ANSWER = ("date", "set-cookie")


@pytest.fixture
def client(world):
    return world.client(raise_server_exceptions=False)


@pytest.mark.parametrize(
    "url", [*OPEN, "/", "/api/works", "/api/works/regular-shui", "/api/docs", "/api/session", "/nowhere"]
)
def test_head_answers_as_get_does_without_the_body(client, url):
    client.get(url)  # made now, so that both come from the same cache
    get, head = client.get(url), client.head(url)
    assert head.status_code == get.status_code and head.content == b"" and get.content
    ours = {name: value for name, value in head.headers.items() if name not in OF_THIS_ANSWER}
    assert ours == {name: value for name, value in get.headers.items() if name not in OF_THIS_ANSWER}


@pytest.mark.parametrize("url", [*OPEN, "/iiif/image/none/info.json"])
def test_a_preflight_says_what_may_be_sent(client, url):
    asked = {
        "Origin": "https://viewer.example",
        "Access-Control-Request-Method": "GET",
        "Access-Control-Request-Headers": "if-none-match, x-requested-with",
    }
    answer = client.options(url, headers=asked)
    assert answer.status_code == 204 and answer.content == b""
    assert answer.headers["access-control-allow-origin"] == "*"
    assert answer.headers["access-control-allow-methods"] == "GET, HEAD, OPTIONS"
    assert answer.headers["access-control-allow-headers"] == "if-none-match, x-requested-with"
    assert int(answer.headers["access-control-max-age"]) > 0
    plain = client.options(url)
    assert plain.status_code == 204 and plain.headers["allow"] == "GET, HEAD, OPTIONS"


@pytest.mark.parametrize(
    "url", ["/api/works", "/api/session", "/api/attempts", "/api/works/x/annotations", "/"]
)
def test_nothing_else_is_open_to_other_sites(client, url):
    asked = {"Origin": "https://viewer.example", "Access-Control-Request-Method": "GET"}
    for answer in (client.options(url, headers=asked), client.get(url, headers=asked)):
        assert "access-control-allow-origin" not in answer.headers
        assert answer.headers["cross-origin-resource-policy"] == "same-origin"


@pytest.mark.parametrize("method", ["GET", "HEAD"])
@pytest.mark.parametrize("url", OPEN)
def test_conditional_requests(client, url, method):
    etag = client.get(url).headers["etag"]
    again = client.request(method, url, headers={"If-None-Match": etag, "Origin": "https://viewer.example"})
    assert (again.status_code, again.content, again.headers["etag"]) == (304, b"", etag)
    assert again.headers["access-control-allow-origin"] == "*"
    assert "etag" in again.headers["access-control-expose-headers"].lower()


@pytest.mark.parametrize(
    ("url", "status"),
    [
        ("/iiif/works/none/manifest.json", 404),
        ("/iiif/works/regular-shui/canvas/none", 404),
        ("/iiif/collections/none.json", 404),
        ("/iiif/image/none/info.json", 404),
        ("/iiif/image/regular-shui/nonsense/max/0/default.jpg", 400),
        ("/iiif/image/regular-shui/full/max/0/default.xyz", 400),
        (f"/iiif/image/{'x' * 70}/info.json", 422),
        ("/api/works/none/files/glb", 404),
    ],
)
@pytest.mark.parametrize("method", ["GET", "HEAD"])
def test_errors_are_readable_for_other_sites(client, url, status, method):
    answer = client.request(method, url, headers={"Origin": "https://viewer.example"})
    assert answer.status_code == status
    assert answer.headers["access-control-allow-origin"] == "*"


def test_too_many_requests_are_refused_readably(new_world):
    world = new_world(rate_limits=RateLimitSettings(all="3/minute"))
    client = world.client()
    for method in ("GET", "HEAD", "OPTIONS"):
        for _ in range(5):
            answer = client.request(method, MANIFEST)
        assert answer.status_code == 429 and answer.headers["access-control-allow-origin"] == "*"
        assert int(answer.headers["retry-after"]) > 0


def test_every_id_in_a_manifest_is_answered_with_what_it_names(new_world):
    world = new_world()
    note = {
        "x": 0.2,
        "y": 0.4,
        "title": {"zh": "起筆", "en": "Entry"},
        "text": {"zh": "逆鋒", "en": "against"},
    }
    world.browser("館主")("POST", "/api/works/regular-shui/annotations", json=note)
    client = world.client()
    facts = client.get(MANIFEST).json()
    named = list(objects(facts))
    kinds = {one["type"] for one in named}
    assert {"Canvas", "AnnotationPage", "Annotation", "Image", "Model", "Collection"} <= kinds
    for one in named:
        answer = client.get(one["id"].split("#")[0].removeprefix("http://testserver"))
        assert answer.status_code == 200, one["id"]
        if one["type"] in ("Canvas", "AnnotationPage", "Annotation"):
            found = answer.json()
            assert (found["id"], found["type"]) == (one["id"], one["type"]) and "@context" in found


def objects(facts):
    """Every object with an id in a manifest."""
    if isinstance(facts, dict):
        if "id" in facts:
            yield facts
        for value in facts.values():
            yield from objects(value)
    elif isinstance(facts, list):
        for value in facts:
            yield from objects(value)


def test_head_of_a_stream_ends_at_once(world):
    from rumu.studio import job_queue

    with world.service.gallery.database.writing() as session:
        job = job_queue.add(session, "test", {}, person_id=world.ids["林"])
        job.state = "running"
    answer = world.browser("林")("HEAD", f"/api/jobs/{job.id}/events")
    assert answer.status_code == 200 and answer.headers["content-type"].startswith("text/event-stream")
