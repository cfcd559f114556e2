"""Fit the weights by which a stroke is called missing: `python scripts/fit_presence.py [--every N]`.

Of every learner's copy (E3C), as it is and with one stroke erased as in benchmarks/missing_strokes.py, the
suspected strokes are weighed as `strokes/presence.py` weighs them. A logistic regression with a ridge tells
those that are gone from the others. Printed are the weights of all copies beside those that ship, and how
many erased strokes are told, when so many whole copies are told falsely, by weights that have not seen the
character. Weights that are worth it are written into `MissingWeights` by hand.
"""

from __future__ import annotations

import argparse
import random
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import astuple, fields
from multiprocessing import get_context
from pathlib import Path

import cv2
import numpy as np
from scipy.optimize import minimize
from scipy.special import expit

import rumu
from rumu.errors import RumuError
from rumu.executors import cores
from rumu.strokes.correspondence import CopyStrokes, match_strokes
from rumu.strokes.presence import MissingSearch, MissingWeights
from rumu.values import BoolArray, FloatArray
from rumu_lab.experiments.marked_copies import Copy, read_copies

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
from missing_strokes import DATA, SEED, TRUE, choose_stroke, erase, master_of, strokes_of

RIDGE, FOLDS, FALSE_TOLD = 0.5, 5, (0, 2, 4, 8)
Row = tuple[str, str, bool, bool, tuple[float, ...]]
"""Character, name of the copy, whether a stroke was erased from it, whether this one is gone, its numbers."""


def weighed(strokes: CopyStrokes) -> list[tuple[int, tuple[float, ...]]]:
    """The suspected strokes by their numbers, with what `StrokeEvidence.odds` sums up, in its order."""
    search = MissingSearch(strokes.compared)
    found = []
    for stroke in search.suspects():
        evidence = search.weigh(stroke)
        found.append((stroke.number, evidence.counted(found=search.found_otherwise[stroke.number])))
    return found


def rows_of(copy: Copy) -> list[Row]:
    """What is weighed of a copy as it is, and of it with a stroke erased."""
    cv2.setNumThreads(1)
    master, name = master_of(copy.template, copy.character), copy.image.stem
    rows: list[Row] = []
    try:
        strokes = strokes_of(rumu.relief(copy.image), master)
        rows += [(copy.character, name, False, TRUE.get(name) == n, x) for n, x in weighed(strokes)]
        match = match_strokes(strokes)
        erased = choose_stroke(match, random.Random(f"{SEED} {copy.image.name}"))
        if erased is not None:
            gray = cv2.imread(str(copy.image), cv2.IMREAD_GRAYSCALE)
            left = strokes_of(rumu.relief(erase(gray, match, erased) / np.float32(255)), master)
            gone = (erased, TRUE.get(name))
            rows += [(copy.character, name, True, n in gone, x) for n, x in weighed(left)]
    except RumuError as error:
        print(f"{name}: {error}", file=sys.stderr)
    return rows


def fit(x: FloatArray, gone: BoolArray) -> FloatArray:
    """(7,): the bias and the six weights."""
    full, sign = np.column_stack([np.ones(len(x)), x]), np.where(gone, 1.0, -1.0)

    def loss(w: FloatArray) -> tuple[float, FloatArray]:
        margin = sign * (full @ w)
        slope = -(sign * expit(-margin)) @ full
        held = np.concatenate([[0.0], w[1:]])
        return float(np.logaddexp(0, -margin).sum() + RIDGE * held @ held / 2), slope + RIDGE * held

    return np.asarray(minimize(loss, np.zeros(full.shape[1]), jac=True, method="L-BFGS-B").x)


def main() -> None:
    """Collect, fit, print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--every", type=int, default=1, help="one copy of so many")
    copies = read_copies(DATA)[:: parser.parse_args().every]
    with ProcessPoolExecutor(cores(), mp_context=get_context("spawn")) as pool:
        rows = [row for some in pool.map(rows_of, copies, chunksize=6) for row in some]
    character, name, after, gone, numbers = zip(*rows, strict=True)
    x, truth, erased = np.array(numbers), np.array(gone), np.array(after)
    shipped = MissingWeights()
    print(f"{len(copies)} copies, {len(rows)} suspected strokes, {truth.sum()} of them gone")
    for field, value, own in zip(fields(shipped), fit(x, truth), astuple(shipped), strict=True):
        print(f"{field.name:14s} {value:7.3f}  ships {own:7.3f}")
    of, names = np.array(character), np.array(name)
    odds = np.zeros(len(x))
    for fold in range(FOLDS):
        out = np.isin(of, sorted(set(character))[fold::FOLDS])
        w = fit(x[~out], truth[~out])
        odds[out] = w[0] + x[out] @ w[1:]
    worst = sorted(
        (max(odds[(names == n) & ~erased & ~truth], default=-9.0) for n in set(name)), reverse=True
    )
    for allowed in FALSE_TOLD:
        limit = worst[allowed]
        told = {n for n in set(name) if (odds[(names == n) & erased & truth] > limit).any()}
        blamed = {n for n in set(name) if (odds[(names == n) & erased & ~truth] > limit).any()}
        print(
            f"characters left out, {allowed} whole copies told falsely: {len(told) / len(copies):.1%} of the "
            f"erased ones told, another blamed in {len(blamed) / len(copies):.1%} (from log odds {limit:.2f})"
        )


if __name__ == "__main__":
    main()
