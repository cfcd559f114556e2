"""What a capture will take, counted from the headers of its photographs before anything is decoded.

Photographs that are small enough stay in memory in their own bits; others lie in scratch files. The surface
that is made of them has so many bytes for each pixel, and must fit in any case.
"""

from __future__ import annotations

import contextlib
import math
import os
import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rumu.capture.decoded_size import Header, memory_limit
from rumu.errors import CaptureError, RumuError
from rumu.values import Bilingual

_MB = 10**6
_UNLIMITED = 2**60
_CONTROL_GROUP = Path("/sys/fs/cgroup")


@dataclass(frozen=True, slots=True)
class MemoryCosts:
    """Bytes that a reconstruction takes.

    pixel: of the surface for each pixel, gray; colour: more, for its albedo. fixed: of the program itself.
    threads: photographs that are decoded at the same time.
    """

    pixel: int = 36
    colour: int = 8
    fixed: int = 300 * _MB
    threads: int = min(4, os.cpu_count() or 1)


@dataclass(frozen=True, slots=True)
class MemoryPlan:
    """How a capture is read. on_disk: whether its photographs lie in scratch files. threads: that decode."""

    on_disk: bool
    threads: int


def plan_memory(headers: Sequence[Header], folder: Path, *, costs: MemoryCosts | None = None) -> MemoryPlan:
    """How the photographs of a capture are kept. headers: of all that are decoded.

    They stay in memory as far as that is free and RUMU_MAX_DECODED_MB allows.
    Raises CaptureError, naming the folder and what is needed, where the memory or the scratch space is short.
    """
    costs = costs or MemoryCosts()
    each = [
        header.width * header.height * min(header.channels, 3) * header.sample_bytes for header in headers
    ]
    largest = max(header.memory(floats=False) for header in headers)
    threads = max(1, min(costs.threads, len(headers), int(memory_limit() / largest)))
    pixels = max(header.width * header.height for header in headers)
    colour = costs.colour if max(header.channels for header in headers) >= 3 else 0
    surface = pixels * (costs.pixel + colour)
    needed, free = costs.fixed + max(threads * largest, surface), available_memory()
    on_disk = sum(each) > memory_limit() or needed + sum(each) > free
    if needed > free:
        raise CaptureError(
            f"{folder.name}: expected at least {_tell(needed)} of free memory for {len(headers)} photographs "
            f"of {pixels / _MB:.0f} megapixels, there are {_tell(free)}; close other programs, or make the "
            "photographs smaller",
            zh=f"{folder.name}：{len(headers)} 張 {pixels / _MB:.0f} 百萬像素的照片至少要 {_tell(needed)} "
            f"可用記憶體，現在有 {_tell(free)}；請關掉別的程式，或把照片縮小。",
        )
    scratch = shutil.disk_usage(tempfile.gettempdir()).free
    if on_disk and sum(each) > scratch:
        place = tempfile.gettempdir()
        raise CaptureError(
            f"{folder.name}: expected at least {_tell(sum(each))} of free space in {place} to lay the "
            f"photographs down in, there are {_tell(scratch)}; set TMPDIR to a folder on a larger disk",
            zh=f"{folder.name}：暫存照片要在 {place} 有 {_tell(sum(each))} 的空間，現在有 {_tell(scratch)}；"
            "請把 TMPDIR 設為空間較大的資料夾。",
        )
    return MemoryPlan(on_disk, threads)


def check_memory(needed: float, *, what: Bilingual, error_type: type[RumuError]) -> None:
    """Raise an error of this type where so many bytes are not free. what: takes them, for the message."""
    free = available_memory()
    if needed > free:
        raise error_type(
            f"expected {_tell(needed)} of free memory for {what.en}, there are {_tell(free)}; close other "
            "programs",
            zh=f"{what.zh}要 {_tell(needed)} 可用記憶體，現在有 {_tell(free)}；請關掉別的程式。",
        )


def available_memory() -> int:
    """Bytes that this process may still take: of the machine, of its control group, of its own limit."""
    return min(_of_machine(), _of_control_group(), _of_process())


def _of_machine() -> int:
    with contextlib.suppress(OSError, ValueError, IndexError):
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) * 1024
    with contextlib.suppress(OSError, ValueError, AttributeError):  # a Mac, which tells only what it has
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return _UNLIMITED


def _of_control_group() -> int:
    with contextlib.suppress(OSError, ValueError):
        most = (_CONTROL_GROUP / "memory.max").read_text(encoding="ascii").strip()
        if most != "max":
            facts = dict(
                line.split() for line in (_CONTROL_GROUP / "memory.stat").read_text("ascii").splitlines()
            )
            taken = int((_CONTROL_GROUP / "memory.current").read_text(encoding="ascii"))
            return int(most) - taken + int(facts.get("inactive_file", 0))
    return _UNLIMITED


def _of_process() -> int:
    try:
        import resource
    except ImportError:  # Windows
        return _UNLIMITED
    most, _ = resource.getrlimit(resource.RLIMIT_AS)
    if most == resource.RLIM_INFINITY:
        return _UNLIMITED
    with contextlib.suppress(OSError, ValueError, IndexError):
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        return most - pages * os.sysconf("SC_PAGE_SIZE")
    return int(most)


def _tell(size: float) -> str:
    return f"{math.ceil(size / _MB)} MB"
