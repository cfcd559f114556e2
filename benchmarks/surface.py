"""How fast and how exact the surfaces are: `python benchmarks/surface.py`.

Times are the best of three. Angles are mean errors in degrees against known normals, for each solver and
data set. Ink is found with our Otsu threshold and with scikit-image's, to say what that would change.
The data is in RUMU_DATA (default: ../shared/data beside the checkout).
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image

from rumu.capture.dome import without_fall_off
from rumu.capture.folder import read_capture
from rumu.image_stack import ImageStack
from rumu.surface.beyond_lambert import find_materials
from rumu.surface.integrate import integrate
from rumu.surface.lamp_positions import place_lamps
from rumu.surface.near_lamps import solve_near
from rumu.surface.photometric import photometric, surface_normals
from rumu.surface.robust import SOLVERS
from rumu.surface.solve import solve
from rumu.surface.strengths import estimate_photometry
from rumu.values import Capture
from rumu_lab.simulation.lamps import NearLamp, from_slopes, normals_of, render
from rumu_lab.simulation.reflectances import REFLECTANCES, photograph_material, spread_lamps

DATA = Path(os.environ.get("RUMU_DATA", Path(__file__).parents[1] / ".." / "shared" / "data")).resolve()
PHOTOS = DATA / "photometric"


def best_of(job: Callable[[], object], *, times: int = 3) -> float:
    """Seconds of the quickest run."""
    seconds = []
    for _ in range(times):
        start = time.perf_counter()
        job()
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def waves(size: int) -> np.ndarray:
    """(size, size, 3) float32 normals of a sheet of smooth random relief."""
    rng = np.random.default_rng(0)
    r, c = np.mgrid[:size, :size] / size
    p, q = np.zeros((size, size)), np.zeros((size, size))
    for k, m, phase in zip(rng.integers(1, 12, 9), rng.integers(1, 12, 9), rng.uniform(0, 6, 9), strict=True):
        slope = 0.1 * np.cos(2 * np.pi * (k * c + m * r) + phase)
        p, q = p + k / 12 * slope, q - m / 12 * slope
    n = np.dstack([-p, -q, np.ones_like(p)])
    return (n / np.linalg.norm(n, axis=2, keepdims=True)).astype(np.float32)


def integration() -> None:
    print("integration                         seconds")
    large, small = waves(2048), waves(512)
    r, c = np.ogrid[:512, :512]
    blob = np.hypot(r - 256, c - 256) < 180 + 40 * np.sin(6 * np.arctan2(r - 256.0, c - 256.0))
    for name, job in {
        "dct 2048 x 2048": lambda: integrate(large, method="dct"),
        "frankot_chellappa 2048 x 2048": lambda: integrate(large, method="frankot_chellappa"),
        "masked 512 x 512": lambda: integrate(small, mask=blob, method="masked"),
    }.items():
        print(f"  {name:<34}{best_of(job):7.3f}")


def circle_normals(mask: np.ndarray) -> np.ndarray:
    """(H, W, 3) normals of the sphere whose outline the mask is."""
    rows, columns = np.nonzero(mask)
    cx, cy = (columns.min() + columns.max()) / 2, (rows.min() + rows.max()) / 2
    radius = (np.ptp(columns) + np.ptp(rows) + 2) / 4
    r, c = np.indices(mask.shape)
    x, y = (c - cx) / radius, (cy - r) / radius
    return np.dstack([x, y, np.sqrt(np.clip(1 - x * x - y * y, 0, None))])


def known() -> dict[str, tuple[Capture, np.ndarray, np.ndarray]]:
    """Captures whose normals are known: capture, normals, where they are compared."""
    truth = np.load(PHOTOS / "bunny" / "normals_gt.npy")
    sets = {}
    for name in ("bunny_lambert", "bunny_lambert_noshadow"):
        capture = read_capture(PHOTOS / "bunny" / name)
        sets[name] = (capture, truth, capture.mask)
    gray = read_capture(PHOTOS / "uw-psm" / "gray")
    ball = circle_normals(gray.mask)
    sets["uw-psm/gray"] = (gray, ball, gray.mask & (ball[..., 2] > 0.4))
    relief = read_capture(PHOTOS / "synthrti-relief" / "train49")
    painted = np.asarray(Image.open(PHOTOS / "synthrti-relief" / "train49" / "normals.png").convert("RGB"))
    sets["synthrti-relief"] = (relief, painted / 127.5 - 1.0, relief.mask)
    return sets


def degrees_off(normals: np.ndarray, truth: np.ndarray, where: np.ndarray) -> float:
    cosine = (normals[where] * truth[where]).sum(axis=1) / np.linalg.norm(truth[where], axis=1)
    return float(np.degrees(np.arccos(np.clip(cosine, -1, 1))).mean())


def angular_errors() -> dict[str, dict[str, float]]:
    """Mean error in degrees of each solver, and its residual in per cent where normals are unknown."""
    table = {}
    for name, (capture, truth, where) in known().items():
        table[name] = {
            solver: degrees_off(surface_normals(capture, solver=solver)[0], truth, where)
            for solver in SOLVERS
        }
    cat = read_capture(PHOTOS / "psbox-cat")
    residuals = {solver: 100 * surface_normals(cat, solver=solver)[3]["residual"] for solver in SOLVERS}
    return table | {"psbox-cat, residual %": residuals}


def accuracy() -> None:
    print("\nmean angular error, degrees     " + "".join(f"{solver:>15}" for solver in SOLVERS))
    for name, row in angular_errors().items():
        print(f"  {name:<30}" + "".join(f"{row[solver]:15.2f}" for solver in SOLVERS))


def lamberts_law_alone(capture: Capture) -> np.ndarray:
    """Normals by the robust solver without other materials."""
    found = estimate_photometry(
        capture.photographs, capture.lights, mask=capture.mask, strengths=capture.strengths
    )
    lights = capture.lights * found.strengths[:, None]
    return solve(capture.photographs, lights, mask=capture.mask, black_level=found.black_level).normals


def other_materials() -> None:
    """Mean errors of "robust" with Lambert's law alone, and with the materials that it finds beside it."""
    print("\nmaterials beside Lambert's: mean error in degrees without, with; how many")
    for name, (capture, truth, where) in known().items():
        normals, _, _, quality = surface_normals(capture)
        before = degrees_off(lamberts_law_alone(capture), truth, where)
        print(
            f"  {name:<30}{before:9.2f}{degrees_off(normals, truth, where):9.2f}{quality['materials']:5.0f}"
        )
    side = 96
    y, x = (((side - 1) / 2 - np.mgrid[:side, :side]) / (side / 2)) * [[[1.0]], [[-1.0]]]
    z = np.sqrt(np.clip(1 - x * x - y * y, 0.1, None))
    ball, on_ball = np.dstack([x, y, z]), np.hypot(x, y) < 0.93
    ball /= np.linalg.norm(ball, axis=2, keepdims=True)
    relief = from_slopes(0.5 * np.cos(6 * x) * np.cos(4.5 * y), 0.4 * np.sin(6 * x) * np.sin(4.5 * y))
    surfaces = {"ball": (ball, on_ball), "relief": (relief, np.ones((side, side), bool))}
    print(f"  {'simulated, lamps':<30}" + "".join(f"{s + f', {n}':>21}" for s in surfaces for n in (12, 48)))
    for name in REFLECTANCES:
        line = f"  {name:<30}"
        for truth, where in surfaces.values():
            for count in (12, 48):
                lights = spread_lamps(count)
                images = photograph_material(truth, lights, name)
                materials = find_materials(images, lights, mask=where)
                before, after = (
                    degrees_off(solve(images, lights, mask=where, materials=m).normals, truth, where)
                    for m in ((), materials)
                )
                line += f"{before:9.2f}{after:9.2f}{len(materials):3d}"
        print(line)


