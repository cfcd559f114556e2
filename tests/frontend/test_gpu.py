"""What the shaders draw, read back and held against rumu: the one-file page, opened from a disk."""

from __future__ import annotations

import base64
import io
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Browser, Page

import rumu
from rumu.gallery.assets import assets_of
from rumu.gallery.catalog import open_gallery, work
from rumu.gallery.single_page import single_page
from rumu.report.pictures import srgb
from rumu.surface.relight import relight_three
from rumu.values import FloatArray, Surface

SIDE = 96
LAMPS = [(135.0, 45.0), (0.0, 0.0), (250.0, 75.0), (30.0, 60.0)]


def dome(*, sign: float = 1.0) -> Surface:
    """A coloured sheet with a dome on it (sign -1: a hollow)."""
    x, y = np.meshgrid(np.linspace(-1, 1, SIDE), np.linspace(1, -1, SIDE))
    radius = np.hypot(x, y)
    height = sign * np.where(radius < 0.8, 0.3 * np.cos(np.pi * radius / 1.6) ** 2, 0.0) * SIDE / 2
    rows, columns = np.gradient(height)
    normals = np.stack([-columns, rows, np.ones_like(height)], axis=-1)  # dz/dy = -dz/drow
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    ramp = np.linspace(0.1, 0.95, SIDE)
    albedo = np.stack(np.broadcast_arrays(ramp[None], ramp[:, None], 0.6), axis=-1)
    return Surface(
        height=height.astype(np.float32),
        normals_from=normals.astype(np.float32),
        albedo_from=albedo.astype(np.float32),
        mask=np.ones((SIDE, SIDE), dtype=np.bool_),
        confidence=np.ones((SIDE, SIDE), dtype=np.float32),
        spacing=0.5,
        unit="mm",
        source="photometric",
    )


def png(pixels: Any) -> str:
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, "PNG")
    return "data:image/png;base64," + base64.b64encode(buffer.getvalue()).decode()


def page_of(surface: Surface, static: Path, target: Path, *, lamps: dict[str, Any] | None = None) -> str:
    """A page that shows a surface, written by hand: the address of its file."""
    rows, columns = surface.height.shape
    albedo = png(srgb(surface.albedo))
    heights = base64.b64encode(surface.height.astype("<f4").tobytes()).decode()
    both = {"zh": "丘", "en": "Dome"}
    viewer = {
        "width": columns,
        "height": rows,
        "unit": surface.unit,
        "spacing": surface.spacing,
        "source": surface.source,
        "source_text": both,
        "heights": {
            "url": f"data:application/octet-stream;base64,{heights}",
            "width": columns,
            "height": rows,
            "min": float(surface.height.min()),
            "max": float(surface.height.max()),
        },
        "normals": png(np.round(surface.normals * 127.5 + 127.5).astype(np.uint8)),
        "albedo": albedo,
        "picture": albedo,
        "mask": png(np.where(surface.mask, 255, 0).astype(np.uint8)),
        "three_lamps": lamps,
        "glb": "",
    }
    words = dict.fromkeys(("title", "hand", "period", "material", "collection_title"), both)
    plain = dict.fromkeys(("source", "licence", "attribution", "script", "dynasty", "collection"), "x")
    facts = {"work": {"id": "dome", "annotations": [], **words, **plain}, "viewer": viewer}
    told = json.dumps(facts).replace("<", "\\u003c")
    script = (static / "standalone.js").read_text(encoding="utf-8").replace("</script", "<\\/script")
    style = (static / "standalone.css").read_text(encoding="utf-8")
    target.write_text(
        f'<!doctype html><meta charset="utf-8"><style>{style}</style><div id="app"></div>'
        f'<script type="application/json" id="rumu-work">{told}</script><script>{script}</script>',
        encoding="utf-8",
    )
    return target.as_uri()


def opened(browser: Browser, address: str) -> Page:
    """The page with its viewer standing, anything it asks of a network refused and any error told."""
    page = browser.new_page(viewport={"width": 900, "height": 700})
    page.context.set_offline(True)
    problems: list[str] = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.goto(address)
    page.evaluate("rumuViewer.viewer.then(() => true)")
    assert problems == []
    return page


