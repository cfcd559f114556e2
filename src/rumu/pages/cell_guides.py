"""Which of the lines of a printed grid are sides of cells, and which are guides within them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rumu.pages.cell_lattice import Lattice, fits_of_sizes
from rumu.pages.cell_scores import edges_at, map_edges
from rumu.pages.line_evidence import LineEvidence, PrintedLineSettings, reduce_evidence


@dataclass(frozen=True, slots=True)
class CellGuideSettings:
    """When lines are guides: the cross of a 田字格, the thirds of a 九宫格.

    guide: by how much cells of two or three pitches are drawn more strongly where lines within them are
        guides. count: cells of one pitch that are compared, where there are so many; few: at least.
    stronger: by how much every second or third line of a lattice is stronger than the others where those are
        guides. compared: most pixels from line to line in the picture in which lines are compared; so small,
        a line that is wider is darker, too.
    """

    guide: float = 1.07
    count: int = 40
    few: int = 4
    stronger: float = 1.5
    compared: float = 36.0


def guides_within(
    evidence: LineEvidence,
    pitch: float,
    *,
    lines: PrintedLineSettings,
    settings: CellGuideSettings | None = None,
) -> tuple[int, float]:
    """Into how many parts guides divide a cell, whose edges are much stronger: 1, 2 or 3; and how strong."""
    settings = settings or CellGuideSettings()
    counts = [settings.count] + [max(settings.few, settings.count // times**2) for times in (2, 3)]
    fits = []
    for times in (1, 2, 3):
        edges = map_edges(evidence, times * pitch, reduction=lines.reduction, enough=1.0)
        fits.append(np.max([one for one, _, _ in fits_of_sizes(edges, counts)], axis=0))
    # a page of few cells has only so many of two or three pitches
    leads = [fits[k][k] / max(fits[0][k], 1e-6) for k in range(3)]
    best = int(np.argmax(leads))
    chosen = best if leads[best] > settings.guide else 0
    return chosen + 1, float(fits[chosen][0])


def lines_to_a_side(
    evidence: LineEvidence,
    lattice: Lattice,
    pitch: float,
    *,
    lines: PrintedLineSettings,
    settings: CellGuideSettings | None = None,
) -> int:
    """Every how many lines of a lattice are sides of cells, the others being guides: 1, 2 or 3.

    Lines are compared piece by piece of one length, so few cells tell it, too, and where they bend.
    """
    settings = settings or CellGuideSettings()
    share = min(1.0, settings.compared / pitch)
    if share < 1:
        evidence = reduce_evidence(evidence, share, settings=lines)
    edges = map_edges(evidence, share * pitch, reduction=lines.reduction, enough=1.0)
    places, cells = np.array(list(lattice.cells)), np.array(list(lattice.cells.values()))
    left, right, top, bottom = edges_at(edges, share * cells).T
    rows, columns = (np.concatenate([places[:, k], places[:, k] + 1]) for k in (0, 1))
    across, down = np.concatenate([top, bottom]), np.concatenate([left, right])
    best, lead = 1, settings.stronger
    for every in (2, 3):
        leads = []
        for numbers, values in ((rows, across), (columns, down)):
            kinds = [values[numbers % every == k] for k in range(every)]
            if min(map(len, kinds)) == 0:
                break
            *others, strongest = sorted(float(np.mean(one)) for one in kinds)
            leads.append(strongest / max(others[-1], 1e-6))
        if len(leads) == 2 and min(leads) > lead:
            best, lead = every, min(leads)
    return best
