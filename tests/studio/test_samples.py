"""The samples as attempts: once, labelled, judged on the first day."""

from __future__ import annotations

from rumu.database.tables import Attempt
from rumu.gallery.starter import starter_samples
from rumu.studio.comparisons import next_pair
from rumu.studio.samples import put_samples, waiting


def test_samples_are_put_in_once_and_labelled(gallery, place, person):
    put = put_samples(gallery, place=place, advance=lambda done, total: None)
    assert put == len(starter_samples()) and waiting(gallery) == []
    assert put_samples(gallery, place=place, advance=lambda done, total: None) == 0
    with gallery.database.reading() as session:
        rows = session.query(Attempt).all()
        assert next_pair(session, person("林")) is not None
    assert {row.kind for row in rows} == {"simulated"} and {row.person_id for row in rows} == {None}
    assert all(row.score is not None for row in rows)
