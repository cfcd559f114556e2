"""A surface as a folder: the same back, or one clear error; whole or not at all."""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest
import tifffile
from PIL import Image

from rumu.errors import OutputError, SurfaceError
from rumu.surface.folder import FLOATS, MESH, PICTURES, read_surface, write_surface
from rumu.surface.relief import relief
from rumu.values import Surface

FILES = {
    *(f"{name}.{end}" for name in ("height", "normals", "albedo", "confidence") for end in ("tif", "png")),
    "mask.png",
    "surface.glb",
    "surface.json",
}


def surface(*, colour=True, unit="mm", source="photometric", h=23, w=31):
    rng = np.random.default_rng(7)
    normals = rng.normal(size=(h, w, 3)) + np.array([0, 0, 3])
    return Surface(
        height=rng.normal(size=(h, w)).astype(np.float32),
        normals_from=(normals / np.linalg.norm(normals, axis=2, keepdims=True)).astype(np.float32),
        albedo_from=rng.random((h, w, 3) if colour else (h, w)).astype(np.float32),
        mask=rng.random((h, w)) > 0.1,
        confidence=rng.random((h, w)).astype(np.float32),
        spacing=0.041 if unit == "mm" else 1.0,
        unit=unit,
        source=source,
        quality={"residual": 0.0123},
    )


@pytest.mark.parametrize("colour", [True, False])
@pytest.mark.parametrize(("unit", "source"), [("mm", "photometric"), ("px", "inflation")])
def test_it_comes_back_as_it_was(tmp_path, colour, unit, source):
    before = surface(colour=colour, unit=unit, source=source)
    write_surface(before, tmp_path / "out", extra={"report.html": "字", "x.bin": b"\x00"})
    assert {p.name for p in (tmp_path / "out").iterdir()} == FILES | {"report.html", "x.bin"}
    assert (tmp_path / "out" / "report.html").read_text(encoding="utf-8") == "字"
    after = read_surface(tmp_path / "out")
    for name in ("height", "normals", "albedo", "confidence", "mask"):
        assert np.array_equal(getattr(after, name), getattr(before, name))
        assert getattr(after, name).dtype == getattr(before, name).dtype
    assert (after.spacing, after.unit, after.source) == (before.spacing, unit, source)
    assert dict(after.quality) == {"residual": 0.0123}


def test_a_surface_two_or_three_pixels_wide_comes_back(tmp_path):
    for number, (h, w) in enumerate([(3, 4), (4, 3), (3, 3), (2, 2)]):
        before = surface(h=h, w=w, source="inflation")
        write_surface(before, tmp_path / str(number))
        assert np.array_equal(read_surface(tmp_path / str(number)).normals, before.normals)


def test_the_pictures_mean_what_they_say(tmp_path):
    before = surface()
    write_surface(before, tmp_path / "out")
    facts = json.loads((tmp_path / "out" / "surface.json").read_text())
    height = np.asarray(Image.open(tmp_path / "out" / "height.png")).astype(float)
    scale = facts["height_png"]
    assert np.abs(height * scale["scale"] + scale["offset"] - before.height).max() <= scale["scale"]
    normals = cv2.imread(str(tmp_path / "out" / "normals.png"), cv2.IMREAD_UNCHANGED)[..., ::-1]
    assert normals.dtype == np.uint16
    assert np.abs(normals / 32767.5 - 1 - before.normals).max() < 2e-5
    assert not (tmp_path / "out" / "normals-green-down.png").exists()
    write_surface(before, tmp_path / "down", files=["normals-green-down.png"])
    down = cv2.imread(str(tmp_path / "down" / "normals-green-down.png"), cv2.IMREAD_UNCHANGED)[..., ::-1]
    assert np.abs(down / 32767.5 - 1 - before.normals * [1, -1, 1]).max() < 2e-5
    assert np.asarray(Image.open(tmp_path / "out" / "albedo.png")).shape == (23, 31, 3)
    assert tifffile.imread(tmp_path / "out" / "height.tif").dtype == np.float32


