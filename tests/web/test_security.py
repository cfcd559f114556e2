"""The security middleware: CSRF tokens, sessions, sizes of bodies, headers, rate limits."""

from __future__ import annotations

import re

import pytest
from starlette.testclient import TestClient

from rumu.studio.tickets import Ticket, Tickets
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
    answer = world.client().post("/api/logout", headers={"X-CSRF-Token": browser.facts["csrf"]})
    assert code_of(answer) == "csrf"


def test_the_cookie_is_out_of_reach_of_scripts_and_other_sites(world):
    plain = world.client().get("/api/session").headers["set-cookie"]
    assert "HttpOnly" in plain and "SameSite=lax" in plain and "Secure" not in plain
    safe = world.client(base_url="https://testserver").get("/api/session").headers["set-cookie"]
    assert "Secure" in safe


@pytest.mark.parametrize(
    "url", ["/", "/api/session", "/api/works", "/nowhere", "/api/docs", "/iiif/works/x/manifest.json"]
)
def test_every_answer_says_what_a_browser_may_do(world, url):
    headers = world.client().get(url).headers
    policy = headers["content-security-policy"]
    assert "unsafe" not in policy and "frame-ancestors 'self'" in policy and "object-src 'none'" in policy
    assert headers["x-content-type-options"] == "nosniff" and headers["referrer-policy"] == "same-origin"
    assert "microphone=()" in headers["permissions-policy"]


@pytest.mark.parametrize("url", ["/", "/api/docs"])
def test_pages_keep_to_the_policy(world, url):
    page = world.client().get(url).text
    assert "<style" not in page and "style=" not in page and "onclick" not in page
    assert "<script>" not in page and re.search(r"(src|href|action)=.?https?:", page) is None


def test_a_refusal_has_the_headers_too(world):
    answer = world.client().post("/api/logout")
    assert answer.status_code == 403 and "content-security-policy" in answer.headers


def test_only_the_gallery_for_viewers_is_open_to_other_sites(world):
    client = world.client()
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
        client = world.client()
        assert (
            client.get(
                "/api/session", headers={"Cookie": f"{world.cookie}={cookie}".encode("latin-1")}
            ).json()["person"]
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


# --- logins and sessions ---------------------------------------------------------------------------


def start_login(world, name="林", password="a long password"):
    browser = world.browser()
    answer = browser("POST", "/api/login", json={"name": name, "password": password})
    assert answer.status_code == 200, answer.text
    browser.facts = answer.json()
    return browser


def copy_cookies(browser):
    """A thief's browser, with the cookies as they are now."""
    thief = TestClient(browser.client.app, raise_server_exceptions=False)
    thief.cookies.update(dict(browser.client.cookies))
    return thief


def test_a_logout_ends_the_session_wherever_its_cookie_was_copied(world):
    browser, elsewhere = start_login(world), start_login(world)
    thief = copy_cookies(browser)
    assert thief.get("/api/attempts").status_code == 200
    assert browser("POST", "/api/logout").json()["person"] is None
    assert thief.get("/api/attempts").status_code == 401
    assert thief.get("/api/session").json()["person"] is None
    assert elsewhere("GET", "/api/attempts").status_code == 200


def test_logging_out_everywhere_ends_all_sessions_of_this_person(world):
    one, two, other = start_login(world), start_login(world), start_login(world, "吳")
    assert one("POST", "/api/logout?everywhere=true").status_code == 200
    assert two("GET", "/api/attempts").status_code == 401
    assert other("GET", "/api/attempts").status_code == 200


def test_a_new_password_ends_all_other_sessions(world):
    one, two = start_login(world, "周"), start_login(world, "周")
    thief = copy_cookies(one)
    words = {"old": "a long password", "new": "quite another one"}
    answer = one("POST", "/api/password", json=words)
    assert answer.json()["person"]["name"] == "周"
    assert one("GET", "/api/attempts").status_code == 200
    assert two("GET", "/api/attempts").status_code == thief.get("/api/attempts").status_code == 401
    three = start_login(world, "周", "quite another one")
    weak = world.browser("館主")(
        "PATCH", f"/api/people/{three.facts['person']['id']}", json={"password": "12345678"}
    )
    assert weak.json()["error"]["code"] == "weak_password"
    assert three("GET", "/api/attempts").status_code == 200  # nothing was changed
    back = {"password": "a long password"}
    world.browser("館主")("PATCH", f"/api/people/{three.facts['person']['id']}", json=back)
    assert three("GET", "/api/attempts").status_code == 401


@pytest.mark.parametrize("names", [("Ｌｉｎ", "lin", "LIN", "ＬＩＮ"), ("林", " 林", "林\u3000", "林 ")])
def test_one_limit_for_all_ways_to_write_a_name(new_world, code_of, names):
    world = new_world(people=False, rate_limits=RateLimitSettings(login_name="3/minute"))
    browser = world.browser()
    codes = [
        code_of(browser("POST", "/api/login", json={"name": name, "password": "wrong password"}))
        for name in names
    ]
    assert codes == ["wrong_login"] * 3 + ["too_often"]


def test_a_weak_password_cannot_join(world, code_of):
    owner = world.browser("館主")
    link = owner("POST", "/api/invitations", json={"role": "teacher"}).json()["link"]
    joining = f"/api/invitations/{link.rsplit('/', 1)[1]}"
    for password, code in (("12345678", "weak_password"), ("王老師王老師王老師", "weak_password")):
        answer = world.browser()("POST", joining, json={"name": "王老師", "password": password})
        assert code_of(answer) == code
    answer = world.browser()("POST", joining, json={"name": "王老師", "password": "tiger bamboo"})
    assert answer.status_code == 201  # the link was not used up


@pytest.mark.parametrize(
    "others",
    [
        "{name}=broken; {own}",
        "{own}; {name}=broken",
        '{name}="; {own}',
        "{name}=; {own}; {name}=W10.x.y",
        "{foreign}; {own}",
        "{own}; {foreign}",
        "{visitor}; {own}",
        "{own}; {visitor}",
        "{ended}; {own}",
        "a; =b; ; c=d=e; {own}",
        "\xff\xfe=\xe9; {own}",
        'theme={{"a": [1,2]}}; {own}',
        "x\x01y=1; {own}",
        "{many}; {own}",
        "{own}; {many}",
    ],
)
def test_other_cookies_of_the_host_end_no_login(world, others):
    browser, ended = world.browser("林"), world.browser("林")
    own, name = f"{world.cookie}={browser.client.cookies[world.cookie]}", world.cookie
    parts = {
        "own": own,
        "name": name,
        "ended": f"{name}={ended.client.cookies[name]}",
        "foreign": f"{name}=" + Tickets("another key").serialise(Ticket("x")),
        "visitor": f"{name}=" + world.service.tickets.serialise(Ticket()),
        "many": "; ".join(f"c{k}={'x' * 100}" for k in range(500)),
    }
    ended("POST", "/api/logout")
    client = world.client(raise_server_exceptions=False)
    headers = {"Cookie": others.format(**parts).encode("latin-1")}
    facts = client.get("/api/session", headers=headers)
    assert facts.status_code == 200 and facts.json()["person"]["name"] == "林", facts.text
    client.cookies.clear()
    changed = client.patch(
        "/api/session", json={"language": "en"}, headers=headers | {"X-CSRF-Token": facts.json()["csrf"]}
    )
    assert changed.status_code == 200, changed.text


def test_with_https_no_other_host_or_path_can_set_the_cookie(new_world):
    client = new_world().client(base_url="https://testserver")
    cookie = client.get("/api/session").headers["set-cookie"]
    assert cookie.startswith("__Host-") and "Path=/;" in cookie and "Secure" in cookie
    assert "Domain" not in cookie


# --- other sites -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("base", "headers", "status"),
    [
        ("http://testserver", {"Origin": "http://testserver"}, 200),
        ("http://testserver", {"Origin": "https://testserver", "Host": "testserver"}, 200),
        ("http://testserver:8000", {"Origin": "http://testserver:8000"}, 200),
        ("http://testserver", {"Sec-Fetch-Site": "same-origin", "Origin": "https://outside.example"}, 200),
        ("http://testserver", {}, 200),
        ("http://testserver", {"Origin": "http://evil.example"}, 403),
        ("http://testserver", {"Origin": "http://testserver.evil.example"}, 403),
        ("http://testserver", {"Origin": "http://testserver:81"}, 403),
        ("http://testserver", {"Origin": "null"}, 403),
        ("http://testserver", {"Origin": "http://[::1"}, 403),
        ("http://testserver", {"Origin": "file://"}, 403),
        ("http://testserver", {"Sec-Fetch-Site": "cross-site"}, 403),
        ("http://testserver", {"Sec-Fetch-Site": "same-site", "Origin": "http://testserver"}, 403),
        ("https://testserver", {"Origin": "http://testserver"}, 403),
    ],
)
def test_requests_of_other_sites_change_nothing(world, code_of, base, headers, status):
    client = world.client(base_url=base)
    token = client.get("/api/session").json()["csrf"]
    answer = client.post("/api/logout", headers={"X-CSRF-Token": token} | headers)
    assert answer.status_code == status
    assert status == 200 or code_of(answer) == "origin"


