"""What photographs of copies get: `python benchmarks/photographs.py [--held-out] [--every N] [--list]`.

A copy is photographed plain, and again under printed grids, under shades, in coloured inks, and turned. Its
mark should be within five points of the plain photograph's, or the refusal should give the true reason. For
each kind it prints how many keep their mark, how many are refused and why, and the largest difference.

Two sets were kept apart: `--held-out` takes characters, grays, widths, angles and depths on which nothing was
tuned.
"""

from __future__ import annotations

import argparse
import os
from collections import Counter, defaultdict
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from functools import lru_cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from rumu_lab.simulation.photographs import GRIDS, INKS, Grid, Shade, photograph, thin_pen

DATA = Path(os.environ.get("RUMU_DATA", Path(__file__).parents[2] / "shared" / "data"))
CLOSE = 5.0
"""Points by which a mark may differ from the plain photograph's."""
PURPLE, RED, PALE_RED = (112, 62, 142), (200, 40, 40), (236, 130, 120)
COPIES = {
    "development": ("regular-shui-good", "regular-tian-medium", "e3c 001630", "e3c 004335", "e3c 002238"),
    "held out": ("e3c 000099", "e3c 001765", "e3c 007834", "e3c 003508", "e3c 007010"),
}
"""Starter samples of 水 and 天 and learners' copies (E3C) of 十 方 寧; of 下 合 非 得 銘."""


@dataclass(frozen=True)
class Case:
    """A photograph. kind: a row of the table. copy: see COPIES. options: of `photograph`.

    quarters: turns, anticlockwise. pen: width of a thin pen. expected: codes of a true refusal.
    """

    kind: str
    copy: str
    options: dict[str, Any]
    quarters: int = 0
    pen: float = 0.0
    expected: tuple[str, ...] = ()


@dataclass
class Row:
    close: int = 0
    truly_refused: int = 0
    worst: float = 0.0
    wrong: list[str] = field(default_factory=list)


def cases(name: str) -> Iterator[Case]:
    held = name == "held out"
    grays = (50, 70, 90, 110, 135, 150, 160) if held else (40, 60, 80, 100, 120, 140, 165)
    lean = 2.2 if held else 1.5
    for k, copy in enumerate(COPIES[name]):
        for i, gray in enumerate(grays):
            for j, kind in enumerate(GRIDS):
                thick = (i + j + k) % 2 == 1
                width = (0.0035, 0.007) if held else (0.003, 0.006)
                own = {"gray": gray, "width": width[thick], "border_width": width[thick] * 1.6}
                yield Case("grid, thick" if thick else "grid, thin", copy, {"grid": Grid(kind, **own)})
                if (i + j) % 3 == 0:
                    yield Case("grid, leaning", copy, {"grid": Grid(kind, **own, lean=lean * (-1) ** i)})
                    yield Case("grid, oblique", copy, {"grid": Grid(kind, **own, keystone=0.05)})
                    yield Case("grid, cells", copy, {"grid": Grid(kind, **own, cells=3, cell=0.8)})
                    yield Case("grid, dashed", copy, {"grid": Grid(kind, **own, dashed=True)})
                    yield Case(
                        "grid, shaded", copy, {"grid": Grid(kind, **own), "shade": Shade(0.3, 60.0 * i)}
                    )
        for kind in GRIDS:
            yield Case("grid, purple", copy, {"grid": Grid(kind, colour=PURPLE, width=0.004)})
            yield Case("grid, red", copy, {"grid": Grid(kind, colour=RED, width=0.004)})
            yield Case("grid, made black", copy, {"grid": Grid(kind, gray=30), "grain": 0.5, "blur": 0.3})
            yield Case(
                "red ink, red grid", copy, {"grid": Grid(kind, colour=PALE_RED), "colour": INKS["red"]}
            )
        for depth in (0.25, 0.35, 0.45, 0.55) if held else (0.2, 0.3, 0.4, 0.5, 0.6):
            for toward in (20, 70, 110, 200, 300) if held else (0, 45, 90, 180, 270):
                yield Case("shade", copy, {"shade": Shade(depth, toward)})
                yield Case("edge of a shadow, soft", copy, {"shade": Shade(depth, toward, 0.15)})
                yield Case("edge of a shadow, sharp", copy, {"shade": Shade(depth, toward, 0.02)})
        for depth in (0.72, 0.85) if held else (0.7, 0.8, 0.9):
            yield Case("shade, deep", copy, {"shade": Shade(depth, 40.0)}, expected=("uneven light",))
        for ink in INKS:
            yield Case(f"ink, {ink}", copy, {"colour": INKS[ink]})
        for quarters, code in ((1, "turned left"), (2, "upside down"), (3, "turned right")):
            yield Case("turned", copy, {}, quarters=quarters, expected=(code,))
        for width in (0.008, 0.014) if held else (0.007, 0.012):
            yield Case("thin pen", copy, {}, pen=width, expected=("too thin", "outline only"))


