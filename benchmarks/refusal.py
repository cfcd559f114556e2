"""What is refused and what is not: `python benchmarks/refusal.py [DATA] [--every N]`.

Right copies (E3C copies, two versions of one place of the Lanting Xu, gross simulated faults, one character
by two works) and wrong ones (another character, impostors, cut and crowded pictures) are put to `refusal`.
Every character belongs to one half, by a hash of its name: the limits were found on the first half, and the
second was looked at when they stood. The last column is what the wrong ones score when they slip through.
"""

from __future__ import annotations

import argparse
import hashlib
import os
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

import rumu
from rumu.assessment.calibration import panel
from rumu.errors import RefusedImage, SurfaceError
from rumu.executors import in_order
from rumu.gallery.masters import Master, read_masters
from rumu.gallery.starter import starter_works
from rumu.pipeline import measure
from rumu_lab.experiments.marked_copies import read_copies
from rumu_lab.experiments.measuring import master_at
from rumu_lab.simulation import faults
from rumu_lab.simulation.impostors import IMPOSTORS, impostor, picture_of

RIGHT = ("E3C copy", "Lanting Xu, two versions", "fault of severity 5", "regular, two works")


@dataclass(frozen=True)
class Case:
    """kind: a row of the table. make: name of the maker below, with its arguments."""

    kind: str
    character: str
    master: Path
    make: str
    arguments: tuple


@dataclass(frozen=True)
class Answer:
    case: Case
    code: str | None
    score: float | None
    strangeness: float | None = None


def half(character: str) -> str:
    """'development' or 'held out', the same on every machine."""
    return ("development", "held out")[hashlib.sha256(character.encode()).digest()[0] % 2]


def cases(data: Path) -> Iterator[Case]:
    rng = np.random.default_rng(7)
    yield from of_e3c(data, rng)
    yield from of_masters("regular", read_masters(data / "masters" / "regular"), rng, most=300)
    yield from of_masters("Lanting Xu", read_masters(data / "masters" / "running-lantingxu"), rng, most=999)
    works = starter_works()
    for work in works:
        for fault in faults.FAULTS:
            yield Case("fault of severity 5", work.id, work.path, "fault", (work.path, fault))
        for kind in IMPOSTORS:
            yield Case(kind.replace("_", " "), work.id, work.path, "fake", (work.path, kind, 0))
        for other in works:
            if other.script == work.script and other.character != work.character:
                yield Case("another work of the script", work.id, work.path, "picture", (other.path,))


def of_e3c(data: Path, rng: np.random.Generator) -> Iterator[Case]:
    copies = read_copies(data)
    templates = sorted({copy.template for copy in copies})
    for k, copy in enumerate(copies):
        name, image, template = copy.character, copy.image, copy.template
        yield Case("E3C copy", name, template, "picture", (image,))
        others = [t for t in templates if t != template]
        yield Case("E3C, another character", name, others[rng.integers(len(others))], "picture", (image,))
        if k % 6 == 0:
            yield Case("E3C, mirrored", name, template, "turned", (image, (0, -1)))
            yield Case("E3C, upside down", name, template, "turned", (image, (-1, -1)))
            beside = [copies[rng.integers(len(copies))].image for _ in range(3)]
            for layout in ("row", "column", "square"):
                yield Case(
                    f"E3C, with others in a {layout}", name, template, "crowd", (layout, (image, *beside))
                )
            for share in (0.15, 0.3):
                side = "lrtb"[rng.integers(4)]
                yield Case(f"E3C, {share:.0%} cut off", name, template, "cut", (image, side, share))
            yield Case("E3C, outline", name, template, "fake", (image, "outline", k))
            yield Case("E3C, a fifth of the size", name, template, "small", (image, 0.2))


def of_masters(
    name: str, masters: tuple[Master, ...], rng: np.random.Generator, *, most: int
) -> Iterator[Case]:
    places: dict[str, list[Master]] = defaultdict(list)
    for master in masters:
        # the Lanting Xu repeats characters in other forms: there one place of the text is one character
        key = master.path.name if name == "Lanting Xu" else master.character or ""
        places[key].append(master)
    shared = [key for key, found in places.items() if len({m.path.parent for m in found}) > 1]
    for key in [shared[k] for k in rng.permutation(len(shared))[:most]]:
        found = places[key]
        copy = found[rng.integers(len(found))]
        same = [m for m in found if m.path.parent != copy.path.parent]
        right = same[rng.integers(len(same))]
        others = [m for m in masters if m.character != copy.character]
        what = f"{name}, two {'versions' if name == 'Lanting Xu' else 'works'}"
        character = copy.character or ""
        yield Case(what, character, right.path, "picture", (copy.path,))
        wrong = others[rng.integers(len(others))].path
        yield Case(f"{name}, another character", character, wrong, "picture", (copy.path,))


def picture(path: Path) -> Path:
    return path


