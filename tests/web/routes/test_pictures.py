"""Pictures of every kind through the routes that take them: a result or a clear error of the request."""

from __future__ import annotations

import io

import numpy as np
import pytest
import tifffile
from PIL import Image

HOSTILE = (
    "thin-16x3000.png",
    "kept-6879-FAULT.tif",
    "kept-7959-FAULT.jpg",
    "assess-174-FAULT.jpg",
    "bomb-depth.tif",
    "bomb-gray16-24mp.png",
)


def marked(browser, data, name="a.png"):
    fields = {"work": "regular-tian", "keep": "false"}
    return browser("POST", "/api/marks", data=fields, files={"picture": (name, data)})


def added(browser, data, name="a.png", **facts):
    return browser("POST", "/api/works", data=facts, files={"picture": (name, data)})


def check_sentences(answer, code_of):
    assert 400 <= answer.status_code < 500, answer.text
    code_of(answer)
    error = answer.json()["error"]
    assert "/tmp" not in error["en"] + error["zh"] and "rumu-" not in error["en"] + error["zh"]
    assert any("\u4e00" <= letter <= "\u9fff" for letter in error["zh"])


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_files_are_errors_of_the_request(world, cases, code_of, name):
    data = (cases / "hostile" / name).read_bytes()
    check_sentences(added(world.browser("林"), data, name), code_of)
    answer = marked(world.browser(), data, name)
    if answer.status_code == 201:  # a whole picture with nothing on it is marked as such
        assert answer.json()["mark"]["refused"]["code"] in ("black", "blank", "noise")
    else:
        check_sentences(answer, code_of)


def test_a_small_picture_is_told_what_was_expected(world, code_of):
    packed = io.BytesIO()
    Image.new("L", (16, 16), 255).save(packed, "PNG")
    for answer in (marked(world.browser(), packed.getvalue()), added(world.browser("林"), packed.getvalue())):
        assert answer.status_code == 422 and code_of(answer) == "too_small"
        error = answer.json()["error"]
        assert "24 x 24" in error["en"] and "16 x 16" in error["en"] and "24 × 24" in error["zh"]


@pytest.mark.parametrize("name", ["mpo.jpg", "la16.tif"])
def test_photographs_and_scans_are_read_everywhere(world, cases, name):
    data = (cases / "images" / name).read_bytes()
    answer = marked(world.browser(), data, name)
    assert answer.status_code == 201 and answer.json()["mark"]["refused"]["code"] != "blank"
    work = added(world.browser("林"), data, name, title_zh=name)
    assert work.status_code == 201, work.text
    thumb = world.browser()("GET", f"/api/works/{work.json()['id']}/files/picture")
    with Image.open(io.BytesIO(thumb.content)) as picture:
        assert picture.size == (400, 400)


@pytest.mark.parametrize("kind", ["gray+alpha 16", "float32", "float16", "rgb float", "HEIF", "AVIF", "GIF"])
def test_a_copy_has_the_same_mark_in_every_format(world, copy_of, kind):
    gray = np.asarray(Image.open(io.BytesIO(copy_of())).convert("L"))
    packed = io.BytesIO()
    if kind == "gray+alpha 16":
        deep = np.stack([gray.astype(np.uint16) * 257, np.full(gray.shape, 65535, np.uint16)], axis=2)
        tifffile.imwrite(packed, deep, photometric="minisblack", extrasamples=["unassalpha"])
    elif "float" in kind:
        values = (gray / np.float32(255)).astype(np.float16 if "16" in kind else np.float32)
        samples = np.stack([values] * 3, axis=2) if "rgb" in kind else values
        tifffile.imwrite(packed, samples, photometric="rgb" if "rgb" in kind else "minisblack")
    else:
        if kind == "HEIF":
            pytest.importorskip("pillow_heif").register_heif_opener()
        Image.fromarray(gray).convert("RGB").save(packed, kind, quality=95)
    wanted, answer = marked(world.browser(), copy_of()), marked(world.browser(), packed.getvalue())
    assert answer.status_code == 201, answer.text
    assert answer.json()["mark"]["score"] == pytest.approx(wanted.json()["mark"]["score"], abs=2.0)
    work = added(world.browser("林"), packed.getvalue(), title_zh=kind)
    assert work.status_code == 201, work.text
    assert world.browser()("GET", f"/api/works/{work.json()['id']}/files/thumb").status_code == 200


def test_heic_without_its_reader_is_named(world, cases, code_of, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "pillow_heif", None)
    data = (cases / "images/x.heic").read_bytes()
    for answer in (marked(world.browser(), data), added(world.browser("林"), data)):
        check_sentences(answer, code_of)
        error = answer.json()["error"]
        assert all("HEIC" in error[language] and "JPEG" in error[language] for language in ("zh", "en"))
