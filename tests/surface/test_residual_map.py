import numpy as np

from rumu.capture.lights import direction
from rumu.surface.photometric import photometric
from rumu.surface.residual_map import residual_map
from rumu.values import Capture
from rumu_lab.simulation.lamps import photographs
from rumu_lab.simulation.shapes import bump


def made(*, spoilt: bool):
    known = bump((96, 120), peak=8.0, sigma=20.0)
    tilts = [0, 60, 120, 180, 240, 300]
    images, _ = photographs(known.height, 0.7, tilts=tilts, slant=40.0, normals=known.normals)
    if spoilt:  # what lies there is no surface: it shines under every second lamp
        images[::2, 20:40, 30:60] = 0.9
    lights = np.array([direction(tilt=t, slant=40.0) for t in tilts])
    mask = np.ones((96, 120), bool)
    mask[:10] = False
    capture = Capture(images=images, lights=lights, mask=mask)
    return capture, photometric(capture)


def test_a_place_that_is_no_surface_stands_out():
    capture, surface = made(spoilt=True)
    found = residual_map(capture, surface, side=60)
    assert found.shape == (48, 60)
    inside, outside = found[12:18, 17:28], found[30:, 35:]
    assert np.nanmedian(inside) > 0.15 and np.nanmedian(outside) < 0.02
    assert np.isnan(found[:4]).all()  # outside the mask


def test_a_true_surface_is_all_pale():
    capture, surface = made(spoilt=False)
    found = residual_map(capture, surface)
    assert np.nanmax(found) < 0.01 and np.isfinite(found[12:]).all()
