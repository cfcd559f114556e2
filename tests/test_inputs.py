"""Files that are read: whatever is no regular file is refused at once."""

from __future__ import annotations

import os
import socket

import pytest

from rumu import inputs
from rumu.errors import ImageError
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
