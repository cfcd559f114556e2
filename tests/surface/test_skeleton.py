"""Skeletons of drawn shapes whose lines are known, and of the works of the starter gallery."""

from __future__ import annotations

import functools

import cv2
import numpy as np
import pytest
from PIL import Image

from rumu.errors import SurfaceError
from rumu.gallery.starter import find_work, starter_works
from rumu.surface.skeleton import Skeleton, Stroke, skeletonise, strokes

SIDE = 256


def drawn(*lines, width=14) -> np.ndarray:
    """(SIDE, SIDE) bool: lines of (x, y) points, drawn with a round brush."""
    ink = np.zeros((SIDE, SIDE), np.uint8)
    for line in lines:
        cv2.polylines(ink, [np.array(line, np.int32).reshape(-1, 1, 2)], False, 1, width)
    return ink.astype(bool)


def ring(radius=70, width=12) -> np.ndarray:
    ink = np.zeros((SIDE, SIDE), np.uint8)
    cv2.circle(ink, (128, 128), radius, 1, width)
    return ink.astype(bool)


CROSS = ([(40, 128), (216, 128)], [(128, 40), (128, 216)])
TEE = ([(40, 60), (216, 60)], [(128, 60), (128, 216)])


@functools.cache
def work(name: str, side: int = SIDE) -> np.ndarray:
    image = Image.open(find_work(name).path).resize((side, side), Image.Resampling.BOX)
    return np.asarray(image) < 128


def forks(skeleton: Skeleton) -> np.ndarray:
    return skeleton.nodes[skeleton.degree >= 3]


def test_a_bar_is_one_segment_along_its_middle():
    skeleton = skeletonise(drawn([(40, 128), (216, 128)]))
    (segment,) = skeleton.segments
    assert skeleton.degree.tolist() == [1, 1]
    assert skeleton.width == pytest.approx(15, abs=1.0)
    np.testing.assert_allclose(segment.points[5:-5, 1], 128, atol=0.6)
    assert np.sort(segment.points[[0, -1], 0]) == pytest.approx([40, 216], abs=8)
    np.testing.assert_allclose(segment.radius[10:-10], 7.5, atol=0.6)
    assert segment.length == pytest.approx(176, abs=14)


def test_points_are_column_then_row_in_the_whole_picture():
    ink = np.zeros((100, 300), bool)
    ink[70:80, 200:280] = True
    skeleton = skeletonise(ink)
    x, y = skeleton.segments[0].points.mean(axis=0)
    assert (x, y) == pytest.approx((239.5, 74.5), abs=1)


def test_a_crossing_is_one_fork_of_four():
    skeleton = skeletonise(drawn(*CROSS))
    assert sorted(skeleton.degree) == [1, 1, 1, 1, 4]
    np.testing.assert_allclose(forks(skeleton), [[128, 128]], atol=1.5)


def test_a_slanting_crossing_of_two_forks_is_one():
    skeleton = skeletonise(drawn([(50, 80), (206, 176)], [(50, 176), (206, 80)]))
    assert sorted(skeleton.degree) == [1, 1, 1, 1, 4]
    np.testing.assert_allclose(forks(skeleton), [[128, 128]], atol=3)


def test_whiskers_are_pruned_and_branches_stay():
    bar = drawn([(40, 128), (216, 128)])
    bumpy, branched = bar.copy(), bar.copy()
    for x in range(60, 210, 20):
        bumpy[117:122, x : x + 5] = True
    branched[96:128, 120:130] = True
    assert sorted(skeletonise(bumpy).degree) == [1, 1]
    assert sorted(skeletonise(branched).degree) == [1, 1, 1, 3]


def test_a_ring_and_a_dot_are_kept():
    hollow = skeletonise(ring())
    (segment,) = hollow.segments
    assert segment.ends[0] == segment.ends[1]
    assert segment.length == pytest.approx(2 * np.pi * 70, rel=0.03)
    dotted = ring()
    cv2.circle(spot := np.zeros((SIDE, SIDE), np.uint8), (128, 128), 9, 1, -1)
    both = skeletonise(dotted | spot.astype(bool))
    assert len(both.segments) == 2
    dot = min(both.segments, key=lambda s: s.length)
    np.testing.assert_allclose(dot.points.mean(axis=0), [128, 128], atol=1)
    assert dot.radius.max() == pytest.approx(9, abs=1)


