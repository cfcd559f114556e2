"""Colour on a page: red marks beside black ink, coloured ink where nothing is black, and what is a seal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.capture.image import Bytes, bounding_box, shrink
from rumu.surface.paper import REDUCED_SIDE, Polarity, tone
from rumu.values import BoolArray, FloatArray


@dataclass(frozen=True, slots=True)
class RedSettings:
    """How red a seal, a red grid or a printed address is: red over the larger of green and blue.

    on_dark: least excess on a dark ground, in gray levels. reddish: the same on paper, as a share of the
        paper's brightest channel. pale, plain: least excess as a share of red itself, of what is reddish and
        of what is plainly red. plain_share: share of a connected reddish part that must be plainly red; the
        rest of what is reddish is brown ink.
    """

    on_dark: int = 25
    reddish: float = 0.09
    pale: float = 0.2
    plain: float = 0.35
    plain_share: float = 0.2


def find_red_marks(
    view: Bytes, *, paper: FloatArray, polarity: Polarity, settings: RedSettings | None = None
) -> BoolArray:
    """(H, W) bool: seals, red grids, printed addresses.

    view: (H, W, 3) uint8. paper: (3,) colour of the paper, 0-255; its own brown is divided out, so that silk
    does not count as red. On a dark ground there is nothing to divide by, and strokes are as brown as paper.
    """
    import cv2

    settings = settings or RedSettings()
    gains = np.ones(3) if polarity == "light" else _gains(paper)
    table = np.stack([np.clip(np.arange(256) * g, 0, 255) for g in gains], axis=1).astype(np.uint8)
    r, g, b = cv2.split(cv2.LUT(view, table[:, None, :]))
    excess = cv2.subtract(r, cv2.max(g, b))
    plain = excess > cv2.convertScaleAbs(r, alpha=settings.plain)
    if polarity == "light":
        return np.asarray((excess > settings.on_dark) & plain)
    reddish = excess > settings.reddish * float(paper.max())
    reddish &= excess > cv2.convertScaleAbs(r, alpha=settings.pale)
    if not reddish.any():
        return np.asarray(reddish)
    _, parts = cv2.connectedComponents(reddish.astype(np.uint8), connectivity=8)
    share = np.bincount(parts[reddish & plain], minlength=int(parts.max()) + 1) / np.bincount(parts.ravel())
    return np.asarray(reddish & (share > settings.plain_share)[parts])


def coloured_as_gray(picture: Bytes) -> Bytes:
    """(H, W) uint8 in which ink of any colour is dark: the darkest channel over that of the paper.

    picture: (H, W, 3) uint8.
    """
    import cv2

    small = shrink(picture, side=REDUCED_SIDE)
    bright = tone(small, polarity="dark")
    paper = np.median(small[bright >= np.median(bright)], axis=0)
    table = np.clip(np.arange(256)[:, None] * _gains(paper), 0, 255).astype(np.uint8)
    a, b, c = cv2.split(cv2.LUT(picture, table[:, None, :]))
    return np.asarray(cv2.min(cv2.min(a, b), c), dtype=np.uint8)


def redness(view: Bytes, *, paper: FloatArray) -> FloatArray:
    """(H, W) float32: how much redder than green and blue, as a share of the paper.

    view: (H, W, 3) uint8. paper: (3,) colour of the paper, 0-255, which is divided out.
    """
    import cv2

    table = np.clip(np.arange(256)[:, None] * _gains(paper), 0, 255).astype(np.float32)
    r, g, b = cv2.split(cv2.LUT(view, table[:, None, :]))
    return np.asarray((r - cv2.max(g, b)) / max(float(paper.max()), 1.0), dtype=np.float32)


def _gains(paper: FloatArray) -> FloatArray:
    """(3,) factors that make the colour of the paper gray."""
    return np.asarray(np.maximum(paper.max(), 1.0) / np.maximum(paper, 1.0))


@dataclass(frozen=True, slots=True)
class SealSettings:
    """When ink of one colour on a page without black ink is a seal, not writing.

    small: extent, as a share of the page's side, below which it is no character. square, edge: extent up to
    which, and share of each side of its box from which, its outline makes it a seal; band: of the box, in
    which its outline lies.
    """

    small: float = 0.28
    square: float = 0.6
    edge: float = 0.8
    band: float = 0.08


def is_seal(mask: BoolArray, *, settings: SealSettings | None = None) -> bool:
    """Whether ink (H, W) of one colour is a seal: small, or within four straight sides."""
    settings = settings or SealSettings()
    y0, y1, x0, x1 = bounding_box(mask)
    extent = max((y1 - y0) / mask.shape[0], (x1 - x0) / mask.shape[1])
    if extent < settings.small or extent > settings.square:
        return bool(extent < settings.small)
    box = mask[y0:y1, x0:x1]
    deep, wide = (max(1, round(settings.band * n)) for n in box.shape)
    sides = (
        box[:deep].any(axis=0),
        box[-deep:].any(axis=0),
        box[:, :wide].any(axis=1),
        box[:, -wide:].any(axis=1),
    )
    return all(float(side.mean()) > settings.edge for side in sides)
