"""Museums' works: every server's way, politely, whole, once, and on again after a kill."""

from __future__ import annotations

import io
import json
import os
import signal
import subprocess
import sys
from collections import Counter

import numpy as np
import pytest
from PIL import Image
from sqlalchemy import select
from tests.gallery.museum import BEHAVIOURS, HEIGHT, WIDTH, open_museum, picture_of

from rumu.database.tables import Collection, Work
from rumu.errors import GalleryError
from rumu.gallery import catalog
from rumu.gallery.catalog import open_gallery
from rumu.gallery.iiif_import import import_manifest
from rumu.gallery.iiif_reading import read_presentation
from rumu.gallery.labels import SharedMetadata
from rumu.gallery.museum_web import FetchSettings, MuseumWeb, NotNow
from rumu.values import Bilingual

QUICK = FetchSettings(pause=0.0, private=True)


@pytest.fixture
def museum():
    with open_museum(len(BEHAVIOURS)) as opened:
        yield opened


@pytest.fixture
def web(tmp_path):
    """A web whose waits are noted and not waited for."""
    waits: list[float] = []
    return MuseumWeb(tmp_path / "kept", QUICK, sleep=waits.append), waits


def works_of(gallery):
    with gallery.database.reading() as session:
        return session.scalars(select(Work).order_by(Work.position)).all()


def pixels(gallery, work):
    return np.asarray(Image.open(io.BytesIO(gallery.store.read(work.picture))).convert("RGB"), dtype=float)


