"""From two picture files to a score: `rumu.assess` beside the same job built on Open3D's ICP, in one run.

`OMP_NUM_THREADS=1 python benchmarks/assess.py`, with one thread as workers have it, prints medians of
processor time, which other work on the machine moves less than the clock, with and without remarks, for a
new master and for one that was there before, the ratio, and the pose error of both, so that neither is quick
by being wrong. The peer reads the same pictures with Pillow, separates ink from paper by Otsu's threshold,
takes heights from OpenCV's distance transform, and starts Open3D's point-to-point ICP from the same five
angles.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

import rumu
from rumu.gallery.starter import find_work
from rumu.registration.icp import IcpSettings
from rumu.registration.points import sample_points
from rumu_lab.simulation import faults

WORKS = ("regular-shui", "regular-shu", "clerical-tian", "running-yue", "cursive-shu")
LEANS = (-11.0, 0.0, 7.0)
ROUNDS = 3
Pair = tuple[Path, Path, float]
Outcome = tuple[float, float]
"""Score and angle."""


def make_pairs(folder: Path) -> list[Pair]:
    """Copies of 512 x 512 with a fault, leaning by a known angle, and their masters."""
    pairs = []
    for work in WORKS:
        for lean in LEANS:
            master = np.asarray(Image.open(find_work(work).path))
            ink = faults.apply(master < 128, "wobble", severity=1, seed=1).ink  # leaves the true pose known
            M = cv2.getRotationMatrix2D((255.5, 255.5), -lean, 1.0)
            copy = 245 - 220 * cv2.warpAffine(ink, M, (512, 512))
            paths = folder / f"{work}{lean:+.0f}.png", folder / f"{work}.png"
            Image.fromarray(np.rint(copy).astype(np.uint8)).save(paths[0])
            Image.fromarray(master).save(paths[1])
            pairs.append((*paths, lean))
    return pairs


def with_rumu(copy: Path, master: Path, *, remarks: bool = True, known: bool = False) -> Outcome:
    """known: whether the master was prepared for the copies before, as that of a path is; else it is new."""
    reference = master if known else np.asarray(Image.open(master))
    assessment = rumu.assess(copy, reference, remarks=remarks)
    return assessment.score, assessment.registration.angle


def cloud_of_file(path: Path) -> np.ndarray:
    """Every ink pixel as a point, centred, in rms radii."""
    gray = np.asarray(Image.open(path).convert("L"))
    _, ink = cv2.threshold(gray, 0, 255, cv2.THRESH_BINARY_INV | cv2.THRESH_OTSU)
    height = cv2.distanceTransform(ink, cv2.DIST_L2, 5)
    rows, columns = np.nonzero(ink)
    points = np.column_stack([columns, -rows, height[rows, columns]]).astype(float)
    points[:, :2] -= points[:, :2].mean(axis=0)
    radius = np.sqrt((points[:, :2] ** 2).sum(axis=1).mean())
    return points / (radius, radius, 0.1 * radius)


def with_open3d(source: np.ndarray, target: np.ndarray, *, voxel: float | None = None) -> Outcome:
    """Five starts, the best by inlier error, and the paper's similarity in place of a score."""
    import open3d as o3d

    registration = o3d.pipelines.registration
    clouds = [o3d.geometry.PointCloud(o3d.utility.Vector3dVector(p)) for p in (source, target)]
    if voxel:
        clouds = [cloud.voxel_down_sample(voxel) for cloud in clouds]
    best = None
    for start in IcpSettings().start_angles:
        T = np.eye(4)
        T[:3, :3] = o3d.geometry.get_rotation_matrix_from_xyz((0.0, 0.0, np.deg2rad(start)))
        found = registration.registration_icp(
            *clouds, 1.0, T, registration.TransformationEstimationPointToPoint()
        )
        if best is None or found.inlier_rmse < best.inlier_rmse:
            best = found
    frobenius = np.linalg.norm(np.asarray(clouds[1].points))
    R = best.transformation
    return float(100 * (1 - best.inlier_rmse**2 / frobenius)), float(np.rad2deg(np.arctan2(R[1, 0], R[0, 0])))


def peer_every_pixel(copy: Path, master: Path) -> Outcome:
    return with_open3d(cloud_of_file(copy), cloud_of_file(master))


def peer_thinned(copy: Path, master: Path) -> Outcome:
    return with_open3d(cloud_of_file(copy), cloud_of_file(master), voxel=0.08)


def peer_on_our_points(copy: Path, master: Path) -> Outcome:
    points = [sample_points(rumu.relief(path)).xyz for path in (copy, master)]
    return with_open3d(*points)


def time_and_error(job: Callable[[Path, Path], Outcome], every: list[Pair]) -> tuple[float, float, float]:
    """Median milliseconds of processor time; median and worst error of the angle in degrees."""
    for copy, master, _ in every:
        job(copy, master)
    times, errors = [], []
    for _ in range(ROUNDS):
        for copy, master, lean in every:
            began = time.process_time()
            _, angle = job(copy, master)
            times.append(1e3 * (time.process_time() - began))
            errors.append(abs(angle - lean))
    return float(np.median(times)), float(np.median(errors)), float(np.max(errors))


def seconds(*command: str) -> float:
    """Best of five runs of a command in a new process."""
    times = []
    for _ in range(5):
        began = time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        times.append(time.perf_counter() - began)
    return min(times)


def main() -> None:
    cv2.setNumThreads(1)  # as in tables and in the service; several would be counted together
    jobs = [
        (f"rumu.assess{alone}, {state} master", partial(with_rumu, remarks=not alone, known=state == "known"))
        for alone in ("", ", the mark alone")
        for state in ("new", "known")
    ]
    try:
        import open3d

        name = f"Open3D {open3d.__version__}"
        jobs += [
            (f"{name}, every ink pixel", peer_every_pixel),
            (f"{name}, voxels of 0.08 rms radii", peer_thinned),
            (f"{name}, rumu's ink, relief and points", peer_on_our_points),
        ]
    except ImportError:
        print("open3d is not installed: no peer beside")
    with tempfile.TemporaryDirectory() as folder:
        every = make_pairs(Path(folder))
        print(f"{len(every)} pairs of 512 x 512, files to score, {ROUNDS} rounds")
        print(f"{'':44s}{'ms':>9s}{'deg':>8s}{'worst':>8s}{'x rumu':>9s}")
        ours = 0.0
        for name, job in jobs:
            ms, middle, worst = time_and_error(job, every)
            ours = ours or ms
            print(f"{name:44s}{ms:9.1f}{middle:8.2f}{worst:8.2f}{ms / ours:9.1f}")
    bare = seconds(sys.executable, "-c", "pass")
    for words in (("-c", "import rumu"), ("-m", "rumu.cli", "--help")):
        extra = 1e3 * (seconds(sys.executable, *words) - bare)
        print(f"python {' '.join(words):37s}{extra:9.1f} ms more than python alone")


if __name__ == "__main__":
    main()
