"""Which of a master's strokes a copy lacks, and which ink of the copy belongs to none of them.

A stroke is missing when the copy is explained as well without it, and when its place is bare paper. First
the strokes that found little ink of their own are picked out; then the copy is matched anew with a master
that lacks the stroke. A stroke that is there, but elsewhere, leaves its ink unexplained then; one that took
its neighbour's ink gives it back. What seems to be missing is asked again of the copy a little changed, as
another photograph would show it: a pixel must not decide. When unsure, nothing is said.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from rumu.strokes.centre_lines import SCALE, find_segments, pixels_at
from rumu.strokes.matching import MatchSettings
from rumu.strokes.placement import (
    Compared,
    Placement,
    claimed_twice,
    draw_discs,
    fill_in,
    lay_without,
    move_ink,
    perturb_ink,
    place_lines,
    predict_places,
    stroke_numbers,
)
from rumu.values import BoolArray, FloatArray


@dataclass(frozen=True, slots=True)
class MissingWeights:
    """Logistic weights of what speaks for, and against, a stroke's being missing; see `StrokeEvidence`.

    Fitted to 810 learners' copies as they are and with one stroke erased; docs/what-was-tried.md says how.
    """

    bias: float = 1.885
    bare: float = 2.558
    bare_expected: float = 1.291
    gain: float = 2.547
    lost: float = -1.929
    elsewhere: float = -3.87
    otherwise: float = -3.858


@dataclass(frozen=True, slots=True)
class PlainRule:
    """When a stroke is gone so plainly that it does not matter what else is not found.

    bare, gain: at least, of both shares on bare paper, and of the gain. covered, elsewhere, found: at most,
    of it that found ink, that finds spare ink, and of how surely another way of laying all strokes finds it.
    """

    bare: float = 0.7
    gain: float = 0.85
    covered: float = 0.2
    elsewhere: float = 0.6
    found: float = 0.1


@dataclass(frozen=True, slots=True)
class PresenceSettings:
    """When a stroke is missing. Lengths in stroke widths unless said.

    off_ink: distance from the copy's ink from which a point lies on bare paper. crossing: distance from
        another stroke within which a point is out of view; least_view: share of a stroke that must be in
        view, else all of it is taken to be.
    min_share: share of the master's ink in a stroke below which nothing is said of it; min_unnamed_share:
        the same of a line that is no canonical stroke.
    weights, least_odds: of the evidence, and their sum, log odds, from which a stroke seems to be missing.
    perturbations: (turn in degrees, scale, resolution) of the copy's ink for which the odds are then found
        again; odds_range: within which each counts. agreed_odds: the mean of all from which the stroke is
        missing, and from which it surely is.
    plain: when a stroke is gone whatever else is missing.
    suspicious: part of that sum, of its bare paper alone, from which a stroke is tested, and most_tested: how
        many are. most_gain: what the gain counts at most.
    tube, widest: half-width, over its own, up to which ink is a stroke's, and greatest of its half-widths
        over its usual one, so that what joins it is not its own.
    pushes, push_step: how many steps to each side, and how long, rms radii, a stroke is pushed when it is
        sought in spare ink; push_reach: how far at most; push_sizes: times its own size.
    other_ways: of laying all strokes, tried before one is believed to be missing.
    """

    off_ink: float = 0.25
    crossing: float = 0.6
    least_view: float = 0.25
    min_share: float = 0.025
    min_unnamed_share: float = 0.06
    weights: MissingWeights = MissingWeights()
    least_odds: float = 1.2
    agreed_odds: tuple[float, float] = (1.5, 3.5)
    perturbations: tuple[tuple[float, float, float], ...] = (
        (0.7, 0.96, 0.8), (-0.7, 1.03, 0.6), (1.2, 1.0, 0.7), (-1.2, 0.98, 0.9),
    )  # fmt: skip
    odds_range: tuple[float, float] = (-3.0, 6.0)
    plain: PlainRule = PlainRule()
    suspicious: float = 0.73
    most_tested: int = 3
    most_gain: float = 1.3
    tube: float = 1.2
    widest: float = 1.25
    pushes: int = 6
    push_step: float = 0.075
    push_reach: float = 0.45
    push_sizes: tuple[float, ...] = (0.75, 1.0)
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
        """How much its bare paper speaks for its being missing, log odds."""
        w = PRESENCE.weights
        return w.bare * self.bare + w.bare_expected * self.bare_expected

    @property
    def found(self) -> float:
        """From 0 to 1, how surely it has found ink that is its own alone."""
        return self.covered * (1.0 - self.claimed) * (1.0 - self.bare)


@dataclass(frozen=True, slots=True)
class StrokeEvidence:
    """What speaks for and against a stroke's being missing, once the rest has been laid without it.

    presence: before that. gain: by how much the rest explains the copy better without it, over its share of
    the ink. lost: ink that the rest does not find besides, over the same: where much is not found, little is
    known. elsewhere: the largest share of it that, pushed a little, would lie on ink that the rest does not
    account for.
    """

    presence: StrokePresence
    gain: float
    lost: float
    elsewhere: float

    def is_plain(self, *, found: float) -> bool:
        """Whether it is gone so plainly that it does not matter what else is not found."""
        rule, seen = PRESENCE.plain, self.presence
        gone = min(seen.bare, seen.bare_expected) >= rule.bare and self.gain >= rule.gain
        found_some = seen.covered > rule.covered or self.elsewhere > rule.elsewhere or found > rule.found
        return gone and not found_some

    def counted(self, *, found: float) -> tuple[float, float, float, float, float, float]:
        """What is weighed, in the order of the weights; found: as of `odds`."""
        seen, lost = self.presence, 0.0 if self.is_plain(found=found) else self.lost
        gain = min(self.gain, PRESENCE.most_gain)
        return seen.bare, seen.bare_expected, gain, lost, self.elsewhere, found

    def odds(self, *, found: float = 0.0) -> float:
        """Log odds that it is missing; found: how surely another way of laying all strokes finds it."""
        w, (*_, gain, lost, elsewhere, found) = PRESENCE.weights, self.counted(found=found)
        odds = w.bias + self.presence.suspicion + w.gain * gain
        return odds + w.lost * lost + w.elsewhere * elsewhere + w.otherwise * found


def find_missing(compared: Compared) -> tuple[dict[int, float], Placement]:
    """The strokes that the copy lacks, and all lines on the copy.

    For the number of each, see `StrokePresence`, how surely it is missing, from 0 to 1. When a stroke seems
    to be missing, other ways of laying the lines are tried, and what finds its ink in one of them is hardly
    missing. Where nothing is missing after all, the best of these ways is given back.
    """
    search = MissingSearch(compared)
    missing, doubted = search.find()
    if missing or not doubted:
        return missing, search.whole
    return {}, min((*search.others, search.whole), key=lambda placement: placement.left_over)


@dataclass(frozen=True, eq=False)
class MissingSearch:
    """The search for the strokes that a copy lacks."""

    compared: Compared

    @cached_property
    def whole(self) -> Placement:
        """All lines on the copy."""
        return place_lines(self.compared.master, self.compared.copy)

    @cached_property
    def others(self) -> tuple[Placement, ...]:
        """The same, laid in other ways."""
        master, copy = self.compared.master, self.compared.copy
        return tuple(place_lines(master, copy, settings=settings) for settings in PRESENCE.other_ways)

    @cached_property
    def presences(self) -> tuple[StrokePresence, ...]:
        """What the copy has of each stroke."""
        return measure_presence(self.compared, self.whole)

    @cached_property
    def perturbed(self) -> tuple[MissingSearch, ...]:
        """The same search in the copy a little changed."""
        found = []
        for change in PRESENCE.perturbations:
            framed = perturb_ink(self.compared.framed, *change)
            found.append(MissingSearch(replace(self.compared, framed=framed, copy=find_segments(framed))))
        return tuple(found)

    @cached_property
    def found_otherwise(self) -> dict[int, float]:
        """For each stroke how surely one of the other ways finds it, from 0 to 1."""
        ways = [measure_presence(self.compared, placement) for placement in self.others]
        return {same[0].number: max(presence.found for presence in same) for same in zip(*ways, strict=True)}

    def find(self) -> tuple[dict[int, float], bool]:
        """What is missing, how surely, and whether more would be if other ways were not asked."""
        strokes = len(np.unique(stroke_numbers(self.compared.master)))
        suspects, doubted = self.suspects(), False
        missing: dict[int, float] = {}
        while suspects and len(missing) < strokes - 1:
            gone = tuple(missing)
            left_over = [self.lay_without((*gone, s.number))[0].left_over for s in suspects]
            best = suspects.pop(int(np.argmin(left_over)))
            evidence = self.weigh(best, missing=gone)
            if evidence.odds() < PRESENCE.least_odds:
                continue
            doubted = True
            odds = self.agreed_odds(evidence, gone)
            if odds >= PRESENCE.agreed_odds[0]:
                missing[best.number] = float(np.interp(odds, PRESENCE.agreed_odds, (0.0, 1.0)))
        return missing, doubted

    def agreed_odds(self, evidence: StrokeEvidence, missing: tuple[int, ...]) -> float:
        """The mean of a stroke's log odds in the copy and in the copy a little changed."""
        number = evidence.presence.number
        own = evidence.odds(found=self.found_otherwise[number])
        every = [own, *(search.odds_of(number, missing) for search in self.perturbed)]
        return float(np.clip(every, *PRESENCE.odds_range).mean())

    def odds_of(self, number: int, missing: tuple[int, ...]) -> float:
        """A stroke's log odds, besides what is missing already."""
        stroke = next(presence for presence in self.presences if presence.number == number)
        return self.weigh(stroke, missing=missing).odds(found=self.found_otherwise[number])

    def suspects(self) -> list[StrokePresence]:
        """The strokes that a test could show to be missing, the most suspicious first."""
        suspects = [presence for presence in self.presences if presence.suspicion > PRESENCE.suspicious]
        return sorted(suspects, key=lambda presence: -presence.suspicion)[: PRESENCE.most_tested]

    def lay_without(self, gone: tuple[int, ...]) -> tuple[Placement, FloatArray]:
        """The rest of the lines on the copy, and the move of its points, see `placement.lay_without`."""
        if gone not in self._laid:
            master = self.compared.master
            self._laid[gone] = lay_without(master, self.compared.copy, stroke_numbers(master), gone)
        return self._laid[gone]

    @cached_property
    def _laid(self) -> dict[tuple[int, ...], tuple[Placement, FloatArray]]:
        """What was laid without some strokes already."""
        return {}

    def weigh(self, stroke: StrokePresence, *, missing: tuple[int, ...] = ()) -> StrokeEvidence:
        """What is to be said of a stroke, besides what is missing already."""
        before = self.lay_without(missing)[0] if missing else self.whole
        rest, move = self.lay_without((*missing, stroke.number))
        compared = self.compared
        numbers, radius = stroke_numbers(compared.master), compared.master.points.radius
        gone, own = np.isin(numbers, (*missing, stroke.number)), numbers == stroke.number
        lost = float(radius[~gone][~rest.covered].sum()) / float(radius.sum())
        moved = replace(compared, framed=move_ink(compared.framed, move))
        return StrokeEvidence(
            stroke,
            gain=(before.left_over - rest.left_over) / stroke.share,
            lost=lost / stroke.share,
            elsewhere=_found_elsewhere(moved, rest, gone=gone, own=own),
        )


