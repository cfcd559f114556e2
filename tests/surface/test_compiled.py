"""The compiled solvers find what the NumPy ones find; without numba the latter do it, and say how slowly."""

from __future__ import annotations

import itertools
import sys

import numpy as np
import pytest

from rumu.capture.folder import read_capture
from rumu.surface import compiled, robust
from rumu.surface.robust import SOLVERS, RobustSettings
from rumu.surface.solve import solve
from rumu_lab.simulation.lamps import Gloss, Sensor, photographs
from rumu_lab.simulation.shapes import ridges

needs_numba = pytest.mark.skipif(not compiled.has_numba(), reason="numba is not installed")


def degrees_apart(one, other):
    """(P,) angles between two lists of unit normals, exact for small ones."""
    chord = np.linalg.norm(one.astype(np.float64) - other, axis=-1)
    return np.degrees(2 * np.arcsin(np.clip(chord / 2, 0, 1)))


def glossy_values(*, colour):
    """(N, P) or (N, P, 3) brightness of a sheet with shadow, gloss and noise, and its lamps."""
    albedo = np.full((70, 90, 3), (0.7, 0.5, 0.3)) if colour else 0.6
    images, lights = photographs(
        ridges((70, 90), width=20.0, pitch=50.0, angle=25.0).height,
        albedo,
        tilts=tuple(np.arange(14) * 360 / 14),
        slant=(30.0, 55.0) * 7,
        gloss=Gloss(strength=0.3, exponent=40.0),
        sensor=Sensor(noise=0.003),
    )
    return images.reshape(14, -1, *images.shape[3:]).astype(np.float32), lights


def both(values, lights, solver, black_level=0.0):
    options = {"solver": solver, "black_level": black_level, "settings": RobustSettings()}
    return robust.solve_tile(values, lights, **options), compiled.solve_tile(values, lights, **options)


@needs_numba
@pytest.mark.parametrize("n", [2, 3, 5, 8, 12, 20, 50, 65])
def test_the_network_sorts(n):
    pairs = compiled.sorting_network(n)
    assert pairs.min() >= 0 and pairs.max() == n - 1 and (pairs[:, 0] < pairs[:, 1]).all()
    # The 0-1 principle: what sorts all sequences of two values sorts all sequences.
    inputs = (
        np.array(list(itertools.product((0, 1), repeat=n)))
        if n <= 8
        else np.random.default_rng(n).integers(0, 5, (4000, n))
    )
    values = inputs.T.copy()
    for low, high in pairs:
        values[low], values[high] = (
            np.minimum(values[low], values[high]),
            np.maximum(values[low], values[high]),
        )
    assert (values == np.sort(inputs.T, axis=0)).all()


@needs_numba
@pytest.mark.parametrize(("n", "rank"), [(3, 2), (8, 7), (12, 10), (20, 18), (50, 45), (50, 24), (65, 0)])
def test_the_network_of_one_rank_brings_it_to_its_place(n, rank):
    values = np.random.default_rng(n).integers(0, 9, (n, 2000))
    wanted = np.sort(values, axis=0)[rank]
    for low, high in compiled.selecting_network(n, rank):
        values[[low, high]] = np.sort(values[[low, high]], axis=0)
    assert (values[rank] == wanted).all()
    assert len(compiled.selecting_network(n, rank)) < len(compiled.sorting_network(n)) or n == 3


@needs_numba
@pytest.mark.parametrize("black_level", [0.0, 0.02])
def test_the_values_of_others_are_left_as_they_are(black_level):
    values, lights = glossy_values(colour=False)
    before = values.copy()
    both(values, lights, "robust", black_level)
    assert (values == before).all()


@needs_numba
@pytest.mark.parametrize("colour", [False, True])
@pytest.mark.parametrize("black_level", [0.0, 0.02])
@pytest.mark.parametrize("solver", SOLVERS)
def test_kernels_and_numpy_agree_to_two_hundredths_of_a_degree(solver, colour, black_level):
    values, lights = glossy_values(colour=colour)
    numpy, kernels = both(values, lights, solver, black_level)
    off = degrees_apart(numpy.normals, kernels.normals)
    # A pixel in a thousand may stand between two solutions of a loss that is not convex.
    assert off.mean() < 0.02 and np.quantile(off, 0.999) < 0.02
    assert np.quantile(np.abs(numpy.albedo - kernels.albedo), 0.999) < 2e-3
    assert np.quantile(np.abs(numpy.confidence - kernels.confidence), 0.99) < 2e-3
    assert numpy.lit + numpy.dark == kernels.lit + kernels.dark == values.shape[0] * values.shape[1]
    assert abs(numpy.lit - kernels.lit) < 1e-3 * numpy.lit
    # each looks at some of the values
    assert np.median(kernels.residuals) == pytest.approx(np.median(numpy.residuals), rel=0.25)


@needs_numba
@pytest.mark.parametrize("solver", SOLVERS)
def test_kernels_and_numpy_agree_on_real_photographs(data, solver):
    capture = read_capture(data / "photometric" / "bunny" / "bunny_lambert")
    values = capture.photographs.at(np.flatnonzero(capture.mask)[::8])
    numpy, kernels = both(values, capture.lights, solver)
    off = degrees_apart(numpy.normals, kernels.normals)
    assert off.mean() < 0.002 and np.quantile(off, 0.99) < 0.02 and off.max() < 0.1


@needs_numba
@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("count", [1, 63, 64, 65])
def test_a_pixel_does_not_depend_on_its_neighbours(solver, count):
    values, lights = glossy_values(colour=False)
    options = {"solver": solver, "black_level": 0.0, "settings": RobustSettings()}
    some = compiled.solve_tile(values[:, 300 : 300 + count], lights, **options)
    whole = compiled.solve_tile(values, lights, **options)
    assert np.array_equal(some.normals, whole.normals[300 : 300 + count])
    assert np.array_equal(some.confidence, whole.confidence[300 : 300 + count])


@needs_numba
@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("level", [0.0, 1.0])
def test_black_and_white_pixels_have_no_confidence_and_stay_finite(solver, level):
    _, lights = glossy_values(colour=False)
    for shape in ((14, 70), (14, 70, 3)):
        done = compiled.solve_tile(
            np.full(shape, level, np.float32),
            lights,
            solver=solver,
            black_level=0.0,
            settings=RobustSettings(),
        )
        assert (done.confidence == 0).all()
        assert np.isfinite(done.normals).all() and np.isfinite(done.albedo).all()
        assert np.allclose(np.linalg.norm(done.normals, axis=1), 1, atol=1e-5)


def test_without_numba_numpy_solves_and_a_warning_names_the_factor(monkeypatch):
    values, lights = glossy_values(colour=False)
    images = values.reshape(14, 70, 90)
    with_numba = solve(images, lights)
    monkeypatch.setitem(sys.modules, "numba", None)
    compiled.has_numba.cache_clear()
    try:
        with pytest.warns(compiled.SlowSolverWarning, match=r"10 to 30 times as long; pip install numba"):
            without = solve(images, lights)
    finally:
        compiled.has_numba.cache_clear()
    off = degrees_apart(with_numba.normals, without.normals)
    assert np.quantile(off, 0.999) < 0.02
