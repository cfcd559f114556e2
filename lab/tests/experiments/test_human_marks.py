"""Methods on human marks: who took part, what was left out, and what is said of it."""

from __future__ import annotations

import pytest

from rumu.errors import CalibrationError
from rumu_lab.experiments import human_marks
from rumu_lab.experiments.grading import Grades
from rumu_lab.experiments.human_marks import OWN_SCALE, SHARED
from rumu_lab.experiments.marked_copies import chosen_copies


@pytest.fixture
def measured(monkeypatch, graded, quick, e3c_data):
    """Ours knows the panel's mark; the others nearly."""
    marks = {f"human/{c.image.name}": c.mark / 100 for c in chosen_copies(quick)}

    def use(measure):
        monkeypatch.setattr(
            human_marks,
            "measure_each",
            lambda work, tasks, settings: [measure(t, marks[t.key]) for t in tasks],
        )

    use(lambda task, mark: graded(task, mark, noise=0.3))
    return use


def test_every_method_is_there_and_ours_is_right(measured, quick):
    found = human_marks.run(quick)
    rows = {row["method"]: row for row in found.facts["methods"]}
    assert {SHARED, OWN_SCALE, "constant", "MBSE", "IoU (cell)", "the paper's SIM"} < set(rows)
    assert rows[OWN_SCALE]["mae"] == pytest.approx(0.0) and rows[SHARED]["within"] == pytest.approx(1.0)
    assert rows["MBSE"]["within"] < 0.9
    assert found.facts["verdict"]["rank"] == 1
    assert found.facts["copies"] == 18 and found.facts["characters"] == 3


def test_a_refused_copy_is_named_and_counts_for_nobody(measured, graded, quick):
    def one_refused(task, mark):
        if task.key == "human/十0.png":
            return Grades(task.key, task.cluster, refused="blank")
        return graded(task, mark)

    measured(one_refused)
    facts = human_marks.run(quick).facts
    assert facts["refused"] == ["human/十0.png"]
    assert all(row["n"] == 17 for row in facts["methods"])


def test_a_method_that_could_not_grade_is_counted(measured, graded, quick):
    from dataclasses import replace

    measured(lambda task, mark: replace(graded(task, mark), failed=("VICP",)))
    assert human_marks.run(quick).facts["could_not_grade"] == {"VICP": 18}


def test_data_that_is_not_there(quick):
    with pytest.raises(CalibrationError, match=r"scores\.csv"):
        human_marks.run(quick)


def test_one_rater(e3c_data, quick):
    copies = chosen_copies(quick)
    assert human_marks.one_rater(copies)["n"] == 18 * 4
    assert 2 < human_marks.one_rater(copies)["mae"] < 20
