"""Photographs under several lamps become a surface: of a mound whose height is known, so we can compare."""

import numpy as np

import rumu
from rumu_lab.simulation.lamps import photographs
from rumu_lab.simulation.shapes import bump

mound = bump((96, 96), peak=6.0, sigma=14.0)
images, lights = photographs(mound.height, 0.8, tilts=(0, 60, 120, 180, 240, 300), slant=40.0)
capture = rumu.Capture(images=images, lights=lights, mask=np.ones(images.shape[1:], dtype=bool))

surface = rumu.reconstruct(capture, solver="least_squares")
angle = np.degrees(np.arccos(np.clip((surface.normals * mound.normals).sum(axis=2), -1, 1)))
print(f"{len(images)} photographs, normals {angle.mean():.3f} degrees off on average")
print(f"the mound is {np.ptp(surface.height):.2f} px high; it was made 6.00")
