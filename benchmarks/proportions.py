"""Remarks on proportion that contradict the character: `python benchmarks/proportions.py [--every N]`.

PARTS says what parts the 25 characters of the learners' copies (E3C) are made of, as one of us sees them
and not as the data of the package have it. Of every copy, or of one of so many, all faults that are worth a
remark are asked for, told or kept back. Counted are those of proportion (a part too wide, out of place, what
is enclosed) that speak of parts which the character does not have; and the masters of which the first part
holds other strokes than it should.
"""

from __future__ import annotations

import argparse
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import cv2
import numpy as np
from missing_strokes import DATA, master_of, strokes_of

import rumu
from rumu.assessment.part_measures import measure_parts
from rumu.assessment.remarks import write_remarks
from rumu.errors import RumuError
from rumu.executors import cores
from rumu.strokes.placement import stroke_numbers
from rumu_lab.experiments.marked_copies import Copy, read_copies

KINDS = ("squeeze", "part_place", "inner")
PARTS: dict[str, tuple[str, tuple[int, ...]]] = {
    "銘": ("side by side", (8,)), "德": ("side by side", (3,)), "得": ("side by side", (3,)),
    "傳": ("side by side", (2,)), "行": ("side by side", (3,)), "讀": ("side by side", (7,)),
    "作": ("side by side", (2,)), "說": ("side by side", (7,)), "裕": ("side by side", (5,)),
    "暮": ("one over the other", (3, 7, 10)), "當": ("one over the other", (3, 5, 8)),
    "寧": ("one over the other", (3, 7, 12)), "合": ("one over the other", (2, 3)),
    "令": ("one over the other", (2, 3)), "益": ("one over the other", (5,)),
    "金": ("one over the other", (2,)),
    "風": ("one around the other", ()), "式": ("one around the other", ()),
    **{character: ("no parts", ()) for character in "方非耳下不十手"},
}  # fmt: skip
"""How the parts of a character stand, and after which strokes the first may end."""
SAID = {
    "left part": "side by side", "right part": "side by side",
    "upper part": "one over the other", "lower part": "one over the other",
    "enclosed": "one around the other",
}  # fmt: skip
"""Words of a remark on proportion -> characters of which it may be said."""


def contradictions(copy: Copy) -> tuple[int, tuple[str, ...]]:
    """How many remarks on proportion there are of a copy, and those that contradict its character."""
    cv2.setNumThreads(1)
    master = master_of(copy.template, copy.character)
    try:
        strokes = strokes_of(rumu.relief(copy.image), master)
    except RumuError:
        return 0, ()
    review = write_remarks(strokes, character=master.canonical)
    said = [r.en for r in (*review.remarks, *review.untold) if r.kind in KINDS]
    stand, _ = PARTS[copy.character]
    wrong = (
        f"{copy.character} {copy.image.stem}: {text}"
        for text in said
        if {where for words, where in SAID.items() if words in text.lower()} != {stand}
    )
    return len(said), tuple(wrong)


def first_part(copy: Copy) -> str:
    """The strokes that the first part of a copy's master holds; empty where it has none."""
    master = master_of(copy.template, copy.character)
    itself, canonical = master.stroke_model.itself, master.canonical
    if canonical is None:
        return ""
    parts = measure_parts(itself, canonical.structure, radical_border=canonical.radical_border)
    if parts is None or itself.laid is None:
        return ""
    numbers = stroke_numbers(itself.master)
    first = set(np.unique(numbers[parts.first & (numbers > 0)]).tolist())
    right = any(first == set(range(1, last + 1)) for last in PARTS[copy.character][1])
    return f"{copy.character} {sorted(first)}" + ("" if right else " wrong")


def main() -> None:
    """Ask, count, print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--every", type=int, default=1, help="one copy of so many")
    copies = read_copies(DATA)
    asked = copies[:: parser.parse_args().every]
    with ProcessPoolExecutor(cores(), mp_context=get_context("spawn")) as pool:
        answers = list(pool.map(contradictions, asked, chunksize=6))
        some = {copy.template: copy for copy in copies}.values()
        parts = [held for held in pool.map(first_part, some) if held]
    wrong = [text for _, texts in answers for text in texts]
    print(f"{len(asked)} copies, {sum(n for n, _ in answers)} remarks on proportion")
    print(f"that contradict the character: {len(wrong)}", *wrong, sep="\n")
    mistaken = [held for held in parts if held.endswith("wrong")]
    print(
        f"{len(parts)} masters with two parts, other strokes in the first: {len(mistaken)}",
        *mistaken,
        sep="\n",
    )


if __name__ == "__main__":
    main()