def test_every_picture_comes_whole_whatever_the_server_does(bare, museum, web):
    steps = []
    done = import_manifest(
        bare, f"{museum.base}/manifest.json", web=web[0], progress=lambda n, of: steps.append((n, of))
    )
    assert (done.added, done.left_out) == (len(BEHAVIOURS), ())
    assert steps == [(n, len(BEHAVIOURS)) for n in range(1, len(BEHAVIOURS) + 1)]
    for number, work in enumerate(works_of(bare)):
        kind = museum.behaviour(number)
        size = (WIDTH // 2, HEIGHT // 2) if kind == "level 0 with sizes" else (WIDTH, HEIGHT)
        assert (work.width, work.height) == size, kind
        original = np.asarray(picture_of(number).resize(size), dtype=float)
        assert np.abs(pixels(bare, work) - original).mean() < 6, kind  # JPEG of JPEG


def test_what_the_museum_says_is_kept_and_shown(bare, museum, web):
    import_manifest(bare, f"{museum.base}/manifest.json", web=web[0])
    work = works_of(bare)[0]
    assert (work.title_zh, work.title_en) == ("蘭亭帖　leaf 1", "Lanting album, leaf 1")
    assert (work.licence, work.source) == ("CC0-1.0", f"{museum.base}/objects/1")
    assert work.attribution == "Gift of & A. Donor; A Museum"
    assert work.record["label"] == {"zh-Hant": ["蘭亭帖"], "en": ["Lanting album"], "fr": ["Album"]}
    assert work.record["canvas"] == museum.canvas_id(0)
    assert work.record["metadata"] == [{"label": {"en": ["Date"]}, "value": {"en": ["Tang"], "zh": ["唐"]}}]
    assert work.record["provider"] == [{"en": ["A Museum"]}]
    assert work.record["rights"] == "http://creativecommons.org/publicdomain/zero/1.0/"
    with bare.database.reading() as session:
        collection = session.scalars(select(Collection)).one()
    assert (collection.title_zh, collection.title_en) == ("蘭亭帖", "Lanting album")
    assert next(found.id for found in catalog.works(bare, query="Lanting").items) == work.id


def test_version_2_is_read_as_version_3_is(bare, museum, web):
    shared = SharedMetadata({"script": "running", "id": "album"}, {"hand": Bilingual("王羲之", "Wang Xizhi")})
    done = import_manifest(bare, f"{museum.base}/v2.json", web=web[0], shared=shared)
    assert (done.collections, done.added) == (("album",), len(BEHAVIOURS))
    work = works_of(bare)[2]
    assert (work.title_zh, work.title_en) == ("書帖　3r", "書帖, 3r")
    assert (work.script, work.hand_zh, work.licence) == ("running", "王羲之", "CC-BY-4.0")
    assert work.attribution == "A Library"
    assert work.record["label"] == {"fr": ["Calligraphie"], "zh": ["書帖"]}
    assert work.record["metadata"][0]["value"] == {"none": ["Wang", "Yan"]}


def test_it_waits_as_long_as_the_server_asks(bare, museum, web):
    import_manifest(bare, f"{museum.base}/manifest.json", web=web[0])
    assert 7.0 in web[1]  # Retry-After
    number = BEHAVIOURS.index("429")
    assert museum.asked[f"/image/{number}/info.json"] == 2


def test_there_is_a_pause_between_requests(bare, museum, tmp_path):
    now, waits = [0.0], []

    def sleep(seconds):
        waits.append(seconds)
        now[0] += seconds

    web = MuseumWeb(tmp_path, FetchSettings(pause=0.5, private=True), sleep=sleep, clock=lambda: now[0])
    import_manifest(bare, f"{museum.base}/manifest.json", web=web)
    assert museum.asked.total() == web.fetched
    assert sum(waits) >= 0.5 * (web.fetched - 1)


def test_a_server_that_wants_too_much_time_ends_the_import_which_goes_on_later(bare, museum, tmp_path):
    settings = FetchSettings(pause=0.0, private=True, longest_wait=5.0)
    with pytest.raises(NotNow, match="come back in 7 s"):
        import_manifest(bare, f"{museum.base}/manifest.json", web=MuseumWeb(tmp_path, settings, sleep=print))
    before = [work.id for work in works_of(bare)]
    assert len(before) == BEHAVIOURS.index("429")
    done = import_manifest(bare, f"{museum.base}/manifest.json", web=MuseumWeb(tmp_path, settings))
    assert (done.added, done.existing) == (len(BEHAVIOURS) - len(before), len(before))
    assert museum.asked["/manifest.json"] == 1  # it was kept


def test_a_picture_that_is_not_there_is_left_out_with_the_reason(bare, museum, web):
    facts = museum.manifest()
    body = facts["items"][4]["items"][0]["items"][0]["body"]
    assert "service" not in body
    body["id"] = f"{museum.base}/image/4/none"
    file = web[0].folder.parent / "manifest.json"
    file.write_text(json.dumps(facts), encoding="utf-8")
    done = import_manifest(bare, file, web=web[0])
    assert done.added == len(BEHAVIOURS) - 1
    assert [name for name, _ in done.left_out] == [museum.canvas_id(4)]
    assert "404" in done.left_out[0][1].en and "404" in done.left_out[0][1].zh


@pytest.mark.parametrize("address", ["image.jpg", "http://[", "ftp://a.example/b.jpg", "http://a..example/"])
def test_a_canvas_whose_picture_has_no_address_is_left_out(bare, museum, web, address):
    facts = museum.manifest()
    facts["items"] = [facts["items"][4], facts["items"][0]]
    facts["items"][0]["items"][0]["items"][0]["body"]["id"] = address
    file = web[0].folder.parent / "manifest.json"
    file.write_text(json.dumps(facts), encoding="utf-8")
    done = import_manifest(bare, file, web=web[0])
    assert (done.added, [name for name, _ in done.left_out]) == (1, [museum.canvas_id(4)])


def test_what_is_no_picture_is_told_by_its_address(bare, museum, web):
    facts = museum.manifest()
    facts["items"] = [facts["items"][4]]
    facts["items"][0]["items"][0]["items"][0]["body"]["id"] = f"{museum.base}/manifest.json"
    file = web[0].folder.parent / "manifest.json"
    file.write_text(json.dumps(facts), encoding="utf-8")
    ((_, reason),) = import_manifest(bare, file, web=web[0]).left_out
    assert reason.en.startswith(f"{museum.base}/manifest.json: expected an image")


def test_each_picture_of_a_canvas_is_a_work(bare, museum, web):
    facts = museum.manifest()
    leaf, other = facts["items"][4], facts["items"][0]
    leaf["items"][0]["items"] += other["items"][0]["items"]
    facts["items"] = [leaf]
    file = web[0].folder.parent / "manifest.json"
    file.write_text(json.dumps(facts), encoding="utf-8")
    for added, existing in ((2, 0), (0, 2)):
        done = import_manifest(bare, file, web=web[0])
        assert (done.added, done.existing, done.left_out) == (added, existing, ())
    titles = sorted(work.title_en for work in works_of(bare))
    assert len(titles) == 2 and titles[1] == f"{titles[0]} (2)"


@pytest.mark.parametrize(
    ("selector", "size"),
    [
        ({"type": "ImageApiSelector", "region": "30,20,120,90", "rotation": "90"}, (90, 120)),
        ({"@type": "iiif:ImageApiSelector", "region": "pct:50,0,50,100"}, (150, 200)),
        ({"type": "FragmentSelector", "value": "xywh=0,0,60,40"}, (60, 40)),
        ({"type": "PointSelector", "x": 3, "y": 4}, (300, 200)),
        ({"type": "ImageApiSelector", "region": "900,0,10,10"}, None),
    ],
)
def test_of_a_picture_the_part_is_brought_that_the_canvas_shows(bare, museum, web, selector, size):
    facts = museum.manifest()
    annotation = facts["items"][0]["items"][0]["items"][0]
    annotation["body"] = {"type": "SpecificResource", "source": annotation["body"], "selector": selector}
    facts["items"] = facts["items"][:1]
    file = web[0].folder.parent / "manifest.json"
    file.write_text(json.dumps(facts), encoding="utf-8")
    done = import_manifest(bare, file, web=web[0])
    works = [(work.width, work.height) for work in works_of(bare)]
    assert works == ([size] if size else []) and len(done.left_out) == (size is None)


def _painted_by(*annotations):
    return {"type": "Canvas", "id": "c", "items": [{"type": "AnnotationPage", "items": [*annotations]}]}


@pytest.mark.parametrize("kind", ["Sound", "Video", "dctypes:MovingImage", "TextualBody"])
def test_sound_film_and_text_are_not_fetched(kind):
    annotation = {"motivation": "painting", "body": {"id": "https://a.example/b", "type": kind}}
    facts = {"type": "Manifest", "label": {"en": ["a"]}, "items": [_painted_by(annotation)]}
    found = read_presentation(json.dumps(facts).encode(), url="https://a.example/m")
    assert (found.canvases, found.without_picture) == ((), 1)


IMAGE = {"id": "https://a.example/i/full/max/0/default.jpg", "type": "Image"}
SERVICE = {"id": "https://a.example/i", "type": "ImageService3", "profile": "level2"}
LOGIN = {"@id": "https://a.example/login", "profile": "http://iiif.io/api/auth/1/login"}


@pytest.mark.parametrize(
    ("annotation", "service"),
    [
        ({"motivation": ["painting"], "body": [IMAGE]}, ""),
        ({"motivation": ["commenting", "sc:painting"], "body": {"type": "Choice", "items": [IMAGE]}}, ""),
        ({"motivation": "painting", "body": {**IMAGE, "service": [LOGIN, SERVICE]}}, "https://a.example/i"),
        ({"motivation": "painting", "body": {**IMAGE, "service": LOGIN}}, ""),
        ({"body": {**IMAGE, "service": {"@id": "https://a.example/i/"}}}, "https://a.example/i"),
        ({"motivation": ["commenting"], "body": [IMAGE]}, None),
    ],
)
def test_a_picture_is_painted_as_web_annotations_may_say_it(annotation, service):
    """motivation and body may be lists, and other services may stand beside that of the picture."""
    facts = {"type": "Manifest", "label": {"en": ["a"]}, "items": [_painted_by(annotation)]}
    found = read_presentation(json.dumps(facts).encode(), url="https://a.example/m")
    if service is None:
        assert not found.canvases and found.without_picture == 1
    else:
        assert [(one.picture, one.service) for one in found.canvases] == [(IMAGE["id"], service)]


def test_a_collection_brings_its_manifests_each_once(bare, museum, web):
    done = import_manifest(bare, f"{museum.base}/collection.json", web=web[0])
    assert done.added == len(BEHAVIOURS)
    assert [name.rpartition("/")[2] for name, _ in done.left_out] == ["gone.json"]


def test_two_leaves_that_are_alike_are_two_works(bare, museum, web):
    facts = museum.manifest()
    for canvas in facts["items"]:
        canvas["label"] = {"none": ["blank"]}
        canvas["items"][0]["items"][0]["body"] = {"id": f"{museum.base}/image/0.jpg", "type": "Image"}
    file = web[0].folder.parent / "manifest.json"
    file.write_text(json.dumps(facts), encoding="utf-8")
    assert import_manifest(bare, file, web=web[0]).added == len(BEHAVIOURS)
    again = import_manifest(bare, file, web=web[0])
    assert (again.added, again.existing) == (0, len(BEHAVIOURS))


def test_a_large_picture_comes_reduced_by_its_tiles(bare, museum, web):
    shared = SharedMetadata({"id": "small"})
    import_manifest(
        bare, f"{museum.base}/manifest.json", web=web[0], shared=shared, max_pixels=WIDTH * HEIGHT // 3
    )
    sizes = {museum.behaviour(n): (work.width, work.height) for n, work in enumerate(works_of(bare))}
    assert set(sizes.values()) == {(WIDTH // 2, HEIGHT // 2)}


KILLED = """
import sys
from pathlib import Path
from rumu.gallery.catalog import open_gallery
from rumu.gallery.iiif_import import import_manifest
from rumu.gallery.museum_web import FetchSettings, MuseumWeb
home = Path(sys.argv[2])
gallery = open_gallery(database=home / "a.sqlite", files=home / "files", starter=False)
web = MuseumWeb(home / "kept", FetchSettings(pause=0.0, private=True), sleep=lambda seconds: None)
done = import_manifest(gallery, sys.argv[1], web=web)
print(done.added, done.existing, len(done.left_out))
"""


def test_200_canvases_killed_twice_are_whole_and_once(tmp_path):
    with open_museum(200) as museum:
        command = [sys.executable, "-c", KILLED, f"{museum.base}/manifest.json", str(tmp_path)]
        for requests in (60, 260):
            running = subprocess.Popen(command, env=os.environ)
            museum.wait_for(requests)
            running.send_signal(signal.SIGKILL)
            running.wait()
        end = subprocess.run(command, env=os.environ, capture_output=True, text=True, check=True)
        added, existing, left_out = map(int, end.stdout.split())
        assert 0 < existing < 200 and added == 200 - existing and left_out == 0
        gallery = open_gallery(database=tmp_path / "a.sqlite", files=tmp_path / "files", starter=False)
        rows = works_of(gallery)
        assert Counter(row.origin for row in rows) == Counter(museum.canvas_id(n) for n in range(200))
        assert all(pixels(gallery, row).shape[:2] == (row.height, row.width) for row in rows)
        # of each picture at most the one that was under way when it was killed came twice
        twice = [path for path, count in museum.asked.items() if count > 1 and path.endswith("default.jpg")]
        alone = [
            path for path in twice if museum.behaviour(int(path.split("/")[-5])) not in ("429", "500 once")
        ]
        assert len(alone) <= 2
        gallery.database.close()


def test_what_is_no_manifest_is_refused(bare, museum, web, tmp_path):
    for name, data in {"a": b"<html>", "b": b"[]", "c": b'{"type": "Canvas"}', "d": b"\xff\xfe"}.items():
        (tmp_path / name).write_bytes(data)
        with pytest.raises(GalleryError, match="expected a manifest or a collection"):
            import_manifest(bare, tmp_path / name, web=web[0])
    assert works_of(bare) == []
