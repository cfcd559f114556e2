"""Series of growing faults: what falls, what does not, and what depends on the table of expected scores."""

from __future__ import annotations

from pathlib import Path

import pytest

from rumu.errors import CalibrationError
from rumu_lab.experiments import severities
from rumu_lab.experiments.grading import OURS, Grades
from rumu_lab.experiments.run_settings import RunSettings
from rumu_lab.experiments.severities import SHARED, SHIPPED, Subject

SUBJECTS = [
    Subject(f"{script}-{k}", script, Path(f"{script}-{k}.png"), ("shift", "lean"))
    for script in ("seal", "regular", "cursive")
    for k in range(2)
]


def fall(graded, task):
    """A mark that falls by ten points a step, and by two for a lean."""
    severity = int(task.key.rsplit("/", 1)[1])
    return graded(task, 1.0 - (0.02 if "lean" in task.key else 0.1) * severity)


@pytest.fixture
def measured(monkeypatch, graded):
    """Puts a way of measuring in the place of the real one."""

    def use(measure):
        monkeypatch.setattr(
            severities, "measure_each", lambda work, tasks, settings: [measure(t) for t in tasks]
        )

    use(lambda task: fall(graded, task))
    return use


def found(settings):
    return severities.findings_on(SUBJECTS, settings, name="severities", where="made-up works")


@pytest.fixture(scope="module")
def falling_facts(tmp_path_factory, graded):
    """What is found where all marks fall, which several tests read."""
    folder = tmp_path_factory.mktemp("falling")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(severities, "measure_each", lambda work, tasks, _: [fall(graded, t) for t in tasks])
        return found(RunSettings(folder / "data", folder / "out", quick=True)).facts


def test_each_work_is_measured_once_at_severity_0(measured, quick, falling_facts):
    steps = severities.steps_of(SUBJECTS, quick)
    assert len(steps) == 6 * 2 * 6
    assert len({s.grades.key for s in steps}) == 6 * (2 * 5 + 1)
    assert falling_facts["copies"] == 66


def test_what_falls_is_ranked_and_its_step_measured(falling_facts):
    facts = falling_facts
    ours = next(row for row in facts["ranks"] if row["method"] == OURS)
    assert (ours["spearman"], ours["order"], ours["violations"]) == pytest.approx((1.0, 1.0, 0.0))
    by_fault = {row["fault"]: row["ours_fall"] for row in facts["by_fault"]}
    assert by_fault == {"shift": pytest.approx(10.0), "lean": pytest.approx(2.0)}
    assert facts["steps"][OURS] == pytest.approx(-0.06)
    assert facts["marks_by_severity"] == pytest.approx([100, 94, 88, 82, 76, 70])


def test_our_other_rows_are_no_rivals(falling_facts):
    facts = falling_facts
    names = {row["method"] for row in facts["methods"]}
    assert {SHARED, SHIPPED, "constant", "MBSE"} < names
    assert facts["verdict"]["rivals"] == len(names) - 5


def test_an_order_that_depends_on_the_table_is_flagged(falling_facts):
    sensitivity = falling_facts["sensitivity"]
    assert set(sensitivity["orders"]) == {"declared", "falling late", "falling early"}
    orders = {tuple(order) for order in sensitivity["orders"].values()}
    assert sensitivity["order_changes"] == (len(orders) > 1)


def test_a_series_with_a_refused_copy_is_left_out(measured, graded, quick):
    def refuses(task):
        if task.key == "severities/seal-0/lean/3":
            return Grades(task.key, task.cluster, refused="too pale")
        return fall(graded, task)

    measured(refuses)
    facts = found(quick).facts
    assert facts["refused"] == ["severities/seal-0/lean/3"] and facts["series"] == 11


def test_nothing_but_refusals(measured, quick):
    measured(lambda task: Grades(task.key, task.cluster, refused="blank"))
    with pytest.raises(CalibrationError, match="refused"):
        found(quick)
