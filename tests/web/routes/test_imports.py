"""Ways in: whatever a teacher's zip holds, nothing outside it is read and nothing of others changes."""

from __future__ import annotations

import copy
import hashlib
import io
import json
import os
import stat
import struct
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from sqlalchemy import select
from starlette.testclient import TestClient
from tests.web.conftest import World, add_people, make_settings

from rumu.database.tables import Annotation, Attempt, Collection, Person, Tour, Work
from rumu.gallery.add_work import add_capture
from rumu.gallery.annotations import add_annotation
from rumu.gallery.archive import export_gallery
from rumu.gallery.catalog import open_gallery
from rumu.gallery.metadata import WorkMetadata
from rumu.gallery.tours import add_tour
from rumu.studio.uploads import add_work
from rumu.values import Bilingual
from rumu.web.app import create_app
from rumu.web.rate_limits import RateLimitSettings

LAMPS = [(1, 0, 2), (0, 1, 2), (-1, 0, 2), (0, -1, 2)]


def png(seed: int, *, side: int = 64) -> bytes:
    """A cross of ink; no two seeds give the same bytes."""
    page = np.full((side, side), 240, np.uint8)
    page[28:36, 8:56] = page[8:56, 28:36] = 20
    page[0, : seed % side] = page[1, : seed // side] = 235
    stream = io.BytesIO()
    Image.fromarray(page).save(stream, "PNG")
    return stream.getvalue()


def photographs(side: int = 32) -> dict[str, bytes]:
    """A mound under four lamps, without its lamp file."""
    y, x = np.mgrid[1 : -1 : side * 1j, -1 : 1 : side * 1j]
    drow, dcol = np.gradient(side / 10 * np.exp(-4 * (x**2 + y**2)))
    normals = np.dstack([-dcol, drow, np.ones_like(x)])
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    files = {}
    for number, lamp in enumerate(LAMPS):
        shade = np.clip(0.8 * normals @ (np.array(lamp) / np.linalg.norm(lamp)), 0, 1)
        stream = io.BytesIO()
        Image.fromarray(np.round(shade * 255).astype(np.uint8)).save(stream, "PNG")
        files[f"{number}.png"] = stream.getvalue()
    return files


def lp(*names: str) -> bytes:
    return "\n".join(
        ["4", *(f"{name} {x} {y} {z}" for name, (x, y, z) in zip(names, LAMPS, strict=True))]
    ).encode()


CAPTURE = {**photographs(), "lights.lp": lp("0.png", "1.png", "2.png", "3.png")}


def make_zip(files: dict[Any, bytes]) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return stream.getvalue()


class Sender:
    """Sends zips as a person and tells how their jobs ended."""

    def __init__(self, world: Any, name: str) -> None:
        self.browser, self.store = world.browser(name), world.service.gallery.store.root

    def __call__(self, files: dict[Any, bytes], **facts: str) -> dict[str, Any]:
        answer = self.browser(
            "POST", "/api/imports", data=facts, files={"zip": ("sent.zip", make_zip(files))}
        )
        if answer.status_code == 422 and answer.json()["error"]["code"] == "unusable":
            job = {"state": "failed", "error": answer.json()["error"]}  # told at once
            assert job["error"]["zh"] and job["error"]["en"] and not list(Path(self.store).glob("uploads/*"))
            for folder in (self.store, f"{tempfile.gettempdir()}/rumu-"):
                assert folder not in answer.text
            return job
        assert answer.status_code == 202, answer.text
        url = f"/api/jobs/{answer.json()['job']['id']}"
        with self.browser.client.stream("GET", f"{url}/events") as stream:
            for _ in stream.iter_lines():
                pass
        job = self.browser("GET", url).json()
        assert job["state"] in ("done", "failed"), job
        if job["state"] == "failed":
            assert job["error"]["zh"] and job["error"]["en"] and "on the server" not in job["error"]["en"], (
                job
            )
        text = json.dumps(job, ensure_ascii=False)
        for folder in (self.store, f"{tempfile.gettempdir()}/rumu-"):
            assert folder not in text, text
        return job


@pytest.fixture(scope="module")
def world(tmp_path_factory):
    """A service that takes as many zips as this module sends."""
    limits = RateLimitSettings(uploads="100000/hour", all="1000000/minute")
    app = create_app(make_settings(tmp_path_factory.mktemp("world"), rate_limits=limits))
    with TestClient(app) as server:
        yield World(server, add_people(app))


@pytest.fixture(scope="module")
def victim(world, copy_of, tmp_path_factory):
    """Someone else's things: a capture, a pupil's attempt, and files of the server outside the gallery."""
    gallery = world.service.gallery
    folder = tmp_path_factory.mktemp("theirs") / "theirs"
    folder.mkdir()
    for name, data in CAPTURE.items():
        (folder / name).write_bytes(data)
    metadata = WorkMetadata(title=Bilingual("別人的", "Theirs"))
    capture = add_capture(gallery, folder, metadata=metadata).id
    attempt = world.browser("吳").marked(copy_of()).json()["id"]
    outside = tmp_path_factory.mktemp("outside")
    for name in ("secret.png", "mask.png", *(f"{k}.png" for k in range(4))):
        (outside / name).write_bytes(png(4000 + len(name)))
    (outside / "secret.txt").write_text("root:x:0:0")
    with gallery.database.reading() as session:
        return {
            "capture": session.get_one(Work, capture),
            "starter": session.get_one(Work, "regular-shui"),
            "attempt": session.get_one(Attempt, attempt),
            "outside": outside,
        }


@pytest.fixture(scope="module")
def snapshot(world) -> Callable[[], dict[str, Any]]:
    """All rows that an import could touch, and the digest of every file of the store."""
    gallery = world.service.gallery

    def take() -> dict[str, Any]:
        seen: dict[str, Any] = {}
        with gallery.database.reading() as session:
            for table in (Collection, Work, Annotation, Tour, Attempt, Person):
                for row in session.scalars(select(table)):
                    columns = {column.name: getattr(row, column.name) for column in table.__table__.columns}
                    seen[f"{table.__tablename__} {row.id}"] = columns
        for folder in ("pictures", "captures", "surfaces", "attempts"):
            for key in gallery.store.keys(folder):
                seen[key] = hashlib.sha256(gallery.store.read(key)).hexdigest()
        return seen

    return take


@pytest.fixture(scope="module")
def unharmed(world, victim, snapshot):
    """A function of a job's sender and a zip: the job, after which all that was there is as it was."""

    def send(files: dict[Any, bytes], *, name: str = "林", **facts: str) -> tuple[dict[str, Any], set[str]]:
        before = snapshot()
        job = Sender(world, name)(files, **facts)
        after = snapshot()
        assert {key: after.get(key) for key in before} == before
        secrets = {hashlib.sha256(path.read_bytes()).hexdigest() for path in victim["outside"].iterdir()}
        assert not secrets & {value for value in after.values() if isinstance(value, str)}
        assert world.browser()("GET", "/api/works?limit=200").status_code == 200
        if job["state"] == "failed":
            assert after == before, "what fails leaves nothing"
        return job, set(after) - set(before)

    return send


# --- zips that lead out ----------------------------------------------------------------------------

SLIPS = [
    "../slip.png",
    "a/../../slip.png",
    "..\\slip.png",
    "a\\..\\..\\slip.png",
    "/tmp/slip.png",
    "//server/share/slip.png",
    "\\\\server\\share\\slip.png",
    "\\slip.png",
    "C:\\slip.png",
    "c:/slip.png",
    "C:slip.png",
    "~/slip.png",
    "~root/slip.png",
    "file:///tmp/slip.png",
    ".. /slip.png",
    ".../slip.png",
    "slip\x01.png",
]
LABELLED = {"labels.csv": "file,character\n永.png,永\n".encode(), "永.png": png(1)}


def link(name: str, kind: int = stat.S_IFLNK) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(name)
    entry.external_attr = (kind | 0o777) << 16
    return entry


@pytest.fixture(scope="module")
def export(tmp_path_factory) -> dict[str, bytes]:
    """The files of an honest export of another gallery: a starter work, an image, a capture, a tour."""
    folder = tmp_path_factory.mktemp("other")
    gallery = open_gallery(database=folder / "rumu.sqlite", files=folder / "files")
    image = add_work(gallery, png(2), {"title_zh": "新作", "character": "永"}, spacing=None)
    (folder / "capture").mkdir()
    for name, data in CAPTURE.items():
        (folder / "capture" / name).write_bytes(data)
    Image.fromarray(np.full((32, 32), 90, np.uint8)).save(folder / "capture" / "3.png")
    add_capture(gallery, folder / "capture", metadata=WorkMetadata(title=Bilingual("新碑", "New stele")))
    add_annotation(gallery, image, {"x": 0.5, "y": 0.5, "title_zh": "新註"})
    add_annotation(gallery, "regular-shui", {"x": 0.1, "y": 0.1, "title_zh": "外來的註"})
    add_tour(gallery, {"title_zh": "外來的導覽", "steps": [{"work": "regular-shui"}]})
    export_gallery(gallery, folder / "out")
    files = (path for path in sorted((folder / "out").rglob("*")) if path.is_file())
    whole = Export({path.relative_to(folder / "out").as_posix(): path.read_bytes() for path in files})
    for work in [one for one in whole.works if one["collection_id"] != "own" and one is not whole.starter]:
        whole.works.remove(work)
        for key in work["files"]:
            whole.files.pop(f"files/{key}", None)
    return whole.packed()


@pytest.mark.parametrize("slip", SLIPS)
def test_no_name_of_any_zip_leads_out(unharmed, export, slip):
    for files in (LABELLED, CAPTURE, export):
        job, _ = unharmed(files | {slip: png(9)})
        assert job["state"] == "failed", slip
    assert not Path("/tmp/slip.png").exists() and not Path("slip.png").exists()


@pytest.mark.parametrize("kind", [stat.S_IFLNK, stat.S_IFCHR, stat.S_IFIFO, stat.S_IFSOCK, stat.S_IFBLK])
def test_no_link_and_no_device_is_unpacked(unharmed, victim, kind):
    target = str(victim["outside"] / "secret.png").encode()
    for name in ("永.png", "0.png", "mask.png", "lights.lp", "labels.csv"):
        files: dict[Any, bytes] = {key: data for key, data in (LABELLED | CAPTURE).items() if key != name}
        job, _ = unharmed(files | {link(name, kind): target})
        assert job["state"] == "failed" and "link or a device" in job["error"]["en"]


def outsiders(outside: Path, name: str) -> list[str]:
    """Names of a file outside the upload."""
    path = outside / name
    return [
        str(path),
        str(path).replace("/", "\\"),
        f"../../../../../../../..{path}",
        "..\\" * 8 + str(path).lstrip("/").replace("/", "\\"),
        f"sub/../../../../../../..{path}",
        path.as_uri(),
        f"~/../..{path}",
        f"//localhost{path}",
        f"C:{path}",
        f"/proc/self/root{path}",
        f".{path}",
    ]


@pytest.mark.parametrize("kind", range(11))
def test_an_lp_reads_no_photograph_of_the_server(unharmed, victim, kind):
    name = outsiders(victim["outside"], "secret.png")[kind]
    job, _ = unharmed(CAPTURE | {"lights.lp": lp("0.png", name, "2.png", "3.png")})
    assert job["state"] == "failed"
    assert name.startswith("//") or "no such file" in job["error"]["en"], job  # which begins a comment


@pytest.mark.parametrize(
    ("changed", "en", "zh"),
    [
        (
            {"lights.lp": lp("0.png", "1.png", "2.png", "3.png").replace(b"4", b"5", 1)},
            "lights.lp",
            "lights.lp",
        ),
        ({"lights.lp": b"1\n0.png 1 2\n"}, "lights.lp line 2", "lights.lp 第 2 行"),
        ({"lights.lp": b"2\n0.png 0.5 0 1\n1.png 0 0.5 1\n"}, "at least 3 images, got 2", "至少要 3 張"),
        ({"lights.lp": lp("0.png", "0.png", "2.png", "3.png")}, "named before", "已經出現過"),
        ({"lights.lp": lp("0.png", "9.png", "2.png", "3.png")}, "no such file", "卻沒有這個檔案"),
        ({"capture.json": b'{"mask": "none.png"}'}, "expected the mask none.png", "遮罩 none.png"),
        ({"capture.json": b'{"spacing_mm": '}, "capture.json", "capture.json"),
    ],
)
def test_a_capture_that_is_plainly_wrong_is_refused_at_once(world, changed, en, zh):
    browser = world.browser("林")
    answer = browser("POST", "/api/imports", files={"zip": ("sent.zip", make_zip(CAPTURE | changed))})
    assert answer.status_code == 422, answer.text
    error = answer.json()["error"]
    assert error["code"] == "unusable" and en in error["en"] and zh in error["zh"]
    assert not list(Path(world.service.gallery.store.root).glob("uploads/*"))


@pytest.mark.parametrize("kind", range(11))
def test_a_mask_of_the_server_is_not_read(unharmed, victim, kind):
    name = outsiders(victim["outside"], "secret.png")[kind]
    job, _ = unharmed(CAPTURE | {"capture.json": json.dumps({"mask": name}).encode()})
    assert job["state"] == "failed" and "expected the mask" in job["error"]["en"]


@pytest.mark.parametrize("kind", range(11))
def test_labels_take_no_picture_of_the_server(unharmed, victim, kind):
    name = outsiders(victim["outside"], "secret.png")[kind]
    table = f"file,character\n永.png,永\n{name},水\n".encode()
    job, _ = unharmed(LABELLED | {"labels.csv": table}, collection=f"labels {kind}")
    assert job["state"] == "done" and job["result"]["left_out_count"] == 1


def test_what_is_no_text_of_the_server_is_not_told(unharmed, victim):
    """A lamp file that is not one is quoted in its error; it can only be one of the zip."""
    for name in outsiders(victim["outside"], "secret.txt"):
        job, _ = unharmed(CAPTURE | {"lights.lp": lp(name, "1.png", "2.png", "3.png")})
        assert "root:x" not in json.dumps(job)


def test_devices_and_odd_characters_are_names_of_files(unharmed):
    table = "file,character\nNUL,永\ncon.png,永\n/dev/zero,永\n水:b?.png,永\n".encode()
    job, _ = unharmed({"labels.csv": table, "con.png": png(11), "水:b?.png": png(12)}, collection="devices")
    assert job["result"]["added"] == 2
    assert [file for file, *_ in job["result"]["left_out"]] == ["NUL", "/dev/zero"]


# --- exports that claim more than a teacher may ----------------------------------------------------


class Export:
    """An export to be changed: its manifest, its works and its files."""

    def __init__(self, files: dict[str, bytes]) -> None:
        self.files = dict(files)
        self.manifest = json.loads(self.files.pop("gallery.json"))
        self.works = [json.loads(line) for line in self.files.pop("works.jsonl").splitlines()]

    @property
    def image(self) -> dict[str, Any]:
        return next(work for work in self.works if work["title_zh"].startswith("新作"))

    @property
    def capture(self) -> dict[str, Any]:
        return next(work for work in self.works if work["kind"] == "capture")

    @property
    def starter(self) -> dict[str, Any]:
        return next(work for work in self.works if work["id"] == "regular-shui")

    def packed(self) -> dict[str, bytes]:
        lines = "\n".join(json.dumps(work) for work in self.works)
        manifest = self.manifest | {"works": len(self.works)}
        return {"gallery.json": json.dumps(manifest).encode(), "works.jsonl": lines.encode()} | self.files

    def move(self, work: dict[str, Any], name: str, key: str) -> None:
        """Let a work's picture, surface or capture lie at another key, with its files."""
        old, work[name] = work[name], key
        for file in [file for file in work["files"] if file == old or file.startswith(f"{old}/")]:
            work["files"][work["files"].index(file)] = key + file[len(old) :]
            self.files[f"files/{key}{file[len(old) :]}"] = self.files.pop(f"files/{file}")


def in_(work: str, **columns: Any) -> Callable[[Export, Any], None]:
    def change(export: Export, victim: Any) -> None:
        getattr(export, work).update(columns)

    return change


def said(**columns: Any) -> Callable[[Export, Any], None]:
    def change(export: Export, victim: Any) -> None:
        export.image["annotations"][0].update(columns)

    return change


def collected(**columns: Any) -> Callable[[Export, Any], None]:
    def change(export: Export, victim: Any) -> None:
        export.manifest["collections"][0].update(columns)

    return change


def steal_attempt(export: Export, victim: Any) -> None:
    export.image.update(picture=victim["attempt"].picture, files=[victim["attempt"].picture])


def bring_attempt(export: Export, victim: Any) -> None:
    export.move(export.image, "picture", victim["attempt"].picture)


def name_picture(export: Export, victim: Any) -> None:
    export.image.update(picture=victim["starter"].picture, files=[victim["starter"].picture])
    export.works.remove(export.starter)
    del export.files[f"files/{victim['starter'].picture}"]


def replace_picture(export: Export, victim: Any) -> None:
    export.works.remove(export.starter)
    export.move(export.image, "picture", victim["starter"].picture)


def name_surface(export: Export, victim: Any) -> None:
    export.image.update(surface=victim["capture"].surface, capture=victim["capture"].capture)
    export.image.update(kind="capture", height_source="photometric")


def file_of_another(export: Export, victim: Any) -> None:
    key = f"{victim['capture'].surface}/height.tif"
    export.image["files"].append(key)
    export.files[f"files/{key}"] = b"1"


def picture_out(export: Export, victim: Any) -> None:
    export.image["files"].append("pictures/../../secret.png")


def no_picture(export: Export, victim: Any) -> None:
    data = b"no picture"
    digest = hashlib.sha256(data).hexdigest()
    export.move(export.image, "picture", f"pictures/{digest[:2]}/{digest}.png")
    export.files[f"files/{export.image['picture']}"] = data


def speak_of_another(export: Export, victim: Any) -> None:
    export.image["annotations"][0]["work_id"] = "seal-ri"


def twice(export: Export, victim: Any) -> None:
    export.works.append(copy.deepcopy(export.image))


def lamps_out(export: Export, victim: Any) -> None:
    key = f"files/{export.capture['capture']}/lights.lp"
    lines = export.files[key].decode().splitlines()
    lines[1] = f"{victim['outside']}/secret.png " + " ".join(lines[1].split()[-3:])
    export.files[key] = "\n".join(lines).encode()


def mask_out(export: Export, victim: Any) -> None:
    key = f"files/{export.capture['capture']}/capture.json"
    export.files[key] = json.dumps({"mask": str(victim["outside"] / "secret.png")}).encode()


def no_surface(export: Export, victim: Any) -> None:
    export.files[f"files/{export.capture['surface']}/height.tif"] = b"no tiff"


def unlisted_file(export: Export, victim: Any) -> None:
    export.files[f"files/{export.capture['capture']}/more.png"] = png(3)


def half(export: Export, victim: Any) -> None:
    """The works before the last are whole."""
    export.works.append(export.image | {"id": "zz", "digest": "0" * 64, "annotations": [], "width": "abc"})


def fewer(export: Export, victim: Any) -> None:
    export.manifest["works"] = 10**6
    export.packed = lambda: {"gallery.json": json.dumps(export.manifest).encode(), "works.jsonl": b""}  # type: ignore[method-assign]


def nested(export: Export, victim: Any) -> None:
    packed = export.packed() | {"works.jsonl": b"[" * 200_000}
    export.packed = lambda: packed  # type: ignore[method-assign]


LONG, ODD_IDS = (
    "長" * 500,
    ("a/b", "../x", "", "a b", "永", "a?b#c", "..", "/x", "%2e%2e", "x" * 65, "-x", None, 5),
)

REFUSED: dict[str, Callable[[Export, Any], None]] = {
    **{
        f"width {value!r}": in_("image", width=value)
        for value in ("abc", "64", None, 0, -1, 2**40, 1.5, True, [])
    },
    **{f"height {value!r}": in_("image", height=value) for value in ("abc", float("nan"), float("inf"))},
    **{
        f"spacing {value!r}": in_("image", spacing=value)
        for value in (float("nan"), float("inf"), 0, -1, "1")
    },
    **{f"position {value!r}": in_("image", position=value) for value in (-1, 2**31, "0", 0.5)},
    **{f"id {value!r}": in_("image", id=value) for value in ODD_IDS},
    **{f"collection {value!r}": in_("image", collection_id=value) for value in ("a/b", "nowhere", None)},
    **{
        f"title {value!r:.9}": in_("image", title_zh=value) for value in (LONG, 5, None, {}, "a\0b", "\ud800")
    },
    **{f"{name} too long": in_("image", **{name: LONG}) for name in ("character", "hand_en", "period_zh")},
    "source too long": in_("image", source=LONG * 100),
    "origin too long": in_("image", origin=LONG * 2),
    "script": in_("image", script="wild"),
    "kind": in_("image", kind="movie"),
    "height source": in_("image", height_source="guess"),
    "height source of a capture": in_("image", height_source="photometric"),
    "capture without surface": in_("capture", surface=None),
    **{f"digest {value!r}": in_("image", digest=value) for value in ("x" * 64, "0" * 63, None)},
    **{
        f"created {value!r}": in_("image", created=value)
        for value in ("yesterday", "2026-01-01T00:00:00", "9999-12-31T23:59:59Z", 5, None)
    },
    "unknown column": in_("image", author_id="1"),
    "search": in_("image", search="words"),
    "files of none": in_("image", files=[]),
    "picture elsewhere": in_("image", picture="uploads/x/sent.zip", files=["uploads/x/sent.zip"]),
    "picture by a path": in_("image", picture="/etc/passwd", files=["/etc/passwd"]),
    "picture up": in_("image", picture="pictures/../attempts/x.png", files=["pictures/../attempts/x.png"]),
    **{
        f"annotation x {value!r}": said(x=value)
        for value in (float("nan"), float("inf"), -0.1, 2, "0.5", None)
    },
    **{f"annotation id {value!r}": said(id=value) for value in ("a/b", "", None)},
    "annotation too long": said(text_zh=LONG * 100),
    "annotation by another": said(author_id="x"),
    "annotation of another work": speak_of_another,
    **{f"collection id {value!r}": collected(id=value) for value in ("a/b", "", "..")},
    "collection title": collected(title_zh=5),
    "collection column": collected(owner="me"),
    "a pupil's attempt": steal_attempt,
    "a pupil's attempt, brought": bring_attempt,
    "a picture that is not brought": name_picture,
    "another content for a picture": replace_picture,
    "a surface that is not brought": name_surface,
    "a file of another work": file_of_another,
    "a file out": picture_out,
    "no picture": no_picture,
    "lamps out": lamps_out,
    "mask out": mask_out,
    "no surface": no_surface,
    "an unlisted file": unlisted_file,
    "twice": twice,
    "half": half,
    "fewer": fewer,
    "nested": nested,
}


@pytest.mark.parametrize("sender", ["林", "館主"])
@pytest.mark.parametrize("trick", REFUSED)
def test_an_export_that_is_not_as_it_must_be_is_refused_whole(unharmed, victim, export, trick, sender):
    changed = Export(export)
    REFUSED[trick](changed, victim)
    job, _ = unharmed(changed.packed(), name=sender)
    assert job["state"] == "failed"


def rename_starter(export: Export, victim: Any) -> None:
    export.starter.update(title_zh="改名", title_en="Renamed", spacing=1.0, licence="mine")


def replace_work(export: Export, victim: Any) -> None:
    export.works.remove(export.starter)
    export.image.update(id="regular-shui", annotations=[])


def replace_capture(export: Export, victim: Any) -> None:
    export.works.remove(export.image)
    export.capture.update(id=victim["capture"].id)


def take_keys(export: Export, victim: Any) -> None:
    """The files of another work's surface and photographs, with other contents."""
    for name in ("surface", "capture"):
        export.move(export.capture, name, getattr(victim["capture"], name))
    export.works.remove(export.image)


def claim_digest(export: Export, victim: Any) -> None:
    export.image.update(id="claimed", digest="ab" * 32, created="2199-01-01T00:00:00+00:00", annotations=[])
    export.image.update(title_zh="新作之三")
    export.works.remove(export.capture)


def rename_collection(export: Export, victim: Any) -> None:
    for one in export.manifest["collections"]:
        one.update(title_zh="改名", licence="mine", note_zh="改")


ADDED: dict[str, tuple[Callable[[Export, Any], None], int]] = {
    "renames": (rename_starter, 2),
    "renames collections": (rename_collection, 0),
    "the id of another work": (replace_work, 0),
    "the id of another capture": (replace_capture, 0),
    "the keys of another work": (take_keys, 0),
    "claims of its digest and time": (claim_digest, 1),
}
"""What a teacher's export may hold, since it only adds; and how many works it adds, in this order."""


@pytest.mark.parametrize("trick", ADDED)
def test_a_teachers_export_only_adds_works(world, unharmed, victim, export, trick):
    changed = Export(export)
    change, count = ADDED[trick]
    change(changed, victim)
    job, new = unharmed(changed.packed())
    assert (job["state"], job["result"]["added"]) == ("done", count), job
    tables = {name.split(" ")[0] for name in new if " " in name}
    assert tables <= {"works", "annotations", "collections"}
    with world.service.gallery.database.reading() as session:
        assert not session.scalars(select(Tour).where(Tour.title_zh == "外來的導覽")).all()
        assert not session.scalars(select(Annotation).where(Annotation.title_zh == "外來的註")).all()
        assert not session.scalars(select(Work).where(Work.digest == "ab" * 32)).all()
    assert any("導覽" in zh for _, _, zh in job["result"]["left_out"])
    for name in new:
        if name.startswith("works "):
            work_id = name.removeprefix("works ")
            for kind in ("thumb", "picture", "normals", "glb"):
                answer = world.browser()("GET", f"/api/works/{work_id}/files/{kind}")
                assert answer.status_code == 200, answer.text


def test_an_owners_export_that_claims_the_keys_of_another_work_gets_others(world, unharmed, victim, export):
    changed = Export(export)
    changed.capture.update(id="restored", digest="cd" * 32)
    changed.manifest["tours"] = []
    for name in ("surface", "capture"):
        changed.move(changed.capture, name, getattr(victim["capture"], name))
    changed.works = [changed.capture]
    job, _ = unharmed(changed.packed(), name="館主")
    assert job["result"]["added"] == 1
    with world.service.gallery.database.reading() as session:
        restored = session.get_one(Work, "restored")
    assert restored.surface != victim["capture"].surface and restored.capture != victim["capture"].capture
    assert world.browser()("GET", "/api/works/restored/files/normals").status_code == 200


def test_an_owner_restores_what_a_teacher_may_not_add(new_world, export):
    world = new_world()
    job = Sender(world, "館主")(export)
    assert job["state"] == "done" and job["result"]["added"] == 2 and job["result"]["left_out"] == []
    with world.service.gallery.database.reading() as session:
        assert session.scalars(select(Tour).where(Tour.title_zh == "外來的導覽")).all()
        assert session.scalars(select(Annotation).where(Annotation.title_zh == "外來的註")).all()


def test_an_owner_who_is_one_no_more_when_the_job_runs_only_adds(new_world, export, monkeypatch):
    from rumu.studio import job_handlers

    world = new_world()
    handler = job_handlers.HANDLERS["import"]

    def later(gallery, payload, progress, storage):
        with gallery.database.writing() as session:
            session.get_one(Person, world.ids["館主"]).role = "teacher"
        return handler(gallery, payload, progress, storage)

    monkeypatch.setitem(job_handlers.HANDLERS, "import", later)
    assert Sender(world, "館主")(export)["result"]["left_out_count"] == 1


# --- zips that are no good -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("head", "word"), [(b"Rar!\x1a\x07\x00", "RAR"), (b"7z\xbc\xaf\x27\x1c", "7z"), (b"", "zip")]
)
def test_another_archive_is_refused_at_once_by_its_name(world, code_of, head, word):
    teacher = world.browser("林")
    answer = teacher("POST", "/api/imports", files={"zip": ("a.zip", head + b"x" * 600)})
    assert code_of(answer) == "no_zip" and word in answer.json()["error"]["en"]


