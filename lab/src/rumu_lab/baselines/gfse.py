"""GFSE-based grader (our reconstruction), after Su and Wang 2003: strokes by Gabor filters.

Known from the abstract: a set of Gabor filters decomposes a character into directional features; an
iterative thresholding that minimises the reconstruction error recovers the shape of the strokes; a
refinement that measures how much strokes overlap removes redundant pieces. Its references name an
iterative threshold and an indefinite zero-one quadratic problem. It extracts strokes and gives no grade.

Our reconstruction: all constants; what makes the thresholding well posed (see `gabor`); the quadratic
problem (see `stroke_pieces`); and the whole grade: half the likeness of the directional features, half
that of the pieces. The copy is placed first, since pixels are compared. Both are filtered with the
reference's stroke width.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from rumu.values import FloatArray
from rumu_lab.baselines.cell import SIDE, Cell, Raw
from rumu_lab.baselines.gabor import GaborSettings, reconstruct, responses
from rumu_lab.baselines.placing import align, placement
from rumu_lab.baselines.stroke_pieces import Piece, choose_pieces, join_pieces, pieces_of

SMALL = 128
"""Side of the picture that is filtered; a stroke is still some six pixels wide there."""


@dataclass(frozen=True, slots=True)
class GfseSettings:
    """blur: of the directional features before they are compared, in cells.

    centre, angle, length, width: differences of two pieces, in cells, degrees and ratios, that cost 1 each.
    """

    gabor: GaborSettings = field(default_factory=GaborSettings)
    blur: float = 0.04
    centre: float = 0.2
    angle: float = 20.0
    length: float = 1.5
    width: float = 1.5


@dataclass(frozen=True, slots=True, eq=False)
class Extracted:
    """features: (directions, SMALL, SMALL) float32, blurred responses. pieces: what the ink is made of.

    error: of the reconstruction from all claims, over the ink.
    """

    features: FloatArray
    pieces: tuple[Piece, ...]
    error: float


def raw(probe: Cell, reference: Cell) -> Raw:
    """Mean of the likeness of the directional features and of the stroke pieces.

    features: 'directions' and 'pieces', the two halves in [0, 1]; 'error', the probe's reconstruction error;
    'count', the probe's pieces over the reference's; those of `placement`.
    """
    settings = GfseSettings()
    width = reference.width
    here, there = extract(align(probe, reference), width, settings), extract(reference, width, settings)
    directions = alike_features(here.features, there.features)
    pieces = alike_pieces(here.pieces, there.pieces, settings=settings)
    features = {
        "directions": directions,
        "pieces": pieces,
        "error": here.error,
        "count": len(here.pieces) / max(len(there.pieces), 1),
    }
    return Raw(min(0.5 * directions + 0.5 * pieces, 1.0), features | placement(probe, reference))


@lru_cache(maxsize=4)  # many copies of one master come in a row
def extract(cell: Cell, width: float, settings: GfseSettings) -> Extracted:
    """Directional features and stroke pieces of a cell; width: of the strokes, in pixels of the cell."""
    import cv2

    small = cv2.resize(cell.density, (SMALL, SMALL), interpolation=cv2.INTER_AREA)
    ink = cv2.resize(cell.ink.astype(np.float32), (SMALL, SMALL), interpolation=cv2.INTER_AREA) >= 0.5
    own = max(width * SMALL / SIDE, 2.0)
    found = responses(small, width=own, settings=settings.gabor)
    claims, error = reconstruct(found, ink, width=own, settings=settings.gabor)
    pieces = join_pieces(choose_pieces(pieces_of(claims, width=own), ink), width=own)
    blurred = np.array([cv2.GaussianBlur(f, (0, 0), settings.blur * SMALL) for f in found])
    return Extracted(blurred, tuple(pieces), error)


def alike_features(a: FloatArray, b: FloatArray) -> float:
    """Normalised cross-correlation per direction, below 0 cut, weighted by how much either writes in it."""
    x, y = (np.asarray(f - f.mean(axis=(1, 2), keepdims=True)).reshape(len(f), -1) for f in (a, b))
    of_x, of_y, of_both = (np.einsum("ij,ij->i", u, v) for u, v in ((x, x), (y, y), (x, y)))
    likeness = np.clip(of_both / np.maximum(np.sqrt(of_x * of_y), 1e-12), 0.0, 1.0)
    return float(np.average(likeness, weights=of_x + of_y + 1e-12))


def alike_pieces(a: tuple[Piece, ...], b: tuple[Piece, ...], *, settings: GfseSettings) -> float:
    """Likeness of the pieces matched one to one, weighted by length; one without a match adds 0."""
    from scipy.optimize import linear_sum_assignment

    if not a or not b:
        return 0.0
    likeness = np.exp(-_cost(a, b, settings))
    lengths = np.add.outer([p.length for p in a], [p.length for p in b])
    rows, columns = linear_sum_assignment(-likeness * lengths)
    total = sum(p.length for p in (*a, *b))
    return float((likeness * lengths)[rows, columns].sum() / total)


def _cost(a: tuple[Piece, ...], b: tuple[Piece, ...], settings: GfseSettings) -> FloatArray:
    """(len(a), len(b)): distance of two pieces in place, angle, length and width, each in its own unit."""

    def apart(values: list[float], others: list[float]) -> FloatArray:
        return np.asarray(np.abs(np.array(values)[:, None] - np.array(others)[None, :]))

    x, y = (apart([p.centre[k] for p in a], [p.centre[k] for p in b]) for k in (0, 1))
    angle = apart([p.angle for p in a], [p.angle for p in b])
    length, width = (
        apart([float(np.log(getattr(p, name))) for p in a], [float(np.log(getattr(p, name))) for p in b])
        for name in ("length", "width")
    )
    parts = (
        np.hypot(x, y) / (settings.centre * SMALL),
        np.minimum(angle, 180.0 - angle) / settings.angle,
        length / np.log(settings.length),
        width / np.log(settings.width),
    )
    return np.asarray(np.sqrt(np.sum(np.square(parts), axis=0)))
