"""Tile sets: where tiles lie, what they hold, and what they are called."""

from __future__ import annotations

import io
import json
import zipfile

import numpy as np
import pytest
from PIL import Image

from rumu.capture.image import to_linear
from rumu.errors import GalleryError
from rumu.gallery.store import Store
from rumu.gallery.tiles import TILE, TileMap, open_tiles, scale_factors, tile_info, tile_name, write_tiles
from rumu.surface.mesh import albedo_srgb

WIDTH, HEIGHT = 1301, 1025  # odd, and one pixel more than two tiles


def made(picture: np.ndarray, kind: str, *, rows: int = 200) -> zipfile.ZipFile:
    height, width = picture.shape[:2]
    bands = lambda: (picture[top : top + rows] for top in range(0, height, rows))  # noqa: E731
    stream = io.BytesIO()
    write_tiles(TileMap(width, height, bands, kind), stream)
    return zipfile.ZipFile(stream)


def pixels(archive: zipfile.ZipFile, name: str) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(archive.read(name))))


@pytest.fixture
def normals() -> np.ndarray:
    """Normals of a wavy surface, as uint8."""
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(np.float32)
    n = np.stack([np.sin(x / 40), np.cos(y / 55), np.full_like(x, 2)], axis=2)
    n /= np.linalg.norm(n, axis=2, keepdims=True)
    return np.round(n * 127.5 + 127.5).astype(np.uint8)


@pytest.mark.parametrize(
    ("width", "height", "factors"),
    [(512, 512, [1]), (513, 8, [1, 2]), (40, 1025, [1, 2, 4]), (16_000, 7_500, [1, 2, 4, 8, 16, 32])],
)
def test_levels_end_where_the_whole_map_is_one_tile(width, height, factors):
    assert scale_factors(width, height) == factors


def test_every_tile_that_the_info_promises_is_there_and_nothing_else(normals):
    archive = made(normals, "normals")
    info = json.loads(archive.read("info.json"))
    names = {"info.json"}
    for scale in info["tiles"][0]["scaleFactors"]:
        for row in range(-(-HEIGHT // (TILE * scale))):
            for column in range(-(-WIDTH // (TILE * scale))):
                names.add(tile_name(column, row, scale=scale, width=WIDTH, height=HEIGHT, suffix="png"))
    assert set(archive.namelist()) == names and len(archive.namelist()) == len(names)
    assert info["sizes"] == [{"width": 326, "height": 257}] and info["profile"] == "level0"


def test_a_tile_has_the_size_that_its_name_says_also_at_the_edge(normals):
    archive = made(normals, "normals")
    for name in set(archive.namelist()) - {"info.json"}:
        width, height = map(int, name.split("/")[1].split(","))
        assert pixels(archive, name).shape == (height, width, 3)


def test_the_finest_tiles_of_normals_are_the_map_itself(normals):
    archive = made(normals, "normals")
    whole = np.zeros_like(normals)
    for name in archive.namelist():
        if name == "info.json":
            continue
        (x, y, w, h), (wide, _) = (tuple(map(int, part.split(","))) for part in name.split("/")[:2])
        if w == wide:
            whole[y : y + h, x : x + w] = pixels(archive, name)
    assert np.array_equal(whole, normals)


def test_coarse_normals_are_unit_vectors_and_the_mean_of_those_under_them(normals):
    archive = made(normals, "normals")
    coarse = pixels(archive, f"0,0,{WIDTH},{HEIGHT}/326,257/0/default.png").astype(float) / 127.5 - 1
    assert np.allclose(np.linalg.norm(coarse, axis=2), 1, atol=0.01)
    mean = (normals[400:404, 800:804].astype(float) / 127.5 - 1).mean(axis=(0, 1))
    cosine = coarse[100, 200] @ mean / (np.linalg.norm(mean) * np.linalg.norm(coarse[100, 200]))
    assert cosine > np.cos(np.radians(1))


@pytest.mark.parametrize("rows", [1, 511, 512, 1025])
def test_bands_of_any_height_make_the_same_tiles(normals, rows):
    names = [name for name in made(normals, "normals").namelist() if name != "info.json"]
    one, other = made(normals, "normals"), made(normals, "normals", rows=rows)
    assert all(one.read(name) == other.read(name) for name in names)


def test_coarse_pictures_are_means_of_light_and_not_of_srgb_values():
    """Black and white lines, one pixel each, are half the light: sRGB 188 and not 128."""
    picture = np.zeros((1024, 1024), np.uint8)
    picture[:, ::2] = 255
    coarse = pixels(made(picture, "light"), "0,0,1024,1024/512,512/0/default.jpg")
    expected = int(albedo_srgb(np.full((1, 1), to_linear(np.array([1.0]))[0] / 2))[0, 0, 0])
    assert expected == 188 and abs(int(np.median(coarse)) - expected) <= 1


def test_colours_keep_their_order():
    picture = np.full((600, 600, 3), (200, 100, 20), np.uint8)
    for name in ("0,0,512,512/512,512/0/default.jpg", "0,0,600,600/300,300/0/default.jpg"):
        assert np.abs(pixels(made(picture, "light"), name).astype(int) - (200, 100, 20)).max() <= 3


@pytest.mark.parametrize(
    "bad", [np.zeros((10, 9), np.uint8), np.zeros((10, 10), np.float32), np.zeros((9, 10), np.uint8)]
)
def test_rows_that_are_not_those_of_the_map_are_refused(bad):
    with pytest.raises(GalleryError, match="expected"):
        write_tiles(TileMap(10, 10, lambda: iter([bad]), "light"), io.BytesIO())


def test_a_tile_is_read_from_a_store_without_the_rest(tmp_path, normals):
    store = Store.open(tmp_path)
    assert open_tiles(store, "a/tiles.zip") is None
    archive = made(normals, "normals")
    store.write("a/tiles.zip", archive.fp.getvalue())
    tiles = open_tiles(store, "a/tiles.zip")
    assert tiles is not None and tiles.read("0,0,512,512/512,512/0/default.jpg") is None
    for name in archive.namelist():
        assert tiles.read(name) == archive.read(name)
    assert tiles.info == tile_info(WIDTH, HEIGHT, suffix="png")


def test_a_tile_set_that_is_made_anew_is_read_anew(tmp_path, normals):
    store = Store.open(tmp_path)
    store.write("t.zip", made(normals, "normals").fp.getvalue())
    assert open_tiles(store, "t.zip") is not None
    store.write("t.zip", made(normals[:600], "normals").fp.getvalue())
    tiles = open_tiles(store, "t.zip")
    assert tiles is not None and tiles.info["height"] == 600
    store.delete("t.zip")
    with pytest.raises(GalleryError, match=r"t\.zip"):
        tiles.read("info.json")
