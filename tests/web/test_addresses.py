"""A service under a path of a host: its pages, API, cookie, redirects, IIIF and invitations."""

from __future__ import annotations

import re
from urllib.parse import urljoin

import pytest
from starlette.testclient import TestClient

from rumu.errors import RumuError
from rumu.web.addresses import check_root_path

ROOT = "/calligraphy"
HOST = "https://museum.example"


class CutOff:
    """What a proxy does that takes the path off before it passes a request on."""

    def __init__(self, app):
        self.app = app

    async def __call__(self, scope, receive, send):
        if scope["type"] == "http":
            path = scope["path"].removeprefix(ROOT)
            scope = {**scope, "path": path, "raw_path": path.encode()}
        await self.app(scope, receive, send)


@pytest.fixture(params=["left on", "taken off"])
def below(request, new_world):
    """(the world, its application as the proxy shows it below ROOT)."""
    world = new_world(root_path=ROOT)
    return world, world.app if request.param == "left on" else CutOff(world.app)


@pytest.mark.parametrize(
    ("given", "path"),
    [("", ""), ("/", ""), ("calligraphy", ROOT), ("/calligraphy/", ROOT), ("/a/b-c.d~e", "/a/b-c.d~e")],
)
def test_a_root_path(given, path):
    assert check_root_path(given) == path


@pytest.mark.parametrize(
    "given", ["/a b", "/a//b", "/..", "/.", "/a?b", "http://x", "/書", "/api", "/iiif/x"]
)
def test_what_is_no_root_path(given):
    with pytest.raises(RumuError, match="such as /calligraphy"):
        check_root_path(given)


def test_the_cookie_is_for_this_path(below):
    world, app = below
    cookie = TestClient(app, base_url=HOST).get(f"{ROOT}/api/session").headers["set-cookie"]
    assert f"Path={ROOT}/;" in cookie and cookie.startswith("__Secure-")
    plain = TestClient(app, base_url="http://museum.example").get(f"{ROOT}/api/session").headers["set-cookie"]
    assert plain.startswith(world.cookie)


def test_a_person_joins_and_logs_out_below_a_path(below):
    _, app = below
    owner, joining = TestClient(app, base_url=HOST), TestClient(app, base_url=HOST)
    csrf = owner.get(f"{ROOT}/api/session").json()["csrf"]
    words = {"name": "館主", "password": "a long password"}
    facts = owner.post(f"{ROOT}/api/login", json=words, headers={"X-CSRF-Token": csrf}).json()
    link = owner.post(
        f"{ROOT}/api/invitations", json={"role": "teacher"}, headers={"X-CSRF-Token": facts["csrf"]}
    ).json()["link"]
    assert link.startswith(f"{ROOT}/#/join/")
    csrf = joining.get(f"{ROOT}/api/session").json()["csrf"]
    words = {"name": "新老師", "password": "tiger bamboo"}
    joined = joining.post(
        f"{ROOT}/api/invitations/{link.rsplit('/', 1)[1]}",
        json=words,
        headers={"X-CSRF-Token": csrf, "Origin": HOST},
    )
    assert joined.status_code == 201
    assert joining.get(f"{ROOT}/api/session").json()["person"]["name"] == "新老師"
    out = joining.post(f"{ROOT}/api/logout", headers={"X-CSRF-Token": joined.json()["csrf"]})
    assert out.status_code == 200
    assert joining.get(f"{ROOT}/api/session").json()["person"] is None
    assert len(joining.cookies.jar) == 1


def test_every_url_is_below_the_path_and_answers(below):
    """Follow every URL in pages, API and IIIF, as far as they lead."""
    _, app = below
    client = TestClient(app, base_url=HOST)
    first = """ api/docs api/openapi.json api/works?limit=2 api/works/regular-shui
        api/works/regular-shui/viewer api/tours api/collections iiif/collections/starter.json
        iiif/image/regular-shui iiif/image/regular-shui/info.json"""
    waiting = [f"{HOST}{ROOT}/", *(f"{HOST}{ROOT}/{path}" for path in first.split())]
    seen: set[str] = set()
    while waiting:
        url = waiting.pop(0)
        if url in seen or len(seen) > 120:
            continue
        seen.add(url)
        answer = client.get(url.removeprefix(HOST), follow_redirects=False)
        assert answer.status_code < 400, (url, answer.text[:200])
        if "location" in answer.headers:
            waiting.append(urljoin(url, answer.headers["location"]))
        elif "json" in answer.headers["content-type"]:
            pattern = rf'"((?:{HOST}|/)[^"\s#]*)[#"]' if "openapi" not in url else r'"url": ?"([^"]*)"'
            waiting += [urljoin(url, one) for one in re.findall(pattern, answer.text) if one != "/"]
        elif "html" in answer.headers["content-type"]:
            waiting += [urljoin(url, one) for one in re.findall(r'(?:href|src)="([^"#]+)"', answer.text)]
    assert len(seen) > 60
    assert all(url.startswith(f"{HOST}{ROOT}") for url in seen), [u for u in seen if ROOT not in u]
    kinds = ("/manifest.json", "/full/max/0/default.jpg", "/files/glb", ".css", "/files/thumb")
    for kind in kinds:
        assert any(kind in url for url in seen), kind


def test_without_its_slash_the_path_leads_to_the_pages(new_world):
    client = TestClient(new_world(root_path=ROOT).app, base_url=HOST)
    answer = client.get(ROOT, follow_redirects=False)
    assert answer.status_code in (301, 307, 308) and answer.headers["location"] == f"{HOST}{ROOT}/"
    assert client.get(ROOT).status_code == 200
    assert client.get(f"{ROOT}x/api/session").status_code == 404


def test_the_owner_s_link_is_below_the_path(rumu, monkeypatch):
    class Stands:
        started, should_exit = False, True

        def __init__(self, config, *, end_work):
            self.config = config

        def run(self, sockets):
            assert sockets

    monkeypatch.setattr("rumu.web.connections.GracefulServer", Stands)
    facts = rumu("serve", "--port", 0, "--json", "--root-path", "/calligraphy/").facts
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+/calligraphy/", facts["url"])
    assert facts["owner_link"].startswith(f"{facts['url']}#/join/")
    rumu("serve", "--root-path", "/api").failed_with("such as /calligraphy")


def test_the_environment_gives_the_path(rumu, monkeypatch):
    monkeypatch.setattr("uvicorn.Server.run", lambda *_, **__: None)
    monkeypatch.setenv("RUMU_ROOT_PATH", "kept")
    assert rumu("serve", "--port", 0, "--json").facts["url"].endswith("/kept/")