def drawn(page: Page, state: dict[str, Any], *, how: str = "relit") -> FloatArray:
    """What the GPU draws in a state, sRGB in [0, 1]: the flat sheet ('relit'), or the view ('snapshot')."""
    coded = page.evaluate(
        """async ([state, how]) => {
          const viewer = await rumuViewer.viewer;
          viewer.set(state);
          const bytes = new Uint8Array(await (await viewer[how]()).arrayBuffer());
          return btoa(Array.from(bytes, (b) => String.fromCharCode(b)).join(""));
        }""",
        [state, how],
    )
    image = Image.open(io.BytesIO(base64.b64decode(coded))).convert("RGB")
    return np.asarray(image, dtype=np.float32) / 255


def coded(image: FloatArray) -> FloatArray:
    """Linear to sRGB in [0, 1], three channels."""
    codes = srgb(image).astype(np.float32) / 255
    return np.asarray(codes if codes.ndim == 3 else np.repeat(codes[..., None], 3, axis=2))


@pytest.fixture(scope="module")
def dome_page(browser: Browser, standalone: Path, tmp_path_factory: pytest.TempPathFactory) -> Page:
    lamps = {
        name: png(srgb(rumu.relight(dome(), tilt=tilt, slant=40)))
        for name, tilt in zip("abc", (0.0, 90.0, 180.0), strict=True)
    }
    target = tmp_path_factory.mktemp("page") / "dome.html"
    return opened(browser, page_of(dome(), standalone, target, lamps=lamps | {"slant": 40}))


@pytest.mark.parametrize(("tilt", "slant"), LAMPS)
def test_the_shader_relights_as_rumu(dome_page: Page, tilt: float, slant: float) -> None:
    found = drawn(dome_page, {"tilt": tilt, "slant": slant, "look": "exact", "mode": "sheet"})
    wanted = coded(rumu.relight(dome(), tilt=tilt, slant=slant))
    assert found.shape == wanted.shape
    assert np.abs(found - wanted).mean() < 2 / 255
    assert wanted.std() > 0.05  # there is something to see


@pytest.mark.parametrize(("tilt", "slant"), [(45.0, 40.0), (300.0, 40.0), (90.0, 25.0)])
def test_the_shader_mixes_three_lamps_as_rumu(dome_page: Page, tilt: float, slant: float) -> None:
    state = {"tilt": tilt, "slant": slant, "look": "exact", "mixture": True, "mode": "sheet"}
    found = drawn(dome_page, state)
    drawn(dome_page, {"mixture": False})
    lit = [rumu.relight(dome(), tilt=t, slant=40) for t in (0.0, 90.0, 180.0)]
    a, b, c = (coded(image)[..., 1] for image in lit)
    a, b, c = (np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4) for v in (a, b, c))
    mixed = relight_three(a, b, c, slant=40, tilt=tilt, new_slant=slant)
    assert np.abs(found[..., 1] - coded(np.clip(mixed, 0, 1))[..., 1]).mean() < 2 / 255