@lru_cache(maxsize=32)
def inks_of(copy: str) -> tuple[np.ndarray, Any]:
    """The copy's ink, (H, W) bool, and its prepared master."""
    import csv

    import rumu
    from rumu.gallery.starter import find_work, starter_samples
    from rumu.pipeline import prepare_master

    if not copy.startswith("e3c "):
        sample = next(s for s in starter_samples() if s.id == copy)
        return np.asarray(Image.open(sample.path).convert("L")) < 128, prepare_master(
            rumu.relief(find_work(sample.work).path)
        )
    with (DATA / "e3c" / "scores.csv").open(encoding="utf-8-sig", newline="") as stream:
        row = next(r for r in csv.DictReader(stream) if r["image"].endswith(f"{copy[4:]}.png"))
    ink = np.asarray(Image.open(DATA / "e3c" / row["image"]).convert("L")) < 128
    return ink, prepare_master(rumu.relief(DATA / "e3c" / row["template"]))


@lru_cache(maxsize=32)
def plain_score(copy: str) -> float | None:
    import rumu

    ink, master = inks_of(copy)
    return rumu.assess(photograph(ink), master, remarks=False).score


def answer(case: Case) -> tuple[float | None, float | None, str | None]:
    """Marks of the plain photograph and of this one, and the code of a refusal."""
    import cv2

    import rumu

    cv2.setNumThreads(1)
    ink, master = inks_of(case.copy)
    drawn = thin_pen(ink, width=case.pen) if case.pen else ink
    page = np.ascontiguousarray(np.rot90(photograph(drawn, **case.options), case.quarters))
    mark = rumu.assess(page, master, remarks=False)
    return plain_score(case.copy), mark.score, mark.refused


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--held-out", action="store_true", help="what nothing was tuned on")
    parser.add_argument("--every", type=int, default=1, help="only every N-th case")
    parser.add_argument("--only", default="", help="only kinds that begin so")
    parser.add_argument("--list", action="store_true", help="name each case that is neither")
    options = parser.parse_args()
    chosen = [
        c for c in cases("held out" if options.held_out else "development") if c.kind.startswith(options.only)
    ]
    chosen = chosen[:: options.every]
    rows: dict[str, Row] = defaultdict(Row)
    reasons: dict[str, Counter[str]] = defaultdict(Counter)
    with ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn")) as pool:
        for case, (plain, mark, refused) in zip(chosen, pool.map(answer, chosen, chunksize=8), strict=True):
            row = rows[case.kind]
            if refused is not None:
                reasons[case.kind][refused.partition(":")[0]] += 1
            off = None if mark is None or plain is None else mark - plain
            if off is not None:
                row.worst = max(row.worst, off, key=abs)
            if refused is not None and refused.partition(":")[0] in case.expected:
                row.truly_refused += 1
            elif off is not None and abs(off) <= CLOSE and not (case.quarters or case.pen):
                row.close += 1
            else:
                row.wrong.append(
                    f"{case.copy} {case.options} {case.pen or ''}: {off if refused is None else refused}"
                )
    print(f"{'kind':24s} {'cases':>6s} {'close':>6s} {'refused':>11s} {'wrong':>6s} {'farthest':>9s}  why")
    for kind, row in rows.items():
        total = row.close + row.truly_refused + len(row.wrong)
        figures = f"{total:6d} {row.close:6d} {row.truly_refused:11d} {len(row.wrong):6d} {row.worst:9.1f}"
        print(f"{kind:24s} {figures}  " + ", ".join(f"{code} {n}" for code, n in reasons[kind].items()))
        if options.list:
            print(*(f"    {one}" for one in row.wrong), sep="\n")


if __name__ == "__main__":
    main()
