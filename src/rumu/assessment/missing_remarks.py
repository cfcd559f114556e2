"""What is said of strokes, parts of strokes and hooks that a copy lacks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from rumu.assessment.advice import WHOLE
from rumu.assessment.findings import Finding
from rumu.assessment.named_strokes import NamedStroke
from rumu.assessment.thresholds import as_lines, ink_severity
from rumu.strokes.correspondence import StrokeMatch
from rumu.strokes.naming import stroke_title
from rumu.values import Remark


def is_measured(named: NamedStroke, match: StrokeMatch) -> bool:
    """Whether a line is to be spoken of: not what is missing, nor what the master itself shows dimly."""
    number, laid = named.stroke.line.number, match.laid
    if laid is None:
        return -1 - named.position not in match.missing
    return number > 0 and number not in match.missing and laid.confidence[number - 1] > named.limits.confident


def find_missing_strokes(every: Sequence[NamedStroke], match: StrokeMatch) -> Iterator[Finding]:
    """The canonical strokes, or the lines, that the copy lacks, each once."""
    for number in match.missing:
        legs = [s for s in every if number in (s.stroke.line.number, -1 - s.position)]
        share = sum(leg.ink_share for leg in legs)
        title = legs[0].name
        if match.laid is not None:
            title = stroke_title(number, match.laid.character.strokes[number - 1].name)
        outlines = [leg.stroke.outline for leg in legs]
        remark = Remark(
            "missing", share, "of the ink", ink_severity("missing", share),
            legs[0].box(np.concatenate(outlines)),
            f"漏寫了{title.zh}，約佔全字墨跡的 {share:.0%}。",
            f"{title.en.capitalize()} is missing, about {share:.0%} of the ink.",
            as_lines(*outlines),
            as_lines(*(leg.master_outline for leg in legs)),
            number if number > 0 else None,
        )  # fmt: skip
        yield Finding(remark, 1.0, WHOLE["missing"], legs[0].cause)


def find_missing_leg(named: NamedStroke) -> Iterator[Finding]:
    """A part of a stroke that bends, of which nothing is there: its place is bare paper."""
    stroke, limits, share = named.stroke, named.limits, named.ink_share
    if share < limits.leg_share or max(stroke.coverage, stroke.inked) > limits.leg_found:
        return
    remark = named.remark(
        "missing", share, "of the ink", ink_severity("missing", share),
        f"{named.name.zh}沒有寫，約佔全字墨跡的 {share:.0%}。",
        f"{named.en} is missing, about {share:.0%} of the ink.",
    )  # fmt: skip
    yield Finding(remark, 1.0, WHOLE["missing"], named.cause)


def find_missing_hook(named: NamedStroke) -> Iterator[Finding]:
    """A hook that was not flicked out: no ink is where it should be."""
    stroke, limits = named.stroke, named.limits
    bare = 1.0 - stroke.inked
    if stroke.coverage > limits.hook_covered or bare < limits.weak * limits.hook_bare:
        return
    severe = named.severity("hook", bare, limits.hook_bare)
    remark = named.remark(
        "no_hook", bare, "of the hook", severe,
        f"{named.name.zh}沒有鉤出。", f"{named.en} is not flicked out.",
    )  # fmt: skip
    yield Finding(remark, bare / limits.hook_bare, WHOLE["no_hook"], named.cause)
