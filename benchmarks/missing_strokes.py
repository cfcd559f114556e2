"""Strokes that copies lack: `python benchmarks/missing_strokes.py [--every N] [--list] [--save FOLDER]`.

Of every learner's copy (E3C, 810 copies of 25 characters) it is asked which canonical strokes are missing
and whether there is one too many, as remarks tell it. A few copies do lack one; all that are told so have
been looked at, see TRUE. Then one stroke of .04 of the ink or more, drawn by lot, is erased from each copy,
which is asked again. Printed are how many whole copies are told of a missing stroke, and of one too many,
how many erased strokes are told by their number, and how many copies have another one blamed. `--save`
writes the pictures with an erased stroke.
"""

from __future__ import annotations

import argparse
import os
import random
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import lru_cache, partial
from multiprocessing import get_context
from pathlib import Path

import cv2
import numpy as np

import rumu
from rumu.assessment.remarks import write_remarks
from rumu.errors import RumuError
from rumu.executors import cores
from rumu.pipeline import PreparedMaster, prepare_master
from rumu.registration.icp import register_points
from rumu.registration.points import sample_points
from rumu.strokes.correspondence import CopyStrokes, StrokeMatch, match_strokes
from rumu.strokes.placement import stroke_numbers
from rumu.values import FloatArray, Surface
from rumu_lab.experiments.marked_copies import Copy, read_copies

DATA = Path(os.environ.get("RUMU_DATA", Path(__file__).parents[2] / "shared" / "data"))
TRUE = {"004105": 11, "004108": 11, "004309": 11, "004222": 10}
"""Copies of 德 that were written without one of its horizontals, and the stroke they are told of."""
LEAST_SHARE = 0.04
"""Share of the ink in a stroke from which it is erased."""
SEED = 11


@dataclass(frozen=True)
class Answer:
    """Of one copy: strokes told as missing; what is said of one too many; the one erased, what is told then.

    refused: why it was.
    """

    copy: Copy
    missing: tuple[int, ...] = ()
    extra: tuple[str, ...] = ()
    erased: int | None = None
    told: tuple[int, ...] = ()
    refused: str = ""


@lru_cache(maxsize=4)
def master_of(template: Path, character: str) -> PreparedMaster:
    """The master, prepared once in a process."""
    return prepare_master(template, character=character)


def strokes_of(surface: Surface, master: PreparedMaster) -> CopyStrokes:
    """The master's strokes on a copy, found once for all that is asked."""
    registration = register_points(sample_points(surface), master.points)
    return CopyStrokes(surface, registration, master.stroke_model)


def too_many(strokes: CopyStrokes, master: PreparedMaster) -> tuple[str, ...]:
    """What is said of strokes too many, told or kept back."""
    review = write_remarks(strokes, character=master.canonical)
    return tuple(remark.zh for remark in (*review.remarks, *review.untold) if remark.kind == "extra")


def answer(copy: Copy, *, save: Path | None) -> Answer:
    """What is told of a copy as it is, and with a stroke erased."""
    cv2.setNumThreads(1)
    master = master_of(copy.template, copy.character)
    try:
        strokes = strokes_of(rumu.relief(copy.image), master)
        match, extra = match_strokes(strokes), too_many(strokes, master)
    except RumuError as error:
        return Answer(copy, refused=str(error))
    stroke = choose_stroke(match, random.Random(f"{SEED} {copy.image.name}"))
    if stroke is None:
        return Answer(copy, match.missing, extra)
    picture = erase(cv2.imread(str(copy.image), cv2.IMREAD_GRAYSCALE), match, stroke)
    if save:
        save.mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(save / f"{copy.image.stem}-{stroke}.png"), picture)
    try:
        told, _ = strokes_of(rumu.relief(picture / np.float32(255)), master).found
    except RumuError as error:
        return Answer(copy, match.missing, extra, stroke, refused=str(error))
    return Answer(copy, match.missing, extra, stroke, tuple(told))


def choose_stroke(match: StrokeMatch, rng: random.Random) -> int | None:
    """One of the strokes that the copy has and that hold enough of the ink."""
    numbers, radius = stroke_numbers(match.master), match.master.points.radius
    fit = [
        number
        for number in np.unique(numbers[numbers > 0]).tolist()
        if radius[numbers == number].sum() >= LEAST_SHARE * radius.sum()
        and match.covered[numbers == number].mean() > 0.6
    ]
    return rng.choice(fit) if fit else None


def erase(page: FloatArray, match: StrokeMatch, stroke: int) -> FloatArray:
    """The page without the ink that is a stroke's alone: nearer to it than to others, and not crossed."""
    height, width = page.shape
    own = stroke_numbers(match.master) == stroke
    at = match.framed.on_picture(match.moved) * np.array([width, height]) - 0.5
    scale = np.sqrt(abs(np.linalg.det(match.framed.to_picture[:, :2] * np.array([[width], [height]]))))
    rows, columns = np.nonzero(page < 128)
    ink = np.column_stack([columns, rows])

    def nearness(which: FloatArray) -> FloatArray:
        """(n,) distance of the ink to some points, over their half-widths."""
        nearest = np.full(len(ink), np.inf)
        for point, radius in zip(at[which], match.radius[which] * scale, strict=True):
            nearest = np.minimum(nearest, np.hypot(*(ink - point).T) / max(radius, 1.0))
        return nearest

    mine, others = nearness(own), nearness(~own)
    gone = (mine < 1.6) & (mine < others) & (others > 0.9)
    left = page.copy()
    left[rows[gone], columns[gone]] = 255
    return left


def main() -> None:
    """Ask, count, print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--every", type=int, default=1, help="one copy of so many")
    parser.add_argument("--list", action="store_true", help="each copy that is told wrongly")
    parser.add_argument("--save", type=Path, help="folder for the pictures with an erased stroke")
    options = parser.parse_args()
    copies = read_copies(DATA)[:: options.every]
    with ProcessPoolExecutor(cores(), mp_context=get_context("spawn")) as pool:
        answers = list(pool.map(partial(answer, save=options.save), copies, chunksize=6))
    true = [a for a in answers if a.missing and TRUE.get(a.copy.image.stem) in a.missing]
    false = [a for a in answers if a.missing and a not in true]
    erased = [a for a in answers if a.erased is not None]
    right = [a for a in erased if a.erased in a.told]
    blamed = [a for a in erased if set(a.told) - {a.erased, TRUE.get(a.copy.image.stem)}]
    more = [a for a in answers if a.extra]
    print(f"{len(answers)} copies: told of a missing stroke {len(true)} truly, {len(false)} falsely")
    print(f"told of one too many: {len(more)}")
    print(
        f"{len(erased)} with a stroke erased: told by its number {len(right) / len(erased):.1%}, "
        f"another one blamed {len(blamed) / len(erased):.1%}"
    )
    unseen = Counter(a.copy.character for a in erased if a not in right)
    print("not told, by character: " + ", ".join(f"{name} {n}" for name, n in unseen.most_common()))
    if options.list:
        for a in [*false, *blamed, *(a for a in erased if a not in right)]:
            print(
                a.copy.character, a.copy.image.stem, "missing", a.missing, "erased", a.erased, "told", a.told
            )
        for a in more:
            print(a.copy.character, a.copy.image.stem, *a.extra)


if __name__ == "__main__":
    main()
