"""The security middleware: CSRF tokens, sessions, sizes of bodies, headers, rate limits."""

from __future__ import annotations

import pytest
from starlette.testclient import TestClient

from rumu.web.security import COOKIE
from rumu.web.settings import BodyLimits, RateLimitSettings

UNSAFE = [
    ("POST", "/api/login"), ("POST", "/api/logout"), ("POST", "/api/marks"), ("POST", "/api/works"),
    ("PATCH", "/api/works/regular-shui"), ("DELETE", "/api/works/regular-shui"), ("POST", "/api/classes"),
    ("PUT", "/api/attempts/x/mark"), ("POST", "/api/imports"), ("POST", "/nowhere"),
]  # fmt: skip


@pytest.mark.parametrize(("method", "url"), UNSAFE)
@pytest.mark.parametrize("token", [None, "", "0" * 40, "é"])
def test_nothing_is_changed_without_the_token(world, code_of, method, url, token):
    browser = world.browser("館主")
    headers = {} if token is None else {"X-CSRF-Token": token.encode()}
    answer = browser.client.request(method, url, headers=headers, json={})
    assert (answer.status_code, code_of(answer)) == (403, "csrf")


def test_another_session_s_token_does_not_do(world, code_of):
    one, other = world.browser("館主"), world.browser("館主")
    answer = one("POST", "/api/logout", headers={"X-CSRF-Token": other.facts["csrf"]})
    assert code_of(answer) == "csrf"
    assert one("POST", "/api/logout").status_code == 200


def test_the_token_without_a_cookie_does_not_do(world, code_of):
    browser = world.browser()
    answer = TestClient(world.app).post("/api/logout", headers={"X-CSRF-Token": browser.facts["csrf"]})
    assert code_of(answer) == "csrf"


def test_the_cookie_is_out_of_reach_of_scripts_and_other_sites(world):
    plain = TestClient(world.app).get("/api/session").headers["set-cookie"]
    assert "HttpOnly" in plain and "SameSite=lax" in plain and "Secure" not in plain
    safe = TestClient(world.app, base_url="https://testserver").get("/api/session").headers["set-cookie"]
    assert "Secure" in safe


@pytest.mark.parametrize(
    "url", ["/", "/api/session", "/api/works", "/nowhere", "/api/docs", "/iiif/works/x/manifest.json"]
)
def test_every_answer_says_what_a_browser_may_do(world, url):
    headers = TestClient(world.app).get(url).headers
    policy = headers["content-security-policy"]
    assert "unsafe" not in policy and "frame-ancestors 'self'" in policy and "object-src 'none'" in policy
    assert headers["x-content-type-options"] == "nosniff" and headers["referrer-policy"] == "same-origin"
    assert "microphone=()" in headers["permissions-policy"]


@pytest.mark.parametrize("url", ["/", "/api/docs"])
def test_pages_keep_to_the_policy(world, url):
    page = TestClient(world.app).get(url).text
    assert "<style" not in page and "style=" not in page and "onclick" not in page
    assert "<script>" not in page and "http://" not in page and "https://" not in page


def test_a_refusal_has_the_headers_too(world):
    answer = TestClient(world.app).post("/api/logout")
    assert answer.status_code == 403 and "content-security-policy" in answer.headers


def test_only_the_gallery_for_viewers_is_open_to_other_sites(world):
    client = TestClient(world.app)
    for url in ("/iiif/works/regular-shui/manifest.json", "/iiif/image/regular-shui/info.json"):
        assert client.get(url).headers["access-control-allow-origin"] == "*"
    for url in ("/api/works", "/api/session", "/"):
        assert "access-control-allow-origin" not in client.get(url).headers


def test_a_body_is_bounded_by_what_it_announces_and_by_what_comes(new_world, code_of):
    world = new_world(body_limits=BodyLimits(default=1000, mark=2000, work=3000, zip=4000))
    browser = world.browser("館主")

    def chunks(size):
        return (b"x" * 100 for _ in range(size // 100))

    for url, most in (
        ("/api/classes", 1000),
        ("/api/marks", 2000),
        ("/api/works", 3000),
        ("/api/imports", 4000),
    ):
        announced = browser("POST", url, content=b"x" * (most + 100))
        streamed = browser(
            "POST",
            url,
            content=chunks(most + 200),
            headers={"Content-Type": "multipart/form-data; boundary=x"},
        )
        assert (announced.status_code, streamed.status_code) == (413, 413), url
        assert code_of(announced) == code_of(streamed) == "too_large"


@pytest.mark.parametrize("length", ["-1", "x", "9" * 30])
def test_a_length_that_is_none(world, length):
    browser = world.browser("館主")
    assert browser("POST", "/api/classes", content=b"", headers={"Content-Length": length}).status_code == 413


@pytest.mark.parametrize(("name", "status"), [(None, 401), ("吳", 403)])
@pytest.mark.parametrize("url", ["/api/works", "/api/imports"])
def test_large_bodies_of_those_who_may_not_send_them_are_not_read(world, name, status, url):
    read = []

    def chunks():
        for _ in range(50):
            read.append(1)
            yield b"x" * 100_000

    answer = world.browser(name)("POST", url, content=chunks())
    assert answer.status_code == status


def test_a_forged_or_damaged_cookie_is_a_visitor(world):
    for cookie in ("x", "W10.x.y", '"', "a b;c", "\xff"):
        client = TestClient(world.app)
        assert (
            client.get("/api/session", headers={"Cookie": f"{COOKIE}={cookie}".encode("latin-1")}).json()[
                "person"
            ]
            is None
        )


def test_rates(new_world, code_of):
    world = new_world(
        rate_limits=RateLimitSettings(
            login="5/minute", login_name="3/minute", tries="1/minute", all="30/minute"
        )
    )
    browser = world.browser()
    wrong = {"name": "林", "password": "wrong password"}
    codes = [code_of(browser("POST", "/api/login", json=wrong)) for _ in range(4)]
    assert codes == ["wrong_login"] * 3 + ["too_often"]
    answers = [browser("POST", "/api/login", json=wrong | {"name": f"n{k}"}) for k in range(3)]
    assert code_of(answers[-1]) == "too_often" and int(answers[-1].headers["retry-after"]) >= 1
    statuses = [browser.client.get("/api/works").status_code for _ in range(40)]
    assert statuses[0] == 200 and statuses[-1] == 429