def test_what_other_sites_may_embed(world):
    client = world.client()
    work = client.get("/api/works/regular-shui").json()
    for url in ("/", "/api/works", "/api/session", "/nowhere", "/api/docs"):
        assert client.get(url).headers["cross-origin-resource-policy"] == "same-origin", url
    for url in (
        work["files"]["glb"],
        work["thumb"],
        work["files"]["manifest"],
        "/iiif/image/none/info.json",
        "/iiif/image/regular-shui/full/max/0/default.jpg",
    ):
        headers = client.get(url).headers
        assert headers["cross-origin-resource-policy"] == "cross-origin", url
        assert headers["access-control-allow-origin"] == "*", url


def test_https_is_kept_to_once_it_is_used(new_world):
    app = new_world(https=True).app
    assert "max-age=31536000" in TestClient(app).get("/").headers["strict-transport-security"]
    facts = TestClient(app).get("/iiif/works/regular-shui/manifest.json").json()
    assert facts["id"].startswith("https://testserver/iiif/")


def test_https_is_not_claimed_without_it(world):
    assert "strict-transport-security" not in world.client().get("/").headers
    safe = world.client(base_url="https://testserver").get("/api/nowhere").headers
    assert safe["strict-transport-security"] == "max-age=31536000"


def test_an_unexpected_error_has_the_headers_too(new_world, monkeypatch, code_of):
    world = new_world()
    monkeypatch.setattr(
        "rumu.web.routes.iiif.manifest", lambda *_, **__: (_ for _ in ()).throw(RuntimeError("/srv/x"))
    )
    client = world.client(raise_server_exceptions=False)
    answer = client.get("/iiif/works/regular-shui/manifest.json")
    assert (answer.status_code, code_of(answer)) == (500, "unexpected") and "/srv" not in answer.text
    assert answer.headers["access-control-allow-origin"] == "*"
    assert "content-security-policy" in answer.headers
