"""What an empty gallery begins with."""

from __future__ import annotations

import numpy as np
import pytest
from tests.gallery.conftest import surface

from rumu.gallery.annotations import annotations_of
from rumu.gallery.catalog import work, works
from rumu.gallery.seed import add_starter_works
from rumu.gallery.tours import tours


def test_it_begins_once(gallery, everything):
    before = everything(gallery)
    assert add_starter_works(gallery) is False
    assert everything(gallery) == before


def test_the_tours_lead_through_works_and_speak_both_languages(gallery):
    assert len(tours(gallery)) == 2
    for tour in tours(gallery):
        assert tour.title_zh and tour.title_en and len(tour.steps) >= 4
        for step in tour.steps:
            assert work(gallery, step["work"])
            assert all(step[f"{name}_{language}"] for name in ("title", "text") for language in ("zh", "en"))
            assert "=" in step["view"]


def test_what_is_said_of_a_stroke_stands_on_its_ink(gallery):
    said = [(row.id, one) for row in works(gallery).items for one in annotations_of(gallery, row.id)]
    assert len(said) == 8
    for work_id, one in said:
        mask = surface(gallery, work_id).mask
        row, column = round(one.y * 512), round(one.x * 512)
        assert mask[row - 8 : row + 9, column - 8 : column + 9].any(), (work_id, one.title_en)


def test_seal_script_is_as_even_as_the_tour_says(gallery):
    """'The line of seal script keeps one width': widths along it vary least of the five."""
    from skimage.morphology import medial_axis

    spread = {}
    for script in ("seal", "clerical", "regular", "running", "cursive"):
        axis, depth = medial_axis(surface(gallery, f"{script}-shui").mask, return_distance=True, rng=0)
        widths = depth[axis & (depth > 2)]
        spread[script] = float(np.std(widths) / np.mean(widths))
    assert min(spread, key=spread.get) == "seal"
    assert spread["seal"] < 0.5 * min(
        value for name, value in spread.items() if name not in ("seal", "clerical")
    )


@pytest.mark.parametrize("script", ["seal", "regular"])
def test_the_parts_of_shui_are_as_many_as_said(gallery, script):
    """'A long line with two short ones on each side' in seal script."""
    from scipy import ndimage

    _, parts = ndimage.label(surface(gallery, f"{script}-shui").mask)
    assert parts == {"seal": 5, "regular": 2}[script]


def test_what_the_first_pages_show_comes_with_the_package(tmp_path):
    """And is what would be made: else run scripts/make_starter_derived.py."""
    import io

    from PIL import Image

    from rumu.gallery.assets import assets_of
    from rumu.gallery.catalog import open_gallery
    from rumu.gallery.derived import KINDS, derived_file, stored_file
    from rumu.studio.job_handlers import make_first_files

    new = open_gallery(database=tmp_path / "a.sqlite", files=tmp_path / "files")
    shipped = {key: new.store.read(key) for key in new.store.keys("derived")}
    make_first_files(new, lambda done, total: None)
    assert set(new.store.keys("derived")) == set(shipped)  # nothing had to be made, nothing is superfluous
    for work_id, kind in (
        ("stele-ru-mu-san-fen", "cover"),
        ("stele-ru-mu-san-fen", "cover-normals"),
        ("regular-shui", "thumb"),
        ("long-cang-yong", "thumb-normals"),
    ):
        known = stored_file(new.store, assets_of(new.store, work(new, work_id)), kind)
        made = KINDS[kind].render(assets_of(new.store, work(new, work_id)))
        then, now = (np.asarray(Image.open(io.BytesIO(data)), float) for data in (known.data, made))
        assert then.shape == now.shape
        assert np.abs(then - now).mean() < 1, (work_id, kind)
        assert derived_file(new, work_id, kind).data == known.data
