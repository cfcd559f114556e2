"""Pictures, maps and meshes: what they hold, how large they are, and that each is made once."""

from __future__ import annotations

import io
import json
import os
import subprocess
import threading
import time
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from tests.gallery.conftest import surface

from conftest import FRONTEND
from rumu.errors import GalleryError, RefusedImage, RumuError, SurfaceError
from rumu.gallery import catalog, renderers
from rumu.gallery.assets import assets_of
from rumu.gallery.derived import (
    EXAGGERATIONS,
    KINDS,
    MAX_DERIVED_VARIABLE,
    MeshShape,
    delete_least_used,
    derived_file,
    viewer_facts,
)
from rumu.gallery.seed import add_starter_works
from rumu.gallery.starter import starter_works
from rumu.gallery.store import Store


@pytest.fixture
def gallery(bare):
    add_starter_works(bare)
    return bare


def picture_of(gallery, kind: str, work: str = "regular-shui") -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(derived_file(gallery, work, kind).data)))


def test_every_picture_is_of_its_type_and_size(gallery):
    sides = {"thumb": 256, "thumb-normals": 128, "picture": 512, "albedo": 512, "normals": 512, "mask": 512}
    for kind, side in sides.items():
        file = derived_file(gallery, "regular-shui", kind)
        with Image.open(io.BytesIO(file.data)) as image:
            assert (image.size, Image.MIME[image.format]) == ((side, side), file.media_type), kind
    assert (
        derived_file(gallery, "regular-shui", "picture").data
        == starter_works(script="regular")[2].path.read_bytes()
    )


def test_maps_hold_the_numbers_of_the_surface(gallery):
    known, facts = (
        surface(gallery, "regular-shui"),
        json.loads(derived_file(gallery, "regular-shui", "facts").data),
    )
    eight = picture_of(gallery, "normals").astype(float) / 127.5 - 1
    assert np.abs(eight - known.normals).max() < 0.006
    heights = np.frombuffer(derived_file(gallery, "regular-shui", "heights").data, "<f4").reshape(512, 512)
    assert np.array_equal(heights, known.height)
    assert (facts["heights"]["min"], facts["heights"]["max"]) == (heights.min(), heights.max())
    told = facts["height16"]
    sixteen = picture_of(gallery, "height16").astype(float) * told["scale"] + told["offset"]
    assert np.abs(sixteen - known.height).max() < 1e-3
    assert np.array_equal(picture_of(gallery, "mask") > 127, known.mask)
    import cv2

    packed = cv2.imdecode(
        np.frombuffer(derived_file(gallery, "regular-shui", "normals-16").data, np.uint8), -1
    )
    assert packed.dtype == np.uint16
    assert np.abs(packed[..., ::-1] / 32767.5 - 1 - known.normals).max() < 5e-5


def test_the_viewer_is_told_where_the_height_comes_from(gallery):
    facts = viewer_facts(gallery, "seal-tian", url=lambda kind, tag: f"{kind}#{tag}")
    assert (facts["source"], facts["unit"], facts["pixels"], facts["three_lamps"]) == (
        "inflation",
        "px",
        [512, 512],
        None,
    )
    assert "not measured" in facts["source_text"]["en"] and "並非量得" in facts["source_text"]["zh"]
    assert facts["height"]["url"].startswith("heights#") and facts["glb"].startswith("glb#")


@pytest.mark.parametrize("work", [work.id for work in starter_works()])
def test_every_starter_mesh_is_sound_and_small(gallery, work):
    import trimesh

    data = derived_file(gallery, work, "glb").data
    assert len(data) <= renderers.GLB_BYTES
    mesh = trimesh.load(io.BytesIO(data), file_type="glb", force="mesh")
    assert mesh.is_winding_consistent and len(mesh.faces) > 10_000
    assert mesh.extents[:2] == pytest.approx([0.1, 0.1], rel=0.02)
    assert mesh.face_normals[:, 2].min() > 0


_VALIDATE = """
const {validateBytes} = require(process.argv[1] + "/node_modules/gltf-validator");
const bytes = new Uint8Array(require("fs").readFileSync(0));
validateBytes(bytes).then((told) => console.log(JSON.stringify(told.issues)));
"""


@pytest.mark.parametrize("work", ["regular-shui", "cursive-tian"])
def test_khronos_validator_finds_no_fault_in_a_mesh(gallery, work, node):
    told = subprocess.run(
        [node, "-e", _VALIDATE, str(FRONTEND)],
        input=derived_file(gallery, work, "glb").data,
        capture_output=True,
        check=True,
    )
    issues = json.loads(told.stdout)
    assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), issues["messages"]


