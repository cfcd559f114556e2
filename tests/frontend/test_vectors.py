"""Run the front end's own tests, against reference values that rumu writes first."""

from __future__ import annotations

import os
import runpy
import subprocess
from pathlib import Path

import pytest

from conftest import DATA, FRONTEND

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def vectors() -> Path:
    """Reference values, and real copies to crop where there are any."""
    if DATA.is_dir():
        runpy.run_path(str(ROOT / "scripts" / "measure_crops.py"))["write"](DATA)
    path = FRONTEND / "tests" / "vectors" / "viewer.json"
    runpy.run_path(str(ROOT / "scripts" / "write_vectors.py"))["main"](path)
    return path


def test_the_front_end_agrees_with_rumu(vectors: Path, node: str) -> None:
    assert vectors.stat().st_size > 10_000
    ran = subprocess.run(
        [node, "node_modules/vitest/vitest.mjs", "run", "--reporter=dot"],
        cwd=FRONTEND,
        env=os.environ | {"NO_COLOR": "1"},
        capture_output=True,
        text=True,
        timeout=400,
        check=False,
    )
    assert ran.returncode == 0, ran.stdout[-4000:] + ran.stderr[-4000:]