def slopes(page: Page) -> tuple[float, float]:
    """Brightness of the upper-left and lower-right slopes of the mesh, from above, lit from upper left."""
    state = {"mode": "mesh", "tilt": 135, "slant": 50, "exaggeration": 2, "camera": [0, 0, 2.2, 0, 0, 0]}
    seen = drawn(page, state, how="snapshot").mean(axis=2)
    drawn(page, {"exaggeration": 1, "camera": None, "mode": "sheet"})
    row, column = (length // 2 for length in seen.shape)
    # The dome fills 0.8 of the half sheet and is steepest at half of that.
    reach = int(0.14 * seen.shape[0] / (2.2 * 2 * np.tan(np.radians(14))))

    def around(r: int, c: int) -> float:
        return float(seen[r - 8 : r + 8, c - 8 : c + 8].mean())

    return around(row - reach, column - reach), around(row + reach, column + reach)


def test_a_raised_mesh_is_not_inside_out(
    dome_page: Page, browser: Browser, standalone: Path, tmp_path: Path
) -> None:
    """The geometry alone: light from the upper left brightens the upper-left slope of a hill, and the
    other one of a hollow."""
    upper, lower = slopes(dome_page)
    assert upper > 1.3 * lower
    hollow = opened(browser, page_of(dome(sign=-1.0), standalone, tmp_path / "hollow.html"))
    upper, lower = slopes(hollow)
    assert lower > 1.3 * upper
    hollow.close()


def test_contours_leave_the_plain_white(dome_page: Page) -> None:
    """The plain lies at a level itself, 0: it is no line. On the dome there are lines."""
    state = {"mode": "contours", "camera": [0, 0, 2.2, 0, 0, 0]}
    seen = drawn(dome_page, state, how="snapshot").mean(axis=2)
    drawn(dome_page, {"camera": None, "mode": "sheet"})
    row, column = (length // 2 for length in seen.shape)
    corner = int(0.46 * seen.shape[0] / (2.2 * 2 * np.tan(np.radians(14))))
    assert seen[row - corner, column - corner] > 0.8
    assert seen[row, column - corner : column + corner].min() < 0.5


def test_what_was_not_measured_is_not_drawn_in_space(
    browser: Browser, standalone: Path, tmp_path: Path
) -> None:
    """The left half alone was measured: nothing of the right half stands in the view of the surface, as
    nothing of it is in the mesh that is downloaded; the flat sheet is whole."""
    half = np.zeros((SIDE, SIDE), dtype=np.bool_)
    half[:, : SIDE // 2] = True
    page = opened(browser, page_of(replace(dome(), mask=half), standalone, tmp_path / "half.html"))
    straight = {"camera": [0, 0, 2.2, 0, 0, 0], "look": "exact", "tilt": 90, "slant": 10}
    shares = []
    for mode in ("sheet", "surface"):
        seen = drawn(page, straight | {"mode": mode}, how="snapshot")
        row, column = (length // 2 for length in seen.shape[:2])
        reach = int(0.3 * seen.shape[0] / (2.2 * 2 * np.tan(np.radians(14))))
        paper = seen[2, 2]
        beside = [np.abs(seen[row, column + side * reach] - paper).max() for side in (-1, 1)]
        shares.append([bool(difference > 0.05) for difference in beside])
    page.close()
    assert shares == [[True, True], [True, False]]


def test_what_is_picked_and_cut_is_the_surface(dome_page: Page) -> None:
    top, ends = dome_page.evaluate(
        """async () => {
          const viewer = await rumuViewer.viewer;
          const { x, y } = viewer.project(0.5, 0.5);
          const cut = viewer.section([0, 0.5, 1, 0.5]);
          const peak = Math.max(...cut.map((p) => p.height));
          return [{ place: viewer.pick(x, y), peak }, cut.at(-1).distance];
        }"""
    )
    assert top["place"]["x"] == pytest.approx(0.5, abs=0.01)
    assert top["place"]["height"] == pytest.approx(float(dome().height.max()), rel=0.01)
    assert top["peak"] == pytest.approx(float(dome().height.max()), rel=0.01)
    assert ends == pytest.approx(SIDE * 0.5)


def test_a_work_of_the_gallery_from_a_disk(browser: Browser, standalone: Path, tmp_path: Path) -> None:
    gallery = open_gallery(database=tmp_path / "rumu.sqlite", files=tmp_path / "files")
    target = tmp_path / "page.html"
    target.write_bytes(single_page(gallery, "regular-shui", static=standalone))
    page = opened(browser, target.as_uri())
    shown = assets_of(gallery.store, work(gallery, "regular-shui")).surface()
    for tilt, slant in LAMPS[:2]:
        found = drawn(page, {"tilt": tilt, "slant": slant, "look": "exact"})
        assert np.abs(found - coded(rumu.relight(shown, tilt=tilt, slant=slant))).mean() < 2 / 255
    page.click(".one-language")
    assert page.evaluate("document.documentElement.lang") in {"zh-Hant", "en"}
    assert page.locator("text=楷書").count() or page.locator("text=regular script").count()
    page.close()
