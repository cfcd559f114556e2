"""Constructed surfaces and marks: pages are tested on values whose truth is known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt
from scipy.spatial import cKDTree

from rumu.values import Assessment, PointSet, Registration, Remark, Surface


def relief_of(ink: np.ndarray) -> Surface:
    """A half-round relief over `ink`, made without the code that computes reliefs."""
    depth = distance_transform_edt(ink)
    reach = max(float(depth.max()), 1.0)
    height = np.sqrt(np.maximum(reach**2 - (reach - depth) ** 2, 0)).astype(np.float32)
    drow, dcol = np.gradient(height)
    normals = np.dstack([-dcol, drow, np.ones_like(height)])
    normals = (normals / np.linalg.norm(normals, axis=2, keepdims=True)).astype(np.float32)
    return Surface(
        height=height,
        normals_from=normals,
        albedo_from=np.where(ink, 0.05, 0.9).astype(np.float32),
        mask=ink,
        confidence=ink.astype(np.float32),
        spacing=1.0,
        unit="px",
        source="inflation",
        quality={"ink_share": float(ink.mean())},
    )


def cross(*, side: int = 96, width: int = 10, bar: bool = True, foot: int = 0) -> np.ndarray:
    """十 as ink: a standing stroke, shifted right by `foot`, and with `bar` a lying one."""
    ink = np.zeros((side, side), dtype=bool)
    middle, half = side // 2, width // 2
    ink[side // 8 : -side // 8, middle - half + foot : middle + half + foot] = True
    if bar:
        ink[middle - half : middle + half, side // 8 : -side // 8] = True
    return ink


def points_of(ink: np.ndarray) -> PointSet:
    rows, columns = np.nonzero(ink)
    height, width = ink.shape
    xy = np.stack([columns + 0.5 - width / 2, height / 2 - rows - 0.5], axis=1) / max(ink.shape)
    centre = xy.mean(axis=0)
    radius = float(np.sqrt(((xy - centre) ** 2).sum(axis=1).mean()))
    xyz = np.column_stack([(xy - centre) / radius, np.zeros(len(xy))])
    return PointSet(xyz, np.zeros((len(xy), 2)), centre, radius, 1 / (max(ink.shape) * radius))


def registration_of(copy: np.ndarray, master: np.ndarray) -> Registration:
    """Centroid on centroid, nothing else: enough for a picture."""
    probe, reference = points_of(copy), points_of(master)
    forward, forward_index = cKDTree(reference.xyz).query(probe.xyz)
    backward, backward_index = cKDTree(probe.xyz).query(reference.xyz)
    return Registration(
        probe=probe,
        reference=reference,
        T_reference_probe=np.eye(4),
        scale=probe.radius / reference.radius,
        angle=-3.2,
        shift=np.array([0.021, -0.013]),
        overlap=0.93,
        d_ms=float((forward**2).mean()),
        forward=forward,
        backward=backward,
        forward_index=forward_index,
        backward_index=backward_index,
        converged=True,
        iterations=12,
    )


def assessment_of(copy: np.ndarray, master: np.ndarray) -> Assessment:
    return Assessment(
        score=57.25,
        level="good",
        interval=(44.5, 69.0),
        sim_paper=99.987,
        similarity=0.913,
        parts={"brushwork": 61.0, "structure": 48.5, "ink": 72.0},
        remarks=(
            Remark(
                "lean", 3.2, "deg", 4.0, None, "整字左倾约3°。行笔前先看准中线。", "Leans 3° to the left."
            ),
            Remark(
                "missing", 12.0, "%", 9.0, (0.1, 0.4, 0.9, 0.6), "横画缺失。", "The lying stroke is missing."
            ),
        ),
        registration=registration_of(copy, master),
        source=("inflation", "inflation"),
    )


@pytest.fixture(scope="session")
def master_surface() -> Surface:
    return relief_of(cross())


@pytest.fixture(scope="session")
def copy_surface() -> Surface:
    return relief_of(cross(bar=False, foot=3))


@pytest.fixture(scope="session")
def assessment() -> Assessment:
    return assessment_of(cross(bar=False, foot=3), cross())


@pytest.fixture(scope="session")
def refusal() -> Assessment:
    return Assessment(
        None, None, None, None, None, {}, (), None, None, refused="the page is blank: no ink was found"
    )
