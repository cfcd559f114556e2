"""Whether pictures that are no sheets get marks: `python benchmarks/no_sheets.py --count 100`.

Pictures of ten kinds are drawn, or taken from RUMU_DATA: noise, clouds, coloured shapes, printed text,
checkerboards, grids with writing, QR codes of other contents, boards of the markers that our sheets have,
single characters, pages of books. Each goes the way of a photographed sheet. Printed for each kind: how many
were refused, with which reasons, and how many cells were marked.
"""

from __future__ import annotations

import argparse
import os
from collections import Counter, defaultdict
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from rumu.errors import RefusedImage
from rumu.pages.sheet_reading import is_sheet, locate_sheet

DATA = Path(os.environ.get("RUMU_DATA", Path(__file__).parents[1] / ".." / "shared" / "data"))
SIDE = 1600
LETTERS = "abcdefghijklmnopqrstuvwxyz      ABCDEFGHIJKLM.,;()0123456789"

Picture = np.ndarray


def draw_noise(rng: np.random.Generator) -> Picture:
    """Independent pixels."""
    return rng.integers(0, 256, (SIDE, SIDE, 3), dtype=np.uint8)


def draw_clouds(rng: np.random.Generator) -> Picture:
    """Soft spots of all sizes, as walls and skies have."""
    total = np.zeros((SIDE, SIDE, 3), np.float32)
    for cells in (3, 6, 12, 25, 50, 100, 200):
        coarse = rng.random((cells, cells, 3)).astype(np.float32)
        total += cv2.resize(coarse, (SIDE, SIDE), interpolation=cv2.INTER_CUBIC) / cells**0.5
    return cv2.normalize(total, None, 0, 255, cv2.NORM_MINMAX).astype(np.uint8)


