"""Comparison -> what a teacher would say: first what is good, then where, what, how much, and what to do.

Every sentence comes from a measurement, in Chinese and English; nothing is said below the size at which a
person would see it. At most three faults are told, the worst first, each cause once. What the whole character
does is not said again of each stroke, and of its parts only what its structure has.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

from rumu.assessment.findings import choose_remarks
from rumu.assessment.ink_measures import measure_ink
from rumu.assessment.ink_remarks import find_ink_faults
from rumu.assessment.named_strokes import name_all
from rumu.assessment.part_measures import measure_inner, measure_parts
from rumu.assessment.praise import Praised, write_praise
from rumu.assessment.stroke_remarks import find_stroke_faults
from rumu.assessment.thresholds import RemarkThresholds
from rumu.assessment.whole_remarks import PoseSeen, find_part_faults, find_whole_faults
from rumu.characters.stroke_data import CanonicalCharacter
from rumu.strokes.correspondence import CopyStrokes, match_strokes
from rumu.values import Bilingual, Remark

COARSE_TREMOR = 1.5
"""Power of a picture's enlargement with which the threshold of tremor grows: enlarged edges are rough."""


class Review(NamedTuple):
    """What is said of a copy. praise: one thing that is good and true; None where nothing stands out.

    remarks: at most three. untold: the faults besides that are worth a remark.
    """

    praise: Bilingual | None
    remarks: tuple[Remark, ...]
    untold: tuple[Remark, ...]


def write_remarks(
    copy: CopyStrokes,
    *,
    character: CanonicalCharacter | None = None,
    framed: bool = False,
    parts: Mapping[str, float] | None = None,
    thresholds: RemarkThresholds | None = None,
) -> Review:
    """Praise and at most three remarks on a copy on which its master's strokes are looked for.

    character: what is written, for the parts that it has; None where it is not known. framed: whether the
    picture is the cell in which the copy was written, so that its size, place and lean are the writer's.
    parts: of the mark, 0-100: each that is low is explained.
    """
    limits = thresholds or RemarkThresholds()
    structure = None if character is None else character.structure
    match, registration = match_strokes(copy), copy.registration
    ink = measure_ink(match, copy.surface, copy.master, registration)
    border = None if character is None else character.radical_border
    measured = measure_parts(match, structure, radical_border=border)
    inner = measure_inner(match, structure)
    cell = registration.reference.radius
    part_faults, explained = find_part_faults(
        match, measured, inner, known=structure is not None, cell=cell, limits=limits
    )
    coarse = replace(limits, tremor=limits.tremor * match.enlargement**COARSE_TREMOR)
    pose = PoseSeen(match, registration, framed)
    strokes = name_all(pose, limits, explained=explained)
    found = [
        *find_whole_faults(pose, limits),
        *part_faults,
        *find_stroke_faults(strokes, match, limits),
        *find_ink_faults(ink, strokes, match, coarse),
    ]
    remarks, untold = choose_remarks(found, parts=parts or {}, limits=limits)
    praise = write_praise(Praised(match, ink, measured, strokes, pose, parts or {}), remarks, found=found)
    return Review(praise, remarks, untold)
