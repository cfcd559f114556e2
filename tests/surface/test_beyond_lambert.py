"""Materials that are not Lambert's: found where they are, and nowhere else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rumu.capture.folder import read_capture
from rumu.surface import beyond_lambert, compiled, robust
from rumu.surface.beyond_lambert import find_materials, solve_materials
from rumu.surface.photometric import surface_normals
from rumu.surface.reflectance import (
    LAMBERT,
    MATERIALS,
    Lamps,
    Material,
    MaterialSettings,
    choose_materials,
    doubt,
    fit_material,
    reflected,
)
from rumu.surface.robust import RobustSettings
from rumu.surface.solve import solve
from rumu_lab.simulation.lamps import from_slopes
from rumu_lab.simulation.reflectances import REFLECTANCES, photograph_material, spread_lamps

SIDE = 64


def ball():
    """Normals of a ball up to 70 degrees, and where they are."""
    r, c = np.mgrid[:SIDE, :SIDE]
    x, y = (c - (SIDE - 1) / 2) / (SIDE / 2), ((SIDE - 1) / 2 - r) / (SIDE / 2)
    z = np.sqrt(np.clip(1 - x * x - y * y, 0.1, None))
    normals = np.dstack([x, y, z])
    return normals / np.linalg.norm(normals, axis=2, keepdims=True), np.hypot(x, y) < 0.93


def waves():
    """Normals of a relief of waves, and where they are."""
    y, x = np.mgrid[:SIDE, :SIDE] / SIDE
    p, q = 0.5 * np.cos(12 * x) * np.cos(9 * y), 0.4 * np.sin(12 * x) * np.sin(9 * y)
    return from_slopes(p, q), np.ones((SIDE, SIDE), bool)


def degrees_off(normals, truth, where):
    cosine = (normals[where] * truth[where]).sum(axis=1)
    return float(np.degrees(np.arccos(np.clip(cosine, -1, 1))).mean())


def both(name, shape, lamps):
    """Mean error by Lambert's law with outliers, and with materials; the materials."""
    truth, where = shape()
    lights = spread_lamps(lamps)
    images = photograph_material(truth, lights, name)
    materials = find_materials(images, lights, mask=where)
    plain = solve(images, lights, mask=where)
    other = solve(images, lights, mask=where, materials=materials)
    return degrees_off(plain.normals, truth, where), degrees_off(other.normals, truth, where), materials


@pytest.mark.parametrize("shape", [ball, waves])
@pytest.mark.parametrize("name", sorted(REFLECTANCES))
@pytest.mark.parametrize("lamps", [12, 40])
def test_no_material_is_solved_worse_than_by_lamberts_law(name, shape, lamps):
    plain, other, _ = both(name, shape, lamps)
    assert other < 1.1 * plain + 0.25


@pytest.mark.parametrize(
    ("name", "shape", "lamps", "share"),
    [
        ("Phong, exponent 8", ball, 12, 0.5),
        ("Phong, exponent 20", waves, 12, 0.3),
        ("Beckmann, slope .22", ball, 40, 0.75),
        ("Ashikhmin-Shirley", waves, 40, 0.5),
        ("Oren-Nayar, slope .6", ball, 40, 0.4),
        ("cloth", ball, 40, 0.4),
    ],
)
def test_materials_that_the_dictionary_does_not_hold_are_solved_better(name, shape, lamps, share):
    plain, other, materials = both(name, shape, lamps)
    assert materials and other < share * plain


@pytest.mark.parametrize("shape", [ball, waves])
def test_lamberts_surfaces_are_left_to_the_last_bit(shape):
    truth, where = shape()
    lights = spread_lamps(12)
    images = photograph_material(truth, lights, "Lambert")
    assert find_materials(images, lights, mask=where) == ()
    plain, forced = (
        solve(images, lights, mask=where, materials=m) for m in ((), (Material("gloss", 0.2, 0.3),))
    )
    kept = (plain.normals == forced.normals).all(axis=2)[where].mean()
    assert kept > 0.97