def test_an_earlier_surface_is_replaced_and_a_strangers_folder_is_not(tmp_path):
    out = tmp_path / "out"
    write_surface(surface(), out, extra={"old.txt": "old"})
    write_surface(surface(colour=False), out)
    assert not (out / "old.txt").exists() and read_surface(out).albedo.ndim == 2
    stranger = tmp_path / "mine"
    stranger.mkdir()
    (stranger / "letter.txt").write_text("keep me")
    with pytest.raises(OutputError, match="it holds other things"):
        write_surface(surface(), stranger)
    assert [p.name for p in stranger.iterdir()] == ["letter.txt"]


def test_nothing_is_left_behind_when_writing_fails(tmp_path, monkeypatch):
    def full(*args, **kwargs):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("tifffile.imwrite", full)
    with pytest.raises(OutputError, match="the disk or quota is full"):
        write_surface(surface(), tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["height.tif", "normals.tif", "albedo.tif", "confidence.tif", "mask.png"])
@pytest.mark.parametrize("harm", ["missing", "empty", "cut", "text"])
def test_a_missing_or_damaged_piece_is_named(tmp_path, name, harm):
    write_surface(surface(), tmp_path / "out")
    piece = tmp_path / "out" / name
    whole = piece.read_bytes()
    if harm == "missing":
        piece.unlink()
    else:
        piece.write_bytes({"empty": b"", "cut": whole[: len(whole) // 2], "text": b"not a picture"}[harm])
    with pytest.raises(SurfaceError, match=f"{name}: expected"):
        read_surface(tmp_path / "out")


def test_pieces_of_another_surface_are_refused(tmp_path):
    write_surface(surface(), tmp_path / "out")
    tifffile.imwrite(tmp_path / "out" / "normals.tif", np.zeros((5, 6, 3), np.float32), photometric="rgb")
    with pytest.raises(SurfaceError, match=r"normals.tif: expected shape \(23, 31, 3\), got \(5, 6, 3\)"):
        read_surface(tmp_path / "out")
    write_surface(surface(), tmp_path / "out")
    tifffile.imwrite(tmp_path / "out" / "height.tif", np.full((23, 31), np.nan, np.float32))
    with pytest.raises(SurfaceError, match=r"height\.tif: expected finite float32"):
        read_surface(tmp_path / "out")
    write_surface(surface(), tmp_path / "out")
    Image.new("L", (4, 4)).save(tmp_path / "out" / "mask.png")
    with pytest.raises(SurfaceError, match=r"mask\.png: expected shape"):
        read_surface(tmp_path / "out")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "expected JSON"),
        ("[]", "something else"),
        ('{"kind": "rumu surface"}', "expected an entry 'spacing'"),
        (
            '{"kind": "rumu surface", "spacing": "wide", "unit": "mm", "source": "inflation", "quality": {}}',
            "describe",
        ),
        (
            '{"kind": "rumu surface", "spacing": 1, "unit": "mile", "source": "inflation", "quality": {}}',
            "a unit among",
        ),
        (
            '{"kind": "rumu surface", "spacing": 1, "unit": "mm", "source": "inflation", "quality": 3}',
            "describe",
        ),
    ],
)
def test_a_bad_description_is_named(tmp_path, text, message):
    write_surface(surface(), tmp_path / "out")
    (tmp_path / "out" / "surface.json").write_text(text)
    with pytest.raises(SurfaceError, match=f"surface.json: .*{message}"):
        read_surface(tmp_path / "out")


def test_a_folder_that_is_no_surface_and_names_that_are_not_plain(tmp_path):
    with pytest.raises(SurfaceError, match=r"surface\.json: expected a surface folder"):
        read_surface(tmp_path)
    for name in ("../escape.txt", "height.tif", "a/b.txt"):
        with pytest.raises(SurfaceError, match="plain file name"):
            write_surface(surface(), tmp_path / "out", extra={name: ""})
    assert list(tmp_path.iterdir()) == []


