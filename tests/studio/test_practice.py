"""Curves and their tables."""

from __future__ import annotations

import csv
import io
from datetime import timedelta

import pytest

from rumu.database.tables import Attempt, now
from rumu.studio import practice
from rumu.studio.errors import Missing


@pytest.fixture
def written(gallery, person):
    """Three attempts at one work (the second refused), one at another, later."""
    lin = person("林")
    start = now() - timedelta(days=3)
    with gallery.database.writing() as session:
        for day, (work, score) in enumerate(
            [("regular-tian", 40.0), ("regular-tian", None), ("regular-tian", 62.5), ("regular-shui", 30.0)]
        ):
            mark = {
                "interval": score and [score - 10, score + 10],
                "parts": [{"name": "structure", "score": 50.0}],
                "remarks": [{"kind": "lean"}, {"kind": "missing"}],
                "refused": None if score else {"code": "blank"},
            }
            session.add(
                Attempt(
                    person_id=lin.id,
                    work_id=work,
                    kind="pen",
                    picture="p",
                    score=score,
                    level=score and "bad",
                    mark=mark,
                    version="0",
                    created=start + timedelta(days=day),
                )
            )
    return lin


def test_curves_by_work_the_latest_first(gallery, written):
    with gallery.database.reading() as session:
        tian, shui = sorted(practice.curves(session, written.id), key=lambda c: -len(c.attempts))
        assert [c.work.id for c in practice.curves(session, written.id)] == ["regular-shui", "regular-tian"]
    assert tian.scores == [40.0, 62.5] and len(tian.points) == 3 and shui.scores == [30.0]
    assert [p.interval for p in tian.points] == [(30, 50), None, (52.5, 72.5)]
    with gallery.database.reading() as session, pytest.raises(Missing):
        practice.curve(session, written.id, work_id="seal-tian")


def test_the_table_is_one_row_an_attempt(gallery, written):
    with gallery.database.reading() as session:
        rows = list(csv.DictReader(io.StringIO(practice.attempts_csv(session, written.id))))
    assert [row["score"] for row in rows] == ["40.0", "", "62.5", "30.0"]
    assert (
        rows[1]["refused"] == "blank"
        and rows[0]["remarks"] == "lean; missing"
        and rows[0]["structure"] == "50.0"
    )
    assert tuple(rows[0]) == practice.COLUMNS
