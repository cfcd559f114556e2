"""How long a command will take yet, by a clock of our own."""

from __future__ import annotations

import contextlib

import pytest

from rumu.cli.run_time import RunTime, Stage
from rumu.cli.terminal import clock_time

STAGES = (
    Stage("Reading photographs", each=1.0, spread=False, counts=True),
    Stage("Checking", once=3.0, spread=False),
    Stage("Solving", each=2.0, once=5.0, spread=False),
    Stage("Asked for", once=4.0, spread=False),
    Stage("Writing", once=6.0, spread=False),
)


def told(takes: dict[str, tuple[float, int]]) -> list[tuple[float, float | None]]:
    """What is really left and what is told at each call.

    takes: seconds and parts of each stage; 0 parts of one that is not counted, which is told of as it begins.
    """
    now = [0.0]
    whole, seen = RunTime(STAGES, clock=lambda: now[0]), []
    for what, (seconds, parts) in takes.items():
        if not parts:
            seen.append((now[0], whole.left(what, 0, 1)))
            now[0] += seconds
        for part in range(1, parts + 1):
            now[0] += seconds / parts
            seen.append((now[0], whole.left(what, part, parts)))
    return [(now[0] - when, left) for when, left in seen]


@pytest.mark.parametrize("slow", [0.2, 1.0, 30.0])
def test_a_machine_at_any_pace_is_told_of_rightly_from_the_first_photograph_on(slow):
    takes = {
        "Reading photographs": (10 * slow, 10),
        "Checking": (3 * slow, 0),
        "Solving": (25 * slow, 50),
        "Asked for": (4 * slow, 0),
        "Writing": (6 * slow, 3),
    }
    for really, left in told(takes):
        assert left == pytest.approx(really, rel=0.2, abs=2.5 * slow)
    assert told(takes)[0] == (pytest.approx(47 * slow), pytest.approx(47 * slow))


def test_a_stage_that_takes_longer_than_usual_corrects_itself_and_one_left_out_counts_no_more():
    takes = {"Reading photographs": (10.0, 10), "Solving": (250.0, 100), "Writing": (6.0, 6)}
    found = told(takes)
    assert found[9][1] < 60  # nothing told yet that solving would be slow
    for really, left in found[20:109]:  # a tenth of solving is done
        assert really <= left <= 1.5 * really + 110  # the stages after it are taken to be as slow
    assert found[-1] == (0.0, 0.0) and found[-4][1] == pytest.approx(3.0, abs=3)


def test_a_stage_that_nobody_planned_counts_by_its_own_pace():
    found = told({"Looking for spheres": (5.0, 0), "Counting": (10.0, 10), "Reading photographs": (10.0, 10)})
    assert found[0][1] is None and found[2][1] == pytest.approx(8.0)
    assert found[11][1] == pytest.approx(9.0 + 3 + 25 + 4 + 6)


def test_every_stage_that_reconstruct_and_rti_tell_is_among_those_planned(
    rumu, capture, tmp_path, monkeypatch
):
    planned, seen = set(), set()

    @contextlib.contextmanager
    def stages(those):
        planned.update(one.what for one in those)
        yield lambda what, done, total: seen.add(what)

    monkeypatch.setattr("rumu.cli.reconstruction.stages", stages)
    monkeypatch.setattr("rumu.cli.rti.stages", stages)
    assert rumu("reconstruct", capture, "-o", tmp_path / "out", "--align").code == 0
    assert rumu("rti", capture, "-o", tmp_path / "out.rti", "--order", "1").code == 0
    assert seen == planned and "Fitting the relightable image" in seen


def test_times_read_as_minutes_and_hours():
    assert [clock_time(one) for one in (4.4, 65, 3599.6, 7265)] == ["0:04", "1:05", "1:00:00", "2:01:05"]