def test_hairlines_and_ink_at_the_edge_are_lines_too():
    ink = drawn([(30, 60), (200, 60)], width=20)
    ink[140, 20:240] = True
    ink[:, 0:6] = True
    rows = sorted(round(float(np.median(s.points[:, 1]))) for s in skeletonise(ink).segments)
    assert {60, 140} <= set(rows)


def direction(stroke: Stroke) -> float:
    """Degrees from start to end as the page shows it: level is 0, straight down -90."""
    right, down = stroke.chord
    return float(np.degrees(np.arctan2(-down, right)))


@pytest.mark.parametrize("lines", [CROSS, TEE])
def test_strokes_go_straight_on_through_a_fork(lines):
    found = strokes(skeletonise(drawn(*lines)))
    assert len(found) == 2
    horizontal, vertical = sorted(found, key=lambda s: abs(direction(s)))
    assert direction(horizontal) == pytest.approx(0, abs=2)
    assert abs(direction(vertical)) == pytest.approx(90, abs=2)
    np.testing.assert_allclose(horizontal.points[5:-5, 1], lines[0][0][1], atol=1.5)
    assert horizontal.length == pytest.approx(176, abs=14)


def test_strokes_begin_at_the_left_or_at_the_top():
    falling, rising, standing = (
        strokes(skeletonise(drawn(line)))[0]
        for line in ([(200, 180), (60, 100)], [(200, 100), (60, 180)], [(140, 220), (120, 30)])
    )
    assert direction(falling) == pytest.approx(-30, abs=3)
    assert direction(rising) == pytest.approx(30, abs=3)
    assert direction(standing) == pytest.approx(-84, abs=3)


def test_a_sharper_way_through_a_fork_is_taken_only_when_allowed():
    bent = drawn([(60, 60), (128, 128), (128, 220)], [(128, 128), (210, 128)])
    assert len(strokes(skeletonise(bent), turn=30.0)) == 3
    assert len(strokes(skeletonise(bent), turn=60.0)) == 2


def test_every_segment_is_in_exactly_one_stroke():
    for starter in starter_works():
        skeleton = skeletonise(work(starter.id))
        numbers = sorted(k for stroke in strokes(skeleton) for k in stroke.segments)
        assert numbers == list(range(len(skeleton.segments))), starter.id


@pytest.mark.parametrize("name", [w.id for w in starter_works()])
def test_the_ink_of_every_script_lies_within_reach_of_its_skeleton(name):
    """Discs of the half-width along the lines must give the ink back, and nothing else."""
    mask = work(name)
    rebuilt = np.zeros(mask.shape, np.uint8)
    for segment in skeletonise(mask).segments:
        for (x, y), r in zip(segment.points, segment.radius, strict=True):
            cv2.circle(rebuilt, (round(float(x)), round(float(y))), round(float(r)), 1, -1)
    shared = (rebuilt.astype(bool) & mask).sum()
    assert shared / mask.sum() > 0.85
    assert shared / rebuilt.sum() > 0.9


@pytest.mark.parametrize(
    ("name", "count"),
    [("seal-shui", 5), ("seal-ren", 2), ("seal-ri", 2), ("seal-tian", 4), ("clerical-ren", 2)],
)
def test_strokes_of_clean_works_are_those_that_were_written(name, count):
    skeleton = skeletonise(work(name))
    assert len([s for s in strokes(skeleton) if s.length > skeleton.width]) == count


@pytest.mark.parametrize("name", ["seal-shu", "clerical-tian", "regular-yue", "cursive-tian"])
def test_another_resolution_gives_the_same_lines(name):
    small, large = (skeletonise(work(name, side)) for side in (192, 384))
    assert large.width / small.width == pytest.approx(2, rel=0.12)
    lengths = [sum(s.length for s in skeleton.segments) for skeleton in (small, large)]
    assert lengths[1] / lengths[0] == pytest.approx(2, rel=0.08)


def test_nonsense_is_refused():
    with pytest.raises(SurfaceError, match="holds ink"):
        skeletonise(np.zeros((9, 9), bool))
    with pytest.raises(SurfaceError, match="bool mask"):
        skeletonise(np.zeros((9, 9)))


@pytest.mark.parametrize("side", [1, 2, 3, 20])
def test_a_blot_of_any_size_has_a_skeleton(side):
    ink = np.zeros((40, 40), bool)
    ink[10 : 10 + side, 10 : 10 + side] = True
    skeleton = skeletonise(ink)
    assert len(skeleton.segments) >= 1
    assert all(len(s.points) == len(s.radius) for s in skeleton.segments)
    assert strokes(skeleton)[0].length < 1.5 * side
