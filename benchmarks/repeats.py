"""How large a difference between two attempts is no chance: `python benchmarks/repeats.py [--every N]`.

Each copy is photographed twice, with another crop, size, light, blur and grain, and both photographs are
marked: what differs between them is the error of measuring. For the mark, its parts and the size of each
kind of fault it prints the differences below which 80 and 90 % of the pairs stay. Then copies of one
character are compared in pairs: how often people agree with the mark on which of the two is better, by the
difference of their marks.
"""

from __future__ import annotations

import argparse
import os
from collections import Counter, defaultdict
from concurrent.futures import ProcessPoolExecutor
from functools import lru_cache
from itertools import combinations
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from PIL import Image

from rumu import pipeline
from rumu.assessment.progress import (
    STATUSES,
    aspect_of,
    compare_attempts,
    signed_size,
    speak_of_one_stroke,
)
from rumu.values import Assessment
from rumu_lab.experiments.marked_copies import Copy, read_table
from rumu_lab.simulation.photographs import Shade, photograph

DATA = Path(os.environ.get("RUMU_DATA", Path(__file__).parents[2] / "shared" / "data"))
STEPS = (0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 15.0, 20.0, 30.0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, default=DATA / "e3c-more", help="copies with scores.csv")
    parser.add_argument("--every", type=int, default=1, help="only every so many copies")
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    copies = read_table(options.data / "scores.csv")[:: options.every]
    with ProcessPoolExecutor(options.jobs, get_context("spawn")) as pool:
        twice = list(pool.map(mark_twice, copies, chunksize=4))
    pairs = [pair for pair in twice if pair is not None]
    print_repeats(pairs, len(copies))
    print_false_changes(pairs)
    marks = [(copy, pair[0].score) for copy, pair in zip(copies, twice, strict=True) if pair]
    print_agreement([(copy, score) for copy, score in marks if score is not None])


@lru_cache(maxsize=2)
def master_of(path: Path, character: str) -> pipeline.PreparedMaster:
    return pipeline.prepare_master(path, character=character)


def mark_twice(copy: Copy) -> tuple[Assessment, Assessment] | None:
    """The marks of two photographs of one copy; None where one of them was refused."""
    ink = 1.0 - np.asarray(Image.open(copy.image).convert("L"), dtype=np.float32) / 255.0
    number = int("".join(c for c in copy.image.stem if c.isdigit()) or 0)
    marks: list[Assessment] = []
    for k in range(2):
        rng = np.random.default_rng([number, k])
        picture = photograph(
            ink,
            side=int(rng.integers(560, 760)),
            fill=float(rng.uniform(0.86, 0.94)),
            shade=Shade(float(rng.uniform(0.0, 0.3)), float(rng.uniform(0, 360))),
            blur=float(rng.uniform(0.4, 1.1)),
            grain=float(rng.uniform(1.0, 3.0)),
            quality=int(rng.integers(80, 95)),
            seed=2 * number + k,
        )
        marks.append(pipeline.assess(picture, master_of(copy.template, copy.character)))
    if any(mark.refused for mark in marks):
        return None
    return marks[0], marks[1]


def print_repeats(pairs: list[tuple[Assessment, Assessment]], copies: int) -> None:
    differences: dict[str, list[float]] = defaultdict(list)
    lost: dict[str, int] = defaultdict(int)
    for a, b in pairs:
        differences["mark"].append(abs((a.score or 0.0) - (b.score or 0.0)))
        for name in a.parts:
            differences[f"part {name}"].append(abs(a.parts[name] - b.parts[name]))
        second = (*b.remarks, *b.untold)
        for remark in (*a.remarks, *a.untold):
            aspect = aspect_of(remark)
            same = [o for o in second if aspect_of(o) == aspect and speak_of_one_stroke(remark, o)]
            if same:
                differences[aspect].append(min(abs(signed_size(remark) - signed_size(o)) for o in same))
            else:
                lost[aspect] += 1
    print(f"{copies} copies, {len(pairs)} photographed twice and marked twice\n")
    print(f"{'':<18}{'n':>6}{'80 %':>9}{'90 %':>9}{'not found again':>18}")
    for name, values in sorted(differences.items()):
        eighty, ninety = np.percentile(values, [80, 90])
        print(f"{name:<18}{len(values):>6}{eighty:>9.3f}{ninety:>9.3f}{lost.get(name, 0):>18}")


def print_false_changes(pairs: list[tuple[Assessment, Assessment]]) -> None:
    """What is said to have changed between two photographs of one copy: all of it is wrong."""
    numbers: Counter[str] = Counter()
    faults: Counter[str] = Counter()
    for a, b in pairs:
        progress = compare_attempts(a, b, framed=False)
        if progress is not None:
            numbers["mark"] += progress.mark.change != "same"
            numbers["a part"] += any(part.change != "same" for part in progress.parts.values())
            faults.update(fault.status for fault in progress.faults)
    told = sum(len(a.remarks) for a, _ in pairs)
    print(f"\ntwo photographs of one copy, {told} faults told of the first; said to have changed:")
    print("  " + ", ".join(f"{name} of {n} copies" for name, n in numbers.items()))
    print("  " + ", ".join(f"{status} {faults[status]}" for status in STATUSES))


def print_agreement(marked: list[tuple[Copy, float]]) -> None:
    gaps, agree = [], []
    by_character: dict[str, list[tuple[Copy, float]]] = defaultdict(list)
    for copy, mark in marked:
        by_character[copy.character].append((copy, mark))
    for own in by_character.values():
        for (a, one), (b, other) in combinations(own, 2):
            if a.mark != b.mark:
                gaps.append(abs(one - other))
                agree.append((one > other) == (a.mark > b.mark))
    print("\ntwo copies of one character: people see the same order as the mark")
    print(f"{'difference':<14}{'pairs':>7}{'agree':>8}")
    for low, high in zip(STEPS, (*STEPS[1:], np.inf), strict=True):
        own_pairs = [same for gap, same in zip(gaps, agree, strict=True) if low <= gap < high]
        if own_pairs:
            print(f"{low:>5.0f} to {high:<5.0f}{len(own_pairs):>7}{np.mean(own_pairs):>8.2f}")


if __name__ == "__main__":
    main()
