"""The paper's three lamps and plain least squares: exact on noise-free Lambertian surfaces."""

from __future__ import annotations

import numpy as np
import pytest

from rumu.errors import SurfaceError
from rumu.surface.integrate import integrate
from rumu.surface.solve import Solution, solve
from rumu.surface.stereo import gradients_from_normals, normals_from_gradients, three_lamps
from rumu_lab.simulation.lamps import Sensor, photographs
from rumu_lab.simulation.shapes import bump, plane

PAPER = (0.0, 90.0, 180.0, 270.0)
SIZE = (60, 80)
LINEAR = Sensor(clip=False)


def lit_bump(*, slant=40.0, albedo=0.8, tilts=PAPER[:3], **options):
    shape = bump(SIZE, peak=6.0, sigma=14.0)
    images, lights = photographs(
        shape.height, albedo, tilts=tilts, slant=slant, normals=shape.normals, cast_shadows=False, **options
    )
    return shape, images, lights


def least_squares(images, lights) -> Solution:
    return solve(images, lights, solver="least_squares")


@pytest.mark.parametrize("slant", [15.0, 40.0, 60.0])
def test_three_lamps_recover_slopes_and_albedo_exactly(slant):
    albedo = np.linspace(0.1, 0.9, SIZE[1]) * np.ones(SIZE)
    shape, images, _ = lit_bump(slant=slant, albedo=albedo, sensor=LINEAR)
    found = three_lamps(*images, slant=slant)
    p, q = gradients_from_normals(shape.normals)
    assert found.valid.all()
    assert np.abs(found.p - p).max() < 1e-4
    assert np.abs(found.q - q).max() < 1e-4
    assert np.abs(found.albedo - albedo).max() < 1e-5
    assert np.abs(found.normals - shape.normals).max() < 1e-4
    assert found.fourth_lamp is None


def test_the_fourth_lamp_is_predicted_and_agrees():
    shape, images, _ = lit_bump(tilts=PAPER)
    a, b, c, d = images
    assert np.abs(d - (a + c - b)).max() < 1e-6
    found = three_lamps(a, b, c, slant=40.0, d=d)
    assert found.fourth_lamp < 1e-6
    assert np.abs(found.q - gradients_from_normals(shape.normals)[1]).max() < 1e-4
    spoilt = three_lamps(a, b, c, slant=40.0, d=1.2 * d)
    assert spoilt.fourth_lamp > 0.05


def test_the_fourth_lamp_quietens_q():
    flat = plane((200, 200), p=0.0, q=0.0)
    images, _ = photographs(
        flat.height, 0.8, tilts=PAPER, slant=45.0, normals=flat.normals, sensor=Sensor(noise=0.004, seed=1)
    )
    three, four = three_lamps(*images[:3], slant=45.0), three_lamps(*images[:3], slant=45.0, d=images[3])
    assert three.q.std() / three.p.std() == pytest.approx(np.sqrt(3.0), rel=0.05)
    assert four.q.std() / four.p.std() == pytest.approx(1.0, rel=0.05)
    brightness = 0.8 * np.cos(np.radians(45.0))
    assert three.p.std() == pytest.approx(np.sqrt(2) * 0.004 / (2 * brightness), rel=0.05)


def test_flat_ink_on_flat_paper_has_no_relief():
    ink = np.zeros((128, 128), dtype=bool)
    ink[30:100, 40:60] = ink[60:75, 20:110] = True
    flat = plane(ink.shape, p=0.0, q=0.0)
    images, _ = photographs(
        flat.height,
        np.where(ink, 0.06, 0.85),
        tilts=PAPER[:3],
        slant=45.0,
        normals=flat.normals,
        sensor=Sensor(noise=0.004, seed=3),
    )
    found = three_lamps(*images, slant=45.0)
    height = integrate(found.normals)
    assert abs(np.median(found.p[ink])) < 0.01
    assert abs(np.corrcoef(height.ravel(), ink.ravel())[0, 1]) < 0.1
    assert np.median(found.albedo[ink]) == pytest.approx(0.06, abs=0.005)


def test_a_bump_is_brighter_on_its_right_flank_in_image_a():
    shape, (a, b, c), _ = lit_bump()
    right, left = a[30, 50:65].mean(), a[30, 15:30].mean()
    assert right > left
    height = integrate(three_lamps(a, b, c, slant=40.0).normals)
    assert np.corrcoef(height.ravel(), shape.height.ravel())[0, 1] > 0.999
    # Lamps taken for each other turn the relief about: what rises along x sinks.
    inside_out = three_lamps(c, b, a, slant=40.0)
    assert np.allclose(inside_out.p, -three_lamps(a, b, c, slant=40.0).p, atol=1e-6)


