"""The sheet of paper in a photograph, where it lies on something darker that is no shadow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.capture.image import Bytes
from rumu.surface.paper import histogram, otsu_threshold, tone
from rumu.values import BoolArray, FloatArray


@dataclass(frozen=True, slots=True)
class SheetSettings:
    """When a picture shows a sheet that lies on something darker; shares of the picture unless said.

    least_area, most_area: of the sheet. bright: share of the sheet that is bright.
    rectangularity: share of its tightest rectangle that it fills.
    edge_step: step across its outline, as a share of the whole contrast.
    dark_border: share of the picture's border that is dark.
    margin: what is cut off the sheet all round, of the reduced side: its edge is soft and may curl.
    deepest: share of the bright part's light that paper in a shadow has at least, where ink runs into it;
        shadow_light: and where none does. shadow_hue: by how much the shares of the three colours may differ.
        shadow_ink: share of the level of either, below which
        it is ink there; shadow_pixels: least ink, of the reduced picture, that tells. bays: share of
        the sheet that is missing from its convex hull where ink runs into the dark beside it.
    """

    least_area: float = 0.25
    most_area: float = 0.97
    bright: float = 0.7
    rectangularity: float = 0.8
    edge_step: float = 0.4
    dark_border: float = 0.4
    margin: float = 0.03
    deepest: float = 0.03
    shadow_light: float = 0.3
    shadow_hue: float = 0.15
    shadow_ink: float = 0.6
    shadow_pixels: int = 12
    bays: float = 0.03


def find_sheet(small: Bytes, *, settings: SheetSettings | None = None) -> BoolArray | None:
    """(h, w) bool of a reduced picture: the sheet of paper that lies on a darker table; None if none does."""
    import cv2

    settings = settings or SheetSettings()
    gray = tone(small, polarity="dark")
    bright = gray > otsu_threshold(histogram(gray))
    rim = np.concatenate([bright[0], bright[-1], bright[:, 0], bright[:, -1]])
    outlines, _ = cv2.findContours(bright.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if 1.0 - rim.mean() < settings.dark_border or not outlines:
        return None
    outline = max(outlines, key=cv2.contourArea)
    sheet = cv2.drawContours(np.zeros(gray.shape, np.uint8), [outline], -1, 1, cv2.FILLED)
    (_, (width, height), _) = cv2.minAreaRect(outline)
    fills = cv2.contourArea(outline) / max(width * height, 1.0)
    if not settings.least_area < sheet.mean() < settings.most_area or fills < settings.rectangularity:
        return None
    contrast = float(np.median(gray[bright])) - float(np.median(gray[~bright]))
    sharp = _edge_step(gray, _straight_sides(outline)) > settings.edge_step * contrast
    if bright[sheet > 0].mean() < settings.bright or not sharp or _is_shadow(small, sheet > 0, settings):
        return None
    cut = 2 * max(1, round(settings.margin * max(gray.shape))) + 1
    border = {"borderType": cv2.BORDER_CONSTANT, "borderValue": 1}  # the picture's own side is no edge
    return np.asarray(cv2.erode(sheet, np.ones((cut, cut), np.uint8), **border) > 0)


def _is_shadow(small: Bytes, sheet: BoolArray, settings: SheetSettings) -> bool:
    """Whether what lies beside a bright part is the same paper in a shadow: as gray as it, with ink on it.

    The ink must run across the edge, or else the edge must cross the whole picture.
    """
    import cv2

    colours = small.reshape(*small.shape[:2], -1).astype(np.float32)
    light, dark = (np.percentile(colours[part], 75, axis=0) for part in (sheet, ~sheet))
    left = dark / np.maximum(light, 1.0)
    if left.mean() < settings.deepest or np.ptp(left) > settings.shadow_hue * left.mean() + settings.deepest:
        return False
    gray = tone(small, polarity="dark").astype(np.float32)
    ink = gray < settings.shadow_ink * np.where(sheet, light.max(), dark.max())
    _, parts, stats, _ = cv2.connectedComponentsWithStats(ink.astype(np.uint8), connectivity=8)
    kernel = np.ones((3, 3), np.uint8)
    inside, outside = (
        set(np.unique(parts[cv2.erode(side.astype(np.uint8), kernel) > 0])) - {0} for side in (sheet, ~sheet)
    )
    across = any(stats[part, cv2.CC_STAT_AREA] >= settings.shadow_pixels for part in inside & outside)
    sides = sum(bool(side.any()) for side in (sheet[0], sheet[-1], sheet[:, 0], sheet[:, -1]))
    rim = set(np.unique(np.concatenate([parts[0], parts[-1], parts[:, 0], parts[:, -1]])))
    alone = [part for part in outside - rim if stats[part, cv2.CC_STAT_AREA] >= settings.shadow_pixels]
    return across or (sides > 2 and bool(alone) and left.mean() > settings.shadow_light)


def _straight_sides(outline: FloatArray) -> FloatArray:
    """(N, 2) those points of an outline (columns, rows) that lie on its convex hull.

    Ink that reaches the side of what is bright makes bays in it, which are as sharp as its own edge.
    """
    import cv2

    hull = cv2.convexHull(outline)
    near = [cv2.pointPolygonTest(hull, (float(x), float(y)), True) < 1.5 for x, y in outline[:, 0]]
    return np.asarray(outline[near, 0])


def _edge_step(gray: Bytes, outline: FloatArray) -> float:
    """Median step across the outline (columns, rows), which is small in the middle of a gradient of light.

    What runs along the picture's own side does not count; -inf where all of it does.
    """
    import cv2

    height, width = gray.shape
    x, y = outline[:, 0], outline[:, 1]
    inside = (x > 0) & (x < width - 1) & (y > 0) & (y < height - 1)
    step = cv2.morphologyEx(gray, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))[y[inside], x[inside]]
    return float(np.median(step)) if inside.any() else -np.inf


def has_bays(off_sheet: BoolArray, *, settings: SheetSettings | None = None) -> bool:
    """Whether something dark runs in from beside the sheet: (H, W) bool, what lies off it."""
    import cv2

    settings = settings or SheetSettings()
    outlines, _ = cv2.findContours((~off_sheet).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    sheet = max(outlines, key=cv2.contourArea)
    whole = cv2.contourArea(cv2.convexHull(sheet))
    return bool(whole - cv2.contourArea(sheet) > settings.bays * whole)
