"""Files that are read: whatever is no regular file is refused at once."""

from __future__ import annotations

import os
import socket

import numpy as np
import pytest
from PIL import Image

import rumu
from rumu import inputs
from rumu.errors import CalibrationError, CaptureError, ImageError, SurfaceError
from rumu.inputs import open_file, read_file

pytestmark = pytest.mark.timeout(20)


def refusal(path, **more):
    with pytest.raises(ImageError) as caught:
        read_file(path, error_type=ImageError, **more)
    assert caught.value.zh and os.sep not in caught.value.zh
    return str(caught.value)


def test_the_content_of_a_file(tmp_path):
    (tmp_path / "a").write_bytes(b"words")
    assert read_file(tmp_path / "a", error_type=ImageError) == b"words"
    (tmp_path / "link").symlink_to(tmp_path / "a")
    assert read_file(tmp_path / "link", error_type=ImageError) == b"words"
    with open_file(tmp_path / "a", error_type=ImageError) as file:
        assert file.read(2) == b"wo"


def test_a_pipe_nobody_writes_to_a_socket_a_folder_and_devices(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    assert "expected a picture, found a pipe" in refusal(tmp_path / "pipe", expected="a picture")
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(tmp_path / "s"))
        assert "found a socket" in refusal(tmp_path / "s")
    assert "found a folder" in refusal(tmp_path)
    for device in ("/dev/zero", "/dev/null", "/dev/urandom"):
        assert "found a device" in refusal(device)
    reading, writing = os.pipe()
    assert "found a pipe" in refusal(f"/dev/fd/{reading}")
    os.close(reading), os.close(writing)


def test_a_file_of_the_kernel(tmp_path):
    assert "found a file of the kernel" in refusal("/proc/self/maps")
    (tmp_path / "link").symlink_to("/proc/self/environ")
    assert "found a file of the kernel" in refusal(tmp_path / "link")


def test_what_is_not_there_or_may_not_be_read(tmp_path, monkeypatch):
    assert "No such file" in refusal(tmp_path / "gone")
    assert "null byte" in refusal("a\0b")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    assert "symbolic links" in refusal(tmp_path / "loop")


def test_a_file_that_grows_is_read_no_further_than_its_limit(tmp_path):
    (tmp_path / "long").write_bytes(b"x" * 11)
    assert "expected at most" in refusal(tmp_path / "long", most=10)
    assert read_file(tmp_path / "long", most=11, error_type=ImageError) == b"x" * 11


def test_a_file_replaced_by_a_pipe_meanwhile(tmp_path, monkeypatch):
    (tmp_path / "a").write_bytes(b"words")
    real = os.stat

    def swap(path, *more, **how):
        facts = real(path, *more, **how)
        if str(path) == str(tmp_path / "a"):
            (tmp_path / "a").unlink()
            os.mkfifo(tmp_path / "a")
        return facts

    monkeypatch.setattr(inputs.os, "stat", swap)
    assert "found a pipe" in refusal(tmp_path / "a")


NO_PATHS = {
    "NoneType": None,
    "PIL.Image.Image": Image.new("L", (40, 40)),
    "list": [[0, 1]],
    "int": 3,
    "bytes": b"a",
}


@pytest.mark.parametrize("door", [rumu.relief, rumu.read_page, lambda thing: rumu.assess(thing, thing)])
@pytest.mark.parametrize("kind", NO_PATHS)
def test_what_is_no_picture_is_told_by_its_type(door, kind):
    expected = f"expected the path of a picture, or a numpy array of shape (H, W) or (H, W, 3), got {kind}"
    with pytest.raises(ImageError) as caught:
        door(NO_PATHS[kind])
    assert str(caught.value) == expected


@pytest.mark.parametrize("kind", NO_PATHS)
@pytest.mark.parametrize("door", [rumu.read_capture, rumu.reconstruct])
def test_what_is_no_capture_is_told_by_its_type(door, kind):
    with pytest.raises(CaptureError, match=f"expected the path of a capture folder, got {kind}"):
        door(NO_PATHS[kind])


@pytest.mark.parametrize("terms", [{"levels": "panel"}, {"levels": [1, 2]}, {"weights": 3}, {"weights": [1]}])
def test_terms_that_are_no_table_are_told(terms):
    page = np.full((40, 40), 255, np.uint8)
    with pytest.raises(CalibrationError, match=f"{next(iter(terms))}: expected .* got"):
        rumu.assess(page, page, **terms)


@pytest.mark.parametrize("mask", [None, np.ones((20, 20), bool), np.eye(20, dtype=bool)])
def test_normals_of_another_convention_are_told(mask):
    down = np.zeros((20, 20, 3))
    down[..., 2] = -1
    with pytest.raises(SurfaceError, match=r"z toward the camera, got (400 of 400|20 of 20) that point away"):
        rumu.integrate(down, mask=mask)
    down[:15, :, 2] = 1
    assert np.isfinite(rumu.integrate(down, mask=mask)).all()