def test_a_large_photometric_mesh_stays_below_5_mb(bare):
    """Noise is what a JPEG and a mesh pack worst."""
    from rumu.gallery.assets import Assets
    from rumu.values import Surface

    rng = np.random.default_rng(3)
    shape = (1500, 2000)
    slopes = rng.normal(0, 0.3, (*shape, 2))
    normals = np.dstack([slopes, np.ones(shape)]).astype(np.float32)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    noisy = Surface(
        height=rng.normal(0, 2, shape).astype(np.float32),
        normals_from=normals,
        albedo_from=rng.uniform(0, 1, (*shape, 3)).astype(np.float32),
        mask=np.ones(shape, bool),
        confidence=np.ones(shape, np.float32),
        spacing=0.05,
        unit="mm",
        source="photometric",
    )
    data = renderers.render_glb(
        Assets(digest="x", picture_file=nullcontext, surface=lambda: noisy), exaggeration=1.0
    )
    assert 500_000 < len(data) <= renderers.GLB_BYTES


def test_the_real_photographs_give_a_small_mesh(bare, data):
    from rumu.gallery.add_work import add_capture
    from rumu.gallery.metadata import WorkMetadata
    from rumu.values import Bilingual

    added = add_capture(
        bare, data / "photometric" / "uw-psm" / "cat", metadata=WorkMetadata(title=Bilingual("貓", "Cat"))
    )
    assert len(derived_file(bare, added.id, "glb").data) <= renderers.GLB_BYTES


def test_a_mesh_has_the_shape_asked_for_and_nothing_else_has_one(gallery):
    import trimesh

    def extents(**shape):
        data = derived_file(gallery, "seal-ri", "stl", shape=MeshShape(**shape)).data
        mesh = trimesh.load(io.BytesIO(data), file_type="stl")
        assert mesh.is_watertight and mesh.volume > 0
        return mesh.extents

    assert extents(exaggeration=3.0)[2] - 2 == pytest.approx(3 * (extents()[2] - 2), rel=1e-4)
    assert extents(width=60.0, base=5.0)[0] == pytest.approx(60.0)
    wrong = [("normals", {"exaggeration": 2.0}), ("glb", {"exaggeration": 0.0})]
    wrong += [("glb", {"exaggeration": float("nan")}), ("ply", {"width": 50.0}), ("picture", {"base": 1.0})]
    for kind, shape in wrong:
        with pytest.raises(GalleryError, match=r"exaggeration|a width and a base"):
            derived_file(gallery, "seal-ri", kind, shape=MeshShape(**shape))
    with pytest.raises(SurfaceError, match="expected a width"):
        derived_file(gallery, "seal-ri", "stl", shape=MeshShape(width=float("nan")))
    with pytest.raises(GalleryError, match="expected a kind of file"):
        derived_file(gallery, "seal-ri", "../../secret")


