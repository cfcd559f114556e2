"""The lens and the mix of three photographs over a large work: as sharp as its pixels."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Page, expect
from tests.e2e.conftest import Visitor
from tests.e2e.test_deep_zoom import LINES, SHARP, canvas, large_page, steps

from rumu_lab.simulation.lamps import photographs

LogIn = Callable[..., Visitor]
SMALL = {"viewport": {"width": 800, "height": 520}}  # a processor draws here
TILTS, SLANT = (0, 90, 180), 40
MARGIN = 550  # pixels on both sides, so that no line is seen in a map of 1024 pixels
ROWS = 600  # pixels around the lines: how sharp the maps are is told by the longer side alone
NEAR = "cam=0,0,0.2,0,0,0"  # about two pixels of the screen for one of the work
FAR = "cam=0,0,0.8,0,0,0"


def large_capture() -> bytes:
    """A zip of three photographs of a sheet with low waves, and lines of two pixels at its middle."""
    page = np.asarray(large_page().convert("L"))
    top = (page.shape[0] - ROWS) // 2
    sheet = np.pad(page[top : top + ROWS], ((0, 0), (MARGIN, MARGIN)), mode="edge") / 255
    y, x = np.mgrid[: sheet.shape[0], : sheet.shape[1]] / 80
    images, lights = photographs(3 * np.sin(x) * np.sin(y), sheet**2.2, tilts=TILTS, slant=SLANT)
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        lines = [str(len(images))]
        for number, (image, light) in enumerate(zip(images, lights, strict=True)):
            packed = io.BytesIO()
            Image.fromarray(np.round(255 * image ** (1 / 2.2)).astype(np.uint8)).save(packed, "PNG")
            archive.writestr(f"{number}.png", packed.getvalue())
            lines.append(f"{number}.png " + " ".join(f"{part:.6f}" for part in light))
        archive.writestr("lights.lp", "\n".join(lines) + "\n")
        archive.writestr("capture.json", '{"encoding": "srgb"}')
    return stream.getvalue()


def open_capture(visitor: Visitor, sent: dict[str, str], query: str) -> Page:
    """The page of the capture, which the first test sends, as sharp as the screen."""
    page = visitor.page
    if "work" not in sent:
        token = page.evaluate("async () => (await (await fetch('/api/session')).json()).csrf")
        answer = page.request.post(
            f"{visitor.url}/api/imports",
            headers={"X-CSRF-Token": token, "Origin": visitor.url},
            multipart={
                "zip": {"name": "large.zip", "mimeType": "application/zip", "buffer": large_capture()},
                "licence": "CC0-1.0",
                "title_en": "A large capture",
            },
        )
        assert answer.status == 202, answer.text()
        job = answer.json()["job"]["id"]
        state = "async (id) => (await (await fetch(`/api/jobs/${id}`)).json())"
        for _ in range(600):
            facts = page.evaluate(state, job)
            if facts["state"] not in ("queued", "running"):
                break
            page.wait_for_timeout(500)
        assert facts["state"] == "done", facts
        found = page.evaluate("async () => (await fetch('/api/works?q=A%20large%20capture')).json()")
        sent["work"] = found["items"][0]["id"]
        sent["path"] = f"/works/{sent['work']}"
    page.goto("about:blank")  # so that what is seen next was drawn for this address
    page = visitor.go(f"/works/{sent['work']}?{query}")
    expect(page.locator(SHARP)).to_be_visible(timeout=240_000)
    return page


def test_the_mix_of_three_photographs_is_as_sharp_as_they_are(as_person: LogIn, sent: dict[str, str]) -> None:
    owner = as_person("owner", **SMALL)
    page = open_capture(owner, sent, f"{NEAR}&lamps=3&tilt=90&slant={SLANT}")
    assert page.get_attribute(".viewer-canvas", "data-factor") == "1"
    mixed = canvas(page)
    assert steps(mixed) > 12  # 1024 pixels of the sheet do not show them
    facts = page.evaluate("async (id) => (await fetch(`/api/works/${id}/viewer`)).json()", sent["work"])
    maps = {"albedo", "normals", "heights", "picture", "lamp-a", "lamp-b", "lamp-c"}
    assert set(facts["tiles"]) == {*maps, "version"}
    page = open_capture(owner, sent, f"{NEAR}&lamps=3&tilt=90&slant=75")
    assert np.abs(canvas(page) - mixed).mean() > 3  # another mixture
    held = int(page.get_attribute(".viewer-canvas", "data-tile-bytes") or 0)
    assert 0 < held < 96e6


@pytest.mark.parametrize("lens", ["magnify", "picture", "normals"])
def test_the_lens_shows_the_pixels_of_the_work(as_person: LogIn, sent: dict[str, str], lens: str) -> None:
    """Magnified, more than the view around it; another layer, as sharp as the view."""
    owner = as_person("owner", **SMALL)
    place = FAR if lens == "magnify" else NEAR
    plain = canvas(open_capture(owner, sent, place))
    page = open_capture(owner, sent, f"{place}&lens={lens}")
    seen = canvas(page)
    middle = tuple(side // 2 for side in seen.shape[:2])
    rows, columns = (slice(at - 60, at + 60) for at in middle)
    changed = np.abs(seen - plain).mean(axis=2) > 6
    assert changed[rows, columns].mean() > (0.01 if lens == "picture" else 0.1)
    corner = changed[: middle[0] // 3, : middle[1] // 3]
    assert not corner.any()  # outside of the lens nothing has changed
    if lens == "magnify":
        assert detail(seen[rows, columns]) > 2 * detail(plain[rows, columns])
    elif lens == "picture":
        assert steps(seen) > 12
    else:
        assert seen[rows, columns, 2].mean() > 240 > seen[rows, columns, 0].mean() + 60  # the blue of normals


def detail(view: np.ndarray) -> float:
    """How much neighbours differ, from one pixel to the next."""
    return float(np.abs(np.diff(view.mean(axis=2), axis=1)).mean())


def test_the_lines_are_too_fine_for_the_maps() -> None:
    """Else the tests above would say nothing."""
    page = np.asarray(large_page().convert("L"))
    y, x = page.shape[0] // 2, page.shape[1] // 2
    lines = Image.fromarray(page[y : y + LINES, x : x + LINES])
    side = LINES * 1024 // (page.shape[1] + 2 * MARGIN)
    small = np.asarray(lines.resize((side, side), Image.Resampling.BOX)).astype(float)
    assert np.ptp(np.asarray(lines)[10]) > 120 and np.ptp(small[10]) < 100
