"""Every equation of the paper has one place: one function of src/."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from functools import cache
from pathlib import Path

import pytest

SRC = Path(__file__).parents[1] / "src" / "rumu"

HOMES = {
    **dict.fromkeys(range(1, 8), "surface/stereo.py"),
    8: "surface/relight.py",
    **dict.fromkeys(range(9, 17), "capture/illumination.py"),
    17: "registration/points.py",
    **dict.fromkeys(range(18, 25), "registration/quaternion.py"),
    25: "registration/icp.py",
    26: "assessment/features.py",
}

CITATION = re.compile(r"Eqs?\. ?\((\d+)\)(?:\s*(?:-|–|to)\s*(?:Eq\. )?\((\d+)\))?")


def numbers(text: str) -> list[int]:
    """The equations that `text` cites: 'Eq. (5)' and 'Eq. (9)-(10)'."""
    cited = []
    for first, last in CITATION.findall(text):
        cited += range(int(first), int(last or first) + 1)
    return cited


def functions(tree: ast.Module) -> list[tuple[str, int, int]]:
    """(name, first line, last line) of each function, outermost first."""
    kinds = (ast.FunctionDef, ast.AsyncFunctionDef)
    return [(n.name, n.lineno, n.end_lineno or n.lineno) for n in ast.walk(tree) if isinstance(n, kinds)]


@cache
def citations() -> tuple[dict[int, set[tuple[str, str]]], list[str]]:
    """equation -> {(file, function)}, and the citations that stand outside of every function."""
    homes: dict[int, set[tuple[str, str]]] = defaultdict(set)
    outside = []
    for path in sorted(SRC.rglob("*.py")):
        source = path.read_text(encoding="utf-8")
        inside = functions(ast.parse(source))
        for match in CITATION.finditer(source):
            line = source.count("\n", 0, match.start()) + 1
            holders = [name for name, first, last in inside if first <= line <= last]
            file = path.relative_to(SRC).as_posix()
            if not holders:
                outside.append(f"{file}:{line}: {match.group()}")
                continue
            for number in numbers(match.group()):
                homes[number].add((file, holders[-1]))  # the innermost: ast.walk goes outside in
    return homes, outside


def test_citations_are_read():
    assert numbers("Eq. (5), Eq. (9)-(11) and Eq. (26)") == [5, 9, 10, 11, 26]
    assert numbers("equation 5, Eq 5, (5)") == []


def test_no_equation_is_cited_outside_of_a_function():
    assert citations()[1] == []


@pytest.mark.parametrize("equation", range(1, 27))
def test_each_equation_has_one_home(equation):
    found = citations()[0].get(equation, set())
    assert len(found) == 1, f"Eq. ({equation}) is cited in {sorted(found) or 'no function'}"
    assert {file for file, _ in found} == {HOMES[equation]}


def test_no_other_equation_is_cited():
    assert set(citations()[0]) <= set(HOMES)
