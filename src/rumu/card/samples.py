"""What the card's own white and grays show in a photograph: brightness at known places."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.card.finding import CardView
from rumu.card.layout import CardLayout
from rumu.image_stack import Photograph
from rumu.values import BoolArray, FloatArray

_FINE = 2  # pixels of the flat card for each millimetre
_CELL = 2  # millimetres of the side of a cell in which white is averaged
_INNER = 0.55  # of a gray patch's side, that is looked at
_BURNT = 0.985  # of white of the file, in any channel, from which a value is burnt out


@dataclass(frozen=True, slots=True, eq=False)
class CardPlaces:
    """Where a card is looked at. white: (n, 2) and gray: (k, 2), millimetres from its middle, y up.

    levels: (k,), the number of the gray in GRAYS.
    """

    layout: CardLayout
    white: FloatArray
    gray: FloatArray
    levels: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class CardSamples:
    """Brightness of one photograph at these places, linear as its file means it, 1 at full scale.

    white: (n,). gray: (k,). out_white, out_gray: squared distance from the picture's middle there, 1 in its
    corners. burnt: share of the white that is burnt out.
    """

    white: FloatArray
    gray: FloatArray
    out_white: FloatArray
    out_gray: FloatArray
    burnt: float


def card_places(layout: CardLayout) -> CardPlaces:
    """The cells of blank paper, and the gray patches."""
    width, height = layout.size
    middle = np.array([width, height]) / 2
    x, y = np.meshgrid(np.arange(_CELL / 2, width, _CELL), np.arange(_CELL / 2, height, _CELL))
    cells = np.column_stack([x.ravel(), y.ravel()])
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]) * _CELL / 2
    white: BoolArray = np.all([layout.is_white(cells + corner) for corner in corners], axis=0)
    patches = layout.patches
    gray = np.array([patch.box.corners.mean(axis=0) for patch in patches])
    up = np.array([1.0, -1.0])
    return CardPlaces(
        layout, (cells[white] - middle) * up, (gray - middle) * up, np.array([p.level for p in patches])
    )


def sample_card(photograph: Photograph, view: CardView, places: CardPlaces) -> CardSamples:
    """The brightness of a photograph at these places."""
    import cv2

    light = photograph.light()
    top = np.asarray(light if light.ndim == 2 else light.max(axis=2))
    green = np.ascontiguousarray(light if light.ndim == 2 else light[..., 1])
    paper = places.layout.size
    size = (round(paper[0] * _FINE), round(paper[1] * _FINE))
    to_fine = np.array([[1 / _FINE, 0, 0.5 / _FINE], [0, 1 / _FINE, 0.5 / _FINE], [0, 0, 1.0]])
    smooth = cv2.GaussianBlur(green, (0, 0), max(0.3, 0.4 * view.scale() / _FINE))
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    flat = cv2.warpPerspective(smooth, view.homography @ to_fine, size, flags=flags)
    most = cv2.warpPerspective(top, view.homography @ to_fine, size, flags=flags)
    cell = _FINE * _CELL
    mean = cv2.blur(flat, (cell, cell))
    middle, up = np.array(paper) / 2, np.array([1.0, -1.0])

    def at(points: FloatArray, picture: FloatArray) -> FloatArray:
        place = (points * up + middle) * _FINE
        column, row = place.astype(int).T
        return np.asarray(picture[row.clip(0, size[1] - 1), column.clip(0, size[0] - 1)], np.float64)

    def out(points: FloatArray) -> FloatArray:
        return view.out(view.pixels(points * up + middle))

    half = round(places.layout.patches[0].box.width * _INNER * _FINE)
    grays = cv2.blur(flat, (half, half))
    return CardSamples(
        at(places.white, mean),
        at(places.gray, grays),
        out(places.white),
        out(places.gray),
        float((at(places.white, most) > _BURNT).mean()),
    )
