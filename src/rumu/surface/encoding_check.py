"""Whether photographs that were read as light hold values for a screen, as many PNGs and TIFFs do.

Under several lamps it shows: such values contradict Lambert's law. The other way round it does not: what is
made for a screen flattens highlights, so that a glossy sheet seems to be the wrong kind.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.capture.image import to_linear
from rumu.image_stack import pixels_of
from rumu.surface.compiled import tile_solver
from rumu.surface.robust import RobustSettings
from rumu.values import Bilingual, Capture, FloatArray, Surface


@dataclass(frozen=True, slots=True)
class EncodingSettings:
    """When it is told that photographs hold values for a screen.

    lamps: fewest that can contradict. least: median share of the brightness that the law leaves unexplained,
    which is as good as none. gain: share of it that remains for values of a screen at most. simpler: the
    same, of equal lamps: values for a screen then explain what would else be lamps of many strengths.
    pixels: about how many are looked at. rounds: in which the strengths of the lamps are found. seen:
    brightness by the law from which a value tells of its lamp. lit: share of the values that are not in
    shadow, below which nothing is told.
    """

    lamps: int = 6
    least: float = 0.01
    gain: float = 0.65
    simpler: float = 0.25
    pixels: int = 4000
    rounds: int = 3
    seen: float = 0.03
    lit: float = 0.5


def encoding_notes(
    capture: Capture, surface: Surface | None = None, *, settings: EncodingSettings | None = None
) -> tuple[Bilingual, ...]:
    """A note where photographs that were read as light agree far better as values for a screen.

    surface: of the capture, where it was made; where other materials were found in it, nothing is said, nor
    of few lamps and of lamps near the sheet.
    """
    settings = settings or EncodingSettings()
    unclear = len(capture.lights) < settings.lamps or capture.positions is not None
    other = surface is not None and surface.quality.get("materials", 0.0) > 0
    if unclear or other or not capture.photographs.stored_as_light:
        return ()
    mask = capture.mask if surface is None else surface.mask
    values = capture.photographs.at(pixels_of(mask, about=settings.pixels))
    now, alike = _unexplained(values, capture.lights, settings)
    then, alike_then = _unexplained(to_linear(values), capture.lights, settings)
    contradicts = settings.least < now < np.inf and then < settings.gain * now
    simpler = alike_then < settings.least < alike < np.inf and alike_then < settings.simpler * alike
    if not contradicts and not simpler:
        return ()
    if simpler and not contradicts:
        now, then = alike, alike_then
    return (
        Bilingual(
            f"照片讀作光的量，但似乎是螢幕用的值（sRGB）：那樣讀，與表面不合的亮度由 {100 * now:.1f}% 降到 "
            f'{100 * then:.1f}%。若是如此，請在 capture.json 寫 "encoding": "srgb"。',
            "the photographs were read as light, but seem to hold values for a screen (sRGB): read so, what "
            f"contradicts the surface falls from {100 * now:.1f}% of the brightness to {100 * then:.1f}%. If "
            'they do, use --encoding srgb, or write "encoding": "srgb" in capture.json',
        ),
    )


def _unexplained(values: FloatArray, lights: FloatArray, settings: EncodingSettings) -> tuple[float, float]:
    """The median share of the brightness that Lambert's law leaves, by lamps of any strength and equal ones.

    Infinite where most is dark. values: (N, P) or (N, P, 3).
    """
    rows = values if values.ndim == 2 else values.mean(axis=2)
    strengths, left = np.ones(len(lights)), []
    for _ in range(settings.rounds):
        lit = lights * strengths[:, None]
        done = tile_solver()(rows, lit, solver="robust", black_level=0.0, settings=RobustSettings())
        if done.lit <= settings.lit * (done.lit + done.dark):
            return np.inf, np.inf
        left.append(float(np.median(done.residuals)))
        law = np.maximum(lights @ done.normals.T, 0.0) * done.albedo
        told = [
            (seen[by > settings.seen], by[by > settings.seen]) for seen, by in zip(rows, law, strict=True)
        ]
        found = [float(np.median(seen / by)) if by.size else 1.0 for seen, by in told]
        strengths = np.maximum(np.array(found), 1e-3)
        strengths /= strengths.mean()
    return left[-1], left[0]
