"""Pages laid out by code from characters of the masters: `python benchmarks/drawn_pages.py [DATA]`.

Each page is written in one master's hand, `DATA/masters/regular`, so the truth is known to the character and
no printed edition is needed: an album, columns without a frame, two and three registers, ruled columns,
double rows of small characters, rows from the left, a rubbing, silk mounted on a lighter ground, a shaded
page with seals; and the same kinds small, large, leaning, noisy and compressed. Printed for each kind:
columns, those found in order and those found besides, those whose number of characters is right and within
one; characters of all kinds named rightly and wrongly with the text given; seconds of the processor.
"""

from __future__ import annotations

import argparse
import csv
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import cv2
import numpy as np

import rumu
from pages import columns_of, count_names, match
from rumu.pages.page import Page

HANDS = ("ouyang-jiuchenggong", "yan-duobaota", "zhao-sanmenji", "zhiyong-qianziwen", "yu-yanlianzhu")
INK, PAPER, SILK, MOUNT = (40, 38, 36), (228, 219, 196), (176, 152, 112), (236, 232, 222)

Picture = np.ndarray


@dataclass(frozen=True)
class Kind:
    """How a page is laid out; lengths in sides of a character.

    registers, columns, rows: how many of each. pitch, pace: from column to column, character to character.
    frame, ruled: lines around the registers, between the columns. double: how often two to six small
    characters stand in two lines after a character. across: rows from the left instead of columns. side: of
    a character, in pixels. loose: by how much characters differ in size and stray, as a share. early: share
    of the columns that end early. dress: what is done with the page of paper.
    """

    registers: int = 1
    columns: int = 10
    rows: int = 14
    pitch: float = 1.5
    pace: float = 1.12
    frame: bool = False
    ruled: bool = False
    double: float = 0.0
    across: bool = False
    side: int = 44
    loose: float = 0.06
    early: float = 0.2
    dress: Callable[[Picture, np.random.Generator], Picture] = field(default=lambda page, rng: page)


def rubbed(page: Picture, rng: np.random.Generator) -> Picture:
    """White on black, with the grain of stone."""
    grain = cv2.GaussianBlur(rng.normal(0, 40, page.shape[:2]).astype(np.float32), (0, 0), 1.2)
    return np.clip(255 - 0.9 * page.astype(float) + 8 + grain[..., None], 0, 255).astype(np.uint8)


