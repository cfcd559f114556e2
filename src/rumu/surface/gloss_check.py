"""Whether a surface seems to shine, and its gloss cannot be parted from it.

Other materials than Lambert's are looked for under eight lamps or more that are far away, see
`rumu.surface.beyond_lambert`. On a flat sheet they are found, but all places show the same of the gloss, and
how it falls off cannot be learnt. Under fewer lamps the solver forgets what contradicts Lambert's law, and
the usual residual stays small; but a highlight is brighter than the law says, and shadows never are. What
changes slowly over the sheet is a near lamp's light, and does not count.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.capture.flatfield import quadratic_terms
from rumu.image_stack import pixels_of
from rumu.surface.reflectance import MaterialSettings
from rumu.surface.residual_map import is_lit, seen_and_law
from rumu.values import Bilingual, Capture, FloatArray, Surface

_ALIKE = Bilingual(
    "表面似有光澤，又很平：各處反光都一樣，由照片學不到光澤如何減弱，所以顏色（反照率）不可信，"
    "深色處尤其會偏亮偏灰。要準確的顏色，請讓燈低一些（不要反射進鏡頭），或用交叉偏振濾鏡拍。",
    "the surface seems to shine and is flat: all places show the same of the gloss, so how it falls off "
    "cannot be learnt, and colours (the albedo) cannot be trusted, dark ones least: they come out too bright "
    "and pale. For true colours put the lamps lower, so that none is mirrored toward the camera, or use "
    "crossed polarisers",
)


@dataclass(frozen=True, slots=True)
class GlossSettings:
    """When a surface seems to shine.

    brighter: share of a pixel's brightness by which a lamp exceeds the law. share: of the pixels of which one
    lamp does. lamps: fewest that can tell. pixels: about how many are looked at.
    flat: degrees within which nine tenths of a flat sheet face one way. below_black: black level that gloss
        on a flat sheet explains, since no camera takes so much away.
    """

    brighter: float = 0.1
    share: float = 0.4
    lamps: int = 5
    pixels: int = 10_000
    flat: float = 5.0
    below_black: float = -0.02


def gloss_notes(
    capture: Capture, surface: Surface, *, settings: GlossSettings | None = None
) -> tuple[Bilingual, ...]:
    """A note where a flat sheet shines, or a surface under few lamps or near ones; empty otherwise."""
    settings = settings or GlossSettings()
    if _shines_alike(capture, surface, settings):
        return (_ALIKE,)
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


def _shines_alike(capture: Capture, surface: Surface, settings: GlossSettings) -> bool:
    """Whether a flat sheet shines: by the materials that were found, or else by a level far below black."""
    few = len(capture.lights) < MaterialSettings().least_lamps or capture.positions is not None
    below = surface.quality.get("black_level", 0.0) < settings.below_black
    if surface.quality.get("materials", 0.0) == 0 and not (few and below):
        return False
    pixels = pixels_of(surface.mask, about=settings.pixels)
    albedo = surface.albedo.reshape(surface.height.size, -1)[pixels].mean(axis=1)
    normals = surface.normals.reshape(-1, 3)[pixels[albedo >= np.median(albedo)]]  # noise turns dark ones
    middle = normals.mean(axis=0)
    cosine = normals @ (middle / np.linalg.norm(middle))
    return bool(np.quantile(cosine, 0.1) > np.cos(np.radians(settings.flat)))


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
