"""Temporary folders: deleted at the end, swept when their process was killed, never anybody else's."""

from __future__ import annotations

import os
import subprocess
import sys
import time

import pytest

from rumu.workspaces import sweep, temporary_folder

HOLD = (
    "import sys, time, pathlib\nfrom rumu.workspaces import temporary_folder\n"
    "with temporary_folder(parent=pathlib.Path(sys.argv[1])) as folder:\n"
    "    (folder / 'large').write_bytes(b'x' * 1000)\n    print(folder, flush=True)\n    time.sleep(60)\n"
)


def holder(parent):
    process = subprocess.Popen([sys.executable, "-c", HOLD, str(parent)], stdout=-1, text=True)
    assert process.stdout.readline().strip()
    return process


def test_a_folder_is_empty_and_goes_at_the_end(tmp_path):
    with temporary_folder(parent=tmp_path) as folder:
        assert folder.is_dir() and not any(folder.iterdir())
        (folder / "a").write_text("x")
        assert sweep(tmp_path) == 0 and (folder / "a").exists()
    with pytest.raises(ValueError, match="no"), temporary_folder(parent=tmp_path):
        raise ValueError("no")
    assert not any(tmp_path.iterdir())


def test_only_the_folder_of_a_killed_process_is_swept(tmp_path):
    dead, alive = holder(tmp_path), holder(tmp_path)
    dead.kill(), dead.wait()
    (tmp_path / "rumu-abcdefgh").mkdir()  # somebody's, or being made
    (tmp_path / "rumu-notes").mkdir()
    (tmp_path / "mine.txt").write_text("x")
    assert sweep(tmp_path) == 1
    assert sum(path.name.startswith("rumu-") for path in tmp_path.iterdir()) == 3
    alive.kill(), alive.wait()
    assert sweep(tmp_path) == 1
    assert {path.name for path in tmp_path.iterdir()} == {"rumu-abcdefgh", "rumu-notes", "mine.txt"}


def test_a_folder_left_while_it_was_made_is_swept_when_it_is_old(tmp_path):
    (tmp_path / "rumu-abcdefgh").mkdir()
    (tmp_path / "rumu-ijklmnop").mkdir()
    (tmp_path / "rumu-ijklmnop" / "kept").write_text("not ours")
    (tmp_path / "rumu-qrstuvwx").mkdir()
    (tmp_path / "rumu-qrstuvwx" / ".owner").write_text("")
    assert sweep(tmp_path) == 0 and len(list(tmp_path.iterdir())) == 3
    for path in tmp_path.iterdir():
        os.utime(path, (time.time() - 7200, time.time() - 7200))
    sweep(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["rumu-ijklmnop"]


def test_a_folder_of_that_name_that_is_a_link_is_left_alone(tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "rumu-abcdefgh").symlink_to(tmp_path / "real")
    assert sweep(tmp_path) == 0 and (tmp_path / "rumu-abcdefgh").is_symlink()
