"""Whether a surface seems to shine where other materials than Lambert's are not looked for.

They are looked for under eight lamps or more that are far away, see `rumu.surface.beyond_lambert`. Under
fewer lamps the solver forgets what contradicts Lambert's law, and the usual residual stays small; but a
highlight is brighter than the law says, and shadows never are. What changes slowly over the sheet is a near
lamp's light, and does not count.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.capture.flatfield import quadratic_terms
from rumu.image_stack import pixels_of
from rumu.surface.reflectance import MaterialSettings
from rumu.surface.residual_map import is_lit, seen_and_law
from rumu.values import Bilingual, Capture, FloatArray, Surface


@dataclass(frozen=True, slots=True)
class GlossSettings:
    """When a surface seems to shine.

    brighter: share of a pixel's brightness by which a lamp exceeds the law. share: of the pixels of which one
    lamp does. lamps: fewest that can tell. pixels: about how many are looked at.
    """

    brighter: float = 0.1
    share: float = 0.4
    lamps: int = 5
    pixels: int = 10_000


def gloss_notes(
    capture: Capture, surface: Surface, *, settings: GlossSettings | None = None
) -> tuple[Bilingual, ...]:
    """A note where a capture of few lamps, or of lamps near the sheet, seems to shine; empty otherwise."""
    settings = settings or GlossSettings()
    count, least = len(capture.lights), MaterialSettings().least_lamps
    if count < settings.lamps or (count >= least and capture.positions is None):
        return ()
    share = _share_that_shines(capture, surface, settings)
    if share < settings.share:
        return ()
    why = (
        Bilingual(f"只有 {count} 盞燈（至少要 {least} 盞）", f"there are {count} lamps, and it takes {least}")
        if count < least
        else Bilingual("燈離紙很近", "the lamps stand near the sheet")
    )
    return (
        Bilingual(
            f"表面似乎有光澤：{100 * share:.0f}% 的地方，有一盞燈下比無光的表面亮得多。{why.zh}，"
            "所以沒有尋找別的材質，斜率可能差好幾度；請用更多、更遠的燈再拍（燈離紙不到一張紙寬時，看來也會這樣）。",
            f"the surface seems to shine: in {100 * share:.0f}% of it one lamp shows far more light than "
            f"matt ground would. Other materials were not looked for, since {why.en}, and the slopes may be "
            "off by several degrees; photograph it under more lamps, far away "
            "(lamps nearer than the sheet is wide look like that, too)",
        ),
    )


def _share_that_shines(capture: Capture, surface: Surface, settings: GlossSettings) -> float:
    """Share of the pixels that one lamp shows clearly brighter than Lambert's law does."""
    pixels = pixels_of(surface.mask, about=settings.pixels)
    values, law = seen_and_law(capture, surface, pixels)
    rows, columns = np.divmod(pixels, surface.height.shape[1])
    height, width = surface.height.shape
    terms = quadratic_terms(columns / width, rows / height)
    wanted = np.array([_evened(seen, shown, terms) for seen, shown in zip(values, law, strict=True)])
    bright = np.maximum(wanted.max(axis=0), 1e-6)
    return float(np.mean(((values - wanted) / bright).max(axis=0) > settings.brighter))


def _evened(values: FloatArray, law: FloatArray, terms: FloatArray) -> FloatArray:
    """(P,) what the law makes under one lamp, times its strength, which may change slowly: a quadric."""
    lit = is_lit(values, law)
    if np.count_nonzero(lit) < 2 * terms.shape[1]:
        return law
    ratio = np.clip(values[lit] / law[lit], 0.0, 2.0 * float(np.median(values[lit] / law[lit])))
    return np.asarray(law * (terms @ np.linalg.lstsq(terms[lit], ratio, rcond=None)[0]))
