"""Where a person's data lie: paths as people write them."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from rumu.errors import OutputError
from rumu.homes import database_place, files_place, user_home


def test_a_home_as_people_write_it(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path / "me"))
    monkeypatch.chdir(tmp_path)
    for text, place in (
        ("~/calligraphy", tmp_path / "me" / "calligraphy"),
        ("~", tmp_path / "me"),
        ("data/rumu", tmp_path / "data" / "rumu"),
        ("./a/../b", tmp_path / "b"),
        (f"  {tmp_path}/c  ", tmp_path / "c"),
    ):
        monkeypatch.setenv("RUMU_HOME", text)
        assert user_home() == place
    for text in ("", "  "):
        monkeypatch.setenv("RUMU_HOME", text)
        monkeypatch.delenv("XDG_DATA_HOME", raising=False)
        assert user_home() == tmp_path / "me" / ".local" / "share" / "rumu" or os.name != "posix"
    monkeypatch.setenv("RUMU_HOME", "~root/x")
    assert user_home() == Path("~root").expanduser() / "x"


def test_a_home_that_cannot_be_a_folder(monkeypatch, tmp_path, rumu):
    (tmp_path / "file").write_text("x")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    for text, words in (
        (f"{tmp_path}/file", "expected a folder, but"),
        (f"{tmp_path}/file/below", "expected a folder, but"),
        (f"{tmp_path}/loop", "RUMU_HOME"),
        ("~nobody-of-this-name/x", "cannot be read as one"),
    ):
        monkeypatch.setenv("RUMU_HOME", text)
        with pytest.raises(OutputError, match=words) as caught:
            user_home()
        assert caught.value.zh
        ended = rumu("gallery", "list")
        assert ended.code == 1 and "RUMU_HOME" in ended.err and "Traceback" not in ended.err


def test_places_of_database_and_files(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("RUMU_HOME", "~/data")
    assert database_place() == str(tmp_path / "data" / "rumu.sqlite")
    assert files_place() == str(tmp_path / "data" / "files")
    monkeypatch.setenv("RUMU_DATABASE", "~/a.sqlite")
    monkeypatch.setenv("RUMU_FILES", "s3://bucket/files")
    assert (database_place(), files_place()) == (str(tmp_path / "a.sqlite"), "s3://bucket/files")
    assert database_place("postgresql://x/y") == "postgresql://x/y"
    assert files_place("~/f") == str(tmp_path / "f")
