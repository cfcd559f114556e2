"""What was measured is stored, read again by the same code, and measured anew by other code."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rumu_lab.experiments import measuring
from rumu_lab.experiments.measuring import measure_each

asked: list[int] = []


def square(number: int) -> int:
    """Work that says how often it was done."""
    asked.append(number)
    return number**2


@pytest.fixture(autouse=True)
def in_this_process(monkeypatch):
    """So that the work can be watched."""
    asked.clear()
    monkeypatch.setattr(measuring, "spread", lambda work, items, executor: map(work, items))


def test_what_was_measured_is_read_again(quick):
    assert measure_each(square, [1, 2, 3], quick) == [1, 4, 9]
    assert measure_each(square, [2, 5, 1], quick) == [4, 25, 1]
    assert asked == [1, 2, 3, 5]


def test_nothing_is_stored_without_a_folder(quick):
    for _ in range(2):
        measure_each(square, [1], replace(quick, out=None))
    assert asked == [1, 1]


def test_other_code_measures_anew(quick, monkeypatch):
    measure_each(square, [1], quick)
    monkeypatch.setattr(measuring, "code_digest", lambda: "other")
    measure_each(square, [1], quick)
    assert asked == [1, 1]


def test_what_was_cut_short_is_measured_again(quick):
    measure_each(square, [1, 2], quick)
    for file in quick.out.rglob("output.pkl"):
        file.write_bytes(file.read_bytes()[:-3])
    assert measure_each(square, [1, 2], quick) == [1, 4]


def test_progress_counts_what_was_there(quick):
    seen = []
    watched = replace(quick, progress=lambda done, total: seen.append((done, total)))
    measure_each(square, [1, 2], quick)
    measure_each(square, [1, 2, 3], watched)
    assert seen == [(1, 3), (2, 3), (3, 3)]


def test_processes_share_what_is_stored(quick, monkeypatch):
    monkeypatch.undo()
    answers = measure_each(abs, list(range(-20, 0)), quick)
    assert answers == measure_each(abs, list(range(-20, 0)), quick) == list(range(20, 0, -1))


def test_a_master_is_prepared_once():
    from rumu.gallery.starter import find_work

    path = find_work("regular-ren").path
    assert measuring.master_at(path) is measuring.master_at(path)
