"""The tile sets of works: what is tiled, where it lies, and when it is made."""

from __future__ import annotations

import contextlib
import io
import json
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image
from tests.gallery.pages import draw_page

from rumu.errors import GalleryError, RefusedImage, SurfaceError
from rumu.gallery import assets, tile_maps
from rumu.gallery.add_work import add_capture, add_picture
from rumu.gallery.assets import Assets, assets_of, decode_picture, store_surface, surface_key
from rumu.gallery.catalog import delete_work, work
from rumu.gallery.derived import KINDS, delete_least_used, stored_file
from rumu.gallery.iiif import manifest
from rumu.gallery.metadata import WorkMetadata
from rumu.gallery.store import Gallery
from rumu.gallery.tile_maps import LAMPS, LARGE, MAPS, has_tiles, make_tiles, stored_tiles, tiles_etag
from rumu.gallery.tiles import tile_name
from rumu.surface.mesh import albedo_srgb
from rumu.surface.relief import relief
from rumu.values import Bilingual
from rumu_lab.simulation.lamps import photographs
from rumu_lab.simulation.reflectances import spread_lamps

SCALE = 3


def add(gallery: Gallery, path: Path, picture: np.ndarray) -> str:
    Image.fromarray(picture).save(path)
    return add_picture(gallery, path, metadata=WorkMetadata(title=Bilingual("卷", "scroll"))).id


@pytest.fixture(scope="module")
def page() -> np.ndarray:
    """A drawn page, three times as large."""
    picture = np.asarray(draw_page())
    return picture.repeat(SCALE, axis=0).repeat(SCALE, axis=1)


def tiles_of(gallery: Gallery, work_id: str, name: str):
    return stored_tiles(gallery.store, assets_of(gallery.store, work(gallery, work_id)), name)


def test_the_albedo_of_a_picture_is_the_picture(bare, page, tmp_path):
    work_id = add(bare, tmp_path / "page.png", page)
    assert has_tiles(work(bare, work_id)) and tiles_of(bare, work_id, "albedo") is None
    make_tiles(bare, work_id, "albedo")
    tiles = tiles_of(bare, work_id, "albedo")
    assert (tiles.info["width"], tiles.info["height"]) == page.shape[1::-1]
    tile = np.asarray(Image.open(io.BytesIO(tiles.read("512,0,512,512/512,512/0/default.jpg"))))
    assert np.abs(tile.astype(float) - page[:512, 512:1024]).mean() < 2


def test_its_manifest_says_where_the_tiles_are(bare, page, tmp_path):
    work_id = add(bare, tmp_path / "page.png", page)
    links = manifest(bare, work_id, base="https://example.org")["seeAlso"]
    assert [link["id"] for link in links] == [
        f"https://example.org/iiif/tiles/{name}/{work_id}/info.json" for name in MAPS
    ]
    small = add(bare, tmp_path / "small.png", page[:900, :900])
    assert "seeAlso" not in manifest(bare, small, base="https://example.org")


def test_normals_are_as_large_as_the_picture_and_raised_where_there_is_ink(bare, page, tmp_path):
    work_id = add(bare, tmp_path / "page.png", page)
    make_tiles(bare, work_id, "normals")
    tiles = tiles_of(bare, work_id, "normals")
    assert (tiles.info["width"], tiles.info["height"]) == page.shape[1::-1]
    levels = np.asarray(Image.open(io.BytesIO(tiles.read("512,512,512,512/512,512/0/default.png"))))
    gray = page[512:1024, 512:1024].reshape(512, 512, -1).mean(axis=2)
    leaning = np.abs(levels.astype(int) - (128, 128, 255)).max(axis=2) > 8
    assert leaning[gray < 100].mean() > 0.5 and leaning[gray > 180].mean() < 0.2


def stored(store, surface) -> Assets:
    """The assets of a measured work with this surface."""
    key = surface_key("a")
    store_surface(store, key, surface)
    return Assets(
        digest="measured",
        picture_file=contextlib.nullcontext,
        surface=partial(assets._measured_surface, store, key, "none"),
        measured=partial(assets._measured_bands, store, key, "none"),
        capture=lambda: SimpleNamespace(lights=spread_lamps(12)),
    )