def _found_elsewhere(compared: Compared, rest: Placement, *, gone: BoolArray, own: BoolArray) -> float:
    """The largest share of a stroke that, pushed a little, lies on ink that none of the others accounts for.

    gone: (n,) points of all that is missing; own: of this stroke.
    """
    import cv2

    s, master, framed = PRESENCE, compared.master, compared.framed
    points = master.points
    moved, _ = fill_in(rest, ~gone, compared.places)
    depth = cv2.distanceTransform(framed.ink.view(np.uint8), cv2.DIST_L2, 5) / SCALE
    strokes = np.flatnonzero(~gone & (stroke_numbers(master) != 0))  # spare ink may be its own
    radius, owner = depth[pixels_at(moved[strokes])], points.owner[strokes]
    lines, line = np.unique(owner, return_inverse=True)
    usual = np.array([np.median(radius[owner == k]) for k in lines])[line]
    tubes = draw_discs(moved[strokes], s.tube * np.minimum(radius, s.widest * usual))
    spare = cv2.dilate((framed.ink & ~tubes).view(np.uint8), np.ones((3, 3), np.uint8)) > 0
    at, steps = moved[own], s.push_step * np.arange(-s.pushes, s.pushes + 1)
    pushes = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 1, 2)
    pushes = pushes[np.hypot(*pushes[:, 0].T) <= s.push_reach]
    middle = at.mean(axis=0)
    tried = np.concatenate([middle + size * (at - middle) + pushes for size in s.push_sizes])
    return float(spare[pixels_at(tried.reshape(-1, 2))].reshape(tried.shape[:2]).mean(axis=1).max())


def measure_presence(compared: Compared, whole: Placement) -> tuple[StrokePresence, ...]:
    """What a copy has of each stroke that holds enough of the ink to be spoken of."""
    s, master, places = PRESENCE, compared.master, compared.places
    points, width = master.points, master.width
    off = compared.framed.off_ink / SCALE
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
