"""The closed-form pose: two matched point sets -> unit quaternion and translation (Besl and McKay 1992)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from rumu.errors import RegistrationError
from rumu.values import FloatArray

Rotation = Literal["z", "full"]


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """x = R(q) p + t.

    quaternion: (4,) unit, q0 >= 0. translation: (3,). d_ms: mean squared distance left over the pairs.
    """

    quaternion: FloatArray
    translation: FloatArray
    d_ms: float

    @property
    def matrix(self) -> FloatArray:
        """(4, 4) homogeneous matrix."""
        T = np.eye(4)
        T[:3, :3] = rotation_matrix(self.quaternion)
        T[:3, 3] = self.translation
        return T


def unit_quaternion(q: FloatArray) -> FloatArray:
    """Eq. (18): |q| = 1 with q0 >= 0, so that each rotation has one quaternion.

    q: (4,) scalar first. Raises RegistrationError for a zero or non-finite quaternion.
    """
    length = float(np.linalg.norm(q))
    if not np.isfinite(length) or length < 1e-12:
        raise RegistrationError(f"expected a quaternion of non-zero length, got {q}")
    return np.asarray(q, dtype=float) / (length if q[0] >= 0 else -length)


def rotation_matrix(q: FloatArray) -> FloatArray:
    """Eq. (19): the rotation of a unit quaternion, (4,) scalar first -> (3, 3), det +1."""
    q0, q1, q2, q3 = q.tolist()  # plain numbers: NumPy's own are slow one by one
    return np.array(
        [
            [q0 * q0 + q1 * q1 - q2 * q2 - q3 * q3, 2 * (q1 * q2 - q0 * q3), 2 * (q1 * q3 + q0 * q2)],
            [2 * (q1 * q2 + q0 * q3), q0 * q0 + q2 * q2 - q1 * q1 - q3 * q3, 2 * (q2 * q3 - q0 * q1)],
            [2 * (q1 * q3 - q0 * q2), 2 * (q2 * q3 + q0 * q1), q0 * q0 + q3 * q3 - q1 * q1 - q2 * q2],
        ]
    )


def mean_squared_distance(P: FloatArray, X: FloatArray, *, pose: Pose) -> float:
    """Eq. (20): f(q) = 1/N sum |x_i - R p_i - t|^2 over matched pairs P, X of (N, 3)."""
    residual = X - P @ rotation_matrix(pose.quaternion).T - pose.translation
    return float(np.mean(np.sum(residual * residual, axis=1)))


def cross_covariance(P: FloatArray, X: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Eq. (21)-(22): centroids mu_p, mu_x and Sigma_px = 1/N sum (p - mu_p)(x - mu_x)^T, p first.

    With p and x exchanged the pose comes out inverted.
    """
    ones = np.full(len(P), 1.0 / len(P))
    mu_p, mu_x = ones @ P, ones @ X
    return mu_p, mu_x, P.T @ X / len(P) - mu_p[:, None] * mu_x


def profile_matrix(S: FloatArray) -> FloatArray:
    """Eq. (23): the symmetric 4 x 4 matrix Q(Sigma_px) with q^T Q q = tr(R(q) Sigma_px)."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = S.tolist()
    t = xx + yy + zz
    return np.array(
        [
            [t, yz - zy, zx - xz, xy - yx],
            [yz - zy, 2 * xx - t, xy + yx, xz + zx],
            [zx - xz, xy + yx, 2 * yy - t, yz + zy],
            [xy - yx, xz + zx, yz + zy, 2 * zz - t],
        ]
    )


def closed_form_pose(P: FloatArray, X: FloatArray, *, rotation: Rotation = "z") -> Pose:
    """Eq. (24): the pose that lays P on X, matched pairs of (N, 3), N >= 3.

    The quaternion is the eigenvector of the largest eigenvalue of Q; t = mu_x - R mu_p. With
    rotation 'z' only (cos a/2, 0, 0, sin a/2) is allowed, so the same problem is solved on the first and
    last row and column of Q: the sheet turns in its plane and is never tilted.
    d_ms follows without another pass: tr Sigma_pp + tr Sigma_xx - 2 q^T Q q (ours, an identity).
    """
    if P.shape != X.shape or P.ndim != 2 or P.shape[1] != 3 or len(P) < 3:
        raise RegistrationError(f"expected two matched (N >= 3, 3) point sets, got {P.shape} and {X.shape}")
    mu_p, mu_x, S = cross_covariance(P, X)
    Q = profile_matrix(S)
    step = 3 if rotation == "z" else 1
    values, vectors = np.linalg.eigh(Q[::step, ::step])
    largest = np.zeros(4)
    largest[::step] = vectors[:, -1]
    q = unit_quaternion(largest)
    spread = float((np.vdot(P, P) + np.vdot(X, X)) / len(P) - mu_p @ mu_p - mu_x @ mu_x)
    return Pose(q, mu_x - rotation_matrix(q) @ mu_p, max(spread - 2.0 * float(values[-1]), 0.0))
