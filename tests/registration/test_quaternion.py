"""The closed-form pose, against scipy's rotations and against what the paper's matrices must satisfy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from rumu.errors import RegistrationError, RumuError
from rumu.registration.quaternion import (
    Pose,
    closed_form_pose,
    cross_covariance,
    mean_squared_distance,
    profile_matrix,
    rotation_matrix,
    unit_quaternion,
)

unit = arrays(float, 4, elements=st.floats(-1, 1)).filter(lambda q: np.linalg.norm(q) > 0.05)
matrices = arrays(float, (3, 3), elements=st.floats(-10, 10))
shifts = arrays(float, 3, elements=st.floats(-50, 50))
seeds = st.integers(0, 2**32 - 1)


def scipy_matrix(q: np.ndarray) -> np.ndarray:
    return Rotation.from_quat([q[1], q[2], q[3], q[0]]).as_matrix()


def cloud(seed: int, n: int = 40) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(n, 3)) * (3.0, 2.0, 0.5)


@given(unit)
def test_the_rotation_is_scipys(q):
    R = rotation_matrix(unit_quaternion(q))
    np.testing.assert_allclose(R, scipy_matrix(q), atol=1e-12)
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0, abs=1e-12)


@given(unit)
def test_a_quaternion_and_its_negative_become_one(q):
    assume(abs(q[0]) > 1e-9)
    one, other = unit_quaternion(q), unit_quaternion(-q)
    np.testing.assert_array_equal(one, other)
    assert one[0] >= 0
    assert np.linalg.norm(one) == pytest.approx(1.0)


def test_a_quarter_turn_about_z_goes_counter_clockwise():
    half = np.pi / 4
    R = rotation_matrix(np.array([np.cos(half), 0.0, 0.0, np.sin(half)]))
    np.testing.assert_allclose(R @ (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), atol=1e-15)


@pytest.mark.parametrize("q", [np.zeros(4), np.full(4, np.nan), np.array([np.inf, 0, 0, 0])])
def test_no_quaternion_comes_from_nothing(q):
    with pytest.raises(RegistrationError, match="expected a quaternion of non-zero length, got"):
        unit_quaternion(q)


@given(unit, matrices)
def test_the_quadratic_form_is_the_trace(q, S):
    q = unit_quaternion(q)
    assert q @ profile_matrix(S) @ q == pytest.approx(np.trace(rotation_matrix(q) @ S), abs=1e-9)


@given(matrices)
def test_the_profile_matrix_is_symmetric_and_has_no_trace(S):
    Q = profile_matrix(S)
    np.testing.assert_array_equal(Q, Q.T)
    assert np.trace(Q) == pytest.approx(0.0, abs=1e-9)


def test_the_covariance_has_p_first():
    P, X = cloud(1), cloud(2)
    mu_p, mu_x, S = cross_covariance(P, X)
    np.testing.assert_allclose(mu_p, P.mean(axis=0))
    np.testing.assert_allclose(mu_x, X.mean(axis=0))
    by_hand = sum(np.outer(p - mu_p, x - mu_x) for p, x in zip(P, X, strict=True)) / len(P)
    np.testing.assert_allclose(S, by_hand, atol=1e-12)
    assert not np.allclose(S, S.T, atol=1e-3)  # or the next test could not tell


def test_a_transposed_covariance_gives_the_inverse_rotation():
    R = scipy_matrix(np.array([0.9, 0.2, -0.3, 0.2]))
    P = cloud(3)
    _, _, S = cross_covariance(P, P @ R.T)
    of = lambda M: rotation_matrix(unit_quaternion(np.linalg.eigh(profile_matrix(M))[1][:, -1]))  # noqa: E731
    np.testing.assert_allclose(of(S), R, atol=1e-9)
    np.testing.assert_allclose(of(S.T), R.T, atol=1e-9)
    assert not np.allclose(R, R.T, atol=0.1)


@given(unit, shifts, seeds)
def test_any_pose_is_found_exactly(q, t, seed):
    P = cloud(seed)
    R = scipy_matrix(q)
    pose = closed_form_pose(P, P @ R.T + t, rotation="full")
    np.testing.assert_allclose(pose.matrix[:3, :3], R, atol=1e-7)
    np.testing.assert_allclose(pose.matrix[:3, 3], t, atol=1e-6)
    np.testing.assert_array_equal(pose.matrix[3], (0.0, 0.0, 0.0, 1.0))
    assert pose.d_ms == pytest.approx(0.0, abs=1e-9)


@given(st.floats(-179.9, 179.9), shifts, seeds)
def test_a_turn_in_the_plane_is_found_exactly(angle, t, seed):
    P = cloud(seed)
    R = Rotation.from_euler("z", angle, degrees=True).as_matrix()
    T = closed_form_pose(P, P @ R.T + t, rotation="z").matrix
    np.testing.assert_allclose(T[:3, :3], R, atol=1e-7)
    np.testing.assert_allclose(T[:3, 3], t, atol=1e-6)


@given(seeds, seeds)
def test_rotation_about_z_never_tilts(seed, other):
    """Even for clouds that have nothing to do with each other."""
    pose = closed_form_pose(cloud(seed), cloud(other), rotation="z")
    np.testing.assert_array_equal(pose.quaternion[1:3], 0.0)
    np.testing.assert_allclose(pose.matrix[2, :3], (0.0, 0.0, 1.0), atol=1e-14)
    np.testing.assert_allclose(pose.matrix[:3, 2], (0.0, 0.0, 1.0), atol=1e-14)


@given(seeds)
def test_rotation_about_z_is_the_best_in_the_plane(seed):
    """No turn of a fine sweep leaves less than the closed form does."""
    P, X = cloud(seed), cloud(seed // 2 + 1)
    pose = closed_form_pose(P, X, rotation="z")
    swept = []
    for half in np.deg2rad(np.arange(-180, 180, 2.0)) / 2:
        q = np.array([np.cos(half), 0.0, 0.0, np.sin(half)])
        t = X.mean(axis=0) - rotation_matrix(q) @ P.mean(axis=0)
        swept.append(mean_squared_distance(P, X, pose=Pose(q, t, np.inf)))
    assert pose.d_ms <= min(swept) + 1e-9
    assert pose.d_ms >= min(swept) - 0.05  # two degrees of a sweep cannot miss it by more


@given(seeds, st.sampled_from(["z", "full"]))
def test_what_is_left_follows_from_the_eigenvalue(seed, rotation):
    """d_ms = tr Spp + tr Sxx - 2 lambda_max is the mean squared distance, without another pass."""
    rng = np.random.default_rng(seed)
    P = cloud(seed)
    X = P[:, [1, 0, 2]] + rng.normal(size=P.shape)
    pose = closed_form_pose(P, X, rotation=rotation)
    assert pose.d_ms == pytest.approx(mean_squared_distance(P, X, pose=pose), rel=1e-9)
    assert pose.d_ms > 0.1


@given(seeds)
def test_full_rotation_is_scipys_best(seed):
    P, X = cloud(seed), cloud(seed // 3 + 7)
    _, left = Rotation.align_vectors(X - X.mean(axis=0), P - P.mean(axis=0))
    pose = closed_form_pose(P, X, rotation="full")
    assert pose.d_ms == pytest.approx(left**2 / len(P), rel=1e-6)
    assert np.linalg.det(pose.matrix[:3, :3]) == pytest.approx(1.0)


@given(seeds, st.sampled_from(["z", "full"]))
def test_a_mirrored_target_is_not_reached_by_mirroring(seed, rotation):
    P = cloud(seed)
    pose = closed_form_pose(P, P * (-1.0, 1.0, 1.0), rotation=rotation)
    assert np.linalg.det(pose.matrix[:3, :3]) == pytest.approx(1.0, abs=1e-9)
    assert pose.d_ms > 1e-3


@pytest.mark.parametrize("rotation", ["z", "full"])
@pytest.mark.parametrize(
    "P",
    [np.outer(np.arange(5.0), (1.0, 2.0, 3.0)), np.outer(np.arange(5.0), (0.0, 0.0, 1.0)), np.ones((4, 3))],
    ids=["a line", "a line along z", "one place"],
)
def test_degenerate_points_still_get_a_rigid_pose(P, rotation):
    t = np.array([1.0, -2.0, 0.5])
    pose = closed_form_pose(P, P + t, rotation=rotation)
    R = pose.matrix[:3, :3]
    assert np.isfinite(pose.matrix).all()
    assert np.linalg.det(R) == pytest.approx(1.0)
    np.testing.assert_allclose(P @ R.T + pose.translation, P + t, atol=1e-9)


@pytest.mark.parametrize(
    ("P", "X"),
    [((2, 3), (2, 3)), ((5, 3), (4, 3)), ((5, 2), (5, 2)), ((15,), (15,))],
)
def test_unmatched_sets_are_refused(P, X):
    with pytest.raises(RumuError, match=r"expected two matched \(N >= 3, 3\) point sets, got \("):
        closed_form_pose(np.zeros(P), np.zeros(X))
