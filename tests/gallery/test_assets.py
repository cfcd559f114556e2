"""The surfaces of works, each computed once, and files that belong to no work."""

from __future__ import annotations

import os
import threading
import time

import numpy as np
import pytest
from tests.gallery.conftest import surface

from rumu.gallery.assets import DAY, delete_orphans
from rumu.gallery.catalog import change_work, work, works
from rumu.gallery.derived import derived_file
from rumu.gallery.starter import find_work


def test_only_what_no_work_names_goes_and_only_when_it_is_old(gallery):
    derived_file(gallery, "seal-ri", "thumb")
    before = {key for place in ("pictures", "derived") for key in gallery.store.keys(place)}
    strays = ("pictures/aa/stray.png", "captures/aa/stray/001.png", "surfaces/aa/stray/height.tif")
    for key in (*strays, "pictures/aa/half.png.0123.part", "derived/aa/x.part", "attempts/a/picture.png"):
        gallery.store.write(key, b"x")
    assert delete_orphans(gallery) == 0
    past = time.time() - 2 * DAY
    for place in ("pictures", "captures", "surfaces", "derived", "attempts"):
        for key in gallery.store.keys(place):
            os.utime(gallery.store.path(key), (past, past))
    assert delete_orphans(gallery) == 5
    assert {key for place in ("pictures", "derived") for key in gallery.store.keys(place)} == before
    assert gallery.store.exists("attempts/a/picture.png")
    for row in works(gallery).items:
        assert gallery.store.exists(row.picture)


def test_the_surface_of_a_picture_is_its_relief(gallery):
    from rumu.pipeline import surface_of

    ours = surface(gallery, "regular-tian")
    assert ours.source == "inflation"
    assert np.array_equal(ours.height, surface_of(find_work("regular-tian").path).height)
    assert surface(gallery, "regular-tian") is ours


def test_a_spacing_makes_millimetres(gallery):
    pixels = surface(gallery, "seal-yue")
    change_work(gallery, "seal-yue", {"spacing": 0.25})
    millimetres = surface(gallery, "seal-yue")
    assert (millimetres.unit, millimetres.spacing) == ("mm", 0.25)
    assert np.allclose(millimetres.height, pixels.height * 0.25)


def test_a_surface_is_computed_once_however_many_threads_ask_for_it(gallery, monkeypatch):
    from rumu.surface import relief as module

    computed, real, surfaces = [], module.relief, []

    def slow(image, **options):
        computed.append(1)
        time.sleep(0.2)
        return real(image, **options)

    monkeypatch.setattr(module, "relief", slow)
    threads = [
        threading.Thread(target=lambda: surfaces.append(surface(gallery, "seal-tian"))) for _ in range(6)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(computed) == 1 and len(surfaces) == 6 and all(one is surfaces[0] for one in surfaces)


def test_a_surface_that_cannot_be_computed_is_tried_again(gallery, monkeypatch):
    from rumu.surface import relief as module

    def fails(image, **options):
        raise MemoryError

    monkeypatch.setattr(module, "relief", fails)
    with pytest.raises(MemoryError):
        surface(gallery, "seal-tian")
    monkeypatch.undo()
    assert surface(gallery, "seal-tian").source == "inflation"


def test_one_cache_holds_surfaces_and_pictures_up_to_a_size(gallery):
    from rumu.gallery import assets

    surface(gallery, "seal-tian")
    key = work(gallery, "seal-tian").picture
    picture = assets.read_picture(gallery.store, key)
    assert assets.read_picture(gallery.store, key) is picture
    assert 0 < assets._cache.currsize <= assets._cache.maxsize
    assert assets._cache[gallery.store, key] is picture
