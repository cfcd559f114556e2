"""Tiny inputs for whole commands, and a way to run them that keeps stdout, stderr and the exit code apart."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image


def glyph(*, side: int = 160, lean: int = 0, bar: bool = True) -> Image.Image:
    """十 in ink on white; `lean` moves the foot of the standing stroke to the left."""
    page = np.full((side, side), 255, dtype=np.uint8)
    top, bottom, middle, half = side // 6, side - side // 6, side // 2, side // 16
    for row in range(top, bottom):
        at = middle - round(lean * (row - top) / (bottom - top))
        page[row, at - half : at + half] = 10
    if bar:
        page[middle - half : middle + half, top:bottom] = 10
    return Image.fromarray(page)


@pytest.fixture
def desk(tmp_path: Path) -> Path:
    """A folder with a master, two copies (one with a space in its name) and pictures that are none."""
    glyph().save(tmp_path / "master.png")
    glyph(lean=14).save(tmp_path / "copy.png")
    glyph(lean=6).save(tmp_path / "a copy.png")
    glyph(bar=False).save(tmp_path / "half.png")
    Image.new("L", (160, 160), 255).save(tmp_path / "blank.png")
    (tmp_path / "empty.png").write_bytes(b"")
    whole = (tmp_path / "master.png").read_bytes()
    (tmp_path / "cut.png").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "words.png").write_text("not a picture\n")
    (tmp_path / "file.txt").write_text("in the way\n")
    return tmp_path


LAMPS = np.array([[0.5, 0, 1], [0, 0.5, 1], [-0.5, 0, 1], [0, -0.5, 1], [0.35, 0.35, 1]])


@pytest.fixture
def capture(tmp_path: Path) -> Path:
    """Five photographs of a low mound under five lamps, with lights.lp."""
    folder = tmp_path / "capture"
    folder.mkdir()
    y, x = np.mgrid[1:-1:40j, -1:1:40j]
    height = 4 * np.exp(-4 * (x**2 + y**2))
    drow, dcol = np.gradient(height)
    normals = np.dstack([-dcol, drow, np.ones_like(height)])
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    lamps = LAMPS / np.linalg.norm(LAMPS, axis=1, keepdims=True)
    lines = [str(len(lamps))]
    for number, lamp in enumerate(lamps):
        shade = np.clip(0.8 * normals @ lamp, 0, 1)
        Image.fromarray(np.round(shade * 65535).astype(np.uint16)).save(folder / f"lamp {number}.png")
        lines.append(f"lamp {number}.png {lamp[0]:.6f} {lamp[1]:.6f} {lamp[2]:.6f}")
    (folder / "lights.lp").write_text("\n".join(lines) + "\n")
    return folder