def test_shadows_alone_call_for_no_vote(monkeypatch):
    """Where half of the lamps agree exactly, Lambert's law stands, whatever the others show."""
    truth, where = ball()
    lights = spread_lamps(24)
    images = photograph_material(truth, lights, "Lambert").copy()
    images[:, SIDE // 3 : SIDE // 2][::4] = 0.0  # cast shadows under six lamps
    tried = []

    def fit(seen, lamps, material, **options):
        tried.append(material)
        return compiled.fit_material(seen, lamps, material, **options)

    monkeypatch.setattr(beyond_lambert, "material_fitter", lambda: fit)
    assert find_materials(images, lights, mask=where) == ()
    assert tried == [LAMBERT]
    find_materials(photograph_material(truth, lights, "Phong, exponent 8"), lights, mask=where)
    assert len(tried) > len(MATERIALS)


def test_lamps_that_are_off_are_not_taken_for_a_material():
    """Wrong lamps contradict Lambert's law as materials do."""
    truth, where = ball()
    lights = spread_lamps(12)
    images = photograph_material(truth, lights, "Lambert")
    wrong = lights + np.random.default_rng(4).normal(0, 0.06, lights.shape)
    wrong /= np.linalg.norm(wrong, axis=1, keepdims=True)
    materials = find_materials(images, wrong, mask=where)
    plain = degrees_off(solve(images, wrong, mask=where).normals, truth, where)
    other = degrees_off(solve(images, wrong, mask=where, materials=materials).normals, truth, where)
    assert plain > 1.0 and other < 1.1 * plain


def test_few_lamps_are_left_alone():
    truth, where = ball()
    lights = spread_lamps(6)
    images = photograph_material(truth, lights, "Phong, exponent 8")
    assert find_materials(images, lights, mask=where) == ()


def test_a_dark_capture_has_no_materials():
    assert (
        find_materials(np.zeros((9, 20, 20), np.float32), spread_lamps(9), mask=np.ones((20, 20), bool)) == ()
    )


def test_what_is_reflected_is_lamberts_cosine_and_doubles_at_grazing_light():
    normals = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]])
    lamps = Lamps(np.array([[0.0, 0.0, 2.0], [0.8, 0.0, 0.6], [-0.8, 0.0, 0.6]]))
    np.testing.assert_allclose(
        reflected(normals, lamps, LAMBERT), [[1, 0.6, 0.6], [0.8, 0.96, 0]], atol=1e-12
    )
    rough = reflected(normals, lamps, Material("rough", share=1.0))
    np.testing.assert_allclose(rough[0], [1.0, 2 * 0.6 / 1.6, 2 * 0.6 / 1.6])


def test_a_metal_reflects_all_light_once():
    """A smooth metal that faces the camera reflects what falls on it, up to the shadow of its facets."""
    rng = np.random.default_rng(0)
    z, turn = rng.uniform(0, 1, 200_000), rng.uniform(0, 2 * np.pi, 200_000)
    aside = np.sqrt(1 - z * z)
    lamps = Lamps(np.stack([aside * np.cos(turn), aside * np.sin(turn), z], axis=1))
    shown = reflected(np.array([[0.0, 0.0, 1.0]]), lamps, Material("metal", 0.1))
    assert shown.mean() * 2 == pytest.approx(1.0, abs=0.04)  # Lambert's cosine: mean 1/2


def test_the_vote_takes_what_explains_most_and_stops():
    contradicted = np.tile([[0.3, 0.29, 0.05, 0.2]], (50, 1))
    contradicted[25:] = [0.3, 0.29, 0.31, 0.02]
    assert choose_materials(contradicted, settings=MaterialSettings()) == [3, 2]
    assert choose_materials(np.full((50, 4), 0.3), settings=MaterialSettings()) == []
    assert choose_materials(contradicted, settings=MaterialSettings(most=1)) == [3]