def ink(path: Path) -> np.ndarray:
    return master_at(path).surface.mask


def fault(path: Path, name: str) -> np.ndarray:
    return picture_of(faults.apply(np.asarray(Image.open(path)) < 128, name, severity=5, seed=1).ink)


def fake(path: Path, kind: str, seed: int) -> np.ndarray:
    return impostor(ink(path), kind, seed=seed)


def turned(path: Path, steps: tuple[int, int]) -> np.ndarray:
    page = np.asarray(Image.open(path).convert("L"))
    return (page[::-1] if steps[0] else page)[:, :: steps[1]].copy()


def small(path: Path, scale: float) -> np.ndarray:
    page = picture_of(ink(path))
    h, w = page.shape
    M = np.array([[scale, 0, w * (1 - scale) / 2], [0, scale, h * (1 - scale) / 2]])
    return cv2.warpAffine(cv2.GaussianBlur(page, (0, 0), 0.4 / scale), M, (w, h), borderValue=245)


def cut(path: Path, side: str, share: float) -> np.ndarray:
    """The picture cropped so that this share of the ink is lost at one side."""
    page = ink(path)
    grown = np.cumsum(page.sum(axis=0 if side in "lr" else 1)) / page.sum()
    k = int(np.searchsorted(grown, share if side in "lt" else 1 - share))
    part = {"l": page[:, k:], "r": page[:, :k], "t": page[k:], "b": page[:k]}[side]
    return picture_of(part)


def crowd(layout: str, paths: tuple[Path, ...]) -> np.ndarray:
    """Several copies in one picture, the one that is meant first, each trimmed to its ink."""
    rows, columns = {"row": (1, 3), "column": (3, 1), "square": (2, 2)}[layout]
    height, width = 480 // rows, 480 // columns
    page = np.zeros((480, 480), np.float32)
    for k, path in enumerate(paths[: rows * columns]):
        own = ink(path)
        box = own[np.ix_(own.any(axis=1), own.any(axis=0))].astype(np.float32)
        scale = 0.8 * min(height / box.shape[0], width / box.shape[1])
        box = cv2.resize(box, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        y = (k // columns) * height + (height - box.shape[0]) // 2
        x = (k % columns) * width + (width - box.shape[1]) // 2
        page[y : y + box.shape[0], x : x + box.shape[1]] = box
    return picture_of(page)


MAKERS = {f.__name__: f for f in (picture, fault, fake, turned, small, cut, crowd)}


def asked(case: Case) -> Answer | None:
    """What `assess` would say, and the score that a refusal withholds."""
    try:
        copy = rumu.relief(MAKERS[case.make](*case.arguments))
        m = measure(copy, master_at(case.master))
    except SurfaceError:
        return None  # a fault that this glyph has no stroke for
    except RefusedImage as refused:
        return Answer(case, refused.reason, None)
    code = m.refusal.code if m.refusal else None
    return Answer(case, code, panel().score(m.features), m.figures.strangeness)


def told(answers: list[Answer]) -> None:
    by_kind: dict[str, dict[str, list[Answer]]] = defaultdict(lambda: defaultdict(list))
    for answer in answers:
        by_kind[answer.case.kind][half(answer.case.character)].append(answer)
    print(f"{'':36s}{'development':>20s}{'held out':>20s}   highest score of the rest; reasons")
    for kind in sorted(by_kind, key=lambda k: (k not in RIGHT, k)):
        cells, both = [], [a for part in by_kind[kind].values() for a in part]
        for part in ("development", "held out"):
            mine = by_kind[kind][part]
            refused = sum(a.code is not None for a in mine)
            cells.append(f"{refused:5d} of {len(mine):4d} {refused / max(len(mine), 1):6.1%}")
        rest = [a.score for a in both if a.code is None and a.score is not None]
        why = ", ".join(f"{c} {n}" for c, n in Counter(a.code for a in both if a.code).most_common())
        highest = f"{max(rest):6.0f}" if rest and kind not in RIGHT else "     -"
        print(f"{kind:36s}{cells[0]:>20s}{cells[1]:>20s}   {highest}   {why}", flush=True)
    for kind in RIGHT:
        strange = sorted(a.strangeness for a in answers if a.case.kind == kind and a.strangeness is not None)
        if strange:
            print(f"strangest of '{kind}': {', '.join(f'{s:.2f}' for s in strange[-5:])}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", nargs="?", default=os.environ.get("RUMU_DATA", "../shared/data"), type=Path)
    parser.add_argument("--every", type=int, default=1, help="only every Nth case, for a quick look")
    parser.add_argument("--only", default="", help="only kinds that hold this word")
    chosen = parser.parse_args()
    every = [case for case in cases(chosen.data) if chosen.only in case.kind]
    answers = [a for a in in_order(partial(asked), every[:: chosen.every]) if a is not None]
    told(answers)


if __name__ == "__main__":
    main()