def draw_scene(rng: np.random.Generator) -> Picture:
    """Boxes, balls and sticks on a coloured ground, dark squares among them."""
    picture = np.full((SIDE, SIDE, 3), rng.integers(60, 255, 3), np.uint8)
    for _ in range(60):
        at, size = rng.integers(0, SIDE, 2), int(rng.integers(20, 300))
        colour = [int(c) for c in rng.integers(0, 255, 3)] if rng.random() < 0.7 else [15, 15, 15]
        kind = rng.integers(3)
        if kind == 0:
            box = cv2.boxPoints(((int(at[0]), int(at[1])), (size, size), float(rng.uniform(0, 90))))
            cv2.fillPoly(picture, [box.astype(np.int32)], colour, cv2.LINE_AA)
        elif kind == 1:
            cv2.circle(picture, (int(at[0]), int(at[1])), size // 2, colour, -1, cv2.LINE_AA)
        else:
            to = (int(rng.integers(0, SIDE)), int(rng.integers(0, SIDE)))
            cv2.line(picture, (int(at[0]), int(at[1])), to, colour, int(rng.integers(2, 40)), cv2.LINE_AA)
    return cv2.GaussianBlur(picture, (0, 0), 1.5)


def draw_text(rng: np.random.Generator) -> Picture:
    """A page of Latin letters."""
    page = Image.new("RGB", (SIDE, SIDE), "white")
    pen, size = ImageDraw.Draw(page), int(rng.integers(16, 60))
    font = ImageFont.load_default(size)
    for y in range(80, SIDE - 80, int(size * 1.5)):
        pen.text((80, y), "".join(rng.choice(list(LETTERS), SIDE // size * 2)), font=font, fill=(20, 20, 20))
    return np.asarray(page)


def draw_checkerboard(rng: np.random.Generator) -> Picture:
    """A board for calibrating cameras."""
    cells = int(rng.integers(5, 30))
    board = np.indices((cells, cells)).sum(axis=0) % 2 * 255
    grown = cv2.resize(board.astype(np.uint8), (SIDE, SIDE), interpolation=cv2.INTER_NEAREST)
    return cv2.cvtColor(grown, cv2.COLOR_GRAY2RGB)


def draw_grid(rng: np.random.Generator) -> Picture:
    """Cells with scribbles, as a sheet of practice of another make."""
    picture, step = np.full((SIDE, SIDE, 3), 245, np.uint8), int(rng.integers(90, 260))
    for at in range(step // 2, SIDE, step):
        cv2.line(picture, (at, 0), (at, SIDE), (190, 60, 50), 3)
        cv2.line(picture, (0, at), (SIDE, at), (190, 60, 50), 3)
    for _ in range(120):
        points = rng.integers(0, SIDE, 2) + rng.normal(0, step / 4, (6, 2))
        cv2.polylines(picture, [points.astype(np.int32)], False, (20, 20, 20), 8, cv2.LINE_AA)
    return picture


def draw_code(rng: np.random.Generator) -> Picture:
    """A QR code that says something else."""
    text = "".join(rng.choice(list("abcdefghijklmnopqrstuvwxyz0123456789/"), int(rng.integers(10, 90))))
    code = cv2.QRCodeEncoder.create().encode("https://example.org/" + text)
    picture = np.full((SIDE, SIDE, 3), 250, np.uint8)
    side = int(rng.integers(300, 1200))
    grown = cv2.resize(code, (side, side), interpolation=cv2.INTER_NEAREST)
    left, top = rng.integers(0, SIDE - side, 2)
    picture[top : top + side, left : left + side] = grown[..., None]
    return picture


def draw_markers(rng: np.random.Generator) -> Picture:
    """A board of the markers that stand in the corners of our sheets, in places where no sheet has them."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_50)
    picture = np.full((SIDE, SIDE, 3), 250, np.uint8)
    for at in range(16):
        side = int(rng.integers(60, 250))
        marker = cv2.aruco.generateImageMarker(dictionary, int(rng.integers(0, 50)), side)
        left, top = at % 4 * 400 + 60, at // 4 * 400 + 60
        picture[top : top + side, left : left + side] = marker[..., None]
    return picture


def take_character(rng: np.random.Generator) -> Picture:
    """A learner's copy by itself."""
    paths = sorted((DATA / "e3c" / "copies").glob("*.png"))
    return cv2.cvtColor(cv2.imread(str(paths[rng.integers(len(paths))])), cv2.COLOR_BGR2RGB)


def take_page(rng: np.random.Generator) -> Picture:
    """A page of a book, or of somebody's practice in a printed copybook."""
    paths = sorted(path for path in (DATA / "pages").rglob("*.*") if path.suffix in (".jpg", ".png"))
    with Image.open(paths[rng.integers(len(paths))]) as picture:
        return np.asarray(picture.convert("RGB"))


KINDS: tuple[Callable[[np.random.Generator], Picture], ...] = (
    draw_noise, draw_clouds, draw_scene, draw_text, draw_checkerboard,
    draw_grid, draw_code, draw_markers, take_character, take_page,
)  # fmt: skip


def main() -> None:
    """Read the pictures as sheets and print what came of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    asked = parser.parse_args()
    reasons: dict[str, Counter[str]] = defaultdict(Counter)
    for number in range(asked.first, asked.first + asked.count):
        kind = KINDS[number % len(KINDS)]
        picture = kind(np.random.default_rng(number))
        reason = "taken for a sheet"
        try:
            locate_sheet(picture)
        except RefusedImage as error:
            reason = f"refused: {error.reason}" + (", taken for a part of one" if is_sheet(picture) else "")
        reasons[kind.__name__.partition("_")[2]][reason] += 1
    for name, counts in reasons.items():
        print(f"{name:14}", ", ".join(f"{reason} {count}" for reason, count in counts.most_common()))
    taken = sum(counts["taken for a sheet"] for counts in reasons.values())
    print(f"{asked.count} pictures that are no sheets, {taken} taken for one")


if __name__ == "__main__":
    main()
