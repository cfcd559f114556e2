"""What an interrupted import leaves is harmless, and goes."""

from __future__ import annotations

import os
import time

from rumu.gallery.assets import DAY, delete_orphans
from rumu.gallery.catalog import works
from rumu.gallery.derived import derived


def test_only_what_no_work_names_goes_and_only_when_it_is_old(gallery):
    derived(gallery, "seal-ri", "thumb")
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