def solving() -> None:
    print("\nsolving                             seconds")
    bunny = read_capture(PHOTOS / "bunny" / "bunny_lambert")
    for solver in SOLVERS:
        seconds = best_of(lambda solver=solver: surface_normals(bunny, solver=solver))
        print(f"  bunny 256 x 256 x 50, {solver:<12}{seconds:7.2f}")
    cat = read_capture(PHOTOS / "psbox-cat")
    print(f"  psbox-cat 430 x 550 x 12, to height {best_of(lambda: photometric(cat), times=1):5.2f}")


def thresholds() -> None:
    """Every third E3C picture and the starter works: by how much scikit-image's threshold changes the ink."""
    from skimage.filters import threshold_otsu

    from rumu.capture.image import read_image
    from rumu.errors import RefusedImage
    from rumu.gallery.starter import starter_works
    from rumu.surface import ink, paper

    ours = paper.otsu_threshold
    off: list[float] = []

    def theirs(counts: np.ndarray) -> float:
        if np.count_nonzero(counts) < 2:  # where scikit-image raises
            return ours(counts)
        threshold = float(threshold_otsu(hist=(counts, np.arange(256.0)))) + 0.5
        off.append(abs(threshold - ours(counts)))
        return threshold

    files = sorted((DATA / "e3c").rglob("*.png"))[::3] + [work.path for work in starter_works()]
    changed, seen = 0, 0
    for file in files:
        try:
            one = ink.find_ink(read_image(file))
            paper.otsu_threshold = ink.otsu_threshold = theirs
            other = ink.find_ink(read_image(file))
        except RefusedImage:
            continue
        finally:
            paper.otsu_threshold = ink.otsu_threshold = ours
        seen += 1
        changed += not np.array_equal(one.density, other.density)
    print(f"\nscikit-image's threshold: another ink in {changed} of {seen} pictures,")
    print(f"  thresholds up to {max(off):.1f} gray levels apart")


