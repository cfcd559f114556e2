"""Deep zoom into a large work: `benchmarks/deep_zoom.py [--width 16000 --height 7500] [--capture 6]`.

A scroll of that many pixels is drawn, some rows at a time, and added to an empty gallery by a process of
its own: seconds by the clock and of processor time, and its most memory. Then a browser opens it: seconds
to the first picture, until the first and the last tile have come, and to sharp tiles on the screen; the
latter two after each of three jumps; frames a second while the lamp moves; bytes of JavaScript, of tiles, and
of the browser's processes beyond those of an empty page (where graphics memory counts too, if the processor
draws). Times by the clock depend on what else the machine does; `--capture` adds so many simulated
photographs of that many pixels instead, which are measured; `--gpu` lets the browser use a card. `--errors`
prints instead how far packed normals of a measured and of an inflated surface are from the true ones.
"""

from __future__ import annotations

import argparse
import io
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import psutil
from drawn_scroll import DrawnScroll, bands, draw_scroll

SOFTWARE = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")
JUMPS = ("0.1,0.03,0.2,0.1,0.03,0", "0.11,0.03,0.05,0.11,0.03,0", "-0.2,-0.05,0.05,-0.2,-0.05,0")
WANTED = "import 60 s, 1500 MB; first tiles 1 s; sharp after a jump .5 s; with a card 30 frames/s; 300 MB"
TILES = """performance.getEntriesByType("resource")
  .filter(({ name }) => name.includes("/iiif/tiles/") && name.includes("/default."))
  .map(({ responseEnd }) => (responseEnd - window.began) / 1000)"""
SHARP = '.viewer-canvas[data-missing="0"]'
PHONE = {
    "viewport": {"width": 390, "height": 844},
    "device_scale_factor": 3,
    "has_touch": True,
    "is_mobile": True,
}
DESK = {"viewport": {"width": 1440, "height": 900}, "device_scale_factor": 2}
FRAMES = """() => new Promise((done) => {
  const dial = document.querySelector('.dial input'), start = performance.now();
  let frames = 0;
  const step = () => {
    dial.value = String((frames * 5) % 360);
    dial.dispatchEvent(new Event('input', { bubbles: true }));
    frames += 1;
    if (performance.now() - start < 3000) requestAnimationFrame(step);
    else done(frames / ((performance.now() - start) / 1000));
  };
  requestAnimationFrame(step);
})"""


def add(source: Path) -> None:
    """Add a scroll or a folder of photographs to the gallery of RUMU_HOME; print what it took, as JSON."""
    from rumu.gallery.add_work import add_capture, add_picture
    from rumu.gallery.catalog import open_gallery
    from rumu.gallery.metadata import WorkMetadata
    from rumu.values import Bilingual

    start = time.time()
    metadata = WorkMetadata(title=Bilingual("長卷", "A long scroll"))
    add_one = add_capture if source.is_dir() else add_picture
    added = add_one(open_gallery(starter=False), source, metadata=metadata)
    used = resource.getrusage(resource.RUSAGE_SELF)
    facts = {"work": added.id, "seconds": time.time() - start, "processor": used.ru_utime + used.ru_stime}
    print(json.dumps(facts | {"megabytes": used.ru_maxrss / 1024}))


@contextmanager
def serving() -> Iterator[str]:
    """The address of a server of the gallery."""
    command = [sys.executable, "-m", "rumu.cli", "serve", "--port", "0", "--json"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE)
    assert server.stdout is not None
    try:
        yield json.loads(server.stdout.readline())["url"].rstrip("/")
    finally:
        server.terminate()
        server.wait(timeout=20)


def go(page: Any, place: str) -> float:
    """Change the address within the page; when that was."""
    page.evaluate("performance.clearResourceTimings(); window.began = performance.now()")
    page.evaluate("(place) => { location.hash = place; }", place)
    return time.time()


