"""`rumu assess --pairs` on all E3C copies: pairs a second, and whether memory stays flat.

`python benchmarks/pairs.py [--jobs N] [--every K]` runs the command as a user would, in processes of its own,
and reads from the kernel, while they work, what memory they hold and what processor time they take. Printed:
the rate, start of the processes and masters included; processor time a pair, which other work on the machine
moves less; and the memory in each third of the run. Linux only: it reads /proc.
"""

from __future__ import annotations

import argparse
import csv
import os
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

DATA = Path(os.environ.get("RUMU_DATA", Path(__file__).parents[2] / "shared" / "data"))
SECONDS = 1.0
"""Between two looks at the memory: a look takes time from the processes that it looks at."""
Sample = tuple[float, float]
"""Seconds since the start, MiB that the processes hold together."""


def table(folder: Path, *, every: int) -> tuple[Path, int]:
    """A table of the E3C copies and their templates, and how many rows it has."""
    with (DATA / "e3c" / "scores.csv").open(encoding="utf-8", newline="") as stream:
        rows = [(row["image"], row["template"]) for row in csv.DictReader(stream)][::every]
    path = folder / "pairs.csv"
    path.write_text("copy,reference\n" + "".join(f"{copy},{master}\n" for copy, master in rows), "utf-8")
    return path, len(rows)


def family(root: int) -> list[int]:
    """The process and all that it started, however far down."""
    children: dict[int, list[int]] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            except (OSError, IndexError):
                continue
            children.setdefault(parent, []).append(int(entry.name))
    found = [root]
    for process in found:
        found += children.get(process, [])
    return found


def held(process: int) -> float:
    """MiB of memory of one process; what it shares with others is counted in shares."""
    try:
        lines = Path(f"/proc/{process}/smaps_rollup").read_text().splitlines()
        return next(float(line.split()[1]) for line in lines if line.startswith("Pss:")) / 1024
    except (OSError, StopIteration):
        return 0.0


def busy(process: int) -> float:
    """Seconds of processor time that one process has taken."""
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def watched(command: list[str]) -> tuple[list[Sample], float, float]:
    """Run the command; the memory on the way, seconds it took, seconds of processor time it took."""
    samples: list[Sample] = []
    taken: dict[int, float] = {}
    began = time.perf_counter()
    running = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    ended = threading.Event()

    def watch() -> None:
        while not ended.wait(SECONDS):
            processes = family(running.pid)
            samples.append((time.perf_counter() - began, sum(map(held, processes))))
            taken.update({process: max(busy(process), taken.get(process, 0.0)) for process in processes})

    watcher = threading.Thread(target=watch)
    watcher.start()
    code = running.wait()
    seconds = time.perf_counter() - began
    ended.set()
    watcher.join()
    if code:
        raise SystemExit(f"{' '.join(command)} ended with {code}")
    return samples, seconds, sum(taken.values())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--jobs", type=int, default=None, help="processes (default: all cores)")
    parser.add_argument("--every", type=int, default=1, help="only every K-th copy")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        pairs, total = table(folder, every=options.every)
        command = [sys.executable, "-m", "rumu.cli", "assess", "--pairs", str(pairs)]
        command += ["-o", str(folder / "out.csv"), "--root", str(DATA / "e3c")]
        command += ["--jobs", str(options.jobs)] if options.jobs else []
        samples, seconds, taken = watched(command)
    print(f"{total} pairs in {seconds:.1f} s: {total / seconds:.1f} pairs a second, {os.cpu_count()} cores")
    print(f"processor time {1e3 * taken / total:.0f} ms a pair; load of the machine {os.getloadavg()[0]:.1f}")
    for third in (1, 2, 3):
        part = [memory for at, memory in samples if (third - 1) * seconds < 3 * at <= third * seconds]
        print(
            f"memory up to {third}/3: usually {statistics.median(part):.0f} MiB, at most {max(part):.0f} MiB"
        )


if __name__ == "__main__":
    main()