def near_lamps() -> None:
    """A simulated relief, 2 % of its side high, under eight lamps at slants of 35 and 45 degrees."""
    print("\nnear lamps, robust: mean and largest error in degrees; placed: from their directions alone")
    print("  sheet sides away    as far lamps     without fall-off      near lamps      placed")
    side = 160
    y, x = np.mgrid[:side, :side]
    height = np.sin(x / 9.0) * np.cos(y / 11.0) + 0.6 * np.sin(x / 3.3 + y / 5)
    truth, whole = normals_of(height), np.ones((side, side), bool)
    for away in (1.0, 1.5, 3.0):
        tilt, slant = np.arange(8) * np.pi / 4, np.radians([45, 35] * 4)
        lights = np.stack([np.cos(tilt) * np.sin(slant), np.sin(tilt) * np.sin(slant), np.cos(slant)], axis=1)
        positions = away * side * lights
        lamps = [NearLamp(tuple(one), strength=0.5) for one in positions]
        stack = ImageStack.of_arrays([render(height, 0.8, lamp=one, cast_shadows=False) for one in lamps])
        even = without_fall_off(stack, positions)
        told = Capture(images=stack, lights=lights, mask=whole)  # type: ignore[arg-type]
        placed = place_lamps(told)
        line = f"  {away:<16g}"
        for found in (
            solve(stack, lights),
            solve(even, lights),
            solve_near(even, lights, positions, solver="robust", mask=whole),
            surface_normals(placed)[0],
        ):
            normals = found if isinstance(found, np.ndarray) else found.normals
            error = np.degrees(np.arccos(np.clip((normals * truth).sum(axis=2), -1, 1)))
            line += f"{error.mean():9.2f}{error.max():9.2f}"
        print(line)


if __name__ == "__main__":
    integration()
    near_lamps()
    accuracy()
    other_materials()
    solving()
    thresholds()
