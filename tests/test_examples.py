"""Every example runs as it stands, in an empty folder, and says something."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.py"))


def test_there_are_examples_in_order():
    assert [int(path.stem[:2]) for path in EXAMPLES] == list(range(len(EXAMPLES)))
    assert len(EXAMPLES) >= 4


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_example(path, tmp_path):
    answer = subprocess.run(
        [sys.executable, "-W", "error::RuntimeWarning", path],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert answer.returncode == 0, answer.stderr
    assert answer.stdout.strip() and not answer.stderr