def test_each_file_is_made_once_and_then_kept(gallery, monkeypatch):
    made, real = [], KINDS["normals"]
    counting = replace(real, render=lambda assets: made.append(1) or real.render(assets))
    monkeypatch.setitem(KINDS, "normals", counting)
    answers = []
    threads = [
        threading.Thread(target=lambda: answers.append(derived_file(gallery, "seal-ri", "normals")))
        for _ in range(8)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(made) == 1 and len(answers) == 8 and len({answer.data for answer in answers}) == 1
    assert not [key for key in gallery.store.keys("derived") if key.endswith(".part")]


def test_a_file_that_fails_half_way_is_not_kept(gallery, monkeypatch):
    def fails(assets) -> bytes:
        raise RuntimeError

    monkeypatch.setitem(KINDS, "normals", replace(KINDS["normals"], render=fails))
    with pytest.raises(RuntimeError):
        derived_file(gallery, "seal-ri", "normals")
    monkeypatch.undo()
    assert derived_file(gallery, "seal-ri", "normals").data


def test_the_tag_changes_with_the_content(gallery):
    from rumu.gallery.catalog import change_work

    before = derived_file(gallery, "seal-ri", "facts")
    assert derived_file(gallery, "seal-ri", "facts").etag == before.etag
    change_work(gallery, "seal-ri", {"spacing": 0.5})
    after = derived_file(gallery, "seal-ri", "facts")
    assert after.etag != before.etag and json.loads(after.data)["unit"] == "mm"
    assert len({derived_file(gallery, "seal-ri", kind).etag for kind in ("thumb", "normals", "mask")}) == 3


def test_a_picture_without_writing_has_a_picture_but_no_surface(bare, labelled):
    from rumu.gallery.bulk_import import import_folder
    from rumu.gallery.catalog import works

    folder = labelled(1)
    Image.new("L", (64, 64), 250).save(folder / "img" / "00000.png")
    import_folder(bare, folder)
    (only,) = works(bare).items
    assert derived_file(bare, only.id, "thumb").data and derived_file(bare, only.id, "picture").data
    with pytest.raises(RefusedImage):
        derived_file(bare, only.id, "normals")


def test_a_large_picture_is_brought_down(bare, tmp_path):
    from rumu.gallery.add_work import add_picture
    from rumu.gallery.metadata import WorkMetadata
    from rumu.values import Bilingual

    page = np.full((2600, 3000, 3), 240, np.uint8)
    page[400:2200, 1300:1600] = 20
    page[1100:1400, 500:2500] = 20
    Image.fromarray(page).save(tmp_path / "large.jpg")
    added = add_picture(bare, tmp_path / "large.jpg", metadata=WorkMetadata(title=Bilingual("十", "ten")))
    assert surface(bare, added.id).height.shape == (2234, 2578)  # of as many pixels as 2400 x 2400
    assert picture_of(bare, "picture", added.id).shape == (1775, 2048, 3)
    assert picture_of(bare, "normals", added.id).shape == (887, 1024, 3)
    assert len(derived_file(bare, added.id, "heights").data) == 4 * 550 * 477  # about 512 x 512


@pytest.mark.parametrize(
    ("shape", "kept"), [((200, 2000), (162, 1619)), ((600, 600), (512, 512)), ((300, 400), (300, 400))]
)
def test_a_long_scroll_has_as_many_heights_as_a_square_sheet(shape, kept):
    from rumu.gallery.assets import Assets
    from rumu.values import Surface

    plain = np.ones(shape, np.float32)
    scroll = Surface(
        height=plain * np.arange(shape[1], dtype=np.float32),
        normals_from=np.dstack([0 * plain, 0 * plain, plain]),
        albedo_from=plain,
        mask=plain > 0,
        confidence=plain,
        spacing=1.0,
        unit="px",
        source="inflation",
    )
    assets = Assets(digest="x", picture_file=nullcontext, surface=lambda: scroll)
    facts = json.loads(renderers.render_facts(assets))["heights"]
    assert (facts["height"], facts["width"]) == kept
    assert len(renderers.render_heights(assets)) == 4 * kept[0] * kept[1]


def test_a_store_elsewhere_serves_as_well(bare):
    from rumu.gallery.store import Gallery

    there = Gallery(bare.database, Store.open("memory://derived"))
    add_starter_works(there)
    for kind in set(KINDS) - {"lamp-a", "lamp-b", "lamp-c"}:
        assert derived_file(there, "regular-ri", kind).data == derived_file(there, "regular-ri", kind).data


# --- the room that they take -----------------------------------------------------------------------


def test_meshes_take_the_nearest_step(gallery):
    asked = np.geomspace(0.02, 90, 40)
    tags = {derived_file(gallery, "regular-ren", "glb", shape=MeshShape(float(x))).etag for x in asked}
    stored = [key for key in gallery.store.keys("derived") if "-glb" in key]
    assert len(tags) == len(stored) <= len(EXAGGERATIONS)
    near, step = (
        derived_file(gallery, "regular-ren", "ply", shape=MeshShape(exaggeration))
        for exaggeration in (1.93, 2.0)
    )
    assert (near.data, near.etag) == (step.data, step.etag)


def derived_bytes(gallery) -> int:
    return sum(file.size for file in gallery.store.files("derived"))


def test_the_least_recently_used_files_go_first(gallery, monkeypatch):
    works = [row.id for row in catalog.works(gallery).items][:6]
    gallery.store.delete("derived")
    for work in works:
        derived_file(gallery, work, "glb")
    keys = {}
    for number, work in enumerate(works):
        folder = assets_of(gallery.store, catalog.work(gallery, work)).digest
        (keys[work],) = (key for key in gallery.store.keys("derived") if folder in key)
        used = time.time() - 86_400 * (10 - number)
        os.utime(gallery.store.path(keys[work]), (used, used))
    derived_file(gallery, works[0], "glb")  # the oldest is used again
    originals = set(gallery.store.keys("pictures"))
    total = derived_bytes(gallery)
    assert delete_least_used(gallery.store, most=total) == 0
    assert delete_least_used(gallery.store, most=total * 2 // 3) > 0
    left = set(gallery.store.keys("derived"))
    assert derived_bytes(gallery) <= total * 2 // 3
    assert keys[works[0]] in left and keys[works[-1]] in left and keys[works[1]] not in left
    assert set(gallery.store.keys("pictures")) == originals
    assert derived_file(gallery, works[1], "glb").data  # made again


def test_the_operator_limits_the_room(gallery, monkeypatch):
    monkeypatch.setenv(MAX_DERIVED_VARIABLE, "12")
    for exaggeration in EXAGGERATIONS:
        for work in ("regular-ren", "regular-shui"):
            derived_file(gallery, work, "ply", shape=MeshShape(exaggeration))
            assert derived_bytes(gallery) < 13_000_000
    monkeypatch.setenv(MAX_DERIVED_VARIABLE, "much")
    with pytest.raises(RumuError, match=f"{MAX_DERIVED_VARIABLE}: expected a whole number of megabytes"):
        derived_file(gallery, "regular-ri", "glb")


def test_a_picture_of_very_many_pixels_is_not_sent_whole_and_not_decoded_either(recwarn, tmp_path):
    """Pillow warns of 90 megapixels and refuses 179; the size alone is read here."""
    import struct
    import zlib

    from rumu.gallery.renderers import browser_media_type

    def png(side: int) -> Path:
        head = b"IHDR" + struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)
        chunks = [(13, head), (0, b"IDAT")]
        packed = [struct.pack(">I", n) + chunk + struct.pack(">I", zlib.crc32(chunk)) for n, chunk in chunks]
        path = tmp_path / f"{side}.png"
        path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(packed))
        return path

    assert browser_media_type(png(11_000)) is None and browser_media_type(png(40_000)) is None
    assert not [one for one in recwarn if "DecompressionBomb" in str(one.category)]
