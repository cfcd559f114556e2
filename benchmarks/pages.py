"""Printed pages parted into columns and characters: `python benchmarks/pages.py [DATA] [--edition NAME ...]`.

For each edition of `pages/printed`: how many columns of the text are found, in order; how many of them hold
the right number of characters, or one more or less (small double rows apart); how many characters get the
right name with the text given as one line, and with a passage, some characters left out and some foreign
ones put in; how many are named without a text, and how many of these are what the text says (another form
of the same character counts as wrong); and the seconds of the processor for a page, without a text and with
one. Columns are matched by their place and their number of characters, never by the text. A column counts
as found when it is matched and differs by at most a quarter of its characters or by three.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import time
from collections import defaultdict
from dataclasses import dataclass, field, replace
from difflib import SequenceMatcher
from pathlib import Path

import numpy as np

import rumu
from rumu.pages.page import Page

Column = tuple[int, int]


@dataclass
class Figures:
    """Sums over pages."""

    columns: int = 0
    found: int = 0
    surplus: int = 0
    right: int = 0
    within_one: int = 0
    characters: int = 0
    named: int = 0
    wrong: int = 0
    kept: int = 0
    named_again: int = 0
    wrong_again: int = 0
    seen: int = 0
    seen_right: int = 0
    seconds: list[float] = field(default_factory=list)
    seconds_text: list[float] = field(default_factory=list)


def written(text: str) -> str:
    """The characters of a text without brackets and other signs."""
    return re.sub(r"[^〇㐀-鿿\U00020000-\U0003ffff]", "", text)


def columns_of(page: Page) -> list[list[list[int]]]:
    """Registers, columns: the places in `page.characters` of their main characters."""
    registers: dict[int, dict[int, list[int]]] = defaultdict(lambda: defaultdict(list))
    for k, one in enumerate(page.characters):
        members = registers[one.register][one.column]
        if one.small is None:
            members.append(k)
    return [[registers[r][c] for c in sorted(registers[r])] for r in sorted(registers)]


def match(found: list[int], true: list[int]) -> list[tuple[int, int]]:
    """Pairs of found and true columns, in order, whose numbers of characters fit best."""
    n, m = len(found), len(true)
    cost = np.full((n + 1, m + 1), np.inf)
    cost[:, 0], cost[0, :] = 10.0 * np.arange(n + 1), 10.0 * np.arange(m + 1)
    for i in range(1, n + 1):
        for j in range(1, m + 1):
            both = cost[i - 1, j - 1] + abs(found[i - 1] - true[j - 1])
            cost[i, j] = min(both, cost[i - 1, j] + 10, cost[i, j - 1] + 10)
    pairs, i, j = [], n, m
    while i and j:
        if cost[i, j] == cost[i - 1, j - 1] + abs(found[i - 1] - true[j - 1]):
            i, j = i - 1, j - 1
            pairs.append((i, j))
        elif cost[i, j] == cost[i - 1, j] + 10:
            i -= 1
        else:
            j -= 1
    return pairs[::-1]


def damaged(text: str, rng: np.random.Generator) -> tuple[str, np.ndarray]:
    """A text with a passage of 5 to 30 and 6 single characters lost and 4 put in; and which were kept."""
    kept = np.ones(len(text), dtype=bool)
    begin = int(rng.integers(0, len(text) - 30))
    kept[begin : begin + int(rng.integers(5, 30))] = False
    kept[rng.integers(0, len(text), 6)] = False
    letters = [letter if keep else "" for letter, keep in zip(text, kept, strict=True)]
    for k in rng.integers(0, len(text), 4):
        letters[k] += "永和九年歲在癸丑"[int(rng.integers(0, 8))]
    return "".join(letters), kept


def count_names(page: Page, registers: list[list[str]]) -> tuple[int, int]:
    """How many characters of the true columns got their name, and how many a wrong one."""
    names: dict[Column, str] = defaultdict(str)
    for one in page.characters:
        if one.small is None or one.character:
            names[one.register, one.column] += one.character or "〓"
    right = wrong = 0
    found = [
        [names[r, c] for c in range(1 + max(k[1] for k in names if k[0] == r))] for r in {k[0] for k in names}
    ]
    for got_register, true_register in zip(found, registers, strict=False):
        pairs = match([len(x) for x in got_register], [len(x) for x in true_register])
        for i, j in pairs:
            blocks = SequenceMatcher(
                None, true_register[j], got_register[i], autojunk=False
            ).get_matching_blocks()
            same = sum(block.size for block in blocks)
            right += same
            wrong += sum(letter != "〓" for letter in got_register[i]) - same
    return right, wrong


def measure(path: Path, registers: list[list[str]], into: Figures, rng: np.random.Generator) -> None:
    """Add the figures of one page."""
    started = time.process_time()
    page = rumu.read_page(path)
    into.seconds.append(time.process_time() - started)
    main = replace(page, characters=tuple(one for one in page.characters if one.small is None))
    right, wrong = count_names(main, registers)
    into.seen, into.seen_right = into.seen + right + wrong, into.seen_right + right
    found = columns_of(page)
    into.columns += sum(map(len, registers))
    into.surplus += sum(map(len, found))
    for got, true in zip(found, registers, strict=False):
        for i, j in match([len(c) for c in got], [len(t) for t in true]):
            difference = abs(len(got[i]) - len(true[j]))
            into.found += difference <= max(3, len(true[j]) / 4)
            into.right += difference == 0
            into.within_one += difference <= 1
            into.surplus -= 1
    text = "".join("".join(register) for register in registers)
    started = time.process_time()
    named = rumu.read_page(path, text=text)
    into.seconds_text.append(time.process_time() - started)
    into.characters += len(text)
    right, wrong = count_names(named, registers)
    into.named, into.wrong = into.named + right, into.wrong + wrong
    less, kept = damaged(text, rng)
    right, wrong = count_names(rumu.read_page(path, text=less), registers)
    into.kept += int(kept.sum())
    into.named_again, into.wrong_again = into.named_again + right, into.wrong_again + wrong


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", nargs="?", default=os.environ.get("RUMU_DATA", "../shared/data"), type=Path)
    parser.add_argument("--edition", nargs="*", help="only these editions")
    arguments = parser.parse_args()
    folder = arguments.data / "pages"
    rng = np.random.default_rng(5)
    editions: dict[str, Figures] = defaultdict(Figures)
    for entry in json.loads((folder / "text.json").read_text(encoding="utf-8")):
        if arguments.edition and entry["edition"] not in arguments.edition:
            continue
        registers = [[written(column["text"]) for column in register] for register in entry["registers"]]
        measure(folder / entry["file"], registers, editions[entry["edition"]], rng)
    print("| edition | columns | found | besides | number right | within one | named | wrong "
          "| named, text damaged | wrong | seen | right of these | s | s with text |")  # fmt: skip
    print("|---" * 14 + "|")
    for name, one in [*editions.items(), ("all", total(list(editions.values())))]:
        print(
            f"| {name} | {one.columns} | {one.found / one.columns:.1%} | {one.surplus} "
            f"| {one.right / one.columns:.1%} | {one.within_one / one.columns:.1%} "
            f"| {one.named / one.characters:.2%} | {one.wrong} "
            f"| {one.named_again / one.kept:.2%} | {one.wrong_again} "
            f"| {one.seen / one.characters:.1%} | {one.seen_right / max(1, one.seen):.2%} "
            f"| {np.median(one.seconds):.2f} | {np.median(one.seconds_text):.2f} |"
        )


def total(figures: list[Figures]) -> Figures:
    """The sum of all editions."""
    whole = Figures()
    for one in figures:
        for name, value in vars(one).items():
            setattr(whole, name, getattr(whole, name) + value)
    return whole


if __name__ == "__main__":
    main()
