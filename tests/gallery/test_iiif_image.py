"""The Image API 3: what a request may say, and what comes back."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from rumu.errors import GalleryError
from rumu.gallery.add_work import add_picture
from rumu.gallery.iiif_image import (
    BadImageRequest,
    PictureRegion,
    image_info,
    image_response,
    region_box,
    size_of,
)
from rumu.gallery.metadata import WorkMetadata
from rumu.values import Bilingual


@pytest.fixture
def page() -> np.ndarray:
    """(90, 120, 3): a black cross on pale paper, red at its upper left, blue at its lower right."""
    page = np.full((90, 120, 3), 235, np.uint8)
    page[40:50, 20:100] = 10
    page[15:80, 55:65] = 10
    page[:12, :12] = (200, 40, 40)
    page[-12:, -12:] = (40, 40, 200)
    return page


@pytest.fixture
def ask(bare, page, tmp_path):
    """A function of region, size, rotation, quality, format: the picture that comes back."""
    Image.fromarray(page).save(tmp_path / "page.png")
    added = add_picture(bare, tmp_path / "page.png", metadata=WorkMetadata(title=Bilingual("十", "ten")))

    def asked(region="full", size="max", rotation="0", quality="default", format="png") -> Image.Image:
        data, media_type = image_response(bare, added.id, region, size, rotation, quality, format)
        image = Image.open(io.BytesIO(data))
        assert Image.MIME[image.format] == media_type
        return image

    asked.gallery, asked.id = bare, added.id
    return asked


def test_the_whole_picture_comes_back_as_it_is(ask, page):
    assert np.array_equal(np.asarray(ask()), page)


@pytest.mark.parametrize(
    ("region", "box"),
    [
        ("full", PictureRegion(0, 0, 120, 90)),
        ("square", PictureRegion(15, 0, 90, 90)),
        ("10,20,30,40", PictureRegion(10, 20, 30, 40)),
        ("100,80,500,500", PictureRegion(100, 80, 20, 10)),
        ("pct:25,50,50,25", PictureRegion(30, 45, 60, 22)),
        ("pct:0,0,100,100", PictureRegion(0, 0, 120, 90)),
        ("pct:41.6,7.5,.5,66", PictureRegion(50, 7, 1, 59)),
    ],
)
def test_regions(region, box, ask, page):
    assert region_box(region, width=120, height=90) == box
    part = np.asarray(ask(region))
    assert np.array_equal(part, page[box.y : box.y + box.height, box.x : box.x + box.width])


@pytest.mark.parametrize(
    "region",
    [
        "",
        "all",
        "0,0,0,10",
        "0,0,10,0",
        "120,0,1,1",
        "0,90,5,5",
        "-1,0,5,5",
        "1,2,3",
        "1,2,3,4,5",
        "1.5,0,5,5",
        "pct:100,0,5,5",
        "pct:0,0,0,5",
        "pct:a,0,5,5",
        "pct:1e2,0,5,5",
        "nan,0,1,1",
        "9999999999,0,1,1",
        "١,0,5,5",
    ],
)
def test_regions_that_cannot_be(region, ask):
    with pytest.raises(BadImageRequest, match="expected a region"):
        ask(region)


@pytest.mark.parametrize(
    ("size", "wanted"),
    [
        ("max", (120, 90)),
        ("60,", (60, 45)),
        (",30", (40, 30)),
        ("50,80", (50, 80)),
        ("!50,80", (50, 37)),
        ("!500,800", (120, 90)),
        ("pct:50", (60, 45)),
        ("pct:0.1", (1, 1)),
        ("^240,", (240, 180)),
        ("^,180", (240, 180)),
        ("^pct:150", (180, 135)),
        ("^!240,1000", (240, 180)),
        ("^300,10", (300, 10)),
        ("^max", (4096, 3072)),
        ("^60,", (60, 45)),
    ],
)
def test_sizes(size, wanted, ask):
    assert size_of(size, PictureRegion(0, 0, 120, 90)) == wanted
    assert ask("full", size).size == wanted


@pytest.mark.parametrize(
    "size",
    [
        "",
        "full",
        "121,",
        ",91",
        "60,91",
        "pct:101",
        "0,",
        ",0",
        "0,0",
        "!0,5",
        "pct:0",
        ",",
        "^",
        "^4097,",
        "^pct:9999",
        *("-5,", "1.5,", "!5", "!,5", "pct:", "pct:x", "^^60,", "^99999999,1", "60;40", "٦,"),
    ],
)
def test_sizes_that_cannot_be(size, ask):
    with pytest.raises(BadImageRequest, match="expected a size"):
        ask("full", size)


def test_turns_are_clockwise_and_mirroring_comes_first(ask, page):
    for quarters in range(4):
        for mirrored in ("", "!"):
            start = page[:, ::-1] if mirrored else page
            wanted = np.rot90(start, -quarters)
            assert np.array_equal(np.asarray(ask(rotation=f"{mirrored}{90 * quarters}")), wanted)
    assert ask(size="60,", rotation="90").size == (45, 60)


@pytest.mark.parametrize("rotation", ["", "45", "22.5", "-90", "450", "x", "!", "!!90", "nan"])
def test_other_turns_are_refused(rotation, ask):
    with pytest.raises(BadImageRequest, match="expected a rotation"):
        ask(rotation=rotation)


def test_qualities_and_formats(ask, page):
    assert ask(quality="color").mode == "RGB"
    gray = ask(quality="gray")
    assert gray.mode == "L" and np.asarray(gray)[0, 50] == 235
    assert set(np.unique(np.asarray(ask(quality="bitonal")))) == {0, 255}
    for format in ("jpg", "webp"):
        near = np.asarray(ask(format=format).convert("RGB"), int)
        assert near.shape == page.shape and np.abs(near - page).mean() < 4
    for quality, format in (("default", "tif"), ("native", "jpg"), ("default", "jpeg"), ("", "jpg")):
        with pytest.raises(BadImageRequest, match="expected a quality"):
            ask(quality=quality, format=format)


def test_a_work_that_is_not_there_is_no_bad_request(ask):
    with pytest.raises(GalleryError, match="no work") as refused:
        image_response(ask.gallery, "nothing", "full", "max", "0", "default", "jpg")
    assert not isinstance(refused.value, BadImageRequest)


def test_the_description_names_only_what_can_be_asked(ask):
    info = image_info(ask.gallery, ask.id, base="https://example.org/iiif/image/")
    assert info["id"] == f"https://example.org/iiif/image/{ask.id}"
    assert (info["width"], info["height"], info["profile"], info["type"]) == (
        120,
        90,
        "level2",
        "ImageService3",
    )
    for size in info["sizes"]:
        assert ask("full", f"{size['width']},{size['height']}").size == (size["width"], size["height"])
    for tile in info["tiles"]:
        for factor in tile["scaleFactors"]:
            side = tile["width"] * factor
            width, height = -(-min(side, 120) // factor), -(-min(side, 90) // factor)
            assert ask(f"0,0,{side},{side}", f"{width},{height}").size == (width, height)


def test_a_large_picture_has_smaller_sizes_and_tiles(bare, tmp_path):
    page = np.full((1500, 5000), 240, np.uint8)
    page[600:900, 800:4200] = 10
    Image.fromarray(page).save(tmp_path / "long.png")
    added = add_picture(bare, tmp_path / "long.png", metadata=WorkMetadata(title=Bilingual("一", "one")))
    info = image_info(bare, added.id, base="x")
    assert info["sizes"][-1] == {"width": 2500, "height": 750}
    data, _ = image_response(bare, added.id, "full", "max", "0", "gray", "jpg")
    assert Image.open(io.BytesIO(data)).size == (4096, 1228)
    with pytest.raises(BadImageRequest):
        image_response(bare, added.id, "full", "5000,", "0", "gray", "jpg")
    tile, _ = image_response(bare, added.id, "4096,1024,512,512", "512,476", "0", "gray", "png")
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(tile)))[:, :104], page[1024:, 4096:4200])
