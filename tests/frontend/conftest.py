"""Build the front end once for the tests that open it in a browser."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from conftest import FRONTEND


@pytest.fixture(scope="session")
def standalone(node: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with standalone.js and standalone.css."""
    target = tmp_path_factory.mktemp("static")
    vite = [node, "node_modules/vite/bin/vite.js"]
    build = [*vite, "build", "--config", "vite.standalone.config.ts", "--outDir", str(target)]
    ran = subprocess.run(build, cwd=FRONTEND, capture_output=True, text=True, timeout=300, check=False)
    assert ran.returncode == 0, ran.stdout[-3000:] + ran.stderr[-3000:]
    return target
