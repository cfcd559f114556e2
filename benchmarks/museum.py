"""Surfaces of the size of museums: `benchmarks/museum.py [--megapixels 24] [--photographs 20] [--large]`.

Simulated photographs of a wavy, inked sheet are written as 8-bit PNGs. Decoding them with OpenCV in
one thread is the measure; `rumu reconstruct` then takes them to normals, albedo and height on disk,
and `rumu rti` to relightable images, each in a process of its own, whose peak memory is printed. Beside
it stand small captures, compiled and in NumPy, one that is glossy everywhere, and masked integration.
Processor time is printed beside elapsed time, since other programs stretch the latter. --large adds 100 MP
x 60. Nothing is kept. The bunny is in RUMU_DATA (default: ../shared/data beside the checkout).
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import cv2
import numpy as np

from rumu.capture.folder import read_capture
from rumu.surface import compiled, robust
from rumu.surface.beyond_lambert import find_materials
from rumu.surface.integrate import integrate
from rumu.surface.photometric import surface_normals
from rumu.surface.robust import RobustSettings
from rumu.surface.solve import solve
from rumu_lab.simulation.lamps import from_slopes
from rumu_lab.simulation.reflectances import photograph_material, spread_lamps

DATA = Path(os.environ.get("RUMU_DATA", Path(__file__).parents[1] / ".." / "shared" / "data")).resolve()
WANTED = "normals.png,height.png,albedo.png"
COMMANDS = (
    ("least_squares", "reconstruct", "out", "--write", WANTED, "--solver", "least_squares"),
    ("robust", "reconstruct", "out", "--write", WANTED, "--solver", "robust"),
    ("rti, a polynomial", "rti", "out.ptm"),
    ("rti, 9 harmonics", "rti", "out.rti"),
)
BAND = 250  # rows that are simulated at a time
CORES = os.cpu_count() or 1


def lamps(count: int) -> np.ndarray:
    """(count, 3) lamps on two rings."""
    tilt = 2 * np.pi * np.arange(count) / count
    slant = np.radians(np.where(np.arange(count) % 2, 35.0, 55.0))
    return np.stack([np.cos(tilt) * np.sin(slant), np.sin(tilt) * np.sin(slant), np.cos(slant)], axis=1)


def write_photographs(folder: Path, *, megapixels: float, count: int) -> None:
    """PNGs of 8 bits and an .lp: a sheet of waves, with ink in squares and noise of the sensor."""
    rng = np.random.default_rng(1)
    height, width = round(np.sqrt(megapixels * 1e6 / 1.5)), round(np.sqrt(megapixels * 1e6 * 1.5))
    waves = [(*rng.uniform(-0.08, 0.08, 2), rng.uniform(0, 6)) for _ in range(9)]
    ink = np.where(rng.random((height // 90 + 1, width // 90 + 1)) > 0.75, 0.25, 0.8).astype(np.float32)
    noise = (0.004 * rng.standard_normal((BAND + 64, width + 64))).astype(np.float32)
    lights = lamps(count)
    images = np.empty((count, height, width), np.uint8)
    columns = np.arange(width, dtype=np.float32)[None]
    for top in range(0, height, BAND):
        rows = np.arange(top, min(top + BAND, height), dtype=np.float32)[:, None]
        p, q = np.zeros((len(rows), width), np.float32), np.zeros((len(rows), width), np.float32)
        for across, down, phase in waves:
            slope = np.cos(np.float32(across) * columns + np.float32(down) * rows + np.float32(phase))
            p += np.float32(across) * slope
            q -= np.float32(down) * slope
        albedo = ink[rows.astype(int) // 90, columns.astype(int) // 90] / np.sqrt(1 + p * p + q * q)
        for i, (x, y, z) in enumerate(lights.astype(np.float32)):
            lit = albedo * np.maximum(z - x * p - y * q, 0)
            lit += noise[i % 64 : i % 64 + len(rows), i % 61 : i % 61 + width]
            images[i, top : top + len(rows)] = np.clip(lit * 255 + 0.5, 0, 255)
    lines = [str(count)]
    for i, (image, light) in enumerate(zip(images, lights, strict=True)):
        cv2.imwrite(str(folder / f"{i:03d}.png"), image)
        lines.append(f"{i:03d}.png {light[0]:.6f} {light[1]:.6f} {light[2]:.6f}")
    (folder / "lamps.lp").write_text("\n".join(lines) + "\n")


def write_photographs_apart(folder: Path, *, megapixels: float, count: int) -> None:
    """As `write_photographs`, by another process: a child's peak counts what its parent took before."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as apart:
        apart.submit(write_photographs, folder, megapixels=megapixels, count=count).result()


def timed(job: Callable[[], object], *, times: int = 1) -> tuple[float, float]:
    """Seconds of the processor and elapsed, of the quickest run."""
    runs = []
    for _ in range(times):
        start = time.process_time(), time.perf_counter()
        job()
        runs.append((time.process_time() - start[0], time.perf_counter() - start[1]))
    return min(runs)


def decode_in_one_thread(folder: Path) -> None:
    """Decode all photographs with OpenCV."""
    cv2.setNumThreads(1)
    for path in sorted(folder.glob("*.png")):
        cv2.imread(str(path), cv2.IMREAD_UNCHANGED)


