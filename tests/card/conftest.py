"""Photographs of the card by the simulated phone, and what is true of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pypdfium2
import pytest

from rumu.card.drawing import card_pdf
from rumu.card.layout import CardLayout
from rumu_lab.simulation.phone import (
    CardScene,
    HandLamp,
    PhoneCamera,
    reflectance_of_print,
    take_card_photograph,
    wavy_sheet,
)

BALL = (-41.0, -122.2, 9.5)
PHONE = PhoneCamera(size=(1200, 1600), blur=0.6)


@pytest.fixture(scope="session")
def printed():
    """Reflectance of the printed A4 card."""
    page = pypdfium2.PdfDocument(card_pdf("A4"))[0]
    return reflectance_of_print(np.asarray(page.render(scale=200 / 72).to_pil().convert("L")))


def lamps_around(count: int, *, distance: float = 400.0, slant: float = 42.0) -> list[np.ndarray]:
    """Positions round the card, at slightly different heights."""
    tilts = np.radians(np.arange(count) * 360 / count + 10)
    slants = np.radians(slant + 8 * np.cos(np.arange(count) * 2.0))
    return [
        distance * np.array([np.cos(t) * np.sin(s), np.sin(t) * np.sin(s), np.cos(s)])
        for t, s in zip(tilts, slants, strict=True)
    ]


@pytest.fixture(scope="session")
def shoot(printed):
    """Photograph a sheet on the card into a folder, a lamp each; the hand moves a little."""

    def take(folder: Path, lamps, *, sheet=None, ball=BALL, phone=PHONE, room=0.0, lobe=0.0) -> Path:
        rng = np.random.default_rng(5)
        folder.mkdir(parents=True, exist_ok=True)
        scene = CardScene(printed, (210.0, 297.0), sheet=sheet, ball=ball, room=room)
        for number, lamp in enumerate(lamps):
            place = tuple(np.array(phone.position) + rng.normal(0, 2.5, 3))
            held = replace(phone, position=place, lean=tuple(rng.normal(0, 0.6, 2)), roll=rng.normal(0, 2))
            data = take_card_photograph(scene, held, HandLamp(tuple(lamp), lobe=lobe), seed=number)
            (folder / f"{number}.jpg").write_bytes(data)
        return folder

    return take


@pytest.fixture(scope="session")
def sheet():
    return wavy_sheet(relief=0.35, seed=3)


@pytest.fixture(scope="session")
def taken(shoot, sheet, tmp_path_factory):
    """Four photographs of a sheet with relief, and the true lamps."""
    lamps = lamps_around(4)
    return shoot(tmp_path_factory.mktemp("card") / "taken", lamps, sheet=sheet), np.array(lamps)


def window_middle() -> np.ndarray:
    """From the card's middle to the window's, y up."""
    layout = CardLayout("A4")
    window = layout.window
    return np.array([0.0, layout.size[1] / 2 - window.top - window.height / 2, 0.0])


def angles(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Degrees between vectors."""
    lengths = np.linalg.norm(one, axis=-1) * np.linalg.norm(other, axis=-1)
    return np.degrees(np.arccos(np.clip((one * other).sum(axis=-1) / np.maximum(lengths, 1e-9), -1, 1)))


def on_the_grid_of(sheet, shape, pixel_mm, values):
    """Values of the sheet (h, w) where the pixels of a flat window lie, and whether they are well inside."""
    rows, columns = np.indices(shape)
    middle = window_middle()
    x = (columns - (shape[1] - 1) / 2) * pixel_mm + middle[0] - sheet.middle[0]
    y = ((shape[0] - 1) / 2 - rows) * pixel_mm + middle[1] - sheet.middle[1]
    h, w = sheet.height.shape
    column = (x / sheet.spacing + (w - 1) / 2).astype(np.float32)
    row = ((h - 1) / 2 - y / sheet.spacing).astype(np.float32)
    inside = (column > 25) & (column < w - 26) & (row > 25) & (row < h - 26)
    return cv2.remap(values.astype(np.float32), column, row, cv2.INTER_LINEAR), inside
