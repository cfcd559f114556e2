"""The front end, built once for the tests that look at it in a browser."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, sync_playwright

ROOT = Path(__file__).parents[2]
FRONTEND = ROOT / "frontend"
CHROMIUM = "/usr/bin/chromium"
# A GPU in software: the same WebGL2 wherever the tests run.
SWITCHES = [
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
]


@pytest.fixture(scope="session")
def frontend() -> Path:
    """The folder of the front end, with node and its packages there; skips elsewhere, fails in CI."""
    missing = [name for name in ("node", "npx") if shutil.which(name) is None]
    if not (FRONTEND / "node_modules").is_dir():
        missing.append("frontend/node_modules (cd frontend && npm ci)")
    if missing and os.environ.get("CI"):
        pytest.fail(f"must be present where CI runs: {', '.join(missing)}")
    if missing:
        pytest.skip(f"absent: {', '.join(missing)}")
    return FRONTEND


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Chromium with WebGL2 in software; skips where it is absent, fails in CI."""
    if not Path(CHROMIUM).exists():
        (pytest.fail if os.environ.get("CI") else pytest.skip)(f"absent: {CHROMIUM}")
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=CHROMIUM, args=SWITCHES)
        yield started
        started.close()


@pytest.fixture(scope="session")
def standalone(frontend: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with standalone.js and standalone.css."""
    target = tmp_path_factory.mktemp("static")
    build = ["npx", "vite", "build", "--config", "vite.standalone.config.ts", "--outDir", str(target)]
    ran = subprocess.run(build, cwd=frontend, capture_output=True, text=True, timeout=300, check=False)
    assert ran.returncode == 0, ran.stdout[-3000:] + ran.stderr[-3000:]
    return target