def on_silk(page: Picture, rng: np.random.Generator) -> Picture:
    """Dark silk, mounted on a lighter ground."""
    silk = page.astype(float) * (np.array(SILK) / PAPER)
    weave = 6 * rng.normal(0, 1, page.shape[:2])[..., None]
    around = [page.shape[0] // 8] * 2 + [page.shape[1] // 8] * 2
    mounted = cv2.copyMakeBorder(silk + weave, *around, cv2.BORDER_CONSTANT, value=MOUNT)
    return np.clip(mounted, 0, 255).astype(np.uint8)


def shaded(page: Picture, rng: np.random.Generator) -> Picture:
    """Light from one side, and two red seals."""
    page, (height, width) = page.copy(), page.shape[:2]
    for y in (0.1, 0.82):
        corner = int(0.03 * width), int(y * height)
        cv2.rectangle(page, corner, (corner[0] + 70, corner[1] + 70), (188, 40, 34), 6)
        cv2.line(page, (corner[0] + 35, corner[1]), (corner[0] + 35, corner[1] + 70), (188, 40, 34), 6)
    return (page * np.linspace(0.55, 1.0, width)[None, :, None]).astype(np.uint8)


def scaled(share: float) -> Callable[[Picture, np.random.Generator], Picture]:
    """The page at a share of its size."""
    way = cv2.INTER_AREA if share < 1 else cv2.INTER_CUBIC
    return lambda page, rng: cv2.resize(page, None, fx=share, fy=share, interpolation=way)


def leaning(page: Picture, rng: np.random.Generator) -> Picture:
    """Turned by two to three degrees, either way."""
    height, width = page.shape[:2]
    degrees = float(rng.choice([-1, 1]) * rng.uniform(2, 3))
    matrix = cv2.getRotationMatrix2D((width / 2, height / 2), degrees, 1)
    return np.asarray(cv2.warpAffine(page, matrix, (width, height), borderValue=PAPER))


def noisy(page: Picture, rng: np.random.Generator) -> Picture:
    """Noise of 20 gray levels, blur and much compression."""
    blurred = cv2.GaussianBlur(page, (0, 0), 1.0) + rng.normal(0, 20, page.shape)
    data = cv2.imencode(".jpg", np.clip(blurred, 0, 255), [cv2.IMWRITE_JPEG_QUALITY, 30])[1]
    return np.asarray(cv2.imdecode(data, cv2.IMREAD_COLOR))


PLAIN = Kind()
FRAMED = Kind(registers=2, frame=True, columns=14, rows=15, side=34, pitch=1.35, pace=1.06, loose=0.04)
KINDS = {
    "album": replace(PLAIN, columns=5, rows=7, side=80, loose=0.1),
    "columns": PLAIN,
    "linked": replace(PLAIN, pace=0.98, loose=0.1),
    "two registers": FRAMED,
    "three registers": replace(FRAMED, registers=3, columns=20, rows=12, side=28),
    "ruled": replace(PLAIN, frame=True, ruled=True, pitch=1.35),
    "double rows": replace(FRAMED, double=0.08),
    "rows": replace(PLAIN, across=True, columns=14, rows=18, pitch=1.7),
    "rubbing": replace(PLAIN, dress=rubbed),
    "silk": replace(PLAIN, dress=on_silk),
    "shaded": replace(PLAIN, dress=shaded),
    "half size": replace(FRAMED, dress=scaled(0.6)),
    "large": replace(FRAMED, dress=scaled(1.8)),
    "leaning": replace(PLAIN, dress=leaning),
    "noisy": replace(FRAMED, dress=noisy),
}


class Hand:
    """The characters of one master, and pages written with them."""

    def __init__(self, folder: Path, rng: np.random.Generator) -> None:
        rows = csv.DictReader((folder.parent / "labels.csv").open(encoding="utf-8"))
        self.files = {
            row["character"]: folder.parent / row["file"]
            for row in rows
            if row["file"].startswith(f"{folder.name}/") and len(row["character"]) == 1
        }
        self.rng = rng

    def glyph(self, character: str, side: float) -> Picture:
        """(h, w) float, 0-1: its ink, so large that its longer side is `side` pixels."""
        gray = cv2.imdecode(np.fromfile(self.files[character], np.uint8), cv2.IMREAD_GRAYSCALE)
        ink = gray < 128 if (gray < 128).mean() < 0.5 else gray >= 128
        x, y, width, height = cv2.boundingRect(ink.astype(np.uint8))
        cut = ink[y : y + height, x : x + width].astype(np.float32)
        share = side / max(width, height)
        size = max(1, round(width * share)), max(1, round(height * share))
        return np.asarray(cv2.resize(cut, size, interpolation=cv2.INTER_AREA))

    def page(self, kind: Kind) -> tuple[Picture, list[list[str]], list[list[str]]]:
        """A page, the main characters of the columns of each register, and all of their characters."""
        side, rng = kind.side, self.rng
        pitch, pace = round(kind.pitch * side), round(kind.pace * side)
        high, wide = kind.rows * pace + side, kind.columns * pitch + side // 2
        margin = 2 * side
        ink = np.zeros((kind.registers * high + 2 * margin, wide + 2 * margin), np.float32)
        registers, written = [], []
        for r in range(kind.registers):
            top = margin + r * high
            self._lines(ink, kind, (margin, top, margin + wide, top + high), pitch)
            columns = []
            for c in range(kind.columns):
                x = margin + wide - side / 4 - (c + 0.5) * pitch
                rows = kind.rows if rng.random() > kind.early else int(rng.integers(2, kind.rows + 1))
                columns.append(self._column(ink, kind, x, top + side / 2, rows))
            registers.append([main for main, _ in columns])
            written.append([every for _, every in columns])
        if kind.across:  # columns from the right become rows from the top
            ink = np.ascontiguousarray(ink.T[::-1])
        paper = (
            PAPER + 4 * cv2.GaussianBlur(rng.normal(0, 1, ink.shape).astype(np.float32), (0, 0), 2)[..., None]
        )
        smooth = cv2.GaussianBlur(ink, (0, 0), 0.6)[..., None]
        picture = np.clip(paper * (1 - smooth) + np.array(INK) * smooth, 0, 255).astype(np.uint8)
        return kind.dress(picture, rng), registers, written

    def _lines(self, ink: Picture, kind: Kind, box: tuple[int, int, int, int], pitch: int) -> None:
        left, top, right, bottom = box
        if kind.frame:
            cv2.rectangle(ink, (left, top), (right, bottom), 0.85, max(1, kind.side // 16))
        for c in range(1, kind.columns if kind.ruled else 0):
            x = right - kind.side // 4 - c * pitch
            cv2.line(ink, (x, top), (x, bottom), 0.7, 1)

    def _column(self, ink: Picture, kind: Kind, x: float, top: float, rows: int) -> tuple[str, str]:
        """Write a column; its main characters, and all of them in reading order."""
        rng, side, pace = self.rng, kind.side, kind.pace * kind.side
        known = list(self.files)
        main = written = ""
        y, end = top, top + rows * pace
        while y + pace <= end + 1:
            if main and rng.random() < kind.double and y + 1.6 * pace <= end:
                each = int(rng.integers(1, 3))
                small = [known[k] for k in rng.integers(0, len(known), 2 * each)]
                for k, character in enumerate(small):
                    line, row = divmod(k, each)
                    away = (0.27 - 0.54 * line) * side
                    self._lay(ink, kind, character, (x + away, y + (row + 0.5) * 0.55 * pace), 0.48 * side)
                written += "".join(small)
                y += 0.55 * each * pace
                continue
            character = known[int(rng.integers(len(known)))]
            stray = rng.normal(0, kind.loose, 3)
            centre = x + 0.5 * stray[0] * side, y + pace / 2 + 0.5 * stray[1] * side
            self._lay(ink, kind, character, centre, side * (0.95 + stray[2]))
            main, written, y = main + character, written + character, y + pace
        return main, written

    def _lay(
        self, ink: Picture, kind: Kind, character: str, centre: tuple[float, float], side: float
    ) -> None:
        glyph = self.glyph(character, side)
        glyph = glyph[::-1].T if kind.across else glyph  # so that it stands upright on the turned page
        left, top = (round(c - s / 2) for c, s in zip(centre, glyph.shape[::-1], strict=True))
        part = ink[top : top + glyph.shape[0], left : left + glyph.shape[1]]
        np.maximum(part, glyph[: part.shape[0], : part.shape[1]], out=part)


def count_columns(page: Page, registers: list[list[str]]) -> np.ndarray:
    """Columns, found, found besides, with the right number of characters, within one."""
    found = columns_of(page)
    counts = np.array([sum(map(len, registers)), 0, sum(map(len, found)), 0, 0])
    for got, true in zip(found, registers, strict=False):
        for i, j in match([len(c) for c in got], [len(t) for t in true]):
            off = abs(len(got[i]) - len(true[j]))
            counts += [0, off <= max(3, len(true[j]) / 4), -1, off == 0, off <= 1]
    return counts


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", nargs="?", default=os.environ.get("RUMU_DATA", "../shared/data"), type=Path)
    parser.add_argument("--kind", nargs="*", choices=list(KINDS), default=list(KINDS))
    parser.add_argument("--hands", type=int, default=len(HANDS), help="how many hands write each kind")
    parser.add_argument("--look", type=Path, help="folder for the pages as PNG")
    arguments = parser.parse_args()
    print("| kind | columns | found | besides | number right | within one | named | wrong | s |")
    print("|---|---|---|---|---|---|---|---|---|")
    for kind in arguments.kind:
        counts, names, seconds = np.zeros(5), np.zeros(3), []
        for number, hand in enumerate(HANDS[: arguments.hands]):
            writer = Hand(arguments.data / "masters" / "regular" / hand, np.random.default_rng(number))
            picture, registers, written = writer.page(KINDS[kind])
            text = "".join(map("".join, written))
            began = time.process_time()
            page = rumu.read_page(picture)
            seconds.append(time.process_time() - began)
            counts += count_columns(page, registers)
            named = rumu.read_page(picture, text=text)
            names += [len(text), *count_names(named, written)]
            if arguments.look is not None:
                arguments.look.mkdir(parents=True, exist_ok=True)
                cv2.imwrite(str(arguments.look / f"{kind}-{hand}.png"), picture[..., ::-1])
        print(
            f"| {kind} | {counts[0]:.0f} | {counts[1] / counts[0]:.1%} | {counts[2]:.0f} "
            f"| {counts[3] / counts[0]:.1%} | {counts[4] / counts[0]:.1%} "
            f"| {names[1] / names[0]:.2%} | {names[2]:.0f} | {np.median(seconds):.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