def test_a_large_measured_work_is_never_read_whole(bare, page, monkeypatch):
    surface = relief(page[::SCALE, ::SCALE])
    whole, work = stored(bare.store, surface), stored(bare.store, surface)
    small = {
        kind: KINDS[kind].render(whole) for kind in ("facts", "heights", "albedo", "normals-16", "height16")
    }
    work = replace(work, digest="large")
    monkeypatch.setattr("rumu.surface.reduction.SHOWN", surface.height.size // 3)
    monkeypatch.setattr("rumu.surface.surface_bands.SHOWN", surface.height.size // 3)
    monkeypatch.setattr("rumu.surface.folder.read_surface", None)
    for name in MAPS:
        tile_maps._make(bare.store, work, name)
        assert stored_tiles(bare.store, work, name) is not None
    for kind in KINDS.keys() - {"picture", "thumb", "lamp-a", "lamp-b", "lamp-c", "stl", "glb", "ply"}:
        assert KINDS[kind].render(work)
    for kind in ("normals-16", "height16"):  # whole, to the last bit
        assert KINDS[kind].render(work) == small[kind]
    before, after = (json.loads(one) for one in (small["facts"], KINDS["facts"].render(work)))
    assert after["height16"] == before["height16"] and after["pixels"] == before["pixels"]
    assert after["spacing"] == pytest.approx(before["spacing"], rel=0.01)
    rows, columns = before["heights"]["height"], before["heights"]["width"]
    first, second = (np.frombuffer(one, "<f4") for one in (small["heights"], KINDS["heights"].render(work)))
    assert np.corrcoef(first, second.reshape(-1)[: rows * columns])[0, 1] > 0.99


def test_a_whole_surface_that_does_not_fit_is_refused_with_what_it_takes(bare, page, monkeypatch):
    work = stored(bare.store, relief(page[::SCALE, ::SCALE]))
    monkeypatch.setattr("rumu.capture.memory_plan.available_memory", lambda: 1_000_000)
    with pytest.raises(SurfaceError, match=r"expected \d+ MB of free memory for the whole surface") as caught:
        work.surface()
    assert "這件作品的整個表面要" in caught.value.zh


def test_a_measured_work_is_tiled_from_its_surface(bare, page):
    surface = relief(page[::SCALE, ::SCALE])
    files = stored(bare.store, surface)
    for name in MAPS:
        tile_maps._make(bare.store, files, name)
    tiles = {name: stored_tiles(bare.store, files, name) for name in MAPS}
    height, width = surface.height.shape
    for name, suffix, expected in (
        ("normals", "png", surface.normals * 127.5 + 127.5),
        ("albedo", "jpg", albedo_srgb(surface.albedo)),
    ):
        assert (tiles[name].info["height"], tiles[name].info["width"]) == (height, width)
        first = tile_name(0, 0, scale=1, width=width, height=height, suffix=suffix)
        tile = np.asarray(Image.open(io.BytesIO(tiles[name].read(first)))).astype(float)
        assert np.abs(tile - expected[:512, :512]).mean() < (0.6 if name == "normals" else 3)


def test_heights_are_tiled_in_levels(bare, page):
    surface = relief(page[::SCALE, ::SCALE])
    files = stored(bare.store, surface)
    tile_maps._make(bare.store, files, "heights")
    tiles = stored_tiles(bare.store, files, "heights")
    height, width = surface.height.shape
    told = tiles.info["heights"]
    for scale in (1, 2):
        name = tile_name(0, 0, scale=scale, width=width, height=height, suffix="png")
        levels = np.asarray(Image.open(io.BytesIO(tiles.read(name)))).astype(float)
        found = (256 * levels[..., 0] + levels[..., 1]) * told["scale"] + told["offset"]
        whole = surface.height[: height // 2 * 2, : width // 2 * 2]
        means = whole if scale == 1 else whole.reshape(height // 2, 2, width // 2, 2).mean(axis=(1, 3))
        rows, columns = np.minimum(means.shape, found.shape)
        assert np.abs(found[:rows, :columns][:512, :512] - means[:512, :512]).max() <= 1.01 * told["scale"]


def test_photographs_under_three_lamps_are_tiled_as_they_are(bare, page, tmp_path, monkeypatch):
    """And the picture of a measured work, which is another than its albedo; of a large one at once."""
    folder = tmp_path / "capture"
    folder.mkdir()
    surface = relief(page[::SCALE, ::SCALE])
    images, lights = photographs(surface.height, surface.albedo, tilts=(180, 0, 90), slant=40)
    lines = ["3"]
    for number, (image, light) in enumerate(zip(images, lights, strict=True)):
        Image.fromarray(np.round(255 * image).astype(np.uint8)).save(folder / f"{number}.png")
        lines.append(f"{number}.png {light[0]:.6f} {light[1]:.6f} {light[2]:.6f}")
    (folder / "lights.lp").write_text("\n".join(lines))
    (folder / "capture.json").write_text('{"encoding": "linear"}')
    monkeypatch.setattr(tile_maps, "LARGE", 1000)
    added = add_capture(bare, folder, metadata=WorkMetadata(title=Bilingual("碑", "stele")))
    files = assets_of(bare.store, work(bare, added.id))
    for kind in (
        "facts",
        "heights",
        "albedo",
        "normals",
        "picture",
        "mask",
        *LAMPS,
    ):  # what its page asks for
        assert stored_file(bare.store, files, kind) is not None or kind == "picture", kind
    height, width = surface.height.shape
    first = tile_name(0, 0, scale=1, width=width, height=height, suffix="jpg")

    def tile(name):
        tiles = tiles_of(bare, added.id, name)
        assert (tiles.info["height"], tiles.info["width"]) == (height, width)
        return np.asarray(Image.open(io.BytesIO(tiles.read(first)))).astype(float)

    for name, number in zip(LAMPS, (1, 2, 0), strict=True):  # tilts 0, 90, 180
        told = albedo_srgb(images[number][:512, :512])
        assert np.abs(tile(name) - (told if tile(name).ndim == told.ndim else told[..., 0])).mean() < 2
    assert np.abs(tile("lamp-a") - tile("lamp-c")).mean() > 1
    mean = np.asarray(decode_picture(bare.store.read(work(bare, added.id).picture)))[:512, :512]
    assert np.abs(tile("picture") - mean).mean() < 2


def test_a_work_from_one_picture_has_no_photographs(bare, page, tmp_path):
    work_id = add(bare, tmp_path / "page.png", page)
    for name in ("picture", *LAMPS):
        with pytest.raises(GalleryError, match=r"expected a work (from|with) photographs"):
            make_tiles(bare, work_id, name)


def test_a_set_is_made_once_and_again_when_it_is_gone(bare, page, tmp_path, monkeypatch):
    work_id = add(bare, tmp_path / "page.png", page)
    made = []
    real = tile_maps.write_tiles
    monkeypatch.setattr(tile_maps, "write_tiles", lambda *all: (made.append(1), real(*all)))
    for _ in range(2):
        make_tiles(bare, work_id, "albedo")
    assert len(made) == 1
    assert delete_least_used(bare.store, most=1) >= 1 and tiles_of(bare, work_id, "albedo") is None
    make_tiles(bare, work_id, "albedo")
    assert len(made) == 2


def test_only_a_large_work_is_tiled_when_it_is_added(bare, page, tmp_path, monkeypatch):
    assert page.shape[0] * page.shape[1] < LARGE
    assert tiles_of(bare, add(bare, tmp_path / "a.png", page), "albedo") is None
    monkeypatch.setattr(tile_maps, "LARGE", page.shape[0] * page.shape[1] - 1)
    work_id = add(bare, tmp_path / "b.png", 255 - (255 - page) // 2)
    assert all(tiles_of(bare, work_id, name) is not None for name in MAPS)


def test_the_tiles_of_a_deleted_work_are_deleted(bare, page, tmp_path):
    work_id = add(bare, tmp_path / "page.png", page)
    make_tiles(bare, work_id, "albedo")
    delete_work(bare, work_id)
    assert not list(bare.store.files("derived"))


def test_the_maps_of_a_work_have_versions_of_their_own(bare, page, tmp_path):
    files = assets_of(bare.store, work(bare, add(bare, tmp_path / "page.png", page)))
    assert tiles_etag(files, "albedo") != tiles_etag(files, "normals")
    with pytest.raises(GalleryError, match="expected a map among albedo, normals"):
        tiles_etag(files, "slopes")


def test_a_blank_leaf_has_tiles_of_its_picture_and_no_normals(bare, page, tmp_path):
    work_id = add(bare, tmp_path / "page.png", page)
    blank = np.full((1100, 1300), 230, np.uint8)
    Image.fromarray(blank).save(tmp_path / "blank.png")
    with bare.database.writing() as session:
        row = session.get_one(type(work(bare, work_id)), work_id)
        row.picture, row.width, row.height = "pictures/aa/blank.png", 1300, 1100
    bare.store.write("pictures/aa/blank.png", (tmp_path / "blank.png").read_bytes())
    make_tiles(bare, work_id, "albedo")
    assert tiles_of(bare, work_id, "albedo").info["width"] == 1300
    with pytest.raises(RefusedImage):
        make_tiles(bare, work_id, "normals")
