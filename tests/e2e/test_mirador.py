"""Works of the gallery in Mirador, a viewer of IIIF on another site."""

from __future__ import annotations

import io
import threading
import time
from collections.abc import Callable, Iterator
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Page, Response, expect
from tests.e2e.conftest import PATIENCE, Visitor
from tests.e2e.test_whole_work import open_work
from tests.gallery.pages import COLUMNS, ROWS, page_text

from conftest import absent

LogIn = Callable[..., Visitor]
MIRADOR = Path(__file__).parents[2] / "frontend" / "node_modules" / ".cache" / "mirador.min.js"
PAGE = """<!doctype html><meta charset="utf-8">
<style>html, body, #viewer { height: 100%; margin: 0; position: relative }</style>
<div id="viewer"></div><script src="mirador.min.js"></script>
<script>
const manifestId = new URLSearchParams(location.search).get("manifest");
const settings = { sideBarOpen: true, panels: { info: true, canvas: true, annotations: true, search: true } };
// a text is no comment, and comments are all that it lists unless told otherwise
const annotations = { filteredMotivations: ["supplementing"] };
Mirador.viewer({ id: "viewer", windows: [{ manifestId }], window: settings, annotations });
</script>"""


class Site(SimpleHTTPRequestHandler):
    """Another site, which has nothing but the viewer."""

    def do_GET(self) -> None:
        script = self.path.startswith("/mirador.min.js")
        body = MIRADOR.read_bytes() if script else PAGE.encode() if self.path.startswith("/?") else b""
        self.send_response(200 if body else 204)
        self.send_header("Content-Type", "text/javascript" if script else "text/html")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: object) -> None:
        """Say nothing of each request."""


@pytest.fixture(scope="module")
def mirador() -> Iterator[str]:
    """The address of the other site."""
    if not MIRADOR.is_file():
        absent("Mirador (scripts/mirador)")
    with ThreadingHTTPServer(("127.0.0.1", 0), Site) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


def open_in(mirador: str, visitor: Visitor, work_id: str) -> Page:
    """The page of the viewer with a work, once parts of its picture have come."""
    page, service = visitor.page, f"{visitor.url}/iiif"

    def is_part(answer: Response) -> bool:
        return answer.url.startswith(f"{service}/image/{work_id}/") and answer.url.endswith("default.jpg")

    with page.expect_response(is_part) as part:
        page.goto(f"{mirador}?manifest={service}/works/{work_id}/manifest.json")
    assert part.value.ok
    return page


def expect_picture(page: Page) -> None:
    """Wait until there is more to see in the middle than one gray."""
    shown, until, spread = (
        page.locator(".openseadragon-canvas").first,
        time.monotonic() + PATIENCE / 1000,
        0.0,
    )
    while spread < 5:
        assert time.monotonic() < until, f"grays spread by {spread:.1f}"
        picture = np.asarray(Image.open(io.BytesIO(shown.screenshot())).convert("L"))
        rows, columns = (slice(side // 3, 2 * side // 3) for side in picture.shape)
        spread = float(picture[rows, columns].std())


def only_its_own(visitor: Visitor) -> None:
    """Leave out what the viewer complains of itself: no complaint may name our service or its headers."""
    wrong = [text for text in visitor.complaints if visitor.url in text or "CORS" in text]
    assert wrong == []
    visitor.complaints.clear()


def test_a_whole_work_is_shown_with_its_text(mirador: str, as_person: LogIn, sent: dict[str, str]) -> None:
    owner = as_person("owner")
    open_work(owner, sent)
    page = open_in(mirador, owner, sent["path"].removeprefix("/works/"))
    expect(page.get_by_role("heading", name="A practice scroll").first).to_be_visible()
    expect_picture(page)
    page.get_by_role("tab", name="Index").click()
    columns = page_text().split()
    for text in (columns[0], columns[-1]):
        expect(page.get_by_text(text, exact=True).first).to_be_visible()
    page.get_by_role("tab", name="Annotations").click()
    expect(page.locator("[annotationid]")).to_have_count(COLUMNS * ROWS)
    page.get_by_role("tab", name="Search").click()
    page.get_by_role("combobox", name="search terms").fill(columns[1][:2])
    page.get_by_role("button", name="Submit search").click()
    count = page_text().replace("\n", "").count(columns[1][:2])
    expect(page.get_by_text(f"1 of {count}")).to_be_visible()
    assert owner.refused == []
    only_its_own(owner)


@pytest.mark.parametrize("work_id", ["running-shui", "stele-ru-mu-san-fen"])
def test_a_single_work_is_shown(mirador: str, visitor: Visitor, work_id: str) -> None:
    expect_picture(open_in(mirador, visitor, work_id))
    assert visitor.refused == []
    only_its_own(visitor)
