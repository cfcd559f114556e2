"""The samples as attempts: once, labelled, judged on the first day."""

from __future__ import annotations

import pytest

from rumu.database.tables import Attempt
from rumu.gallery.assets import assets_of, derived_folder
from rumu.gallery.catalog import work
from rumu.gallery.cover import choose_cover
from rumu.gallery.derived import stored_file
from rumu.gallery.starter import starter_samples
from rumu.studio.comparisons import next_pair
from rumu.studio.job_handlers import add_samples, missing_samples, prepare
from rumu.studio.job_queue import CancelledError


def test_samples_are_put_in_once_and_labelled(gallery, storage, person):
    put = add_samples(gallery, storage=storage)
    assert put == len(starter_samples()) and missing_samples(gallery) == []
    assert add_samples(gallery, storage=storage) == 0
    with gallery.database.reading() as session:
        rows = session.query(Attempt).all()
        assert next_pair(session, person("林")) is not None
    assert {row.kind for row in rows} == {"simulated"} and {row.person_id for row in rows} == {None}
    assert all(row.score is not None for row in rows)


def test_the_home_page_is_prepared_before_the_thumbnails(gallery, storage):
    def stop(*_) -> None:
        raise CancelledError

    choose_cover(gallery, "running-shui")
    assets = assets_of(gallery.store, work(gallery, "running-shui"))
    gallery.store.delete(derived_folder(assets.digest))  # what came with the package
    with pytest.raises(CancelledError):
        prepare(gallery, {}, stop, storage)
    kinds = ("cover", "cover-normals", "thumb")
    made = [stored_file(gallery.store, assets, kind) is not None for kind in kinds]
    assert made == [True, True, False]
