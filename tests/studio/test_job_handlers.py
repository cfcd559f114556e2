"""The samples as attempts: once, labelled, judged on the first day."""

from __future__ import annotations

from rumu.database.tables import Attempt
from rumu.gallery.starter import starter_samples
from rumu.studio.comparisons import next_pair
from rumu.studio.job_handlers import add_samples, missing_samples


def test_samples_are_put_in_once_and_labelled(gallery, storage, person):
    put = add_samples(gallery, storage=storage)
    assert put == len(starter_samples()) and missing_samples(gallery) == []
    assert add_samples(gallery, storage=storage) == 0
    with gallery.database.reading() as session:
        rows = session.query(Attempt).all()
        assert next_pair(session, person("林")) is not None
    assert {row.kind for row in rows} == {"simulated"} and {row.person_id for row in rows} == {None}
    assert all(row.score is not None for row in rows)
