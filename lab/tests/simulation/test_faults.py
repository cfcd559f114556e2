"""Each fault is measured on the picture, by other means than those that made it."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from PIL import Image

from rumu.errors import SurfaceError
from rumu.gallery.starter import find_work
from rumu_lab.simulation.faults import FAULTS, FaultyGlyph, apply
from rumu_lab.simulation.glyph import Glyph
from rumu_lab.simulation.severity import KINDS, size_of

SIDE = 256
WORKS = ("regular-shui", "clerical-tian", "seal-shu")


@functools.cache
def glyph(work: str = "clerical-tian") -> np.ndarray:
    image = Image.open(find_work(work).path).resize((SIDE, SIDE), Image.Resampling.BOX)
    return np.asarray(image) < 128


@functools.cache
def faulted(fault: str, severity: float, work: str = "clerical-tian", seed: int = 1) -> FaultyGlyph:
    return apply(glyph(work), fault, severity=severity, seed=seed)


def centroid(mask: np.ndarray) -> np.ndarray:
    return np.argwhere(mask).mean(axis=0)


def axis(mask: np.ndarray) -> float:
    """Direction of the longer principal axis, degrees clockwise from +x, in (-90, 90]."""
    values, vectors = np.linalg.eigh(np.cov(np.argwhere(mask).T))
    row, column = vectors[:, int(values.argmax())]
    return float(np.degrees(np.arctan2(row, column)) % 180.0)


def iou(a: np.ndarray, b: np.ndarray) -> float:
    return float((a & b).sum() / (a | b).sum())


def difference(angle: float) -> float:
    return (angle + 90.0) % 180.0 - 90.0


@pytest.mark.parametrize("fault", FAULTS)
def test_no_severity_is_no_fault(fault: str) -> None:
    np.testing.assert_array_equal(faulted(fault, 0.0).mask, glyph())
    assert faulted(fault, 0.0).size == 0.0


@pytest.mark.parametrize("fault", FAULTS)
def test_the_seed_alone_decides(fault: str) -> None:
    again = apply(glyph(), fault, severity=3.0, seed=1)
    np.testing.assert_array_equal(again.mask, faulted(fault, 3.0).mask)
    np.testing.assert_array_equal(again.ink, faulted(fault, 3.0).ink)
    assert again.description == faulted(fault, 3.0).description


@pytest.mark.parametrize(
    "fault", [f for f in FAULTS if KINDS[f].unit in ("px", "deg") and f not in ("thin", "thick")]
)
def test_another_seed_is_another_fault_of_the_same_size(fault: str) -> None:
    others = [faulted(fault, 3.0, seed=s) for s in range(2, 7)]
    assert any(not np.array_equal(o.mask, faulted(fault, 3.0).mask) for o in others)
    np.testing.assert_allclose([abs(o.size) for o in others], abs(faulted(fault, 3.0).size), rtol=1e-6)


@pytest.mark.parametrize("work", WORKS)
@pytest.mark.parametrize("fault", FAULTS)
def test_the_copy_departs_further_from_the_master_as_the_fault_grows(fault: str, work: str) -> None:
    master = glyph(work).astype(float)
    unlike = [float(np.abs(faulted(fault, s, work).ink - master).sum()) for s in (1.0, 3.0, 5.0)]
    assert unlike[0] < unlike[2]
    assert unlike[0] <= unlike[1] * 1.02
    assert unlike[1] <= unlike[2] * 1.02


@pytest.mark.parametrize("fault", FAULTS)
def test_every_fault_names_its_place_and_its_size_in_two_languages(fault: str) -> None:
    result = faulted(fault, 4.0)
    x0, y0, x1, y1 = result.region
    assert 0.0 <= x0 < x1 <= 1.0
    assert 0.0 <= y0 < y1 <= 1.0
    assert any(ch.isdigit() for ch in result.description + result.description_zh)
    assert not result.description.isascii() or result.description_zh != result.description
    assert result.unit == KINDS[fault].unit
    assert result.mask.dtype == np.bool_
    assert result.ink.dtype == np.float32
    assert 0.0 <= result.ink.min() <= result.ink.max() <= 1.0


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_lean_turns_the_character_by_what_it_says(seed: int) -> None:
    result = faulted("lean", 3.0, "clerical-shui", seed)
    assert abs(result.size) == pytest.approx(12.0)
    turned = difference(axis(result.mask) - axis(glyph("clerical-shui")))
    assert turned == pytest.approx(result.size, abs=1.0), "positive is clockwise"
    assert ("counter" in result.description) == (result.size < 0)
    np.testing.assert_allclose(centroid(result.mask), centroid(glyph("clerical-shui")), atol=0.7)


def test_off_centre_moves_the_centroid_by_eleven_and_eight_pixels_of_512() -> None:
    for seed in range(1, 6):
        result = faulted("off_centre", 2.0, seed=seed)
        down, right = centroid(result.mask) - centroid(glyph())
        assert abs(right) == pytest.approx(22.0 * SIDE / 512, abs=0.5)
        assert abs(down) == pytest.approx(16.0 * SIDE / 512, abs=0.5)
        assert ("far right" in result.description) == (right > 0)
        assert ("too low" in result.description) == (down > 0)


def test_small_shrinks_the_box_by_what_it_says() -> None:
    box = np.ptp(np.argwhere(glyph()), axis=0)
    smaller = np.ptp(np.argwhere(faulted("small", 3.0).mask), axis=0)
    np.testing.assert_allclose(smaller / box, 0.76, atol=0.02)


@pytest.mark.parametrize("fault", ["thin", "thick"])
def test_weight_changes_the_area_by_the_length_of_the_edge(fault: str) -> None:
    from skimage.measure import perimeter

    before, after = glyph(), faulted(fault, 2.0).mask
    step = KINDS[fault].step * 2.0 * SIDE / 512 * (1 if fault == "thick" else -1)
    assert (after.sum() - before.sum()) == pytest.approx(perimeter(before) * step, rel=0.15)


def test_thinning_never_breaks_a_stroke() -> None:
    from skimage.measure import label

    for work in WORKS:
        assert label(faulted("thin", 5.0, work).mask).max() <= label(glyph(work)).max()


@pytest.mark.parametrize("seed", [1, 2, 3, 4, 5])
def test_a_pushed_stroke_moves_by_what_it_says_and_the_others_stay(seed: int) -> None:
    work = "seal-shui"  # five strokes that touch nowhere, so that each can be found again
    from skimage.measure import label

    result = faulted("shift", 4.0, work, seed)
    assert result.size == pytest.approx(20.0)
    before, after = label(glyph(work)), label(result.mask)
    moved = [
        (after_c - before_c)
        for before_c, after_c in zip(
            *([centroid(lab == k) for k in range(1, lab.max() + 1)] for lab in (before, after)), strict=True
        )
    ]
    lengths = sorted(float(np.linalg.norm(step)) for step in moved)
    assert lengths[-1] == pytest.approx(20.0 * SIDE / 512, abs=0.7)
    assert lengths[-2] < 0.3
    down, right = max(moved, key=np.linalg.norm)
    assert (" right" in result.description.split(":")[1]) == (right > 0)
    assert (" down" in result.description) == (down > 0)


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_a_turned_stroke_turns_by_what_it_says(seed: int) -> None:
    bar = np.zeros((SIDE, SIDE), dtype=bool)
    bar[120:136, 40:216] = True
    result = apply(bar, "angle", severity=4.0, seed=seed)
    assert abs(result.size) == pytest.approx(14.0)
    assert difference(axis(result.mask)) == pytest.approx(result.size, abs=0.5), "positive is clockwise"
    assert ("counter" in result.description) == (result.size < 0)
    np.testing.assert_allclose(centroid(result.mask), centroid(bar), atol=0.7)


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_of_a_cross_the_lying_stroke_leans_and_the_standing_one_stays(seed: int) -> None:
    cross = np.zeros((SIDE, SIDE), dtype=bool)
    lying, standing = cross.copy(), cross.copy()
    lying[120:136, 40:216] = standing[40:216, 120:136] = True
    result = apply(lying | standing, "horizontal", severity=3.0, seed=seed)
    assert abs(result.size) == pytest.approx(6.0)
    assert (result.mask & standing).sum() / standing.sum() > 0.99
    alone = result.mask.copy()
    alone[:, 112:144] = False
    assert difference(axis(alone)) == pytest.approx(result.size, abs=0.7), "positive is clockwise"


def test_without_a_lying_stroke_none_can_lean() -> None:
    bar = np.zeros((SIDE, SIDE), dtype=bool)
    bar[40:216, 120:136] = True
    with pytest.raises(SurfaceError, match="horizontal"):
        apply(bar, "horizontal", severity=1.0)


def test_a_heavy_entry_widens_the_beginning_of_one_stroke_alone() -> None:
    bar = np.zeros((SIDE, SIDE), dtype=bool)
    bar[120:136, 40:216] = True
    result = apply(bar, "entry", severity=4.0)
    added = np.argwhere(result.mask & ~bar)
    assert added[:, 1].max() < 40 + 0.3 * 176
    assert result.mask[:, 48].sum() == pytest.approx(16 * 1.6, abs=3)
    np.testing.assert_array_equal(result.mask[:, 120:], bar[:, 120:])


def test_a_turned_stroke_of_a_cross_leaves_the_other_alone() -> None:
    cross = np.zeros((SIDE, SIDE), dtype=bool)
    cross[120:136, 40:216] = cross[40:216, 120:136] = True
    result = apply(cross, "angle", severity=5.0, seed=1)
    lying, standing = np.zeros_like(cross), np.zeros_like(cross)
    lying[120:136, 40:216] = standing[40:216, 120:136] = True
    kept = [float((result.mask & bar).sum() / bar.sum()) for bar in (lying, standing)]
    assert max(kept) > 0.99
    assert min(kept) < 0.6


def test_a_shortened_stroke_loses_its_share_of_length() -> None:
    bar = np.zeros((SIDE, SIDE), dtype=bool)
    bar[120:134, 40:220] = True
    result = apply(bar, "short", severity=3.0)
    assert np.ptp(np.argwhere(result.mask)[:, 1]) + 1 == pytest.approx(180 * 0.76, abs=2)


@pytest.mark.parametrize(("severity", "count"), [(1.0, 1), (3.0, 2), (5.0, 3)])
def test_missing_takes_a_share_of_the_strokes_and_nothing_else(severity: float, count: int) -> None:
    from skimage.measure import label

    result = faulted("missing", severity, "seal-shui")
    assert label(result.mask).max() == 5 - count
    assert len(result.strokes) == count
    assert not (result.mask & ~glyph("seal-shui")).sum() > 20


def test_the_only_stroke_cannot_be_left_out() -> None:
    bar = np.zeros((64, 64), dtype=bool)
    bar[30:36, 8:56] = True
    with pytest.raises(SurfaceError, match="one stroke"):
        apply(bar, "missing", severity=1.0)


def test_a_missing_stroke_leaves_a_crossing_whole() -> None:
    """What lies under another stroke is that stroke's ink as well."""
    from skimage.measure import label

    cross = np.zeros((SIDE, SIDE), dtype=bool)
    cross[120:136, 40:216] = cross[40:216, 120:136] = True
    result = apply(cross, "missing", severity=1.0, seed=2)
    assert label(result.mask).max() == 1
    assert result.mask.sum() == pytest.approx(176 * 16, rel=0.05)


