"""ICP on ink: rumu, with OpenCV's k-d tree and with SciPy's, beside Open3D and small_gicp, in one run.

`python benchmarks/registration.py` prints time and pose error, medians over random poses of several works.
All get the same points and the same start. Peers come from the `bench` extra; one that is not installed is
left out, and a line says so.
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from unittest import mock

import cv2
import numpy as np
from PIL import Image
from scipy.spatial import cKDTree

import rumu
from rumu.gallery.starter import find_work
from rumu.registration import icp
from rumu.registration.icp import IcpSettings, Search, register_points
from rumu.registration.points import sample_points
from rumu.values import PointSet, Surface

WORKS = ("regular-shui", "regular-shu", "clerical-tian", "seal-shui", "running-yue", "cursive-shu")
POSES = 5
REACH = 1.0
"""How far Open3D and small_gicp look for a partner, in rms radii; half of it or twice it was no better."""


@dataclass(frozen=True)
class Case:
    """A leaning, shifted copy, its master, and the pose that is right."""

    probe: PointSet
    reference: PointSet
    R: np.ndarray
    t: np.ndarray
    sheets: tuple[np.ndarray, np.ndarray]


def turned(picture: np.ndarray, lean: float) -> np.ndarray:
    h, w = picture.shape
    M = cv2.getRotationMatrix2D(((w - 1) / 2, (h - 1) / 2), -lean, 1.0)
    return cv2.warpAffine(picture, M, (w, h), flags=cv2.INTER_LINEAR, borderValue=255)


def sheet(surface: Surface, points: PointSet, step: int = 4) -> np.ndarray:
    """(N, 3) the whole sheet, blank paper and all, in the frame and unit of the ink points."""
    height, width = surface.height.shape
    rows, columns = np.mgrid[:height:step, :width:step]
    x, y = (columns + 0.5 - width / 2) / max(height, width), (height / 2 - rows - 0.5) / max(height, width)
    z = surface.height[::step, ::step] * points.pixel / 0.1
    return np.column_stack(
        [
            (x.ravel() - points.centre[0]) / points.radius,
            (y.ravel() - points.centre[1]) / points.radius,
            z.ravel(),
        ]
    )


def cases() -> Iterator[Case]:
    rng = np.random.default_rng(0)
    for work in WORKS:
        picture = np.asarray(Image.open(find_work(work).path))
        master = rumu.relief(picture)
        reference = sample_points(master)
        for _ in range(POSES):
            lean, offset = rng.uniform(-15, 15), rng.uniform(-0.15, 0.15, 2)
            copy = rumu.relief(turned(picture, lean))
            own = sample_points(copy)
            moved = np.append(offset, 0.0)
            a = np.deg2rad(lean)
            R = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
            sheets = (sheet(copy, own) + moved, sheet(master, reference))
            yield Case(replace(own, xyz=own.xyz + moved), reference, R, -R @ moved, sheets)


def with_rumu(case: Case) -> np.ndarray:
    settings = IcpSettings(start_angles=(0.0,))
    return register_points(case.probe, case.reference, settings=settings).T_reference_probe


def with_scipy(case: Case, *, workers: int) -> np.ndarray:
    """Our registration with SciPy's k-d tree in place of OpenCV's."""

    def kd_tree(points: np.ndarray, *, with_second: bool) -> Search:
        tree = cKDTree(points)

        def search(queries: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            apart, index = tree.query(queries, k=[1, 2] if with_second else [1], workers=workers)
            return index[:, 0], apart[:, 1] if with_second else np.zeros(len(queries))

        return search

    with mock.patch.object(icp, "kd_tree", kd_tree):
        return with_rumu(case)


def with_open3d(case: Case, *, whole_sheet: bool = False) -> np.ndarray:
    import open3d as o3d

    source, target = case.sheets if whole_sheet else (case.probe.xyz, case.reference.xyz)
    clouds = [o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points)) for points in (source, target)]
    found = o3d.pipelines.registration.registration_icp(
        *clouds, REACH, np.eye(4), o3d.pipelines.registration.TransformationEstimationPointToPoint()
    )
    return np.asarray(found.transformation)


def with_small_gicp(case: Case, *, whole_sheet: bool = False) -> np.ndarray:
    import small_gicp

    source, target = case.sheets if whole_sheet else (case.probe.xyz, case.reference.xyz)
    clouds = [small_gicp.PointCloud(points) for points in (target, source)]
    found = small_gicp.align(
        *clouds, registration_type="ICP", max_correspondence_distance=REACH, max_iterations=40
    )
    return np.asarray(found.T_target_source)


def measured(run: Callable[[Case], np.ndarray], every: list[Case]) -> tuple[float, float, float, float]:
    """Median milliseconds, median and worst rotation error in degrees, median translation error."""
    run(every[0])
    times, turns, shifts = [], [], []
    for case in every:
        began = time.perf_counter()
        T = run(case)
        times.append(1e3 * (time.perf_counter() - began))
        off = (np.trace(case.R.T @ T[:3, :3]) - 1) / 2
        turns.append(np.rad2deg(np.arccos(np.clip(off, -1, 1))))
        shifts.append(np.linalg.norm(T[:3, 3] - case.t))
    return float(np.median(times)), float(np.median(turns)), float(np.max(turns)), float(np.median(shifts))


RUNS: tuple[tuple[str, str | None, Callable[[Case], np.ndarray]], ...] = (
    ("rumu, ink points, both ways, trimmed", None, with_rumu),
    ("rumu, SciPy's cKDTree, one thread", None, lambda c: with_scipy(c, workers=1)),
    ("rumu, SciPy's cKDTree, two threads", None, lambda c: with_scipy(c, workers=2)),
    ("Open3D point-to-point, the same ink points", "open3d", with_open3d),
    ("small_gicp ICP, the same ink points", "small_gicp", with_small_gicp),
    ("Open3D, whole sheet with its blank paper", "open3d", lambda c: with_open3d(c, whole_sheet=True)),
    (
        "small_gicp, whole sheet with its blank paper",
        "small_gicp",
        lambda c: with_small_gicp(c, whole_sheet=True),
    ),
)


def main() -> None:
    every = list(cases())
    turns = [np.rad2deg(np.arccos((np.trace(case.R) - 1) / 2)) for case in every]
    print(
        f"{len(every)} pairs, {np.mean([len(c.probe.xyz) for c in every]):.0f} ink points, "
        f"{len(every[0].sheets[0])} points of sheet; median lean {np.median(turns):.1f} deg, one start"
    )
    print(f"{'':46s}{'ms':>8s}{'deg':>8s}{'worst':>8s}{'shift, rms radii':>18s}")
    for name, module, run in RUNS:
        try:
            if module:
                importlib.import_module(module)
        except ImportError:
            print(f"{name:46s}  not installed")
            continue
        ms, middle, worst, shift = measured(run, every)
        print(f"{name:46s}{ms:8.1f}{middle:8.2f}{worst:8.2f}{shift:18.3f}")


if __name__ == "__main__":
    main()