def browse(url: str, work: str, switches: tuple[str, ...], options: dict[str, Any]) -> dict[str, float]:
    """Open a work in a browser, zoom, and move its lamp."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        program = shutil.which("chromium")
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox", *switches])
        page = browser.new_context(**options).new_page()
        page.set_default_timeout(120_000)
        page.goto(f"{url}/#/about")  # the pages themselves are loaded
        page.wait_for_load_state("networkidle")
        empty = browser_bytes()
        facts: dict[str, float] = {}
        start = go(page, f"#/works/{work}")
        page.wait_for_selector(".viewer-canvas")
        facts["first picture, s"] = time.time() - start
        page.wait_for_selector(SHARP)
        facts["sharp, s"] = time.time() - start
        facts["first tile, s"], facts["last tile, s"] = page.evaluate(
            f"(() => {{ const ends = {TILES}; return [Math.min(...ends), Math.max(...ends)]; }})()"
        )
        most = 0
        for number, camera in enumerate(JUMPS, start=1):
            before = page.get_attribute(".viewer-canvas", "data-factor")
            start = go(page, f"#/works/{work}?cam={camera}")
            if number == 1:
                page.wait_for_selector(f'.viewer-canvas:not([data-factor="{before}"])')
            page.wait_for_timeout(30)
            page.wait_for_selector(SHARP)
            facts[f"sharp after jump {number}, s"] = time.time() - start
            facts[f"last tile after jump {number}, s"] = page.evaluate(f"Math.max(0, ...{TILES})")
            most = max(most, int(page.get_attribute(".viewer-canvas", "data-tile-bytes") or 0))
        facts["relighting, frames/s"] = page.evaluate(FRAMES)
        facts["tiles, MB"] = most / 1e6
        facts["JavaScript, MB"] = page.evaluate("performance.memory.usedJSHeapSize") / 1e6
        facts["browser beyond an empty page, MB"] = (browser_bytes() - empty) / 1e6
        browser.close()
    return facts


def browser_bytes() -> int:
    """Bytes that this program's browser processes hold alone."""
    total = 0
    for process in psutil.Process().children(recursive=True):
        if "chrom" in process.name():
            total += process.memory_full_info().uss
    return total


def print_errors() -> None:
    """How far normals are turned by the ways in which they can be packed, in degrees, and their bytes."""
    from PIL import Image

    from rumu.surface.inflation import inflate
    from rumu.surface.relief import normals_of

    band = next(bands(DrawnScroll(width=2000, height=500)))
    true = normals_of(inflate(band[..., 0] < 120))
    noise = np.random.default_rng(1).normal(0, 0.03, true.shape).astype(np.float32)
    measured = (true + noise) / np.linalg.norm(true + noise, axis=2, keepdims=True)
    for name, normals in (("of ink", true), ("measured, noise 1.7 degrees", measured)):
        levels = np.round(normals * 127.5 + 127.5).astype(np.uint8)
        for way, options in (
            ("PNG", {"format": "PNG"}),
            ("JPEG 95, 4:4:4", {"format": "JPEG", "quality": 95, "subsampling": 0}),
            ("WebP 95", {"format": "WEBP", "quality": 95}),
        ):
            packed = io.BytesIO()
            Image.fromarray(levels).save(packed, **options)
            again = np.asarray(Image.open(packed).convert("RGB")).astype(float) / 127.5 - 1
            again /= np.linalg.norm(again, axis=2, keepdims=True)
            turned = np.degrees(np.arccos(np.clip((again * normals).sum(axis=2), -1, 1)))
            size = packed.tell() / levels[..., 0].size * 512**2 / 1000
            print(
                f"{name}, {way}: mean {turned.mean():.2f}, 99 % below {np.percentile(turned, 99):.2f}, "
                f"most {turned.max():.1f} degrees; {size:.0f} kB for a tile"
            )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--width", type=int, default=16_000)
    parser.add_argument("--height", type=int, default=7_500)
    parser.add_argument("--capture", type=int, metavar="PHOTOGRAPHS")
    parser.add_argument("--no-browser", action="store_true")
    parser.add_argument("--gpu", action="store_true")
    parser.add_argument("--errors", action="store_true")
    parser.add_argument("--add", metavar="SCROLL", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.errors:
        print_errors()
        return
    if options.add:
        add(Path(options.add))
        return
    with tempfile.TemporaryDirectory() as folder:
        os.environ["RUMU_HOME"] = f"{folder}/home"
        scroll = Path(folder) / ("photographs" if options.capture else "scroll.tif")
        if options.capture:
            from museum import write_photographs_apart

            scroll.mkdir()
            megapixels = options.width * options.height / 1e6
            write_photographs_apart(scroll, megapixels=megapixels, count=options.capture)
            print(f"{options.capture} photographs of {megapixels:g} megapixels")
        else:
            draw_scroll(scroll, DrawnScroll(options.width, options.height))
            print(f"{options.width} x {options.height} pixels, {scroll.stat().st_size / 1e6:.0f} MB")
        command = [sys.executable, __file__, "--add", str(scroll)]
        facts = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
        print("import: {seconds:.1f} s, {processor:.1f} s of one core, {megabytes:.0f} MB".format(**facts))
        if options.no_browser:
            return
        with serving() as url:
            for name, kind in (("desk", DESK), ("phone", PHONE)):
                found = browse(url, facts["work"], () if options.gpu else SOFTWARE, kind)
                print(f"{name}: " + ", ".join(f"{what} {value:.2f}" for what, value in found.items()))
        print(f"wanted: {WANTED}; " + ("drawn by a card" if options.gpu else "drawn by the processor here"))


if __name__ == "__main__":
    main()
