"""Pairs are measured once, found again, and never mixed with those of other code."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from rumu.gallery.starter import find_work
from rumu_lab.baselines.methods import METHODS
from rumu_lab.experiments import measuring
from rumu_lab.experiments.measuring import OURS, OWN, GradingTask, Measured
from rumu_lab.experiments.simulated_copies import Faulty, Written

MASTER = find_work("regular-ren").path


def numbered(task: GradingTask, *, pictures=None) -> Measured:
    """Work that tells how often it was done."""
    asked.append(task.key)
    return Measured(task.key, task.cluster, {OURS: float(task.key) / 10})


asked: list[str] = []


def tasks(count):
    return [GradingTask(str(k), "c", MASTER, Written(MASTER)) for k in range(count)]


@pytest.fixture(autouse=True)
def here(monkeypatch):
    """In this process, so that the work can be watched."""
    asked.clear()
    monkeypatch.setattr(measuring, "_in_parallel", map)
    monkeypatch.setattr(measuring, "BEHIND", {**measuring.BEHIND, "numbered": ("rumu/values.py",)})


def test_a_pair_is_measured_by_every_method():
    bad = Faulty(MASTER, "angle", 5, 11)
    pair = [GradingTask("good", "c", MASTER, Written(MASTER)), GradingTask("bad", "c", MASTER, bad)]
    good, worse = measuring.measure_all(pair)
    assert set(good.raw) == {*OWN, *METHODS}
    assert good.mark == pytest.approx(100, abs=1) and worse.mark < good.mark
    assert good.refused is None and good.failed == ()


def test_a_refused_copy_says_why(tmp_path):
    from PIL import Image

    Image.new("L", (200, 200), 255).save(tmp_path / "blank.png")
    (measured,) = measuring.measure_all([GradingTask("k", "c", MASTER, Written(tmp_path / "blank.png"))])
    assert measured.refused and measured.raw == {} and np.isnan(measured.mark)


def test_a_picture_is_made_once(tmp_path, monkeypatch):
    recipe = Faulty(MASTER, "lean", 3, 11)
    made = measuring.drawn(recipe, tmp_path)
    np.testing.assert_array_equal(made, recipe.picture())
    monkeypatch.setattr(Faulty, "picture", lambda self: pytest.fail("made again"))
    np.testing.assert_array_equal(measuring.drawn(recipe, tmp_path), made)


def test_what_was_measured_is_found_again(tmp_path):
    first = measuring.measure_by(numbered, tasks(3), store=tmp_path)
    again = measuring.measure_by(numbered, tasks(5), store=tmp_path)
    assert asked == ["0", "1", "2", "3", "4"]
    assert again[:3] == first and [m.key for m in again] == ["0", "1", "2", "3", "4"]


def test_a_line_that_was_cut_short_is_measured_again(tmp_path):
    measuring.measure_by(numbered, tasks(3), store=tmp_path)
    (file,) = tmp_path.iterdir()
    file.write_text(file.read_text()[:-15])
    measuring.measure_by(numbered, tasks(4), store=tmp_path)
    assert asked == ["0", "1", "2", "2", "3"]
    assert [json.loads(line)["key"] for line in file.read_text().splitlines()] == ["0", "1", "2", "3"]


def test_other_code_measures_anew(tmp_path, monkeypatch):
    measuring.measure_by(numbered, tasks(1), store=tmp_path)
    monkeypatch.setattr(measuring, "code_hash", lambda parts: "f" * 64)
    measuring.measure_by(numbered, tasks(1), store=tmp_path)
    assert asked == ["0", "0"]


def test_progress_counts_what_was_there(tmp_path):
    measuring.measure_by(numbered, tasks(2), store=tmp_path)
    seen = []
    measuring.measure_by(numbered, tasks(3), store=tmp_path, progress=lambda k, n: seen.append((k, n)))
    assert seen == [(3, 3)]


def test_the_hash_follows_what_a_work_rests_on(tmp_path, monkeypatch):
    import rumu
    import rumu_lab

    root = tmp_path
    ours = ("surface/ink.py", "assessment/mark.py", "cli/words.py", "pipeline.py")
    for name in (*(f"rumu/{name}" for name in ours), "rumu_lab/baselines/hog.py"):
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text("one")
    for package in (rumu, rumu_lab):
        monkeypatch.setattr(package, "__file__", str(root / package.__name__ / "__init__.py"))

    def who_starts_anew(name: str) -> set[str]:
        before = {work: measuring.code_hash(parts) for work, parts in measuring.BEHIND.items()}
        Path(root / name).write_text(Path(root / name).read_text() + "more")
        return {
            work for work, parts in measuring.BEHIND.items() if measuring.code_hash(parts) != before[work]
        }

    ours = {"measure_ours", "measure_variants", "measure_density"}
    assert who_starts_anew("rumu/surface/ink.py") == {*ours, "measure_others"}
    assert who_starts_anew("rumu/assessment/mark.py") == who_starts_anew("rumu/pipeline.py") == ours
    assert who_starts_anew("rumu_lab/baselines/hog.py") == {"measure_others"}
    assert who_starts_anew("rumu/cli/words.py") == set()
