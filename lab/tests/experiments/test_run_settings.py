"""The digest names the code of both packages, and nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from rumu_lab.experiments import run_settings


@pytest.mark.parametrize(
    ("file", "changes"),
    [("rumu/surface/ink.py", True), ("rumu_lab/baselines/hog.py", True), ("rumu/web/style.css", False)],
)
def test_the_digest_follows_the_code(tmp_path, monkeypatch, file, changes):
    import rumu
    import rumu_lab

    for package in (rumu, rumu_lab):
        monkeypatch.setattr(package, "__file__", str(tmp_path / package.__name__ / "__init__.py"))
    path = Path(tmp_path / file)
    path.parent.mkdir(parents=True)
    path.write_text("one")
    before = run_settings.code_digest.__wrapped__()
    path.write_text("two")
    assert (run_settings.code_digest.__wrapped__() != before) == changes


def test_the_commit_is_that_of_the_checkout():
    root = Path(run_settings.__file__).resolve().parents[4]
    assert (run_settings.commit() is not None) == (root / ".git").exists()
