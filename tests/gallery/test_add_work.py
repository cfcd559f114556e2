"""One work more: a picture, photographs, glyphs of a font."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from tests.gallery.conftest import surface

from rumu.errors import CaptureError, GalleryError, ImageError, RefusedImage, SurfaceError
from rumu.gallery.add_work import add_capture, add_glyphs, add_picture, named_collection
from rumu.gallery.catalog import work, works
from rumu.gallery.derived import derived_file, viewer_facts
from rumu.gallery.metadata import EMPTY, WorkMetadata
from rumu.gallery.starter import find_work
from rumu.values import Bilingual

CAT = WorkMetadata(title=Bilingual("貓", "Cat"))


def test_a_picture_is_kept_as_it_came(gallery):
    path = find_work("regular-shui").path
    entry = WorkMetadata(title=Bilingual("水", "water"), character="水", script="regular")
    first = add_picture(
        gallery, path, metadata=entry, collection=named_collection("Mine & yours"), spacing=0.1
    )
    kept = work(gallery, first.id)
    assert first.new and kept.collection_id == "mine-yours" and kept.origin == "regular-shui.png"
    assert gallery.store.read(kept.picture) == path.read_bytes()
    assert (kept.licence, kept.spacing, surface(gallery, first.id).unit) == ("none stated", 0.1, "mm")
    again = add_picture(gallery, path, metadata=entry, collection=named_collection("Mine & yours"))
    assert (again.id, again.new) == (first.id, False)


def test_a_height_from_density_says_so(bare):
    entry = WorkMetadata(title=Bilingual("水", "water"))
    added = add_picture(bare, find_work("regular-shui").path, metadata=entry, method="density")
    assert work(bare, added.id).height_source == surface(bare, added.id).source == "density"


def test_what_holds_no_writing_is_refused(bare, tmp_path):
    Image.new("L", (64, 64), 255).save(tmp_path / "blank.png")
    (tmp_path / "words.png").write_text("words")
    with pytest.raises(RefusedImage, match=r"blank\.png: "):
        add_picture(bare, tmp_path / "blank.png", metadata=CAT)
    with pytest.raises(ImageError):
        add_picture(bare, tmp_path / "words.png", metadata=CAT)
    with pytest.raises(SurfaceError, match="method: expected one of inflation, density, got 'depth'"):
        add_picture(bare, find_work("regular-shui").path, metadata=CAT, method="depth")
    assert works(bare).total == 0 and list(bare.store.keys("pictures")) == []


def test_a_whole_page_is_taken_and_its_characters_have_relief(bare, data):
    file = data / "pages" / "printed" / "qianlong-80.jpg"
    added = add_picture(bare, file, metadata=WorkMetadata(title=Bilingual("乾隆藏", "Qianlong canon")))
    relief = surface(bare, added.id)
    assert relief.height.shape == (1568, 1120)
    assert relief.mask.mean() > 0.08 and (relief.height[relief.mask] > 0).all()


@pytest.fixture
def mound(tmp_path: Path):
    """A function of lamps (name to vector): a folder of photographs of a low mound, and lights.lp."""

    def make(lamps: dict[str, tuple[float, float, float]], *, side: int = 40) -> Path:
        folder = tmp_path / "capture"
        folder.mkdir()
        y, x = np.mgrid[1 : -1 : side * 1j, -1 : 1 : side * 1j]
        drow, dcol = np.gradient(side / 10 * np.exp(-4 * (x**2 + y**2)))
        normals = np.dstack([-dcol, drow, np.ones_like(x)])
        normals /= np.linalg.norm(normals, axis=2, keepdims=True)
        lines = [str(len(lamps))]
        for name, lamp in lamps.items():
            light = np.array(lamp) / np.linalg.norm(lamp)
            shade = np.round(np.clip(0.8 * normals @ light, 0, 1) * 65535).astype(np.uint16)
            Image.fromarray(shade).save(folder / name)
            lines.append(f"{name} {light[0]:.8f} {light[1]:.8f} {light[2]:.8f}")
        (folder / "lights.lp").write_text("\n".join(lines) + "\n")
        return folder

    return make


FIVE = {
    f"燈 {n}.png": light for n, light in enumerate([(1, 0, 2), (0, 1, 2), (-1, 0, 2), (0, -1, 2), (1, 1, 3)])
}
THREE = {"a.png": (1.0, 0, 1), "b.png": (0, 1.0, 1), "c.png": (-1.0, 0, 1)}


def test_a_capture_is_kept_with_photographs_and_surface(gallery, mound):
    from rumu.capture.folder import read_capture
    from rumu.gallery.assets import assets_of
    from rumu.pipeline import reconstruct

    folder = mound(FIVE)
    (folder / "capture.json").write_text('{"spacing_mm": 0.05}')
    added = add_capture(gallery, folder, metadata=CAT)
    kept, wanted = work(gallery, added.id), reconstruct(folder)
    assert (kept.kind, kept.height_source, kept.spacing) == ("capture", "photometric", 0.05)
    assert np.allclose(surface(gallery, added.id).height, wanted.height, atol=1e-5)
    again = assets_of(gallery.store, work(gallery, added.id)).capture()
    assert np.array_equal(again.images, read_capture(folder).images) and again.spacing == 0.05
    photographs = [key for key in gallery.store.keys(kept.capture) if key.endswith("0.png") or "00" in key]
    assert {gallery.store.read(key) for key in photographs} == {(folder / name).read_bytes() for name in FIVE}
    assert add_capture(gallery, folder, metadata=CAT) == type(added)(added.id, False)
    assert viewer_facts(gallery, added.id)["three_lamps"] is None
    with pytest.raises(GalleryError, match="three lamps"):
        derived_file(gallery, added.id, "lamp-a")


def test_lamps_near_the_sheet_keep_their_places(gallery, tmp_path):
    from rumu.capture.folder import read_capture
    from rumu.gallery.assets import assets_of
    from rumu.pipeline import reconstruct

    folder, side, mm = tmp_path / "near", 40, 0.5
    folder.mkdir()
    y, x = np.mgrid[1 : -1 : side * 1j, -1 : 1 : side * 1j] * (side - 1) / 2 * mm
    places = [
        (25.0, 0, 30),
        (0, 25.0, 30),
        (-25.0, 0, 30),
        (0, -25.0, 30),
        (18.0, 18.0, 40),
        (-18.0, 18.0, 40),
    ]
    adjust = [1.0, 0.8, 1.25, 1.0, 0.9, 1.1]
    for number, (place, by) in enumerate(zip(places, adjust, strict=True)):
        away = np.dstack([place[0] - x, place[1] - y, np.full_like(x, place[2])])
        shade = 500.0 / by * away[..., 2] / np.linalg.norm(away, axis=2) ** 3 + 0.1 * (np.hypot(x, y) < 4)
        Image.fromarray(np.round(np.clip(shade, 0, 1) * 65535).astype(np.uint16)).save(
            folder / f"光{number}.png"
        )
    told = [dict(zip("xyz", place, strict=True)) for place in places]
    dome = {"lightConfiguration": "lights3d", "imageWidth": side * mm, "positions3d": told}
    dome["ledAdjust"] = [dict.fromkeys("rgb", by) for by in adjust]
    (folder / "lamps.dome").write_text(json.dumps(dome))
    before, wanted = read_capture(folder), reconstruct(folder)
    added = add_capture(gallery, folder, metadata=CAT)
    after = assets_of(gallery.store, work(gallery, added.id)).capture()
    np.testing.assert_allclose(after.positions, before.positions, rtol=1e-9)
    np.testing.assert_allclose(after.strengths, before.strengths, rtol=1e-9)
    assert after.spacing == before.spacing == mm
    np.testing.assert_allclose(after.images, before.images, atol=1e-6)
    np.testing.assert_allclose(reconstruct(after).height, wanted.height, atol=1e-4)
    np.testing.assert_allclose(surface(gallery, added.id).height, wanted.height, atol=1e-4)


def test_three_lamps_of_the_papers_kind_keep_their_photographs_for_mixing(bare, mound):
    added = add_capture(bare, mound(THREE), metadata=CAT)
    lamps = viewer_facts(bare, added.id)["three_lamps"]
    assert set(lamps) == {"a", "b", "c", "slant"} and lamps["slant"] == pytest.approx(45, abs=0.01)
    shown = [derived_file(bare, added.id, f"lamp-{name}").data for name in "abc"]
    assert len(set(shown)) == 3


def test_a_capture_comes_back_from_an_export(gallery, bare, mound, tmp_path, everything):
    from rumu.gallery.archive import export_gallery
    from rumu.gallery.bulk_import import import_folder
    from rumu.gallery.catalog import delete_work

    added = add_capture(gallery, mound(FIVE), metadata=CAT)
    export_gallery(gallery, tmp_path / "out")
    import_folder(bare, tmp_path / "out")
    assert everything(bare) == everything(gallery)
    assert np.array_equal(surface(bare, added.id).height, surface(gallery, added.id).height)
    kept = work(bare, added.id)
    delete_work(bare, added.id)
    assert not bare.store.exists(kept.capture) and not bare.store.exists(kept.surface)


def test_photographs_that_do_not_belong_together_are_refused(bare, mound):
    folder = mound(FIVE)
    (folder / "lights.lp").unlink()
    with pytest.raises(CaptureError):
        add_capture(bare, folder, metadata=CAT)
    assert works(bare).total == 0


def test_characters_of_a_font_become_works(bare, data):
    font = data / "fonts" / "LXGWSeal-Regular.ttf"
    added = add_glyphs(bare, font, "天 水天", metadata=WorkMetadata(title=EMPTY, script="seal"))
    assert [work(bare, one.id).character for one in added] == ["天", "水"]
    kept = work(bare, added[0].id)
    assert "OFL" in kept.licence or "Open Font License" in kept.licence
    assert "LXGW" in kept.title_zh and "digital letterform" in kept.material_en
    with (
        Image.open(find_work("seal-tian").path) as shipped,
        Image.open(bare.store.path(kept.picture)) as ours,
    ):
        assert np.abs(np.asarray(shipped, int) - np.asarray(ours, int)).mean() < 0.5


@pytest.mark.parametrize("characters", ["永", "天永", "", " "])
def test_a_character_that_the_font_lacks_adds_nothing(bare, data, characters):
    with pytest.raises(GalleryError, match=r"has no 永|expected characters"):
        add_glyphs(
            bare, data / "fonts" / "LXGWSeal-Regular.ttf", characters, metadata=WorkMetadata(title=EMPTY)
        )
    assert works(bare).total == 0


def test_what_is_no_font_is_refused(bare, tmp_path):
    (tmp_path / "x.ttf").write_text("words")
    for path, words in (
        (tmp_path / "x.ttf", "cannot read it"),
        (tmp_path / "y.ttf", "expected a font there"),
    ):
        with pytest.raises(GalleryError, match=words):
            add_glyphs(bare, path, "天", metadata=WorkMetadata(title=EMPTY))


def test_a_surface_that_another_work_has_is_never_replaced(gallery, mound):
    folder = mound(FIVE)
    first = add_capture(gallery, folder, metadata=CAT)
    key = f"{work(gallery, first.id).surface}/height.tif"
    theirs = gallery.store.read(key)[:-1] + b"x"
    gallery.store.write(key, theirs)
    second = add_capture(gallery, folder, metadata=replace(CAT, character="貓"))
    assert second.new and work(gallery, second.id).surface == work(gallery, first.id).surface
    assert gallery.store.read(key) == theirs
