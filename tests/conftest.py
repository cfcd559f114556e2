"""What every test may use: the folder of real data, which is not part of the project."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

DATA = Path(os.environ.get("RUMU_DATA", Path(__file__).parents[1] / ".." / "shared" / "data")).resolve()


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder of real photographs and copies (RUMU_DATA, or ../shared/data beside the checkout)."""
    if not DATA.is_dir():
        if os.environ.get("CI"):
            pytest.fail(f"real data must be present where CI runs: {DATA}")
        pytest.skip(f"real data is absent: {DATA} (set RUMU_DATA)")
    return DATA
