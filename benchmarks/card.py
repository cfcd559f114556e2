"""How exact a phone's photographs of the capture card are: `python benchmarks/card.py`.

A simulated phone photographs the printed card with a sheet of known relief in its window, under a small lamp
in several places; JPEGs go through `read_card_capture` and `reconstruct`. Printed are the largest error of
the lamps' directions and how unsure the reader said they are, the mean error of the normals, and that of the
scale, by how far apart the left and the right part of the sheet lie. The simulation shares no code with what
reads the photographs. Options: --megapixels (default 5), --seed, --only.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
import pypdfium2

from rumu.card.capture import CardCapture, read_card_capture
from rumu.card.drawing import card_pdf
from rumu.card.layout import CardLayout
from rumu.errors import CaptureError
from rumu.pipeline import reconstruct
from rumu.values import Surface
from rumu_lab.simulation.phone import (
    CardScene,
    HandLamp,
    LaidSheet,
    PhoneCamera,
    reflectance_of_print,
    take_card_photograph,
    wavy_sheet,
)


@dataclass(frozen=True)
class Case:
    """One way to photograph.

    distance: of the lamp, mm. curve: exponent that the phone adds to light. lobe: of the lamp, which shines
    with this power of the cosine from its axis. aim: standard deviation, mm, of where that meets the card.
    """

    name: str
    lamps: int = 6
    distance: float = 420.0
    ball: bool = True
    room: float = 0.0
    curve: float = 1.0
    exif: bool = True
    lobe: float = 0.0
    aim: float = 0.0


CASES = (
    Case("ball, 6 lamps at 0.42 m"),
    Case("ball, 3 lamps at 0.42 m", lamps=3),
    Case("ball, 6 lamps at 1 m", distance=1000.0),
    Case("ball, 6 lamps, room gives 5 %", room=0.05),
    Case("ball, 6 lamps, phone adds contrast", curve=1.12),
    Case("ball, 6 lamps, no EXIF", exif=False),
    Case("ball, 6 lamps, LED (cosine)", lobe=1.0),
    Case("ball, 6 lamps, beam (cosine cubed)", lobe=3.0),
    Case("no ball, 6 lamps at 0.42 m", ball=False),
    Case("no ball, 6 lamps at 0.33 m", ball=False, distance=330.0),
    Case("no ball, 3 lamps at 0.33 m", ball=False, lamps=3, distance=330.0),
    Case("no ball, 6 lamps, LED (cosine)", ball=False, lobe=1.0),
    Case("no ball, 6 lamps, beam (cosine cubed)", ball=False, lobe=3.0),
    Case("no ball, 6 lamps, beam aimed badly", ball=False, lobe=3.0, aim=25.0),
    Case("no ball, 6 lamps at 1 m", ball=False, distance=1000.0),
)


def photograph(
    case: Case, folder: Path, printed: np.ndarray, sheet: LaidSheet, *, size: tuple[int, int], seed: int
) -> np.ndarray:
    """Take the photographs of a case; (N, 3) the true lamps from the window's middle."""
    rng = np.random.default_rng(seed)
    scene = CardScene(
        printed, (210.0, 297.0), sheet=sheet, ball=(-41.0, -122.2, 9.5) if case.ball else None, room=case.room
    )
    phone = PhoneCamera(
        size=size, exif=case.exif, curve=None if case.curve == 1 else lambda light: light**case.curve
    )
    lamps = []
    for k in range(case.lamps):
        tilt = np.radians(360 * k / case.lamps + rng.uniform(-15, 15))
        slant, far = np.radians(rng.uniform(32, 52)), case.distance * rng.uniform(0.9, 1.1)
        lamps.append(
            far * np.array([np.cos(tilt) * np.sin(slant), np.sin(tilt) * np.sin(slant), np.cos(slant)])
        )
        held = replace(
            phone,
            position=tuple(np.array(phone.position) + rng.normal(0, 2.5, 3)),
            lean=tuple(rng.normal(0, 0.6, 2)),
            roll=rng.normal(0, 2),
            white=0.5 * rng.uniform(0.8, 1.1),
        )
        aim = tuple(rng.normal(0, case.aim, 2)) if case.aim else (0.0, 0.0)
        data = take_card_photograph(scene, held, HandLamp(tuple(lamps[-1]), lobe=case.lobe, aim=aim), seed=k)
        (folder / f"{k}.jpg").write_bytes(data)
    return np.array(lamps) - _middle()


