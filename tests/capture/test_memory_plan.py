"""What a capture takes is counted before it is decoded: in memory, on disk, or refused."""

from __future__ import annotations

import resource
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from rumu.capture import memory_plan
from rumu.capture.decoded_size import MEMORY_VARIABLE, Header
from rumu.capture.folder import read_capture
from rumu.capture.memory_plan import MemoryCosts, available_memory, plan_memory
from rumu.errors import CaptureError
from rumu.image_stack import ScratchFile

HEADERS = [Header("PNG", 10_000, 10_000, channels=1)] * 60


def folder_of_three(path: Path) -> Path:
    rng = np.random.default_rng(0)
    for name in "abc":
        Image.fromarray(rng.integers(50, 200, (400, 400, 3), np.uint8)).save(path / f"{name}.png")
    (path / "capture.json").write_text('{"slant": 45}')
    return path


def test_photographs_lie_on_disk_when_their_memory_is_short(tmp_path, monkeypatch):
    in_memory = read_capture(folder_of_three(tmp_path))
    monkeypatch.setenv(MEMORY_VARIABLE, "1")
    on_disk = read_capture(tmp_path)
    kept = [one.samples for one in on_disk.photographs._photographs]
    assert all(isinstance(one, ScratchFile) for one in kept)
    assert all(one.samples.dtype == np.uint8 for one in in_memory.photographs._photographs)
    np.testing.assert_array_equal(in_memory.images, on_disk.images)


def test_what_cannot_fit_is_refused_before_anything_is_decoded(tmp_path, monkeypatch):
    folder_of_three(tmp_path)
    (tmp_path / "b.png").write_bytes((tmp_path / "b.png").read_bytes()[:-2000])  # would be told if decoded
    monkeypatch.setattr(memory_plan, "available_memory", lambda: 200_000_000)
    with pytest.raises(
        CaptureError, match=r"at least 30\d MB of free memory for 3 photographs .* 200 MB"
    ) as one:
        read_capture(tmp_path)
    assert one.value.zh is not None and "200 MB" in one.value.zh


def test_a_hundred_megapixels_under_sixty_lamps_fit_into_four_gigabytes(monkeypatch):
    monkeypatch.setattr(memory_plan, "available_memory", lambda: 4_000_000_000)
    plan = plan_memory(HEADERS, Path("statue"))
    assert plan.on_disk and plan.threads >= 1
    monkeypatch.setattr(memory_plan, "available_memory", lambda: 2_000_000_000)
    with pytest.raises(CaptureError, match="statue: expected at least 3"):
        plan_memory(HEADERS, Path("statue"))


def test_photographs_lie_on_disk_where_the_surface_needs_their_memory(monkeypatch):
    """While it is solved for, the surface lies in memory beside them."""
    headers = [Header("PNG", 6000, 4000, channels=1)] * 20
    costs = MemoryCosts(pixel=30, fixed=300_000_000, threads=2)  # 1.02 GB, and 0.48 of photographs
    for free, on_disk in ((1_600_000_000, False), (1_400_000_000, True)):
        monkeypatch.setattr(memory_plan, "available_memory", lambda free=free: free)
        assert plan_memory(headers, Path("x"), costs=costs).on_disk is on_disk
    monkeypatch.setattr(memory_plan, "available_memory", lambda: 1_000_000_000)
    with pytest.raises(CaptureError, match="at least 1020 MB of free memory"):
        plan_memory(headers, Path("x"), costs=costs)


def test_the_scratch_space_is_counted(monkeypatch):
    monkeypatch.setattr(memory_plan, "available_memory", lambda: 2**40)
    monkeypatch.setattr("shutil.disk_usage", lambda _: type("Usage", (), {"free": 5_999_000_000})())
    with pytest.raises(CaptureError, match=r"at least 6000 MB of free space in .*TMPDIR"):
        plan_memory(HEADERS, Path("statue"))


def test_fewer_threads_decode_larger_photographs(monkeypatch):
    monkeypatch.setattr(memory_plan, "available_memory", lambda: 2**40)
    monkeypatch.setenv(MEMORY_VARIABLE, "250")
    assert plan_memory(HEADERS, Path("x"), costs=MemoryCosts(threads=8)).threads == 2


def test_the_limit_of_the_process_counts(monkeypatch):
    before = available_memory()
    monkeypatch.setattr(resource, "getrlimit", lambda _: (2**33, resource.RLIM_INFINITY))
    assert 0 < available_memory() < min(before + 2**28, 2**33)


def test_the_limit_of_the_control_group_counts(tmp_path, monkeypatch):
    (tmp_path / "memory.max").write_text("100000000\n")
    (tmp_path / "memory.current").write_text("60000000\n")
    (tmp_path / "memory.stat").write_text("anon 1\ninactive_file 10000000\n")
    monkeypatch.setattr(memory_plan, "_CONTROL_GROUP", tmp_path)
    assert available_memory() == 50_000_000
