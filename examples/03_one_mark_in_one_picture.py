"""A mark in one picture: the master, a simulated copy, the copy as a mesh, and both laid on each other.

The picture goes to the path given, or to one-mark.png; the README's was made so.
"""

import sys

import numpy as np
from PIL import Image

import rumu
from rumu.gallery.starter import find_work, starter_samples
from rumu.pipeline import surface_of
from rumu.report.mesh_picture import MeshView, mesh_picture
from rumu.report.overlay import OverlaySettings, overlay_picture
from rumu.report.pictures import PAPER, albedo_picture, shrink_to_fit

SIDE, GAP = 300, 12

sample = next(s for s in starter_samples(work="regular-shui") if s.degree == "medium")
master, copy = surface_of(find_work(sample.work).path), surface_of(sample.path)
mark = rumu.assess(copy, master)


def tile(picture: np.ndarray) -> np.ndarray:
    """The picture in the middle of a square of paper."""
    if picture.ndim == 2:  # gray on white becomes gray on paper
        picture = np.round(picture[..., None] / 255 * np.array(PAPER)).astype(np.uint8)
    small = shrink_to_fit(picture, side=SIDE)
    square = np.full((SIDE, SIDE, 3), PAPER, dtype=np.uint8)
    top, left = (SIDE - small.shape[0]) // 2, (SIDE - small.shape[1]) // 2
    square[top : top + small.shape[0], left : left + small.shape[1]] = small
    return square


pictures = [
    albedo_picture(master),
    albedo_picture(copy),
    mesh_picture(copy, view=MeshView(width=2 * SIDE))[0],
    overlay_picture(mark.registration, master=master, settings=OverlaySettings(side=2 * SIDE)),
]
gap = np.full((SIDE, GAP, 3), 255, dtype=np.uint8)
row = [part for picture in pictures for part in (tile(picture), gap)][:-1]
target = sys.argv[1] if len(sys.argv) > 1 else "one-mark.png"
Image.fromarray(np.concatenate(row, axis=1)).save(target, optimize=True)
print(f"{target}: {sample.id} (simulated), {mark.score:.0f} of 100, {mark.level}")
