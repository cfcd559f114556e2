"""How often the character of a master is recognised, and how often a certain answer is right.

`python benchmarks/recognition.py [--count N] [--seed S]` asks for N characters of the stele works in regular
script, drawn at random, and for half as many learners' copies (E3C). An answer that is another form of the
same character (姪 where the label says 侄) counts as wrong; `--list` prints every certain answer that is so.
"""

from __future__ import annotations

import argparse
import csv
import os
from pathlib import Path

import numpy as np

import rumu
from rumu.errors import RumuError
from rumu.pipeline import PreparedMaster
from rumu.strokes.recognition import RecognisedCharacter, recognise
from rumu_lab.experiments.marked_copies import read_copies

DATA = Path(os.environ.get("RUMU_DATA", Path(__file__).parents[2] / "shared" / "data"))


def asked(path: Path) -> RecognisedCharacter | None:
    """The answer for one picture."""
    try:
        master = PreparedMaster(rumu.relief(path))
        return recognise(master.canvas, master.stroke_model.framed)
    except RumuError:
        return None


def main() -> None:
    """Print a line for each kind of picture."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--list", action="store_true")
    terms = parser.parse_args()
    rng = np.random.default_rng(terms.seed)
    folder = DATA / "masters" / "regular"
    with (folder / "labels.csv").open(encoding="utf-8", newline="") as stream:
        masters = [(folder / row["file"], row["character"]) for row in csv.DictReader(stream)]
    copies = [(copy.image, copy.character) for copy in read_copies(DATA)]
    print("pictures                   best is right   certain   right of the certain")
    for name, every, count in (
        ("steles", masters, terms.count),
        ("learners' copies", copies, terms.count // 2),
    ):
        chosen = [every[k] for k in rng.choice(len(every), min(count, len(every)), replace=False)]
        answers = [(asked(path), path, label) for path, label in chosen]
        right = [found is not None and found.character.character == label for found, _, label in answers]
        certain = [found is not None and found.is_certain for found, _, _ in answers]
        both = sum(r and c for r, c in zip(right, certain, strict=True))
        print(
            f"{len(chosen):4} {name:20} {np.mean(right):12.0%} {np.mean(certain):11.0%} "
            f"{both / max(sum(certain), 1):12.1%} ({both} of {sum(certain)})"
        )
        if terms.list:
            for (found, path, label), r, c in zip(answers, right, certain, strict=True):
                if c and not r and found is not None:
                    print(f"     {path}: {label} is taken for {found.character.character}")


if __name__ == "__main__":
    main()
