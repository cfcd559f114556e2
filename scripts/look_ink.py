"""Draw contact sheets of pictures beside the ink that is found in them.

    .venv/bin/python scripts/look_ink.py OUT PATH... [--every N] [--count N]

PATH: pictures or folders of them. Each cell shows the picture and, beside it, its ink in black, or a red
field where it is refused. Figures of all pictures go to standard output.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import cv2
import numpy as np

from rumu.capture.image import read_image
from rumu.errors import RumuError
from rumu.surface.ink import find_ink

CELL, COLUMNS, ROWS = 150, 6, 7
SUFFIXES = {".png", ".jpg", ".jpeg", ".webp", ".tif", ".bmp"}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("paths", type=Path, nargs="+")
    parser.add_argument("--every", type=int, default=1, help="take every N-th file")
    parser.add_argument("--count", type=int, default=0, help="at most this many, spread evenly")
    options = parser.parse_args()
    files = list_pictures(options.paths)[:: options.every]
    if options.count:
        files = [files[i] for i in np.unique(np.linspace(0, len(files) - 1, options.count).astype(int))]
    options.out.mkdir(parents=True, exist_ok=True)
    for page, start in enumerate(range(0, len(files), COLUMNS * ROWS)):
        sheet = contact_sheet(files[start : start + COLUMNS * ROWS])
        cv2.imwrite(str(options.out / f"ink_{page:02d}.png"), sheet[:, :, ::-1])


def list_pictures(paths: list[Path]) -> list[Path]:
    """The pictures named, and those of the folders named, sorted."""
    found: list[Path] = []
    for path in paths:
        inside = path.rglob("*") if path.is_dir() else [path]
        found += sorted(p for p in inside if p.suffix.lower() in SUFFIXES)
    return found


def contact_sheet(files: list[Path]) -> np.ndarray:
    """(rows, columns, 3) uint8: picture and ink side by side, with the file's name under them."""
    sheet = np.full((ROWS * (CELL + 14), COLUMNS * (2 * CELL + 6), 3), 160, np.uint8)
    for i, file in enumerate(files):
        row, column = divmod(i, COLUMNS)
        y, x = row * (CELL + 14), column * (2 * CELL + 6)
        left, right, text = describe_ink(file)
        sheet[y : y + left.shape[0], x : x + left.shape[1]] = left
        sheet[y : y + right.shape[0], x + CELL : x + CELL + right.shape[1]] = right
        place = (x + 2, y + CELL + 10)
        cv2.putText(sheet, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.33, (0, 0, 0), 1, cv2.LINE_AA)
    return sheet


def describe_ink(file: Path) -> tuple[np.ndarray, np.ndarray, str]:
    """The picture, its ink, and one line about it."""
    picture = read_image(file)
    shown = np.rint(255 * (picture if picture.ndim == 3 else np.dstack([picture] * 3))).astype(np.uint8)
    name = "".join(c if ord(c) < 128 else "" for c in file.stem)[-10:]
    try:
        ink = find_ink(picture)
    except RumuError as error:
        print(f"{file}: {error}")
        return fit_cell(shown), np.full((CELL - 4, CELL - 4, 3), (220, 60, 60), np.uint8), f"{name} {error}"
    left_out = {k: v for k, v in ink.left_out.items() if v}
    figures = " ".join(f"{name} {value:.2f}" for name, value in ink.figures.items())
    print(f"{file}: {ink.polarity}, share {ink.mask.mean():.3f}, {figures}, left out {left_out}")
    drawn = np.dstack([np.where(ink.mask, 0, 255).astype(np.uint8)] * 3)
    text = f"{name} {ink.polarity[0]} {ink.mask.mean():.3f} " + " ".join(
        f"{k[0]}{v}" for k, v in left_out.items()
    )
    return fit_cell(shown), fit_cell(drawn), text


def fit_cell(picture: np.ndarray) -> np.ndarray:
    """The picture scaled to one cell."""
    scale = (CELL - 4) / max(picture.shape[:2])
    return cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)


if __name__ == "__main__":
    main()
