"""A headset, emulated in the browser: the sheet is seen in it, and the page is as before afterwards."""

from __future__ import annotations

import io

import numpy as np
from PIL import Image
from playwright.sync_api import Page
from tests.e2e.conftest import Visitor
from tests.e2e.test_walk import opened

from conftest import FRONTEND

EMULATOR = FRONTEND / "node_modules" / "iwer" / "build" / "iwer.min.js"
PUT_ON = """
window.headset = new IWER.XRDevice(IWER.metaQuest3);
window.headset.installRuntime({ forceInstall: true });
"""


def looked(page: Page) -> np.ndarray:
    """Where the sheet is on the page; the emulator takes its canvas into a layer of its own."""
    picture = page.screenshot(clip={"x": 0, "y": 70, "width": 880, "height": 600})
    return np.asarray(Image.open(io.BytesIO(picture)).convert("RGB"), dtype=np.float32)


def test_the_sheet_is_seen_in_a_headset(visitor: Visitor) -> None:
    visitor.page.context.add_init_script(f"{EMULATOR.read_text(encoding='utf-8')}\n;{PUT_ON}")
    page = opened(visitor, "/works/regular-shui?mode=surface")
    page.wait_for_timeout(1000)
    before = looked(page)
    page.get_by_role("button", name="VR", exact=True).click()
    page.wait_for_timeout(2500)
    assert page.evaluate("Boolean(window.headset.activeSession)")
    inside = looked(page)
    assert np.mean(np.abs(inside - before)) > 2
    assert (inside.max(axis=2) < 60).mean() > 0.003, "there is ink to be seen"
    page.evaluate("window.headset.activeSession.end()")
    page.wait_for_timeout(2000)
    assert np.mean(np.abs(looked(page) - before)) < 1
