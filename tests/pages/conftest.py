"""Printed sheets as pictures, written on and photographed by the simplest of cameras."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pypdfium2
import pytest

from rumu.gallery.sheet_masters import SheetMasters, choose_masters
from rumu.pages.sheet_layout import SheetPage, lay_out
from rumu.pages.sheet_pdf import sheet_pdf

DPI = 200
TEXT = "永天人水"


def print_page(page: SheetPage, masters: SheetMasters, *, gray: bool = False) -> np.ndarray:
    """(H, W, 3) uint8: a page as a printer prints it."""
    document = pypdfium2.PdfDocument(sheet_pdf([page], masters.shapes))
    flat = np.asarray(document[0].render(scale=DPI / 72).to_pil().convert("RGB"))
    return np.repeat(cv2.cvtColor(flat, cv2.COLOR_RGB2GRAY)[..., None], 3, axis=2) if gray else flat


def write_in(
    flat: np.ndarray, page: SheetPage, masters: SheetMasters, *, cells: set[tuple[int, int]]
) -> np.ndarray:
    """The page with a leaning copy of its master in some cells."""
    written, scale = flat.astype(np.float32), DPI / 25.4
    for cell in page.cells:
        if (cell.row, cell.column) not in cells:
            continue
        ink = copy_of(masters, cell.character)
        factor = cell.box.width * scale / len(ink)
        left, top = int(cell.box.left * scale), int(cell.box.top * scale)
        side = int(cell.box.width * scale) + 2
        place = np.array([[factor, 0, cell.box.left * scale - left], [0, factor, cell.box.top * scale - top]])
        place[:, 2] += 0.5 * factor - 0.5  # from middles of pixels to middles of pixels
        smooth = cv2.GaussianBlur(ink, (0, 0), 0.4 / factor)
        laid = cv2.warpAffine(smooth, place, (side, side), flags=cv2.INTER_LINEAR)
        written[top : top + side, left : left + side] *= 1 - 0.88 * laid[..., None]
    return np.clip(written, 0, 255).astype(np.uint8)


def copy_of(masters: SheetMasters, character: str) -> np.ndarray:
    """(512, 512) float32: the ink of a copy that leans and is a little small."""
    ink = masters.by_character[character].ink
    matrix = cv2.getRotationMatrix2D((256, 256), -4, 0.9)
    return cv2.warpAffine(ink, matrix, ink.shape[::-1])


def photograph(
    flat: np.ndarray,
    *,
    size: tuple[int, int] = (1800, 1500),
    tilt: float = 0.12,
    turn: float = 0.0,
    blur: float = 0.8,
    gamma: float = 1.0,
) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
    """A picture (H, W, 3) of a page on a brown table, and the map from millimetres to its pixels.

    tilt: by how much the far side is shorter. turn: degrees clockwise. blur: pixels of the page by which it
    is smeared. gamma: light is smeared, and stored as its root of this degree.
    """
    height, width = size
    h, w = (n / DPI * 25.4 for n in flat.shape[:2])
    corners = np.array([[-w, -h], [w, -h], [w, h], [-w, h]]) / 2
    corners[:2, 0] *= 1 - tilt
    a = np.deg2rad(turn)
    corners = corners @ np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]])
    corners *= 0.94 * min(width / np.ptp(corners[:, 0]), height / np.ptp(corners[:, 1]))
    corners += np.array([width, height]) / 2 - (corners.max(axis=0) + corners.min(axis=0)) / 2
    paper = np.array([[0, 0], [w, 0], [w, h], [0, h]])
    matrix = cv2.getPerspectiveTransform(paper.astype(np.float32), corners.astype(np.float32))
    scale = DPI / 25.4
    from_pixels = np.array([[1 / scale, 0, 0.5 / scale], [0, 1 / scale, 0.5 / scale], [0, 0, 1]])
    shown = cv2.GaussianBlur((flat / np.float32(255)) ** np.float32(gamma), (0, 0), blur)
    picture = cv2.warpPerspective(
        shown,
        matrix @ from_pixels,
        (width, height),
        flags=cv2.INTER_LINEAR,
        borderValue=tuple((level / 255) ** gamma for level in (96, 80, 64)),
    )
    picture = 255 * picture ** (1 / gamma)

    def pixels(points: np.ndarray) -> np.ndarray:
        return cv2.perspectiveTransform(points.reshape(-1, 1, 2).astype(np.float64), matrix).reshape(-1, 2)

    light = 1 - 0.3 * np.linspace(0, 1, width)[None, :, None]
    return np.clip(picture * light, 0, 255).astype(np.uint8), pixels


@pytest.fixture(scope="session")
def sheets() -> SimpleNamespace:
    """What sheets are made with: print_page, write_in, copy_of, photograph."""
    return SimpleNamespace(print_page=print_page, write_in=write_in, copy_of=copy_of, photograph=photograph)


@pytest.fixture(scope="session")
def masters() -> SheetMasters:
    return choose_masters(TEXT)


@pytest.fixture(scope="session")
def page() -> SheetPage:
    (only,) = lay_out(SheetPage(TEXT, "strokes", pupil="王小明"))
    return only


@pytest.fixture
def benchmarks(monkeypatch):
    """What the benchmarks draw and measure can be imported."""
    monkeypatch.syspath_prepend(Path(__file__).parents[2] / "benchmarks")