@pytest.mark.skipif(not compiled.has_numba(), reason="numba is not installed")
@pytest.mark.parametrize(
    "material", [LAMBERT, Material("gloss", 0.3, 0.5), Material("metal", 0.4), MATERIALS[-2]]
)
def test_the_compiled_search_finds_what_the_other_does(material):
    truth, where = waves()
    lights = spread_lamps(14)
    normals = truth[where][::7]
    lamps = Lamps(lights)
    rows = 0.3 * reflected(normals, lamps, material) + np.random.default_rng(1).normal(
        0, 2e-3, (len(normals), 14)
    )
    seen = lamps.relative(np.clip(rows, 0, 1), MaterialSettings())
    starts = lamps.starts(seen, normals + np.array([0.1, -0.1, 0.0]))
    one, other = (
        search(seen, lamps, material, starts=starts, settings=MaterialSettings())
        for search in (fit_material, compiled.fit_material)
    )
    apart = np.degrees(np.arccos(np.clip((one.normals * other.normals).sum(axis=1), -1, 1)))
    assert np.median(apart) < 0.05 and np.quantile(apart, 0.95) < 0.5
    assert np.degrees(np.arccos(np.clip((other.normals * normals).sum(axis=1), -1, 1))).mean() < 1.0
    assert np.abs(one.contradicted - other.contradicted).max() < 0.05


@pytest.mark.parametrize("name", ["Lambert", "Phong, exponent 20", "Oren-Nayar, slope .6"])
def test_the_compiled_doubt_is_that_of_numpy(name):
    truth, where = ball()
    lights = spread_lamps(15)
    values = photograph_material(truth, lights, name)[:, where].astype(np.float32)
    values[:, ::50], values[:, 1::50], values[3, 2::5] = 0.0, 1.0, 1.0  # unlit, overexposed, some white
    done = compiled.solve_tile(values, lights, solver="robust", black_level=0.0, settings=RobustSettings())
    lamps, settings = Lamps(lights), MaterialSettings()
    seen = lamps.relative(values.T.astype(np.float64), settings)
    one, other = (find(seen, lamps, done.normals, settings) for find in (doubt, compiled.doubt))
    assert (np.abs(one[0] - other[0]) < 1e-3).mean() > 0.999  # but where a lamp is just dark
    assert (one[1] == other[1]).mean() > 0.999
    if name != "Lambert":
        assert one[1].any() and not one[1].all()


def test_without_numba_the_same_materials_are_found(monkeypatch):
    truth, where = ball()
    lights = spread_lamps(12)
    images = photograph_material(truth, lights, "Phong, exponent 20")
    found = find_materials(images, lights, mask=where)
    monkeypatch.setattr(compiled, "has_numba", lambda: False)
    again = find_materials(images, lights, mask=where)
    assert found and [replace(one, lobe=()) for one in again] == [replace(one, lobe=()) for one in found]
    for one, other in zip(again, found, strict=True):
        assert one.lobe == pytest.approx(other.lobe, abs=0.02 * max(other.lobe))


def test_colour_under_gloss_is_that_of_the_ground():
    """White gloss does not bleach the albedo."""
    truth, _ = ball()
    lights = spread_lamps(24)
    lamps = Lamps(lights)
    normals = truth[20:44, 20:44].reshape(-1, 3)
    matte, glossy = (reflected(normals, lamps, m) for m in (LAMBERT, Material("gloss", 0.6, 1.0)))
    ground = np.array([0.6, 0.2, 0.1])
    gloss = (glossy - matte)[..., None] * 0.3
    values = np.clip(matte[..., None] * ground + gloss, 0, 1).transpose(1, 0, 2).astype(np.float32)
    plain = robust.solve_tile(values, lights, solver="robust", black_level=0.0, settings=RobustSettings())
    done = solve_materials(values, lights, plain, [Material("gloss", 0.6, 1.0)])
    bleached, kept = (np.abs(one.albedo - ground).mean() for one in (plain, done))
    changed = (plain.normals != done.normals).any(axis=1).mean()
    assert changed > 0.5 and kept < 0.25 * bleached and kept < 0.04


