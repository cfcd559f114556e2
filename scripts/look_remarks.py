"""Draw learners' copies beside their masters, with the marks and remarks on them, for a teacher's eye.

    .venv/bin/python scripts/look_remarks.py OUT [--set tuning|kept|first|second|...|ninth]

Half of the E3C copies, by a checksum of their names, are for tuning the remarks; the other half is kept for
looking. From each half come the 10 that people marked best, the 10 worst and 20 of the middle, at most three
of a character; `first` to `ninth` are chosen in the same way from what is left of that half, one after the
other, at most two of a character, and the 34 of `ninth` from all that is left then. A row shows master and
copy with what each remark speaks of, the copy laid on the master (red where it is off, blue where it is
wanting), people's mark, ours, and the remarks.
OUT/remarks.txt holds the same words.
"""

from __future__ import annotations

import argparse
import re
import zlib
from collections import Counter
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from rumu import pipeline
from rumu.assessment.thresholds import Lines
from rumu.pdf_text import find_chinese_font
from rumu.report.overlay import OverlaySettings, overlay_picture
from rumu.values import Assessment
from rumu_lab.experiments.marked_copies import Copy, read_copies

SIDE, ROWS, WORDS, LETTERS = 360, 4, 700, 66
ENDS, MIDDLE = 10, 20
_LATER = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth")
OF_A_CHARACTER = {"tuning": 3, "kept": 3} | dict.fromkeys(_LATER, 2) | {"ninth": 5}
COLOURS = ((200, 30, 30), (20, 90, 190), (20, 130, 60), (160, 90, 0), (120, 40, 140))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--set", choices=tuple(OF_A_CHARACTER), default="tuning")
    parser.add_argument("--rows", default="0:40", help="only these of the 40, for example 10:20")
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    chosen = choose(read_copies(options.data), options.set)
    first, last = (int(number) for number in options.rows.split(":"))
    words = []
    for start in range(first, min(last, len(chosen)), ROWS):
        drawn = [draw(n, row) for n, row in enumerate(chosen[start : start + ROWS], start=start + 1)]
        words += [text for _, text in drawn]
        sheet = np.concatenate([picture for picture, _ in drawn])
        Image.fromarray(sheet).save(options.out / f"remarks_{start // ROWS:02d}.png")
    (options.out / "remarks.txt").write_text("\n\n".join(words) + "\n", encoding="utf-8")


def choose(rows: list[Copy], name: str) -> list[Copy]:
    """The best, the worst and the middle, by people's marks, of one half without what was looked at."""
    names = list(OF_A_CHARACTER)
    half = [row for row in rows if zlib.crc32(row.image.name.encode()) % 2 == int(name != "tuning")]
    before = [row for other in names[1 : names.index(name)] for row in choose(rows, other)]
    by_mark = sorted((row for row in half if row not in before), key=lambda row: (-row.mark, row.image.name))
    most = OF_A_CHARACTER[name]
    counts: Counter[str] = Counter()
    best = _first(by_mark, ENDS, counts, most)
    worst = _first([row for row in by_mark[::-1] if row not in best], ENDS, counts, most)
    rest = [row for row in by_mark if row not in best and row not in worst]
    nearest = sorted(rest, key=lambda row: abs(row.mark - rest[len(rest) // 2].mark))
    return [*best, *worst, *_first(nearest, MIDDLE, Counter(), most)]


def _first(rows: list[Copy], count: int, counts: Counter[str], most: int) -> list[Copy]:
    """The first of them, not too many of a character."""
    chosen: list[Copy] = []
    for row in rows:
        if len(chosen) < count and counts[row.character] < most:
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
    pointed = point_out(copy, [remark.outline for remark in mark.remarks])
    wanted = point_out(master, [remark.master_outline for remark in mark.remarks])
    page = Image.new("RGB", (WORDS, SIDE), "white")
    pen, font = ImageDraw.Draw(page), ImageFont.truetype(str(find_chinese_font() or "DejaVuSans.ttf"), 14)
    score = "refused" if mark.score is None else f"{mark.score:.0f}"
    parts = ", ".join(f"{name} {value:.0f}" for name, value in mark.parts.items())
    said = [f"{number}. {row.character} {row.image.name}  people {row.mark:.0f}, rumu {score} ({parts})"]
    if mark.refused:
        said.append(mark.refused)
    if mark.praise is not None:
        said += [f"  + {mark.praise.zh}", f"    {mark.praise.en}"]
    for k, remark in enumerate(mark.remarks, start=1):
        said.append(f"  {k} [{remark.kind} {remark.size:.3f} {remark.severity:.1f}] {remark.zh}")
        said.append(f"    {remark.en}")
    for k, line in enumerate(part for whole in said for part in _wrapped(whole)):
        pen.text((8, 6 + 20 * k), line, fill="black", font=font)
    rule = np.full((SIDE, 2, 3), 120, np.uint8)
    strip = np.concatenate([wanted, rule, pointed, rule, overlay, rule, np.asarray(page)], axis=1)
    strip[-1] = 120
    return strip, "\n".join(said)


def picture(path: Path) -> np.ndarray:
    """(SIDE, SIDE, 3) uint8."""
    with Image.open(path) as image:
        gray = image.convert("RGB")
        return np.asarray(gray.resize((SIDE, SIDE), Image.Resampling.BILINEAR))


def _wrapped(text: str) -> list[str]:
    """The lines of a text; a Chinese character is as wide as two letters."""
    lines, line, used = [], "", 0
    for word in re.findall(r"[\u2e80-\uffef]|[^\s\u2e80-\uffef]+\s*|\s+", text):
        wide = sum(1 + (letter >= "\u2e80") for letter in word)
        if used + wide > 1.3 * LETTERS:
            lines, line, used = [*lines, line], "      ", 6
        line, used = line + word, used + wide
    return [*lines, line]


def point_out(shown: np.ndarray, outlines: list[Lines]) -> np.ndarray:
    """A picture, paler, with the lines that its remarks speak of and their numbers."""
    drawn = np.ascontiguousarray(255 - (255 - shown) // 2)
    for k, outline in enumerate(outlines):
        colour, at = COLOURS[k % len(COLOURS)], None
        for line in outline:
            points = np.round(np.array(line) * SIDE).astype(np.int32)
            cv2.polylines(drawn, [points.reshape(-1, 1, 2)], False, colour, 2, cv2.LINE_AA)
            cv2.circle(drawn, tuple(points[0].tolist()), 4, colour, -1, cv2.LINE_AA)
            at = tuple(points[len(points) // 2].tolist()) if at is None else at
        if at is not None:
            cv2.putText(drawn, str(k + 1), at, cv2.FONT_HERSHEY_SIMPLEX, 0.6, colour, 2, cv2.LINE_AA)
    return drawn


if __name__ == "__main__":
    main()
