"""Which of a master's strokes a copy lacks, and which ink of the copy belongs to none of them.

A stroke is missing when the copy is explained as well without it, and when its place is bare paper. First
the strokes that found little ink of their own are picked out; then the copy is matched anew with a master
that lacks the stroke. A stroke that is there, but elsewhere, leaves its ink unexplained then; one that took
its neighbour's ink gives it back. When unsure, nothing is said.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from rumu.strokes.centre_lines import SCALE, CentreLines, FramedInk, find_segments, pixels_at
from rumu.strokes.matching import LineMatch, MatchSettings
from rumu.strokes.placement import (
    Placement,
    claimed_twice,
    draw_discs,
    fill_in,
    lay_without,
    move_ink,
    place_lines,
    predict_places,
    stroke_numbers,
)
from rumu.values import BoolArray, FloatArray


@dataclass(frozen=True, slots=True)
class MissingRule:
    """Figures that together say that a stroke is missing; see `StrokePresence` for the first four.

    min_gain: by how much the rest explains the copy better without the stroke, over its share of the ink.
    max_spare: largest patch near its place that the rest does not account for, over its own ink.
    """

    max_covered: float = 1.0
    min_bare: float = 0.0
    min_bare_expected: float = 0.0
    min_claimed: float = 0.0
    min_gain: float = 0.5
    max_spare: float = 0.3


@dataclass(frozen=True, slots=True)
class PresenceSettings:
    """When a stroke is missing. Lengths in stroke widths unless said.

    off_ink: distance from the copy's ink from which a point lies on bare paper. crossing: distance from
        another stroke within which a point is out of view; least_view: share of a stroke that must be in
        view, else all of it is taken to be.
    suspicious: figure from which a stroke is tested, and most_tested: how many are.
    min_share: share of the master's ink in a stroke below which nothing is said of it; min_unnamed_share:
        the same of a line that is no canonical stroke; small_share: up to which `small_rule` holds.
    rules: of which one must hold.
    there_covered, there_claimed, there_bare: share of a stroke, laid in another way, that must have found
        ink, and that may claim another's or lie on bare paper, for it to be there after all.
    tube, widest: half-width, over its own, up to which ink is a stroke's, and greatest of its half-widths
        over its usual one, so that what joins it is not its own. spare_reach: distance from the place of a
        stroke, rms radii, within which spare ink may be it.
    other_ways: of laying all strokes, tried before one is believed to be missing.
    """

    off_ink: float = 0.25
    crossing: float = 0.6
    least_view: float = 0.25
    suspicious: float = 0.3
    most_tested: int = 4
    min_share: float = 0.025
    min_unnamed_share: float = 0.06
    small_share: float = 0.045
    small_rule: MissingRule = MissingRule(0.3, 0.8, 0.8, min_gain=0.6, max_spare=0.2)
    rules: tuple[MissingRule, ...] = (
        MissingRule(0.4, 0.6, 0.6, min_gain=0.6, max_spare=0.45),  # found nothing
        MissingRule(min_bare=0.42, min_bare_expected=0.7, min_gain=0.4, max_spare=0.3),  # found some
        MissingRule(min_bare_expected=0.55, min_gain=0.7, max_spare=0.13),  # nothing is left for it
        MissingRule(min_bare_expected=0.9, min_claimed=0.25, max_spare=0.1),  # took another's ink
        MissingRule(0.15, 0.3, 0.3, min_gain=0.9, max_spare=0.13),  # mostly crossed by others
    )
    there_covered: float = 0.6
    there_claimed: float = 0.5
    there_bare: float = 0.2
    tube: float = 1.2
    widest: float = 1.25
    spare_reach: float = 0.6
    other_ways: tuple[MatchSettings, ...] = (
        MatchSettings(
            warp_sigmas=(0.35, 0.28, 0.22, 0.18, 0.15, 0.12),
            stroke_sigmas=(0.2, 0.17, 0.14, 0.12, 0.1, 0.085, 0.07, 0.06, 0.05),
            stroke_travel=0.4,
        ),
        MatchSettings(affine_cost=5.0, bend_cost=6.0, stroke_travel=0.3),
        MatchSettings(warp_sigmas=(0.12, 0.1, 0.08), stroke_sigmas=(0.1, 0.08, 0.06, 0.05)),
    )


PRESENCE = PresenceSettings()


@dataclass(frozen=True, slots=True, eq=False)
class StrokePresence:
    """How much of a stroke a copy has, before it is tested whether it is missing.

    number: of the canonical stroke, or else minus the number of the line, from -1. share: of the master's
    ink. covered: share of it that found ink of its own. bare: share that lies on bare paper where it was
    matched; bare_expected: the same where its neighbours predict it. claimed: share whose ink another stroke
    claims too.
    """

    number: int
    share: float
    covered: float
    bare: float
    bare_expected: float
    claimed: float

    @property
    def suspicion(self) -> float:
        """From 0 to 1, how much speaks for its being missing."""
        return max(self.bare, self.claimed, 1.0 - self.covered, 0.8 * self.bare_expected)

    @property
    def is_there(self) -> bool:
        """Whether it has found ink that is its own alone."""
        s = PRESENCE
        return self.covered >= s.there_covered and self.claimed < s.there_claimed and self.bare < s.there_bare

    def is_missing(self, gain: float, spare: float) -> bool:
        """Whether a rule says so; gain, spare: see `MissingRule`."""
        small = self.share < PRESENCE.small_share
        return any(
            self.covered <= rule.max_covered
            and self.bare >= rule.min_bare
            and self.bare_expected >= rule.min_bare_expected
            and self.claimed >= rule.min_claimed
            and gain >= rule.min_gain
            and spare <= rule.max_spare
            for rule in ((PRESENCE.small_rule,) if small else PRESENCE.rules)
        )


@dataclass(frozen=True, slots=True, eq=False)
class Compared:
    """A copy beside its master, in the common frame.

    master, copy: their lines. framed: the copy's ink. places: (n, 2) where the master's points lie when it is
    measured in the same way.
    """

    master: CentreLines
    copy: CentreLines
    framed: FramedInk
    places: FloatArray


def find_missing(compared: Compared) -> tuple[tuple[int, ...], Placement]:
    """Numbers of the strokes that the copy lacks, see `StrokePresence`, and all lines on the copy.

    When a stroke seems to be missing, other ways of laying the lines are tried, and what finds its ink in the
    best of them is there after all. That placement is given back.
    """
    master, copy = compared.master, compared.copy
    whole = place_lines(master, copy)
    missing = _find_missing(compared, whole)
    if not missing:
        return (), whole
    others = [place_lines(master, copy, settings=settings) for settings in PRESENCE.other_ways]
    best = min(others, key=lambda placement: placement.left_over)
    if best.left_over > whole.left_over:
        return missing, whole
    there = {presence.number for presence in measure_presence(compared, best) if presence.is_there}
    return tuple(number for number in missing if number not in there), best


def lay_rest(compared: Compared, missing: tuple[int, ...]) -> tuple[FramedInk, CentreLines, Placement]:
    """The copy's ink framed as the master's is without what is missing, and the lines on it.

    The points of what is missing stand where their neighbours predict them.
    """
    master, copy, framed, places = compared.master, compared.copy, compared.framed, compared.places
    numbers = stroke_numbers(master)
    kept = ~np.isin(numbers, missing)
    rest, move = lay_without(master, copy, numbers, missing)
    if (move != np.eye(2, 3)).any():
        framed = move_ink(framed, move)
        copy = find_segments(framed)
        rest = place_lines(master, copy, kept=kept)
    moved, covered = fill_in(rest, kept, places)
    responsibility = np.zeros((len(places), len(copy.points.xy)), np.float32)
    responsibility[kept] = rest.found.responsibility
    lines = np.unique(master.points.owner[kept])  # the rest's lines were numbered anew
    owner = np.where(rest.owner >= 0, lines[rest.owner], -1)
    return framed, copy, replace(rest, found=LineMatch(moved, responsibility), covered=covered, owner=owner)


def _find_missing(compared: Compared, whole: Placement) -> tuple[int, ...]:
    master, copy = compared.master, compared.copy
    numbers = stroke_numbers(master)
    suspects = _suspects(compared, whole)
    missing: list[int] = []
    left_over, strokes = whole.left_over, len(np.unique(numbers))
    without: dict[int, tuple[Placement, FloatArray]] = {}  # each suspect, besides what is missing
    while suspects and len(missing) < strokes - 1:
        if not without:
            without = {s.number: lay_without(master, copy, numbers, (*missing, s.number)) for s in suspects}
        best = max(suspects, key=lambda s: left_over - without[s.number][0].left_over)
        rest, move = without[best.number]
        suspects.remove(best)
        gone = np.isin(numbers, (*missing, best.number))
        moved = replace(compared, framed=move_ink(compared.framed, move))
        spare = _spare_ink(moved, rest, gone=gone, own=numbers == best.number)
        if best.is_missing((left_over - rest.left_over) / best.share, spare):
            missing.append(best.number)
            left_over = rest.left_over
            without = {}
    return tuple(missing)


def _suspects(compared: Compared, whole: Placement) -> list[StrokePresence]:
    """The strokes that a test could show to be missing, the most suspicious first."""
    every = measure_presence(compared, whole)
    suspects = [presence for presence in every if presence.suspicion > PRESENCE.suspicious]
    suspects = sorted(suspects, key=lambda presence: -presence.suspicion)[: PRESENCE.most_tested]
    return [presence for presence in suspects if presence.is_missing(gain=np.inf, spare=0.0)]


def _spare_ink(compared: Compared, rest: Placement, *, gone: BoolArray, own: BoolArray) -> float:
    """The largest patch near the place of a stroke that none of the others accounts for, over its own ink.

    gone: (n,) points of all that is missing; own: of this stroke.
    """
    import cv2

    s, master, framed = PRESENCE, compared.master, compared.framed
    points = master.points
    moved, _ = fill_in(rest, ~gone, compared.places)
    depth = cv2.distanceTransform(framed.ink.view(np.uint8), cv2.DIST_L2, 5) / SCALE
    strokes = np.flatnonzero(~gone & (stroke_numbers(master) != 0))  # spare ink may be its own
    radius, owner = depth[pixels_at(moved[strokes])], points.owner[strokes]
    usual = np.array([np.median(radius[owner == k]) for k in owner])
    tubes = draw_discs(moved[strokes], s.tube * np.minimum(radius, s.widest * usual))
    spare = framed.ink & ~tubes
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (3, 3))
    spare = cv2.morphologyEx(spare.view(np.uint8), cv2.MORPH_OPEN, disc) > 0
    near = draw_discs(moved[own], np.full(np.count_nonzero(own), s.spare_reach))
    _, patches = cv2.connectedComponents(spare.view(np.uint8), connectivity=8)
    areas = np.bincount(patches.ravel())
    areas[0] = 0
    areas[np.setdiff1d(np.arange(len(areas)), patches[near])] = 0
    own_area = float((2.0 * points.radius[own]).sum() * points.spacing) * SCALE**2
    return float(areas.max()) / own_area


def measure_presence(compared: Compared, whole: Placement) -> tuple[StrokePresence, ...]:
    """What a copy has of each stroke that holds enough of the ink to be spoken of."""
    import cv2

    s, master, places = PRESENCE, compared.master, compared.places
    points, width = master.points, master.width
    off = cv2.distanceTransform((~compared.framed.ink).view(np.uint8), cv2.DIST_L2, 5) / SCALE
    moved, numbers = whole.found.moved, stroke_numbers(master)
    bare = off[pixels_at(moved)] > s.off_ink * width
    found = []
    for number in np.unique(numbers[numbers != 0]).tolist():
        own = numbers == number
        radius = points.radius[own]
        share = float(radius.sum() / points.radius.sum())
        if share < (s.min_share if number > 0 else s.min_unnamed_share):
            continue
        expected = predict_places(places, moved, ~own & whole.covered, own)
        bare_expected = off[pixels_at(expected)] > s.off_ink * width
        claimed = claimed_twice(points, moved, places, own=own, width=width)
        found.append(
            StrokePresence(
                number,
                share,
                covered=float(np.average(whole.covered[own], weights=radius)),
                bare=_share_in_view(bare[own], moved[own], moved[~own], radius, width),
                bare_expected=_share_in_view(bare_expected, expected, moved[~own], radius, width),
                claimed=float(np.average(claimed, weights=radius)),
            )
        )
    return tuple(found)


def _share_in_view(
    bare: BoolArray, at: FloatArray, others: FloatArray, radius: FloatArray, width: float
) -> float:
    """Share of a stroke that is bare, of what is in view: not where another stroke crosses it."""
    s = PRESENCE
    if bare.all() or not bare.any():
        return float(bare.all())
    apart = ((at[:, None] - others) ** 2).sum(axis=2).min(axis=1, initial=np.inf)
    seen = apart > (s.crossing * width) ** 2
    if radius[seen].sum() < s.least_view * radius.sum():
        return float(np.average(bare, weights=radius))
    return float(np.average(bare[seen], weights=radius[seen]))
