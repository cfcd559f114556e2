"""The work on the home page: the owner's choice while it exists, else a measured one."""

from __future__ import annotations

from io import BytesIO

import numpy as np
import pytest
from PIL import Image

from rumu.errors import GalleryError
from rumu.gallery import catalog, cover
from rumu.gallery.assets import assets_of, surface_files
from rumu.gallery.derived import derived_file
from rumu.gallery.renderers import COVER, COVER_NORMALS


def test_the_measured_work_stands_on_the_home_page_until_another_is_chosen(gallery) -> None:
    work, chosen = cover.cover_work(gallery)
    assert work is not None and not chosen
    assert (work.id, work.height_source) == ("stele-ru-mu-san-fen", "photometric")
    cover.choose_cover(gallery, "running-shui")
    assert cover.cover_work(gallery)[0].id == "running-shui" and cover.cover_work(gallery)[1]
    cover.choose_cover(gallery, "regular-shu")
    catalog.delete_work(gallery, "regular-shu")
    assert cover.cover_work(gallery)[0].id == work.id and not cover.cover_work(gallery)[1]
    cover.choose_cover(gallery, "seal-tian")
    cover.choose_cover(gallery, None)
    assert cover.cover_work(gallery)[0].id == work.id
    with pytest.raises(GalleryError, match="no work 'nothing'"):
        cover.choose_cover(gallery, "nothing")


def test_an_bare_has_no_cover(bare) -> None:
    assert cover.cover_work(bare) == (None, False)


def test_the_stele_is_measured_from_its_photographs_when_it_is_first_looked_at(gallery) -> None:
    """Carved strokes lie below the slab; the files of the home page are small enough for a phone."""
    work = catalog.work(gallery, "stele-ru-mu-san-fen")
    assert not gallery.store.exists(f"{work.surface}/surface.json")
    surface = assets_of(gallery.store, work).surface()
    assert surface.source == "photometric" and surface.unit == "mm"
    assert surface.height.shape == (work.height, work.width)
    assert np.median(surface.height) - np.percentile(surface.height, 1) > 1.5  # grooves of four millimetres
    assert np.percentile(surface.height, 99) - np.median(surface.height) < 1.5  # and nothing stands out
    keys = surface_files(gallery.store, work)
    assert f"{work.surface}/surface.json" in keys and f"{work.surface}/normals.tif" in keys
    sizes = {kind: derived_file(gallery, work.id, kind).data for kind in ("cover", "cover-normals")}
    assert sum(map(len, sizes.values())) < 400_000
    assert max(Image.open(BytesIO(sizes["cover"])).size) == min(COVER, work.width)
    assert max(Image.open(BytesIO(sizes["cover-normals"])).size) == COVER_NORMALS