def test_without_float_files_it_comes_back_from_its_pictures(tmp_path):
    gray = np.full((80, 100), 0.8, np.float32)
    gray[20:60, 40:55] = 0.1
    for image in (gray, np.stack([gray, gray * 0.9, gray * 0.7], axis=-1)):
        surface = relief(image)
        write_surface(surface, tmp_path / "out", files=(*PICTURES, MESH))
        assert not list((tmp_path / "out").glob("*.tif"))
        back = read_surface(tmp_path / "out")
        assert back.albedo.shape == surface.albedo.shape
        np.testing.assert_array_equal(back.mask, surface.mask)
        np.testing.assert_allclose(back.height, surface.height, atol=float(np.ptp(surface.height)) / 60000)
        np.testing.assert_allclose(back.normals, surface.normals, atol=1e-4)
        np.testing.assert_allclose(back.albedo, surface.albedo, atol=0.005)
        np.testing.assert_allclose(back.confidence, surface.confidence, atol=0.003)
        assert (back.source, back.quality) == (surface.source, surface.quality)


@pytest.mark.parametrize("name", ["height.png", "normals.png", "albedo.png", "confidence.png"])
def test_a_picture_that_is_needed_is_named(tmp_path, name):
    gray = np.full((80, 100), 0.8, np.float32)
    gray[20:60, 40:55] = 0.1
    write_surface(relief(gray), tmp_path / "out", files=(*PICTURES, MESH))
    (tmp_path / "out" / name).write_bytes(b"no picture")
    with pytest.raises(SurfaceError, match=rf"{name}: expected a PNG"):
        read_surface(tmp_path / "out")
    (tmp_path / "out" / name).unlink()
    with pytest.raises(SurfaceError, match=rf"{name}: expected a file"):
        read_surface(tmp_path / "out")


def test_only_what_is_asked_for_is_written_and_floats_are_read_where_they_are(tmp_path):
    before = surface()
    files = ("normals.tif", "height.png", "albedo.tif", "confidence.png")
    write_surface(before, tmp_path / "out", files=files)
    assert {p.name for p in (tmp_path / "out").iterdir()} == {*files, "mask.png", "surface.json"}
    after = read_surface(tmp_path / "out")
    assert np.array_equal(after.normals, before.normals) and np.array_equal(after.albedo, before.albedo)
    assert np.abs(after.height - before.height).max() < np.ptp(before.height) / 60000
    write_surface(before, tmp_path / "few", files=("height.tif",))
    with pytest.raises(SurfaceError, match=r"normals\.png: expected a file"):
        read_surface(tmp_path / "few")
    with pytest.raises(SurfaceError, match=r"expected files among .*, got height\.jpg"):
        write_surface(before, tmp_path / "other", files=("height.jpg",))


def test_float_files_are_tiled_and_packed_and_others_read_them(tmp_path):
    before = surface(h=256, w=512)
    write_surface(before, tmp_path / "out", files=("normals.tif", "height.tif"))
    for name in ("normals", "height"):
        with tifffile.TiffFile(tmp_path / "out" / f"{name}.tif") as tiff:
            page = tiff.pages[0]
            assert page.is_tiled and page.compression == tifffile.COMPRESSION.ADOBE_DEFLATE
            assert sum(page.databytecounts) < 0.95 * getattr(before, name).nbytes
        theirs = cv2.imread(str(tmp_path / "out" / f"{name}.tif"), cv2.IMREAD_UNCHANGED)
        wanted = getattr(before, name)
        assert np.array_equal(theirs[..., ::-1] if theirs.ndim == 3 else theirs, wanted)


def test_a_folder_of_an_earlier_version_is_read(tmp_path):
    before = surface()
    for files, floats in ((FLOATS, None), (PICTURES, False)):
        write_surface(before, tmp_path / "out", files=files)
        marker = tmp_path / "out" / "surface.json"
        facts = json.loads(marker.read_text())
        del facts["files"]
        marker.write_text(json.dumps(facts | ({} if floats is None else {"floats": floats})))
        assert np.allclose(read_surface(tmp_path / "out").height, before.height, atol=1e-3)