def _middle() -> np.ndarray:
    layout = CardLayout("A4")
    return np.array([0, layout.size[1] / 2 - layout.window.top - layout.window.height / 2, 0])


def angles(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Degrees between vectors."""
    lengths = np.linalg.norm(one, axis=-1) * np.linalg.norm(other, axis=-1)
    return np.degrees(np.arccos(np.clip((one * other).sum(axis=-1) / np.maximum(lengths, 1e-9), -1, 1)))


def compare(sheet: LaidSheet, made: CardCapture, surface: Surface) -> tuple[float, float]:
    """Mean error of the normals in degrees, and error of the scale as a share."""
    rows, columns = np.indices(surface.height.shape)
    x = (columns - (columns.shape[1] - 1) / 2) * made.pixel_mm
    y = ((rows.shape[0] - 1) / 2 - rows) * made.pixel_mm + _middle()[1]
    h, w = sheet.height.shape
    column, row = x / sheet.spacing + (w - 1) / 2, (h - 1) / 2 - y / sheet.spacing
    maps = column.astype(np.float32), row.astype(np.float32)
    inside = (column > 20) & (column < w - 21) & (row > 20) & (row < h - 21)
    true = [
        cv2.remap(one.astype(np.float32), *maps, cv2.INTER_LINEAR) for one in np.moveaxis(sheet.normals, 2, 0)
    ]
    off = angles(np.dstack(true), surface.normals)[inside]
    albedo = cv2.remap(sheet.albedo.astype(np.float32), *maps, cv2.INTER_LINEAR)
    rows, columns = np.nonzero(inside)
    top, bottom, left, right = rows.min(), rows.max(), columns.min(), columns.max()
    third, shifts = (right - left) // 3, []
    window = cv2.createHanningWindow((third, bottom - top), cv2.CV_32F)
    for start in (left, right - third):
        part = np.s_[top:bottom, start : start + third]
        pair = [
            np.ascontiguousarray(one[part] / one[part].mean() - 1, np.float32)
            for one in (albedo, surface.albedo.mean(axis=2))
        ]
        shifts.append(cv2.phaseCorrelate(*pair, window)[0][0])
    return float(off.mean()), float((shifts[1] - shifts[0]) / (right - third - left))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--megapixels", type=float, default=5.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="cases whose name holds this")
    asked = parser.parse_args()
    width = round(np.sqrt(asked.megapixels * 1e6 * 0.75))
    size = (width, round(width / 0.75))
    page = pypdfium2.PdfDocument(card_pdf("A4"))[0]
    printed = reflectance_of_print(np.asarray(page.render(scale=300 / 72).to_pil().convert("L")))
    sheet = wavy_sheet(seed=asked.seed)
    print(
        f"{size[0]} x {size[1]} pixels    lamps: worst  said to be  normals: mean   scale    reading, s CPU"
    )
    for case in (one for one in CASES if asked.only in one.name):
        with tempfile.TemporaryDirectory() as folder:
            true = photograph(case, Path(folder), printed, sheet, size=size, seed=asked.seed)
            start = time.process_time()
            try:
                made = read_card_capture(folder)
            except CaptureError as error:
                print(f"{case.name:36s} refused: {str(error)[:64]}...")
                continue
            spent = time.process_time() - start
            normals, scale = compare(sheet, made, reconstruct(made.capture))
            worst = float(angles(true, made.capture.lights).max())
            said = max(lamp.unsure for lamp in made.lamps)
            print(
                f"{case.name:36s} {worst:4.1f}°       {said:4.1f}°        {normals:4.2f}°       "
                f"{100 * scale:+5.2f} %   {spent:5.1f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
