"""Commands as whole processes: what stays when one is killed (kill -9) is no process, and soon no folder."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest
from tests.test_workspaces import holder


def processes_with(marker: str) -> set[int]:
    """Numbers of the processes whose environment holds the marker."""
    found = set()
    for entry in os.scandir("/proc"):
        if entry.name.isdecimal() and int(entry.name) != os.getpid():
            try:
                if marker.encode() in Path(f"/proc/{entry.name}/environ").read_bytes():
                    found.add(int(entry.name))
            except OSError:
                continue
    return found


COMMANDS = {
    "assess": ("assess", "--pairs", "pairs.csv", "-o", "out.csv", "--jobs", "2"),
    "find": ("find", "copy.png", "--masters", "masters"),
    "reconstruct": ("reconstruct", "capture", "-o", "out"),
    "demo": ("demo", "--no-open", "--port", "0"),
    "serve": ("serve", "--port", "0", "--processes", "2"),
    "import": ("gallery", "import", "masters"),
}


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="looks for processes in /proc")
@pytest.mark.parametrize("name", COMMANDS)
def test_nothing_outlives_a_killed_command_for_long(
    rumu, name, desk, *, capture, tmp_path_factory, monkeypatch
):
    """Its workers end; the next command sweeps what it left in both folders, and another's stays."""
    home, temporary = tmp_path_factory.mktemp("home"), tmp_path_factory.mktemp("tmp")
    env = os.environ | {"RUMU_HOME": str(home), "TMPDIR": str(temporary)}
    (desk / "pairs.csv").write_text("copy,reference\n" + "copy.png,master.png\n" * 200)
    (desk / "masters").mkdir()
    for number in range(60):
        copied = (desk / "master.png").read_bytes() + bytes([number])
        (desk / "masters" / f"{number}.png").write_bytes(copied)
    rows = "".join(f"{number}.png\n" for number in range(60))
    (desk / "masters" / "labels.csv").write_text(f"file\n{rows}")
    for seconds in (1.2, 2.6):
        process = subprocess.Popen(
            [sys.executable, "-m", "rumu.cli", *COMMANDS[name]], cwd=desk, env=env, stdout=-3, stderr=-3
        )
        time.sleep(seconds)
        process.send_signal(signal.SIGKILL)
        process.wait()
    until = time.monotonic() + 30
    while (left := processes_with(f"RUMU_HOME={home}")) and time.monotonic() < until:
        time.sleep(0.2)
    assert not left
    other = holder(temporary)
    monkeypatch.setenv("RUMU_HOME", str(home))
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    for words in (("gallery", "list"), ("relief", desk / "copy.png", "-o", desk / "o2")):
        swept = rumu(*words, "--json")
        assert swept.code == 0, swept.err
    kept = [path for path in temporary.iterdir() if path.name.startswith("rumu-")]
    other.kill(), other.wait()
    assert len(kept) == 1
    for folder in (desk, home, *(path for path in home.iterdir() if path.is_dir())):
        assert not [path for path in folder.iterdir() if "rumu-" in path.name]


@pytest.mark.timeout(120)
@pytest.mark.parametrize("place", ["pipe", "/dev/zero", "/proc/self/maps", "socket", "folder"])
def test_no_command_waits_for_what_is_no_file(rumu, desk, capture, place, monkeypatch):
    """A pipe that nobody writes to, a device without end, a file of the kernel, a socket, a folder."""
    if not Path("/dev/zero").exists() or not Path("/proc/self").exists():
        pytest.skip("no such files on this system")
    monkeypatch.chdir(desk)
    os.mkfifo(desk / "pipe")
    (desk / "folder").mkdir()
    listener = socket.socket(socket.AF_UNIX)
    listener.bind("socket")
    (desk / "good.csv").write_text("copy,reference\ncopy.png,master.png\n")
    (desk / "link.png").symlink_to(Path(place).absolute())
    (desk / "link.json").symlink_to(Path(place).absolute())
    (desk / "labels.csv").write_text("file\nlink.png\nmaster.png\n")
    (capture / "lights.lp").unlink()
    (capture / "lights.lp").symlink_to(Path(place).absolute())
    for arguments in (
        ("assess", place, "--reference", "master.png"),
        ("assess", "copy.png", "--reference", place),
        ("assess", "--pairs", place, "-o", "out.csv"),
        ("assess", "copy.png", "--reference", "master.png", "--calibration", place),
        ("assess", "copy.png", "--reference", "master.png", "--levels", "link.json"),
        ("calibrate", place, "-o", "mine.json"),
        ("relief", place, "-o", "out"),
        ("stl", place, "-o", "out.stl"),
        ("find", place, "--masters", "labels.csv"),
        ("reconstruct", capture, "-o", "out"),
        ("gallery", "add", place),
        ("gallery", "add", "--font", place, "--characters", "水"),
        ("gallery", "import", place),
        ("relight", place, "--tilt", 0, "--slant", 30),
    ):
        ended = rumu(*arguments)
        assert ended.code in (1, 2) and ended.err, arguments
        assert "Traceback" not in ended.err and "unexpected" not in ended.err, (arguments, ended.err)
    assert rumu("find", "copy.png", "--masters", "labels.csv").code == 0
    listener.close()