def test_extra_strokes_are_added_where_there_was_paper() -> None:
    from skimage.measure import label

    for count in (1, 3):
        result = faulted("extra", float(count))
        added = result.mask & ~glyph()
        regions = label(added)
        assert sum((regions == k).sum() > 60 for k in range(1, regions.max() + 1)) == count
        assert (glyph() & ~result.mask).sum() < 0.01 * glyph().sum()


def test_squeeze_keeps_the_width_and_moves_the_parting_to_the_right() -> None:
    parts = np.zeros((SIDE, SIDE), dtype=bool)
    parts[60:200, 40:100] = parts[60:200, 140:200] = True
    result = apply(parts, "squeeze", severity=4.0)
    columns = np.flatnonzero(result.mask.any(axis=0))
    left, right = np.split(columns, [int(np.diff(columns).argmax()) + 1])
    assert (columns[0], columns[-1]) == (40, 199)
    assert result.size == pytest.approx(20.0)
    # 160 columns part in the middle; 32 of them go over from the right half to the left one.
    assert len(left) == pytest.approx(60 * (80 + 32) / 80, abs=2)
    assert len(right) == pytest.approx(60 * (80 - 32) / 80, abs=2)


def test_a_trembling_hand_lengthens_the_edge_at_about_the_same_weight() -> None:
    from skimage.measure import perimeter

    result = faulted("wobble", 3.0)
    assert perimeter(result.mask) > 1.04 * perimeter(glyph())
    assert result.mask.sum() == pytest.approx(glyph().sum(), rel=0.05)


