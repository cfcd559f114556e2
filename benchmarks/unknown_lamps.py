"""Lamps found from photographs alone: `python benchmarks/unknown_lamps.py`.

A simulated sheet with known relief, ink, fibres and noise under lamps that nobody tells. Printed are the
largest error of the directions, the mean error of the normals, the standard error of the steepness as it was
said, and what told ridges from hollows; where only the rule did, the better of both readings is printed, and
marked when the rule was wrong. Then the captures in RUMU_DATA (default: ../shared/data beside the checkout):
round objects, no sheets, which are to be refused.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from rumu.capture.folder import read_capture
from rumu.errors import CaptureError
from rumu.image_stack import ImageStack
from rumu.pipeline import reconstruct
from rumu.surface.unknown_lamps import find_lamps
from rumu_lab.simulation.lamps import DistantLamp, NearLamp, Sensor, render
from rumu_lab.simulation.phone import wavy_sheet

DATA = Path(os.environ.get("RUMU_DATA", Path(__file__).parents[1] / ".." / "shared" / "data")).resolve()
CASES = (
    # name; lamps, standard deviation of the relief in mm, noise, distance of the lamps in mm (0: far away)
    ("8 lamps far away", 8, 0.35, 0.004, 0.0),
    ("4 lamps far away, noisy", 4, 0.35, 0.010, 0.0),
    ("8 lamps, shallow relief", 8, 0.10, 0.006, 0.0),
    ("8 lamps at 400 mm", 8, 0.35, 0.004, 400.0),
    ("6 lamps at 300 mm, noisy", 6, 0.35, 0.008, 300.0),
    ("6 lamps, flat sheet with ink", 6, 0.0, 0.004, 0.0),
)


def angles(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Degrees between unit vectors."""
    return np.degrees(np.arccos(np.clip((one * other).sum(axis=-1), -1, 1)))


def main() -> None:
    """Print a line for each case."""
    print(f"{'sheet of 100 x 120 mm':30s} slopes  lamps: worst  normals: mean  said to be  ridges told by")
    for seed, (name, count, relief, noise, near) in enumerate(CASES, start=1):
        rng = np.random.default_rng(seed)
        sheet = wavy_sheet(relief=relief, seed=seed)
        albedo = sheet.albedo * (1 + 0.01 * rng.standard_normal(sheet.albedo.shape))
        tilts = 360 * np.arange(count) / count + rng.uniform(-15, 15, count)
        slants = rng.uniform(30, 55, count)
        far = [DistantLamp(tilt, slant, 0.9) for tilt, slant in zip(tilts, slants, strict=True)]
        lights = np.array([one.direction for one in far])
        lamps = [NearLamp(tuple(near * one)) for one in lights] if near else far
        options = {"spacing": sheet.spacing, "normals": sheet.normals}
        frames = [
            render(sheet.height, albedo, lamp=lamp, sensor=Sensor(noise=noise, seed=k), **options)
            for k, lamp in enumerate(lamps)
        ]
        slopes = float(np.degrees(np.arccos(np.clip(sheet.normals[..., 2], -1, 1))).mean())
        try:
            found = find_lamps(ImageStack.of_arrays(frames), mask=np.ones(albedo.shape, bool))
        except CaptureError as error:
            print(f"{name:30s} {slopes:5.1f}°  refused: {str(error)[:70]}...")
            continue
        turned = angles(lights, found.capture.lights).mean() > 45
        way = np.array([-1, -1, 1]) if turned else np.ones(3)
        worst = angles(lights, found.capture.lights * way).max()
        off = angles(sheet.normals, reconstruct(found.capture).normals * way)[40:-40, 40:-40].mean()
        told = f"{found.sign}{', wrongly' if turned else ''}"
        said = f"{100 * found.unsure:4.1f} %"
        print(
            f"{name:30s} {slopes:5.1f}°  {worst:6.1f}°       {off:6.2f}°        {said}      {told}",
            flush=True,
        )
    real_captures()


def real_captures() -> None:
    """Print what becomes of each capture of the test data."""
    print("\ncaptures of objects")
    for folder in sorted(one for one in (DATA / "photometric").rglob("*") if one.is_dir()):
        try:
            capture = read_capture(folder)
        except CaptureError:
            continue  # no capture
        try:
            found = find_lamps(capture.photographs, mask=capture.mask)
            off = angles(capture.lights, found.capture.lights).mean()
            print(f"  {folder.name:24s} found, {off:.1f}° off on average")
        except CaptureError as error:
            print(f"  {folder.name:24s} refused: {str(error)[:80]}...")


if __name__ == "__main__":
    main()
