"""Compare today's marks, remarks and surfaces with those that were recorded: `python scripts/check_marks.py`.

A change of the code that is to change no mark runs this before and after. It marks every E3C copy against its
template and every starter sample against its work, reconstructs the captures of `benchmarks/surface.py`, and
prints the largest difference of each figure from `recorded_marks.json.gz` beside it. It ends with 1 when one
differs by more than 1e-6 or a remark by a letter. `--write` records anew, for a change that is meant to.
"""

from __future__ import annotations

import argparse
import gzip
import hashlib
import json
import os
import sys
from collections import defaultdict
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from rumu_lab.experiments.marked_copies import read_copies

ROOT = Path(__file__).parents[1]
RECORD = Path(__file__).with_name("recorded_marks.json.gz")
DATA = Path(os.environ.get("RUMU_DATA", ROOT / ".." / "shared" / "data")).resolve()
STARTER = ROOT / "src" / "rumu" / "gallery" / "starter"
TOLERANCE = 1e-6
"""Largest difference of a figure that is no change."""

Figures = dict[str, Any]


def jobs() -> Iterator[tuple[str, Path, list[tuple[str, Path]], str | None]]:
    """(key of the master, its picture, [(key, picture) of its copies], script) of every master."""
    copies = defaultdict(list)
    for copy in read_copies(DATA):
        copies[copy.template].append((f"copies/{copy.image.name}", copy.image))
    for template, found in copies.items():
        yield f"templates/{template.name}", template, found, None
    works = {work["id"]: work for work in json.loads((STARTER / "works.json").read_text("utf-8"))}
    for sample in json.loads((STARTER / "samples.json").read_text("utf-8")):
        work = works[sample["work"]]
        copy = (f"sample {sample['id']}", STARTER / "samples" / f"{sample['id']}.png")
        yield work["id"], STARTER / "works" / f"{work['id']}.png", [copy], work["script"]


def mark(job: tuple[str, Path, list[tuple[str, Path]], str | None]) -> dict[str, Figures]:
    """The figures of every copy of one master."""
    import cv2

    import rumu

    cv2.setNumThreads(1)
    _, picture, copies, script = job
    master = rumu.relief(picture)
    return {key: figures(rumu.assess(copy, master, script=script)) for key, copy in copies}


def figures(assessment: Any) -> Figures:
    """What is compared of one mark: numbers in 'numbers', words in 'words'."""
    a = assessment
    low, high = a.interval or (None, None)
    return {
        "numbers": {
            "score": a.score,
            "low": low,
            "high": high,
            "sim_paper": a.sim_paper,
            "similarity": a.similarity,
            **{f"part {name}": value for name, value in a.parts.items()},
        },
        "words": [
            a.level,
            a.refused,
            a.refused_zh,
            *(word for r in a.remarks for word in (r.kind, r.zh, r.en)),
        ],
        "drawings": hashlib.sha256(
            repr([(_rounded(r.region), r.outline) for r in a.remarks]).encode()
        ).hexdigest()[:16],
    }


def _rounded(region: tuple[float, ...] | None) -> tuple[float, ...] | None:
    """A box as fine as outlines are: its last digits are noise."""
    return None if region is None else tuple(round(float(side), 4) for side in region)


def surfaces() -> dict[str, Figures]:
    """The angular errors of `benchmarks/surface.py`, and the spread of the heights that come of them."""
    import rumu

    sys.path.insert(0, str(ROOT / "benchmarks"))
    import surface as benchmark

    table = {
        name: {"numbers": {solver: value for solver, value in row.items()}}
        for name, row in benchmark.angular_errors().items()
    }
    for name in ("bunny/bunny_lambert", "psbox-cat"):
        height = rumu.reconstruct(DATA / "photometric" / name).height
        table[f"height {name}"] = {"numbers": {"std": float(height.std()), "max": float(height.max())}}
    return table


def measure() -> dict[str, Figures]:
    """Everything that is compared, by key."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    found: dict[str, Figures] = {}
    with ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn")) as pool:
        coming = pool.submit(surfaces)
        work = sorted(jobs(), key=lambda job: -len(job[2]))
        chunks = [(k, m, c[i : i + 12], s) for k, m, c, s in work for i in range(0, len(c), 12)]
        for part in pool.map(mark, chunks):
            found |= part
        return found | coming.result()


def compare(before: dict[str, Figures], now: dict[str, Figures]) -> bool:
    """Print the largest difference of each figure and every other change; True when nothing changed."""
    largest: dict[str, tuple[float, str]] = {}
    changed = [f"{key}: {'is gone' if key in before else 'is new'}" for key in before.keys() ^ now.keys()]
    for key in before.keys() & now.keys():
        old, new = before[key], now[key]
        for name in old["numbers"].keys() | new["numbers"].keys():
            a, b = old["numbers"].get(name), new["numbers"].get(name)
            off = 0.0 if a == b else float("inf") if a is None or b is None else abs(a - b)
            largest[name] = max(largest.get(name, (0.0, "")), (off, key))
        for kind in ("words", "drawings"):
            if old.get(kind) != new.get(kind):
                changed.append(f"{key}: {kind}: {old.get(kind)} -> {new.get(kind)}")
    for name, (off, key) in sorted(largest.items()):
        print(f"{name:20s} largest difference {off:.2e}" + (f"  ({key})" if off > TOLERANCE else ""))
    print(*sorted(changed)[:20], sep="\n")
    print(f"{len(now)} compared, {len(changed)} with other words or drawings")
    return not changed and all(off <= TOLERANCE for off, _ in largest.values())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="record today's figures instead of comparing")
    chosen = parser.parse_args()
    now = measure()
    if chosen.write:
        text = json.dumps(now, ensure_ascii=False, sort_keys=True, indent=0)
        RECORD.write_bytes(gzip.compress(text.encode(), mtime=0))
        print(f"{RECORD.name}: {len(now)} recorded")
    elif not compare(json.loads(gzip.decompress(RECORD.read_bytes())), now):
        sys.exit(1)


if __name__ == "__main__":
    main()
