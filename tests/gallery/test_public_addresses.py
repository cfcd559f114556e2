"""Only machines of the open internet are asked, by name, by redirect, and whatever a name means later."""

from __future__ import annotations

import httpx
import pytest
from tests.gallery.museum import open_museum

from rumu.errors import GalleryError
from rumu.gallery.iiif_import import import_manifest
from rumu.gallery.museum_web import FetchSettings, MuseumWeb, NotNow, NotThere
from rumu.gallery.public_addresses import destination, is_public

PUBLIC = ("93.184.216.34", "8.8.8.8", "2606:2800:220:1:248:1893:25c8:1946")
INNER = (
    "127.0.0.1", "127.8.8.8", "10.1.2.3", "172.16.0.1", "192.168.1.1", "169.254.169.254", "100.64.0.1",
    "0.0.0.0", "224.0.0.1", "255.255.255.255", "240.0.0.1", "::1", "::", "fe80::1", "fe80::1%eth0", "fd00::1",
    "ff02::1",
    "::ffff:127.0.0.1", "::ffff:10.0.0.1", "64:ff9b::7f00:1", "2002:7f00:1::", "nonsense",
)  # fmt: skip


@pytest.mark.parametrize("address", PUBLIC)
def test_addresses_of_the_internet_are_public(address):
    assert is_public(address)


@pytest.mark.parametrize("address", INNER)
def test_addresses_of_the_inner_network_are_not(address):
    assert not is_public(address)


def test_one_inner_address_among_several_is_enough_to_refuse():
    with pytest.raises(GalleryError, match="inner network"):
        destination("https://museum.example/m", resolve=lambda host, port: ["8.8.8.8", "10.0.0.1"])
    found = destination("https://museum.example/m", resolve=lambda host, port: ["8.8.8.8"])
    assert (found.host, found.port, found.address) == ("museum.example", 443, "8.8.8.8")


@pytest.mark.parametrize(
    "url",
    [
        "ftp://a.example/",
        "file:///etc/passwd",
        "https://",
        "http://user:pass@a.example/",
        "//a",
        "http://[1/",
    ],
)
def test_other_addresses_are_refused(url):
    with pytest.raises(GalleryError, match="expected an address"):
        destination(url, resolve=lambda host, port: ["8.8.8.8"])


@pytest.mark.parametrize(
    "url", ["http://127.1/", "http://2130706433/", "http://0x7f000001/", "http://[::1]/"]
)
def test_other_spellings_of_this_machine_are_refused(url):
    with pytest.raises(GalleryError):
        destination(url)


def web_of(tmp_path, answers, *, resolve=lambda host, port: ["93.184.216.34"], **settings):
    """A web whose answers are those of a function, with the requests that it was asked."""
    asked: list[httpx.Request] = []

    def answer(request):
        asked.append(request)
        return answers(request)

    web = MuseumWeb(
        tmp_path,
        FetchSettings(pause=0.0, **settings),
        transport=httpx.MockTransport(answer),
        resolve=resolve,
        sleep=lambda seconds: None,
    )
    return web, asked


def test_the_connection_goes_to_the_address_that_was_checked(tmp_path):
    meanings = iter([["93.184.216.34"], ["127.0.0.1"]])  # a name that means another machine a moment later
    web, asked = web_of(
        tmp_path, lambda request: httpx.Response(200, content=b"{}"), resolve=lambda h, p: next(meanings)
    )
    web.json_bytes("https://museum.example/m.json")
    assert asked[0].url.host == "93.184.216.34" and asked[0].headers["host"] == "museum.example"
    assert asked[0].extensions["sni_hostname"] == "museum.example"
    with pytest.raises(GalleryError, match="inner network"):
        web.json_bytes("https://museum.example/other.json")
    assert len(asked) == 1


@pytest.mark.parametrize(
    ("url", "named"),
    [
        ("https://museum.example/a", "museum.example"),
        ("http://museum.example:8080/a", "museum.example:8080"),
        ("https://\u535a\u7269\u9928.example/a", "xn--9krs63ehs0a.example"),
    ],
)
def test_the_server_is_told_the_name_that_was_asked_for(tmp_path, url, named):
    web, asked = web_of(tmp_path, lambda request: httpx.Response(200, content=b"{}"))
    web.json_bytes(url)
    assert asked[0].headers["host"] == named