def test_ambient_light_shrinks_every_slope_by_the_known_share():
    _, (a, b, c), _ = lit_bump()
    clean, veiled = three_lamps(a, b, c, slant=40.0), three_lamps(a + 0.1, b + 0.1, c + 0.1, slant=40.0)
    share = (a + c) / (a + c + 0.2)
    assert np.allclose(veiled.p, clean.p * share, atol=1e-5)
    assert np.allclose(veiled.q, clean.q * share, atol=1e-5)


def test_shadow_and_saturation_are_not_valid():
    _, (a, b, c), _ = lit_bump()
    a, b = a.copy(), b.copy()
    a[5, 5], b[6, 6] = 0.0, 1.0
    found = three_lamps(a, b, c, slant=40.0)
    assert not found.valid[5, 5] and not found.valid[6, 6] and found.valid[7, 7]
    assert found.p[5, 5] == 0.0 and found.albedo[6, 6] == 0.0
    black = three_lamps(*np.zeros((4, 8, 8))[:3], slant=40.0, d=np.zeros((8, 8)))
    assert not black.valid.any() and np.isfinite(black.normals).all() and black.fourth_lamp == 0.0


def test_least_squares_is_exact_where_every_lamp_reaches():
    shape, images, lights = lit_bump(tilts=(0, 60, 140, 200, 300), slant=35.0)
    found = least_squares(images, lights)
    assert np.abs(found.normals - shape.normals).max() < 1e-5
    assert np.abs(found.albedo - 0.8).max() < 1e-5
    assert (found.confidence > 0).all()


def test_least_squares_agrees_with_the_closed_form():
    _, images, lights = lit_bump(sensor=Sensor(noise=0.01, seed=5))
    closed, general = three_lamps(*images, slant=40.0), least_squares(images, lights)
    assert np.allclose(closed.normals, general.normals, atol=1e-5)
    assert np.allclose(closed.albedo, general.albedo, atol=1e-5)


def test_gradients_and_normals_are_inverse_and_clamped():
    rng = np.random.default_rng(0)
    p, q = rng.normal(0, 1, (2, 20, 30)).astype(np.float32)
    back = gradients_from_normals(normals_from_gradients(p, q))
    assert np.allclose(back[0], p, atol=1e-5) and np.allclose(back[1], q, atol=1e-5)
    steep = np.array([[[1.0, 0.0, 0.0], [0.6, 0.8, -0.5], [0.0, 0.0, 0.0], [0.0, 0.0, -1.0]]])
    p, q = gradients_from_normals(steep, steepest=10.0)
    assert np.allclose(np.hypot(p, q), [[10.0, 10.0, 0.0, 0.0]], atol=1e-5)
    assert p[0, 0] < 0 and q[0, 1] < 0


@pytest.mark.parametrize("slant", [0.0, 90.0, -10.0, float("nan")])
def test_a_bad_slant_is_refused(slant):
    image = np.full((4, 4), 0.5)
    with pytest.raises(SurfaceError, match="slant strictly between 0 and 90"):
        three_lamps(image, image, image, slant=slant)


def test_images_that_do_not_belong_together_are_refused():
    image = np.full((4, 4), 0.5)
    with pytest.raises(SurfaceError, match="images of one shape"):
        three_lamps(image, image, np.full((4, 5), 0.5), slant=45.0)
    with pytest.raises(SurfaceError, match="finite image b"):
        three_lamps(image, np.full((4, 4), np.nan), image, slant=45.0)
    with pytest.raises(SurfaceError, match=r"image a of shape \(H, W\)"):
        three_lamps(np.zeros((4, 4, 3)), image, image, slant=45.0)
    with pytest.raises(SurfaceError, match=r"lights of shape \(3, 3\)"):
        least_squares(np.zeros((3, 4, 4)), np.eye(3)[:2])
    with pytest.raises(SurfaceError, match="one plane"):
        least_squares(np.zeros((3, 4, 4)), np.array([[1.0, 0, 0], [0, 0, 1.0], [0.6, 0, 0.8]]))
    with pytest.raises(SurfaceError, match="finite images"):
        least_squares(np.full((3, 4, 4), np.inf), np.eye(3))
    with pytest.raises(SurfaceError, match="N >= 3"):
        least_squares(np.zeros((2, 4, 4)), np.eye(3)[:2])
