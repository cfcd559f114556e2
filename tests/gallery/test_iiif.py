"""Manifests that the IIIF models take back, and that say what the gallery says."""

from __future__ import annotations

import json

import pytest

from rumu.errors import GalleryError
from rumu.gallery.annotations import add_annotation
from rumu.gallery.bulk_import import import_folder
from rumu.gallery.catalog import work, works
from rumu.gallery.iiif import collection_manifest, manifest
from rumu.gallery.iiif_image import image_info, image_response
from rumu.gallery.seed import add_starter_works

BASE = "https://example.org"


@pytest.fixture
def gallery(bare):
    add_starter_works(bare)
    return bare


def addresses(value) -> list[str]:
    """Every id in a manifest."""
    if isinstance(value, dict):
        own = [value["id"]] if "id" in value else []
        return own + [one for part in value.values() for one in addresses(part)]
    return [one for part in value for one in addresses(part)] if isinstance(value, list) else []


@pytest.mark.parametrize("work_id", ["regular-shui", "clerical-tian", "seal-ri"])
def test_a_manifest_is_taken_back_by_the_models(gallery, work_id):
    from iiif_prezi3 import Manifest

    made = manifest(gallery, work_id, base=BASE + "/")
    assert json.loads(Manifest(**made).json()) == made
    assert made["@context"] == "http://iiif.io/api/presentation/3/context.json"
    assert made["id"] == f"{BASE}/iiif/works/{work_id}/manifest.json"
    assert all(address.startswith(BASE + "/") for address in addresses(made))
    ids = [a for a in addresses(made) if "/works/" in a]
    assert len(ids) == len(set(ids))


def test_a_manifest_says_what_the_gallery_says(gallery):
    row = work(gallery, "clerical-tian")
    made = manifest(gallery, "clerical-tian", base=BASE)
    assert made["label"] == {"zh-Hant": [row.title_zh], "en": [row.title_en]}
    assert "not measured" in made["summary"]["en"][0]
    told = {pair["label"]["en"][0]: pair["value"]["en"][0] for pair in made["metadata"]}
    assert told["Licence"] == row.licence and told["Hand"] == row.hand_en and told["Source"] == row.source
    assert row.attribution in made["requiredStatement"]["value"]["zh-Hant"][0]
    assert made["rights"].startswith("http://creativecommons.org/licenses/by-nd/3.0")
    (canvas,) = made["items"]
    assert (canvas["width"], canvas["height"]) == (512, 512)
    assert made["rendering"][0]["format"] == "model/gltf-binary"


def test_the_picture_of_a_manifest_is_one_that_the_image_api_serves(gallery):
    (canvas,) = manifest(gallery, "seal-ri", base=BASE)["items"]
    body = canvas["items"][0]["items"][0]["body"]
    service = body["service"][0]
    info = image_info(gallery, "seal-ri", base=f"{BASE}/iiif/image")
    assert (service["id"], service["type"], service["profile"]) == (info["id"], info["type"], info["profile"])
    region, size, rotation, last = body["id"].removeprefix(service["id"] + "/").split("/")
    data, media_type = image_response(gallery, "seal-ri", region, size, rotation, *last.split("."))
    assert data and media_type == body["format"]


def test_what_is_said_of_a_work_is_in_its_manifest(gallery):
    add_annotation(gallery, "seal-ri", {"x": 1.0, "y": 0.0, "title_zh": "角", "text_en": "The corner"})
    (canvas,) = manifest(gallery, "seal-ri", base=BASE)["items"]
    (page,) = canvas["annotations"]
    said = {one["body"]["language"]: one for one in page["items"]}
    assert (said["zh-Hant"]["body"]["value"], said["en"]["body"]["value"]) == ("角", "The corner")
    assert said["en"]["motivation"] == "commenting"
    x, y, width, height = map(int, said["en"]["target"].partition("#xywh=")[2].split(","))
    assert (x + width, y) == (512, 0) and width == height > 0
    assert "annotations" not in manifest(gallery, "seal-tian", base=BASE)["items"][0]


def test_a_work_of_which_little_is_known(bare, labelled):
    from iiif_prezi3 import Manifest

    folder = labelled(1)
    (folder / "labels.csv").write_text("file\nimg/00000.png\n", encoding="utf-8")
    import_folder(bare, folder)
    made = manifest(bare, works(bare).items[0].id, base=BASE)
    assert Manifest(**made)
    told = {pair["label"]["en"][0]: pair["value"]["en"][0] for pair in made["metadata"]}
    assert told["Licence"] == "none stated" and told["Period"] == "not known" and "Hand" not in told
    assert "rights" not in made


def test_a_collection_lists_its_works_in_order(gallery):
    from iiif_prezi3 import Collection

    made = collection_manifest(gallery, "starter", base=BASE)
    assert json.loads(Collection(**made).json()) == made
    wanted = [
        f"{BASE}/iiif/works/{row.id}/manifest.json" for row in works(gallery, collection="starter").items
    ]
    assert [item["id"] for item in made["items"]] == wanted
    assert made["summary"]["zh-Hant"]


def test_what_is_not_there_has_no_manifest(gallery):
    with pytest.raises(GalleryError, match="no work"):
        manifest(gallery, "nothing", base=BASE)
    with pytest.raises(GalleryError, match="no collection"):
        collection_manifest(gallery, "nothing", base=BASE)