@pytest.mark.parametrize("location", ["http://[", "javascript:alert(1)", "file:///etc/passwd"])
def test_a_redirect_to_no_address_is_refused(tmp_path, location):
    web, _ = web_of(tmp_path, lambda request: httpx.Response(302, headers={"Location": location}))
    with pytest.raises(GalleryError, match=r"no address|expected an address"):
        web.json_bytes("https://museum.example/m.json")


def test_hosts_at_one_address_share_no_connection(tmp_path):
    web, _ = web_of(tmp_path, lambda request: httpx.Response(200, content=b"{}"))
    for host in ("a.example", "b.example", "a.example"):
        web.json_bytes(f"https://{host}/{host}.json")
    assert len(web._clients) == 2


def test_a_redirect_to_the_inner_network_is_refused(tmp_path):
    def resolve(host, port):
        return ["10.0.0.1"] if host == "inner.example" else ["93.184.216.34"]

    def answer(request):
        return httpx.Response(302, headers={"Location": "http://inner.example/secret"})

    web, asked = web_of(tmp_path, answer, resolve=resolve)
    with pytest.raises(GalleryError, match="inner network"):
        web.json_bytes("https://museum.example/m.json")
    assert len(asked) == 1


def test_a_local_server_is_refused_unless_it_is_allowed(tmp_path, bare):
    with open_museum(1) as museum:
        for path in ("manifest.json", "elsewhere"):
            with pytest.raises(GalleryError, match="inner network"):
                import_manifest(bare, f"{museum.base}/{path}", web=MuseumWeb(tmp_path / "kept"))
        assert museum.asked.total() == 0


def test_redirects_that_go_round_end(tmp_path):
    web, asked = web_of(tmp_path, lambda request: httpx.Response(301, headers={"Location": "/again"}))
    with pytest.raises(NotThere, match="too many redirects"):
        web.json_bytes("https://museum.example/m.json")
    assert len(asked) == FetchSettings().redirects + 1


def test_addresses_with_http_in_a_document_with_https_are_tried_with_https(tmp_path):
    def answer(request):
        if request.url.scheme == "http":
            raise httpx.ConnectError("no plain http here")
        return httpx.Response(200, content=b"picture")

    web, asked = web_of(tmp_path, answer)
    near = "https://museum.example/m.json"
    assert web.picture_bytes("http://museum.example/a.jpg", near=near) == b"picture"
    assert [request.url.scheme for request in asked] == ["https"]
    assert web.picture_bytes("http://museum.example/a.jpg", near=near) == b"picture"
    assert len(asked) == 1  # it is kept


def test_where_there_is_no_https_the_address_is_taken_as_it_stands(tmp_path):
    def answer(request):
        if request.url.scheme == "https":
            raise httpx.ConnectError("no TLS here")
        return httpx.Response(200, content=b"picture")

    web, asked = web_of(tmp_path, answer)
    near = "https://museum.example/m.json"
    for name in ("a", "b"):
        assert web.picture_bytes(f"http://old.example/{name}.jpg", near=near) == b"picture"
    assert [request.url.scheme for request in asked] == ["https", "http", "http"]


def test_an_answer_without_end_is_cut_off(tmp_path):
    web, _ = web_of(tmp_path, lambda request: httpx.Response(200, content=b"x" * 2000), max_json=1000)
    with pytest.raises(NotThere, match="at most 1000 bytes"):
        web.json_bytes("https://museum.example/m.json")
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []


def test_a_server_that_is_away_is_said_so(tmp_path):
    def answer(request):
        raise httpx.ConnectTimeout("nobody")

    web, asked = web_of(tmp_path, answer, tries=3)
    with pytest.raises(NotNow, match="run the import again"):
        web.json_bytes("https://museum.example/m.json")
    assert len(asked) == 3


def test_what_was_fetched_where_private_addresses_are_allowed_is_kept_for_nobody_else(tmp_path):
    """Else the service would show its owner files of the inner network that the command line fetched."""
    with open_museum(1) as museum:
        url = f"{museum.base}/manifest.json"
        allowed = MuseumWeb(tmp_path, FetchSettings(pause=0.0, private=True))
        assert allowed.json_bytes(url) == allowed.json_bytes(url) and museum.asked["/manifest.json"] == 1
        with pytest.raises(GalleryError, match="inner network"):
            MuseumWeb(tmp_path, FetchSettings(pause=0.0)).json_bytes(url)