def test_blunt_ends_add_ink_at_the_tips_alone() -> None:
    work = "regular-shui"
    result = faulted("blunt", 5.0, work)
    added = np.argwhere(result.mask & ~glyph(work))
    tips = np.array(
        [
            end
            for s in Glyph(glyph(work)).strokes
            for end, free in zip(s.points[[0, -1]], s.free, strict=True)
            if free
        ]
    )
    nearest = np.linalg.norm(added[:, None] - tips[None], axis=2).min(axis=1)
    assert len(added) > 50
    assert np.quantile(nearest, 0.9) < 0.15 * SIDE


def test_blots_and_streaks_take_the_share_that_they_say() -> None:
    ink = glyph().sum()
    blots, streaks = faulted("blot", 4.0), faulted("dry", 4.0)
    assert 100 * (blots.mask & ~glyph()).sum() / ink == pytest.approx(blots.size, abs=2.0)
    assert 6.0 < blots.size < 16.0
    assert 100 * (glyph() & ~streaks.mask).sum() / ink == pytest.approx(28.0, abs=4.0)
    assert not (streaks.mask & ~glyph()).sum() > 0.01 * ink


def test_pale_ink_keeps_its_shape() -> None:
    result = faulted("pale", 5.0)
    assert iou(result.mask, glyph()) > 0.99
    assert result.ink.max() == pytest.approx(0.4)