def test_a_bomb_is_refused(unharmed):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("0", b"\0" * 200_000_000)
    inner = stream.getvalue()
    for files in ({"a.zip": inner}, {"labels.csv": b"file\na.png\n", "a.png": inner}):
        job, _ = unharmed(files)
        assert job["state"] == "failed"


def test_a_zip_of_false_sizes_is_refused(world, unharmed, monkeypatch):
    lying = bytearray(make_zip({"labels.csv": b"file\n" * 100}))
    at = lying.index(b"PK\x01\x02")
    lying[at + 24 : at + 28] = struct.pack("<I", 3)
    monkeypatch.setitem(Sender.__call__.__globals__, "make_zip", lambda files: bytes(lying))
    job, _ = unharmed({})
    assert job["state"] == "failed"


# --- errors ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("data", [b"no picture", png(1)[:60], b""])
def test_errors_of_single_pictures_name_no_folder_of_the_server(world, data):
    answer = world.browser("林")("POST", "/api/works", files={"picture": ("a.png", data)})
    assert answer.status_code == 422, answer.text
    assert tempfile.gettempdir() not in answer.text and "rumu-" not in answer.text
    error = answer.json()["error"]
    assert error["zh"] and error["en"] and error["zh"] != error["en"]


@pytest.mark.parametrize(("code", "status"), [(5, 422), (28, 507)])
def test_an_error_of_the_store_names_no_folder_of_the_server(world, monkeypatch, code, status):
    from rumu.gallery import store

    def fail(target, data):
        raise OSError(code, os.strerror(code), str(target))

    monkeypatch.setattr(store, "_write_local", fail)
    answer = world.browser("林")("POST", "/api/works", files={"picture": ("a.png", png(77))})
    assert answer.status_code == status, answer.text
    assert world.service.gallery.store.root not in answer.text and tempfile.gettempdir() not in answer.text


@pytest.mark.parametrize(
    "files",
    [
        LABELLED | {"collection.json": b"[" * 200_000},
        LABELLED | {"collection.json": json.dumps({"note": {"zh": "a\0b", "en": ""}}).encode()},
        LABELLED | {"collection.json": json.dumps({"note": {"zh": LONG * 100, "en": ""}}).encode()},
        CAPTURE | {"capture.json": b"[" * 200_000},
        CAPTURE | {"capture.json": b'{"spacing_mm": NaN}'},
    ],
    ids=["nested", "control characters", "long", "nested capture", "NaN"],
)
def test_json_that_is_no_good_is_told_as_such(unharmed, files):
    job, _ = unharmed(files, collection="")
    assert job["state"] == "failed"
    assert any(word in job["error"]["en"] for word in (".json", "note_zh")), job
