"""The home page on a phone whose browser has nothing yet: `python benchmarks/home.py [--visits 4]`.

A server is started with a new gallery, and a browser whose processor is slowed down four times opens its
home page several times, each time with an empty cache; the first visit also finds a server that has
answered nothing yet. Prints for each visit the seconds until words stand there, until the largest picture is
painted (the browser's own measure, Largest Contentful Paint) and until the lamp moves over it, with the
kilobytes that came over the wire; then once more over a line of 1.6 megabits and 150 ms, which is what
Lighthouse takes for a phone. The lamp is drawn by a graphics card on a phone and by the processor here.
Run it on a machine that does nothing else.
"""

from __future__ import annotations

import argparse
import os
import shutil
import tempfile
from typing import Any

from deep_zoom import PHONE, SOFTWARE, serving

SLOWED = 4
SLOW_LINE = {
    "offline": False,
    "latency": 150,
    "downloadThroughput": 1.6e6 / 8,
    "uploadThroughput": 0.75e6 / 8,
}
WATCH = """
window.painted = 0;
new PerformanceObserver((list) => { for (const one of list.getEntries()) window.painted = one.startTime; })
  .observe({ type: "largest-contentful-paint", buffered: true });
"""


def visit(browser: Any, url: str, line: dict[str, Any] | None) -> dict[str, float]:
    """Seconds and kilobytes of one visit with an empty cache."""
    context = browser.new_context(**PHONE)
    page = context.new_page()
    page.set_default_timeout(60_000)
    page.add_init_script(WATCH)
    tools = context.new_cdp_session(page)
    received = []
    tools.on("Network.loadingFinished", lambda event: received.append(event["encodedDataLength"]))
    tools.send("Network.enable")
    tools.send("Emulation.setCPUThrottlingRate", {"rate": SLOWED})
    if line:
        tools.send("Network.emulateNetworkConditions", line)
    now = "performance.now() / 1000"
    page.goto(url, wait_until="commit")
    page.wait_for_selector(".home-words h1")
    words = page.evaluate(now)
    page.wait_for_selector(".lit-work canvas.lit")
    lamp = page.evaluate(now)
    page.wait_for_load_state("networkidle")
    painted = page.evaluate("window.painted / 1000")
    context.close()
    return {"words": words, "picture": painted, "lamp": lamp, "kB": sum(received) / 1000}


def main() -> None:
    from playwright.sync_api import sync_playwright

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--visits", type=int, default=4)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        os.environ["RUMU_HOME"] = folder
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", *SOFTWARE]
        )
        browser.new_page().goto("data:text/html,<p>awake")
        with serving() as url:
            lines: list[dict[str, Any] | None] = [None] * options.visits + [SLOW_LINE]
            for number, line in enumerate(lines, start=1):
                facts = visit(browser, url, line)
                told = ", ".join(f"{name} {value:.2f}" for name, value in facts.items() if name != "kB")
                print(
                    f"visit {number}{', slow line' if line else ''}: seconds to {told}; {facts['kB']:.0f} kB"
                )
        browser.close()


if __name__ == "__main__":
    main()
