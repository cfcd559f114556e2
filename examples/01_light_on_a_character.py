"""One image of ink becomes a surface, and the surface is lit from where you like."""

from PIL import Image

import rumu
from rumu.gallery.starter import find_work
from rumu.report.pictures import srgb

surface = rumu.relief(find_work("seal-ri").path)
print(f"{surface.height.max():.0f} {surface.unit} high, source: {surface.source} (computed, not measured)")

for tilt in (0, 90, 180, 270):
    lit = rumu.relight(surface, tilt=tilt, slant=55)
    Image.fromarray(srgb(lit)).save(f"lit-from-{tilt}.png")
    print(f"lit-from-{tilt}.png")
