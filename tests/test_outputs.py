"""Outputs on a full disk: nothing stays, and it is said where and how much is needed."""

from __future__ import annotations

import errno
import os
import pickle
import subprocess
import sys

import pytest

from rumu.cli.terminal import print_outcome
from rumu.errors import DiskFull, OutputError
from rumu.outputs import is_full, whole_file, whole_folder


def full(path: object = "x", number: int = errno.ENOSPC) -> OSError:
    return OSError(number, "No space left on device", str(path))


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT])
def test_a_file_without_space_leaves_nothing(tmp_path, number):
    target = tmp_path / "out" / "a.png"
    with pytest.raises(DiskFull, match=r"at least 3\.0 MB") as told, whole_file(target) as part:
        part.write_bytes(b"x" * 3 * 2**20)
        raise full(part, number)
    assert str(told.value).startswith(f"{tmp_path / 'out'}: ") and "3.0 MB" in told.value.zh
    assert str(tmp_path) not in told.value.en + told.value.zh
    assert not list((tmp_path / "out").iterdir())


def test_a_file_in_a_folder_without_space_names_the_folder_that_was_wanted(tmp_path):
    with (
        pytest.raises(DiskFull) as told,
        whole_folder(tmp_path / "out", marker="m") as folder,
        whole_file(folder / "a.png") as part,
    ):
        part.write_bytes(b"x")
        raise full(part)
    assert str(told.value).startswith(f"{tmp_path}: ")
    assert not list(tmp_path.iterdir())


def test_other_errors_stay_what_they_are(tmp_path):
    with pytest.raises(PermissionError), whole_file(tmp_path / "a"):
        raise PermissionError(errno.EACCES, "no")
    assert not is_full(PermissionError(errno.EACCES, "no")) and not is_full(None)


def test_it_comes_whole_from_another_process():
    error = pickle.loads(pickle.dumps(DiskFull("/srv/files", 12_345_678)))
    assert isinstance(error, OutputError) and error.needed == "11.8 MB" and "/srv/files" in str(error)
    assert error.zh == DiskFull("/srv/files", 12_345_678).zh


@pytest.mark.parametrize("error", [full("/srv/out/a.png"), DiskFull("/srv/out/a.png")])
def test_a_command_says_it_in_one_line_in_both_languages(error, capsys):
    @print_outcome
    def write():
        raise error

    with pytest.raises(SystemExit):
        write()
    line = capsys.readouterr().err
    assert line.startswith("rumu: /srv/out/a.png: the disk or quota is full") and line.count("\n") == 1
    assert "磁碟或配額已滿" in line


LIMITED = (  # a file that may not grow beyond 200 kB stands for a disk that is full
    "import resource, runpy, sys\nresource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))\n"
    "sys.argv = ['rumu', *sys.argv[1:]]\nfrom rumu.cli import main\nmain()\n"
)


@pytest.mark.skipif(sys.platform == "win32", reason="needs limits of processes")
@pytest.mark.parametrize(
    "arguments",
    [
        ("relief", "big.png", "-o", "out"),
        ("stl", "big.png", "-o", "out.stl"),
        ("assess", "big.png", "--reference", "big.png", "--report", "out.html"),
        ("gallery", "export", "regular-shui", "--html", "-o", "out.html"),
    ],
)
def test_commands_on_a_full_disk(rumu, tmp_path, arguments):
    import numpy as np
    from PIL import Image

    page = np.random.default_rng(0).integers(200, 255, (900, 900), dtype=np.uint8)
    page[100:800, 400:480] = page[400:480, 100:800] = 10
    Image.fromarray(page).save(tmp_path / "big.png")
    rumu("gallery", "list")  # makes the database, which SQLite reports on in its own words
    ended = subprocess.run(
        [sys.executable, "-c", LIMITED, *arguments], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert ended.returncode == 1, ended
    assert ended.stderr.count("\n") == 1 and "the disk or quota is full" in ended.stderr, ended.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["big.png"]


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full")  # noqa: PTH110
def test_output_that_cannot_be_printed():
    with open("/dev/full", "w") as full:  # noqa: PTH123
        ended = subprocess.run(
            [sys.executable, "-m", "rumu.cli", "gallery", "list"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert (ended.returncode, ended.stderr) == (
        1,
        "rumu: the output cannot be written (No space left on device)\n",
    )
