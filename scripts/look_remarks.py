"""Draw learners' copies beside their masters, with the marks and remarks on them, for a teacher's eye.

    .venv/bin/python scripts/look_remarks.py OUT [--set tuning|kept] [--data ../shared/data]

Half of the E3C copies, by a checksum of their names, are for tuning the remarks; the other half is kept for a
last look. From each half come the 10 that people marked best, the 10 worst and 20 of the middle, at most
three of a character. A row shows the master, the copy with what each remark speaks of, the copy laid on the
master (red where it is off, blue where it is wanting), people's mark, ours, and the remarks. OUT/remarks.txt
holds the same words, in Chinese too.
"""

from __future__ import annotations

import argparse
import textwrap
import zlib
from collections import Counter
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from rumu import pipeline
from rumu.report.overlay import OverlaySettings, overlay_picture
from rumu.values import Assessment
from rumu_lab.experiments.marked_copies import Copy, read_copies

SIDE, ROWS, WORDS = 300, 5, 640
ENDS, MIDDLE, OF_A_CHARACTER = 10, 20, 3
COLOURS = ((200, 30, 30), (20, 90, 190), (20, 130, 60), (160, 90, 0), (120, 40, 140))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--set", choices=("tuning", "kept"), default="tuning")
    parser.add_argument("--rows", default="0:40", help="only these of the 40, for example 10:20")
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    chosen = choose(read_copies(options.data), kept=options.set == "kept")
    first, last = (int(number) for number in options.rows.split(":"))
    words = []
    for start in range(first, min(last, len(chosen)), ROWS):
        drawn = [draw(n, row) for n, row in enumerate(chosen[start : start + ROWS], start=start + 1)]
        words += [text for _, text in drawn]
        sheet = np.concatenate([picture for picture, _ in drawn])
        Image.fromarray(sheet).save(options.out / f"remarks_{start // ROWS:02d}.png")
    (options.out / "remarks.txt").write_text("\n\n".join(words) + "\n", encoding="utf-8")


def choose(rows: list[Copy], *, kept: bool) -> list[Copy]:
    """The best, the worst and the middle of one half, by people's marks."""
    half = [row for row in rows if (zlib.crc32(row.image.name.encode()) % 2 == 1) == kept]
    by_mark = sorted(half, key=lambda row: (-row.mark, row.image.name))
    counts: Counter[str] = Counter()
    best = _first(by_mark, ENDS, counts)
    worst = _first(by_mark[::-1], ENDS, counts)
    rest = [row for row in by_mark if row not in best and row not in worst]
    nearest = sorted(rest, key=lambda row: abs(row.mark - rest[len(rest) // 2].mark))
    return [*best, *worst, *_first(nearest, MIDDLE, Counter())]


def _first(rows: list[Copy], count: int, counts: Counter[str]) -> list[Copy]:
    """The first of them, not too many of a character."""
    chosen: list[Copy] = []
    for row in rows:
        if len(chosen) < count and counts[row.character] < OF_A_CHARACTER:
            counts[row.character] += 1
            chosen.append(row)
    return chosen


@lru_cache(maxsize=32)
def prepared(path: Path, character: str) -> pipeline.PreparedMaster:
    """The master, made ready once."""
    return pipeline.prepare_master(path, character=character)


def assessed(row: Copy) -> Assessment:
    """The mark of one copy."""
    return pipeline.assess(row.image, prepared(row.template, row.character), framed=True)


def draw(number: int, row: Copy) -> tuple[np.ndarray, str]:
    """The row of one copy, (SIDE, width, 3) uint8, and its words."""
    mark = assessed(row)
    master, copy = picture(row.template), picture(row.image)
    overlay = np.full((SIDE, SIDE, 3), 255, np.uint8)
    if mark.registration is not None:
        settings = OverlaySettings(side=SIDE)
        overlay = overlay_picture(
            mark.registration, master=prepared(row.template, row.character).surface, settings=settings
        )
    pointed = point_out(copy, mark)
    page = Image.new("RGB", (WORDS, SIDE), "white")
    pen, font = ImageDraw.Draw(page), ImageFont.truetype("DejaVuSans.ttf", 14)
    score = "refused" if mark.score is None else f"{mark.score:.0f}"
    parts = ", ".join(f"{name} {value:.0f}" for name, value in mark.parts.items())
    lines = [f"{number}. {row.image.name}  people {row.mark:.0f}, rumu {score} ({parts})"]
    text = [f"{number}. {row.character} {lines[0][len(str(number)) + 2 :]}"]
    if mark.refused:
        lines.append(mark.refused)
    if mark.praise is not None:
        lines += textwrap.wrap(f"+ {mark.praise.en}", 84)
        text.append(f"  + {mark.praise.zh} {mark.praise.en}")
    for k, remark in enumerate(mark.remarks, start=1):
        lines += textwrap.wrap(f"{k} [{remark.kind} {remark.severity:.1f}] {remark.en}", 84)
        text.append(f"  {k} [{remark.kind} {remark.size:.3f} {remark.severity:.1f}] {remark.zh} {remark.en}")
    for k, line in enumerate(lines):
        pen.text((8, 6 + 19 * k), line, fill="black", font=font)
    rule = np.full((SIDE, 2, 3), 120, np.uint8)
    strip = np.concatenate([master, rule, pointed, rule, overlay, rule, np.asarray(page)], axis=1)
    strip[-1] = 120
    return strip, "\n".join(text)


def picture(path: Path) -> np.ndarray:
    """(SIDE, SIDE, 3) uint8."""
    with Image.open(path) as image:
        gray = image.convert("RGB")
        return np.asarray(gray.resize((SIDE, SIDE), Image.Resampling.BILINEAR))


def point_out(copy: np.ndarray, mark: Assessment) -> np.ndarray:
    """The copy, paler, with the lines and numbers of its remarks."""
    drawn = np.ascontiguousarray(255 - (255 - copy) // 2)
    for k, remark in enumerate(mark.remarks):
        colour, at = COLOURS[k % len(COLOURS)], None
        for line in remark.outline:
            points = np.round(np.array(line) * SIDE).astype(np.int32)
            cv2.polylines(drawn, [points.reshape(-1, 1, 2)], False, colour, 2, cv2.LINE_AA)
            at = tuple(points[len(points) // 2].tolist()) if at is None else at
        if at is not None:
            cv2.putText(drawn, str(k + 1), at, cv2.FONT_HERSHEY_SIMPLEX, 0.6, colour, 2, cv2.LINE_AA)
    return drawn


if __name__ == "__main__":
    main()