@pytest.mark.parametrize("colour", [False, True])
def test_each_pixel_tells_how_strong_its_gloss_is(colour):
    """One varnish over grounds of any albedo: its share of a dark one is not that of the voters."""
    truth, _ = ball()
    lights = spread_lamps(24)
    lamps = Lamps(lights)
    normals = truth[20:44, 20:44].reshape(-1, 3)
    voted = Material("gloss", 0.4, 0.3)
    matte, glossy = (reflected(normals, lamps, m) for m in (LAMBERT, voted))
    ground = np.tile([0.08, 0.12, 0.2, 0.3, 0.45, 0.6], len(normals) // 6)
    shown = (ground[:, None] * matte + 0.25 * (glossy - matte)).T
    values = np.clip(shown, 0, 1).astype(np.float32)
    values = values[..., None] * np.float32([1.0, 1.0, 1.0]) if colour else values
    plain = robust.solve_tile(values, lights, solver="robust", black_level=0.0, settings=RobustSettings())
    done = solve_materials(values, lights, plain, [voted])
    changed = (plain.normals != done.normals).any(axis=1)
    found = done.albedo.mean(axis=1) if colour else done.albedo
    off = np.abs(found / ground - 1)[changed]
    assert changed.mean() > 0.4 and np.median(off) < 0.06 and np.quantile(off, 0.9) < 0.3


def test_ink_votes_beside_paper():
    """Little of a sheet is ink, and what it reflects is mostly gloss."""
    truth, _ = waves()
    lights = spread_lamps(14)
    ink = np.zeros((SIDE, SIDE), bool)
    ink[20:44, 28:36] = True
    lamps, normals = Lamps(lights), truth.reshape(-1, 3)
    matte, glossy = (reflected(normals, lamps, m) for m in (LAMBERT, Material("gloss", 0.3, 1.0)))
    shown = np.where(ink.reshape(-1, 1), 0.06, 0.7) * matte + 0.05 * (glossy - matte)
    shown += np.random.default_rng(0).normal(0, 0.002, shown.shape)
    images = np.clip(shown, 0, 1).T.reshape(14, SIDE, SIDE).astype(np.float32)
    everywhere = np.ones((SIDE, SIDE), bool)
    materials = find_materials(images, lights, mask=everywhere)
    before, after = (
        degrees_off(solve(images, lights, materials=m).normals, truth, ink) for m in ((), materials)
    )
    assert before > 6.0 and after < 0.6 * before


def test_confidence_stays_a_share_and_unlit_pixels_stay_unmeasured():
    truth, where = ball()
    lights = spread_lamps(12)
    images = photograph_material(truth, lights, "Phong, exponent 8")
    images[:, :20] = 0.0
    solved = solve(images, lights, mask=where, materials=(Material("gloss", 0.6, 3.0),))
    assert solved.confidence.min() >= 0 and solved.confidence.max() <= 1
    assert (solved.confidence[:20] == 0).all() and np.isfinite(solved.normals).all()


def test_matte_captures_of_real_things_stay_as_they_are(data):
    """Plaster and a painted ball contradict Lambert's law by shadow and lamps, not by their material."""
    for name in ("uw-psm/gray", "uw-psm/buddha", "psbox-cat", "bunny/bunny_lambert"):
        capture = read_capture(data / "photometric" / name)
        assert surface_normals(capture)[3]["materials"] == 0, name


def test_a_relief_half_of_metal_is_solved_better(data):
    from PIL import Image

    folder = data / "photometric" / "synthrti-relief" / "train49"
    capture = read_capture(folder)
    painted = np.asarray(Image.open(folder / "normals.png").convert("RGB")) / 127.5 - 1.0
    truth = painted / np.linalg.norm(painted, axis=2, keepdims=True)
    plain = solve(capture.photographs, capture.lights, mask=capture.mask).normals
    normals, _, _, quality = surface_normals(capture)
    assert quality["materials"] >= 1
    assert degrees_off(normals, truth, capture.mask) < degrees_off(plain, truth, capture.mask) - 0.5
    assert beyond_lambert.MaterialSettings().least_lamps <= len(capture.lights)
