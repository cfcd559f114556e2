"""The loop of closest points: known poses come back, and nothing is hidden when they do not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import cdist
from scipy.spatial.transform import Rotation

from rumu.errors import RegistrationError
from rumu.registration.icp import (
    IcpSettings,
    NearestPoint,
    Neighbours,
    closest_points,
    register_points,
    trimmed_share,
)
from rumu.registration.points import Sampling, sample_points
from rumu.registration.quaternion import Pose, unit_quaternion
from rumu.values import PointSet

WORKS = ("regular-shui", "regular-shu", "clerical-tian", "running-yue", "cursive-shu")
angles = st.floats(-25, 25)
pixels = st.floats(-40, 40)


@pytest.fixture(scope="session")
def points(surface):
    """Ink points of a mask."""
    return lambda mask, **options: sample_points(surface(mask), settings=Sampling(**options))


@pytest.fixture(scope="session")
def shui(points, glyph):
    return points(glyph("regular-shui") > 0.5)


def posed(cloud: PointSet, T: np.ndarray) -> np.ndarray:
    return cloud.xyz @ T[:3, :3].T + T[:3, 3]


def turned(cloud: PointSet, R: np.ndarray, t: np.ndarray) -> PointSet:
    """The same ink seen under another pose, points exactly corresponding."""
    a = 2 * np.arctan2(R[1, 0], R[0, 0])
    D = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    return replace(cloud, xyz=cloud.xyz @ R.T + t, direction=cloud.direction @ D.T)


# known poses


@settings(max_examples=12)
@given(lean=angles, x=pixels, y=pixels, work=st.sampled_from(WORKS))
def test_leaning_and_shifted_writing_is_laid_upright(*, points, glyph, moved, work, lean, x, y):
    ink = glyph(work)
    reference = points(ink > 0.5)
    found = register_points(points(moved(ink, lean=lean, shift=(x, y))), reference)
    assert found.converged
    assert found.angle == pytest.approx(lean, abs=0.4)  # a thousand points of strokes ten points wide
    # turned about the middle of the cell, its centroid moves as well
    R = Rotation.from_euler("z", -lean, degrees=True).as_matrix()[:2, :2]
    expected = R @ reference.centre - reference.centre + np.array([x, y]) / 512
    np.testing.assert_allclose(found.shift, expected, atol=0.003)
    assert found.scale == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("work", WORKS)
def test_leaning_is_found_within_a_fifth_of_a_degree_on_the_whole(points, glyph, moved, work):
    ink = glyph(work)
    reference = points(ink > 0.5)
    leans = np.linspace(-24.3, 24.7, 8)
    found = [register_points(points(moved(ink, lean=lean)), reference).angle for lean in leans]
    assert np.sqrt(np.mean((found - leans) ** 2)) < 0.2


@pytest.mark.parametrize("lean", [-17.0, 9.0, 25.0])
def test_a_ring_is_turned_upright_less_surely(points, glyph, moved, lean):
    """The ring of seal script slides on itself; only its bar and its corners say how it leans."""
    ink = glyph("seal-ri")
    assert register_points(points(moved(ink, lean=lean)), points(ink > 0.5)).angle == pytest.approx(
        lean, abs=1.5
    )


@settings(max_examples=15)
@given(lean=angles, x=st.floats(-0.3, 0.3), y=st.floats(-0.3, 0.3))
def test_exact_copies_come_back_exactly(shui, lean, x, y):
    R = Rotation.from_euler("z", lean, degrees=True).as_matrix()
    t = np.array([x, y, 0.0])
    found = register_points(turned(shui, R, t), shui)
    np.testing.assert_allclose(found.T_reference_probe[:3, :3], R.T, atol=1e-6)
    np.testing.assert_allclose(found.T_reference_probe[:3, 3], -R.T @ t, atol=1e-6)
    assert found.d_ms == pytest.approx(0.0, abs=1e-9)
    assert found.overlap == 1.0


def test_clockwise_is_positive(points, glyph, moved, shui):
    """Turned by indexing alone, so that no sign of a library enters: a quarter turn clockwise is k=-1."""
    ink = glyph("regular-shui")
    quarter = points(np.ascontiguousarray(np.rot90(ink > 0.5, k=-1)))
    wide = IcpSettings(start_angles=(90.0, -90.0))
    assert register_points(quarter, shui, settings=wide).angle == pytest.approx(90.0, abs=0.3)
    assert register_points(points(moved(ink, lean=8.0)), shui).angle == pytest.approx(8.0, abs=0.3)


@pytest.mark.parametrize(
    ("roll", "shift"), [((0, 30), (30, 0)), ((0, -30), (-30, 0)), ((-20, 0), (0, 20)), ((25, 10), (10, -25))]
)
def test_right_and_up_are_positive_shifts_in_fractions_of_the_cell(points, glyph, shui, roll, shift):
    mask = np.roll(glyph("regular-shui") > 0.5, roll, axis=(0, 1))  # rows grow downward
    found = register_points(points(mask), shui)
    np.testing.assert_allclose(found.shift, np.array(shift) / 512, atol=1e-3)
    assert found.angle == pytest.approx(0.0, abs=0.1)


def test_a_lost_stroke_is_no_shift(points, glyph, shui):
    """The centroid moves, the writing does not."""
    mask = glyph("regular-shui") > 0.5
    mask[:, 300:] = False
    copy = points(mask)
    moved_by = np.hypot(*(copy.centre - shui.centre))
    assert moved_by > 0.05
    assert np.hypot(*register_points(copy, shui).shift) < 0.3 * moved_by


@pytest.mark.parametrize("scale", [0.5, 0.8, 1.1])
def test_size_is_recorded_and_never_in_the_pose(points, glyph, moved, shui, scale):
    found = register_points(points(moved(glyph("regular-shui"), scale=scale)), shui)
    assert found.scale == pytest.approx(scale, rel=0.02)
    R = found.T_reference_probe[:3, :3]
    np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0)


def test_a_mirrored_character_is_turned_and_not_mirrored(points, glyph, shui):
    same = register_points(shui, shui)
    mirrored = register_points(points((glyph("regular-shui") > 0.5)[:, ::-1].copy()), shui)
    assert np.linalg.det(mirrored.T_reference_probe[:3, :3]) == pytest.approx(1.0)
    assert np.mean(mirrored.forward**2) > 4 * np.mean(same.forward**2)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_full_rotation_sets_a_tilted_sheet_level(shui, axis):
    relief = replace(shui, xyz=shui.xyz + np.outer(0.3 * np.sin(2 * shui.xyz[:, 0]), (0, 0, 1)))
    R = Rotation.from_euler(axis + "z", [9.0, 6.0], degrees=True).as_matrix()
    t = np.array([0.1, -0.05, 0.2])
    tilted = replace(relief, xyz=relief.xyz @ R.T + t)
    found = register_points(tilted, relief, settings=IcpSettings(rotation="full", direction_weight=0.0))
    np.testing.assert_allclose(found.T_reference_probe[:3, :3], R.T, atol=2e-3)
    flat = register_points(tilted, relief, settings=IcpSettings(direction_weight=0.0))
    assert flat.d_ms > 10 * found.d_ms  # rotation about z alone cannot
    np.testing.assert_allclose(flat.T_reference_probe[2, :3], (0, 0, 1), atol=1e-12)


# roles, starts, directions


@pytest.mark.parametrize(
    ("copy", "master"),
    [("regular-ren", "running-ren"), ("clerical-tian", "regular-tian"), ("regular-shu", "regular-shui")],
)
@pytest.mark.parametrize("lean", [0.0, 13.0])
def test_swapped_roles_give_the_inverse_pose(*, points, glyph, moved, copy, master, lean):
    P, X = points(moved(glyph(copy), lean=lean)), points(glyph(master) > 0.5)
    there, back = register_points(P, X), register_points(X, P)
    # another hand's writing: when its size is taken anew, each way has the unit of its own reference
    exact = there.overlap > IcpSettings().complete_overlap
    np.testing.assert_allclose(
        there.T_reference_probe @ back.T_reference_probe, np.eye(4), atol=1e-6 if exact else 2e-3
    )
    assert there.scale == pytest.approx(1 / back.scale, rel=1e-6 if exact else 2e-3)
    assert there.angle == pytest.approx(-back.angle, abs=1e-4 if exact else 0.05)
    np.testing.assert_allclose(there.forward, back.backward, atol=1e-6 if exact else 5e-2)
    assert there.overlap == pytest.approx(back.overlap, abs=0.0 if exact else 0.01)


def test_several_starts_find_what_one_does_not(points, glyph):
    upright = reference = points(glyph("regular-shu") > 0.5)
    one, several = (
        register_points(upright, reference, settings=IcpSettings(start_angles=starts))
        for starts in ((170.0,), (170.0, 15.0, -170.0))
    )
    assert abs(one.angle) > 45.0
    assert several.angle == pytest.approx(0.0, abs=0.3)


def test_directions_keep_a_stroke_off_one_that_crosses_it(shui):
    """Pairs agree in direction more often when directions have a weight."""
    near = Neighbours(shui, shui, direction_weight=0.0)
    both = Neighbours(shui, shui, direction_weight=0.7)
    pose = Pose(unit_quaternion(np.array([1.0, 0, 0, 0.05])), np.array([0.15, 0.1, 0.0]), np.inf)
    agree = [
        np.mean(np.sum(shui.direction * shui.direction[n.pairs(pose).forward_index], axis=1))
        for n in (near, both)
    ]
    assert agree[1] > agree[0] + 0.05


def test_no_start_is_no_registration(shui):
    with pytest.raises(RegistrationError, match="at least one starting angle, got none"):
        register_points(shui, shui, settings=IcpSettings(start_angles=()))


# nearest points


@pytest.mark.parametrize("small_steps", [False, True])
@pytest.mark.parametrize("count", [1, 2, 40, 512, 513, 1500])
@pytest.mark.parametrize("step", [0.3, 0.01, 0.0])  # far, near, and not at all
def test_every_answer_is_that_of_brute_force(small_steps, count, step):
    rng = np.random.default_rng(count)
    cloud, asking = rng.normal(size=(count, 5)), rng.normal(size=(700, 5))
    nearest = NearestPoint(cloud, small_steps=small_steps)
    for _ in range(6):
        squared, index = nearest(asking)
        apart = cdist(asking, cloud)
        np.testing.assert_allclose(np.sqrt(squared), apart.min(axis=1), atol=2e-6)
        np.testing.assert_allclose(apart[np.arange(700), index], np.sqrt(squared), atol=1e-12)
        asking = asking + step * rng.normal(size=asking.shape)


def test_what_was_answered_before_stays():
    """An answer is a value: the next search does not write into it."""
    rng = np.random.default_rng(0)
    cloud, asking = rng.normal(size=(900, 5)), rng.normal(size=(50, 5))
    nearest = NearestPoint(cloud, small_steps=True)
    _, first = nearest(asking)
    before = first.copy()
    nearest(asking + 1.0)
    np.testing.assert_array_equal(first, before)


def test_other_points_may_ask():
    rng = np.random.default_rng(1)
    cloud = rng.normal(size=(900, 5))
    nearest = NearestPoint(cloud, small_steps=True)
    for n in (50, 80, 50):
        asking = rng.normal(size=(n, 5))
        np.testing.assert_array_equal(nearest(asking)[1], cdist(asking, cloud).argmin(axis=1))


# the loop


@pytest.mark.parametrize("overlap", [1.0, 0.7])
@pytest.mark.parametrize("start", [-12.0, 0.0, 15.0])
def test_the_error_never_rises(points, glyph, shui, overlap, start):
    """With each further iteration allowed, what is returned is no worse, and it is the error of its pose."""
    pair = Neighbours(points(glyph("running-shui") > 0.5), shui, direction_weight=0.7)
    half = np.deg2rad(start) / 2
    first = Pose(unit_quaternion(np.array([np.cos(half), 0, 0, np.sin(half)])), np.zeros(3), np.inf)
    ends = [
        closest_points(pair, start=first, overlap=overlap, settings=IcpSettings(), limit=n)
        for n in range(1, 25)
    ]
    errors = [end.error for end in ends]
    assert (np.diff(errors) <= 1e-15).all()
    assert start == 0.0 or errors[-1] < 0.8 * errors[0]
    for end in (ends[0], ends[4], ends[-1]):
        squared = np.sort(pair.pairs(end.pose).squared)
        assert end.error == pytest.approx(squared[: round(overlap * len(squared))].mean(), rel=1e-12)


def test_the_distances_are_those_of_brute_force(points, glyph, shui):
    found = register_points(points(glyph("running-shui") > 0.5), shui)
    w = IcpSettings().direction_weight
    a = 2 * np.deg2rad(found.angle)
    D = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    P = np.hstack([posed(found.probe, found.T_reference_probe), w * found.probe.direction @ D.T])
    X = np.hstack([found.reference.xyz, w * found.reference.direction])
    apart = cdist(P, X)
    np.testing.assert_allclose(found.forward, apart.min(axis=1), atol=1e-9)
    np.testing.assert_allclose(found.backward, apart.min(axis=0), atol=1e-9)
    np.testing.assert_allclose(apart[np.arange(len(P)), found.forward_index], found.forward, atol=1e-9)
    np.testing.assert_allclose(apart[found.backward_index, np.arange(len(X))], found.backward, atol=1e-9)
    left = P[:, :3] - X[found.forward_index, :3]
    assert found.d_ms == pytest.approx(np.mean(np.sum(left**2, axis=1)))


def test_not_converging_is_said(points, glyph, moved, shui):
    leaning = points(moved(glyph("regular-shui"), lean=6.0))
    short = register_points(leaning, shui, settings=IcpSettings(max_iterations=1))
    assert not short.converged
    assert short.iterations == 1
    long = register_points(leaning, shui)
    assert long.converged
    assert 0 < long.iterations < IcpSettings().max_iterations


def test_registration_is_repeatable(points, glyph, shui):
    probe = points(glyph("cursive-shui") > 0.5)
    one, two = register_points(probe, shui), register_points(probe, shui)
    np.testing.assert_array_equal(one.T_reference_probe, two.T_reference_probe)
    np.testing.assert_array_equal(one.forward, two.forward)


# trimming


def test_a_blot_does_not_move_the_pose_and_is_not_forgiven(points, glyph, moved, shui):
    mask = moved(glyph("regular-shui"), lean=5.0)
    blotted = mask.copy()
    blotted[60:90, 60:90] = True  # beside the character, at the top left
    found = register_points(points(blotted), shui)
    untrimmed = register_points(points(blotted), shui, settings=IcpSettings(min_overlap=1.0))
    assert abs(found.angle - 5.0) < 0.3 < abs(untrimmed.angle - 5.0)
    assert np.hypot(*found.shift) < 0.6 * np.hypot(*untrimmed.shift)
    assert found.overlap < 0.95
    clean = register_points(points(mask), shui)
    assert np.percentile(found.forward, 97) > 3 * np.percentile(clean.forward, 97)
    assert len(found.forward) == len(found.probe.xyz)  # every point, not those that were kept


@given(st.lists(st.floats(0, 10), min_size=5, max_size=60), st.sampled_from([0.0, 1.0, 2.0]))
def test_the_share_is_the_best_of_all(squared, power):
    given_squares = np.array(squared)
    options = IcpSettings(trim_power=power)
    share, least = trimmed_share(given_squares, settings=options)
    if given_squares.mean() < 1e-12:
        assert share == 1.0
        return
    n = len(squared)
    shares = [k / n for k in range(1, n + 1) if k / n >= options.min_overlap]
    psi = {s: np.sort(given_squares)[: round(s * n)].mean() * s ** -(1 + power) for s in shares}
    assert least == pytest.approx(min(psi.values()))
    assert psi[share] == pytest.approx(least)


def test_the_share_of_a_cloud_with_outliers_is_that_of_its_inliers():
    rng = np.random.default_rng(4)
    squared = np.concatenate([rng.random(700) * 1e-3, 1 + rng.random(300)])
    rng.shuffle(squared)
    assert trimmed_share(squared, settings=IcpSettings())[0] == pytest.approx(0.7, abs=0.005)


def test_the_share_has_a_floor():
    squared = np.linspace(0.01, 1, 100) ** 8  # the fewer are kept the better
    assert trimmed_share(squared, settings=IcpSettings())[0] == pytest.approx(0.4)
    assert trimmed_share(squared, settings=IcpSettings(min_overlap=0.6))[0] == pytest.approx(0.6)
    assert trimmed_share(np.zeros(9), settings=IcpSettings())[0] == 1.0
