"""Where copy and master part: strokes that the copy lacks, and ink where the master is blank."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from rumu.assessment.omissions import MasterLines, left_over
from rumu.values import FloatArray, Registration

Kind = Literal["missing", "extra"]


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """What one has and the other lacks.

    points: (n, 2) where, on centre lines, in the frame of the master, rms radii, y up. share: of the ink, of
    the copy for 'extra', of the master for 'missing'. strokes: how many usual strokes of the master that is.
    """

    kind: Kind
    points: FloatArray
    share: float
    strokes: float


def find_regions(registration: Registration, master: MasterLines) -> tuple[Region, ...]:
    """What is missing and what is too much, as far as it is believed; see `omissions`."""
    left = left_over(registration, master)
    if left is None:
        return ()
    found = (
        Region("missing", left.missing_at, left.missing, left.missing / left.usual),
        Region("extra", left.extra_at, left.extra, left.extra / left.usual),
    )
    return tuple(region for region in found if region.share > 0.0)