def test_edges_stay_as_smooth_as_the_master_s() -> None:
    """What is moved must look written, not cut out: no stair or speck of a pixel is left."""
    from skimage.measure import label, perimeter

    for fault in ("shift", "angle", "short", "lean", "squeeze", "stroke_thin", "uneven"):
        result = faulted(fault, 2.0)
        sizes = np.bincount(label(result.mask).ravel())[1:]
        assert sizes.min() > 20, fault
        assert perimeter(result.mask) < 1.15 * perimeter(glyph()), fault


def test_size_scales_with_the_picture() -> None:
    big = np.asarray(Image.open(find_work("clerical-tian").path)) < 128
    for mask in (glyph(), big):
        right = centroid(apply(mask, "off_centre", severity=2.0, seed=1).mask)[1] - centroid(mask)[1]
        assert abs(right) / mask.shape[1] == pytest.approx(22.0 / 512.0, abs=2e-3)


def test_the_declared_table_is_whole() -> None:
    assert set(FAULTS) == set(KINDS)
    assert all(kind.step > 0 and kind.zh and kind.en for kind in KINDS.values())
    assert size_of("lean", severity=5.0) == 20.0


def test_nonsense_is_refused_by_name() -> None:
    with pytest.raises(SurfaceError, match="expected a fault among shift"):
        apply(glyph(), "ugly", severity=1.0)
    with pytest.raises(SurfaceError, match="severity from 0 to 5"):
        apply(glyph(), "lean", severity=6.0)
    with pytest.raises(SurfaceError, match="holds ink"):
        apply(np.zeros((9, 9), dtype=bool), "lean", severity=1.0)
    with pytest.raises(SurfaceError, match="bool mask"):
        apply(np.zeros((9, 9)), "lean", severity=1.0)