def run(name: str, folder: Path, out: Path, *options: str) -> tuple[float, float, float, float]:
    """Seconds of the processor and elapsed of a command, its peak memory in GB, and MB written."""
    start = time.perf_counter()
    command = [sys.executable, "-m", "rumu.cli", name, str(folder), "-o", str(out), "--json", *options]
    process = subprocess.Popen(command, stdout=subprocess.PIPE)
    assert process.stdout is not None
    answer = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise SystemExit(json.loads(answer)["error"])
    written = sum(file.stat().st_size for file in (out.iterdir() if out.is_dir() else [out])) / 1e6
    peak = usage.ru_maxrss * 1024 / 1e9
    return usage.ru_utime + usage.ru_stime, time.perf_counter() - start, peak, written


def large_photographs(megapixels: float, count: int) -> None:
    """One line for decoding, one for each solver, and one for each relightable image."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "photographs"
        folder.mkdir()
        write_photographs_apart(folder, megapixels=megapixels, count=count)
        print(f"\n{count} photographs of {megapixels:g} MP, 8-bit PNG, {CORES} cores", flush=True)
        print(f"  {'':<28}{'cpu s':>8}{'elapsed':>9}{'GB':>7}{'MB written':>12}   times the decoding")
        decoded = timed(lambda: decode_in_one_thread(folder))
        print(f"  {'OpenCV decodes, one thread':<28}{decoded[0]:8.1f}{decoded[1]:9.1f}", flush=True)
        for what, command, out, *options in COMMANDS:
            cpu, elapsed, peak, written = run(command, folder, Path(place) / out, *options)
            print(
                f"  {'rumu ' + what:<28}{cpu:8.1f}{elapsed:9.1f}{peak:7.2f}{written:12.0f}   "
                f"{elapsed / decoded[1]:.1f} elapsed, {cpu / CORES / decoded[0]:.1f} by cpu over the cores",
                flush=True,
            )


def small_captures() -> None:
    """The bunny's photographs, solved by the kernels and by NumPy."""
    capture = read_capture(DATA / "photometric" / "bunny" / "bunny_lambert")
    values = capture.photographs.at(np.flatnonzero(capture.mask))
    print("\nbunny 256 x 256 x 50               cpu s   elapsed   NumPy cpu s   factor")
    for solver in robust.SOLVERS:
        options = {"solver": solver, "black_level": 0.0, "settings": RobustSettings()}
        kernels = timed(
            lambda solver=solver: solve(
                capture.photographs, capture.lights, solver=solver, mask=capture.mask
            ),
            times=5,
        )
        numpy = timed(lambda options=options: robust.solve_tile(values, capture.lights, **options))
        tile = timed(lambda options=options: compiled.solve_tile(values, capture.lights, **options), times=3)
        print(
            f"  {solver:<30}{kernels[0]:8.3f}{kernels[1]:10.3f}{numpy[0]:14.3f}{numpy[0] / tile[0]:9.0f}",
            flush=True,
        )
    checked = timed(lambda: surface_normals(capture), times=15)
    print(f"  {'robust, with all checks':<30}{checked[0]:8.3f}{checked[1]:10.3f}", flush=True)


def glossy_capture() -> None:
    """A relief that is glossy everywhere, so that every pixel is searched under each of its materials."""
    side = 512
    y, x = np.mgrid[:side, :side] * (12 / side)
    normals = from_slopes(0.5 * np.cos(x) * np.cos(0.75 * y), 0.4 * np.sin(x) * np.sin(0.75 * y))
    lights = spread_lamps(20)
    images = photograph_material(normals, lights, "Phong, exponent 20").astype(np.float32)
    materials = find_materials(images, lights, mask=np.ones((side, side), bool))
    plain, other = (
        timed(lambda m=m: solve(images, lights, materials=m), times=3)[0] for m in ((), materials)
    )
    print(f"\nglossy {side} x {side} x 20, robust     cpu s")
    print(f"  {'by Lambert':<30}{plain:8.3f}")
    print(f"  {f'under {len(materials)} materials':<30}{other:8.3f}   {other / plain:.1f} times")


def masked_integration() -> None:
    """A blob with weights of noise, so that the preconditioner is not exact."""
    print("\nmasked integration                 cpu s   elapsed")
    for side in (512, 3200):
        r, c = np.ogrid[:side, :side]
        angle = np.arctan2(r - side / 2, c - side / 2)
        blob = np.hypot(r - side / 2, c - side / 2) < side * (0.35 + 0.08 * np.sin(6 * angle))
        slope = 0.3 * np.cos(40 * np.pi * (r + c) / side) * np.ones((side, side))
        normals = np.dstack([-slope, slope, np.ones_like(slope)]).astype(np.float32)
        normals /= np.linalg.norm(normals, axis=2, keepdims=True)
        weights = np.random.default_rng(0).uniform(0.3, 1, (side, side)).astype(np.float32)
        for name, trust in (("", None), (" with weights", weights)):
            cpu, elapsed = timed(
                lambda n=normals, m=blob, w=trust: integrate(n, mask=m, weights=w),
                times=3 if side < 1000 else 1,
            )
            print(f"  {f'{side} x {side}{name}':<30}{cpu:8.3f}{elapsed:10.3f}", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--megapixels", type=float, default=24)
    parser.add_argument("--photographs", type=int, default=20)
    parser.add_argument("--large", action="store_true", help="also 60 photographs of 100 megapixels")
    given = parser.parse_args()
    small_captures()
    glossy_capture()
    masked_integration()
    large_photographs(given.megapixels, given.photographs)
    if given.large:
        large_photographs(100, 60)
