"""The structure of the code: public names, direction of imports, cheap imports, files of readable length."""

from __future__ import annotations

import ast
import inspect
import itertools
import re
import subprocess
import sys
from pathlib import Path

import pytest

import rumu

ROOT = Path(__file__).parents[1]
SRC = ROOT / "src" / "rumu"
FILES = sorted(SRC.rglob("*.py"))

PUBLIC = {
    "Assessment",
    "Capture",
    "Page",
    "Registration",
    "RumuError",
    "Surface",
    "assess",
    "find",
    "integrate",
    "read_capture",
    "read_page",
    "reconstruct",
    "register",
    "relief",
    "relight",
}


def loaded_by(statement: str) -> set[str]:
    """Top-level modules in a fresh interpreter after `statement`."""
    code = f"{statement}\nimport sys; print(' '.join(name.split('.')[0] for name in sys.modules))"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(answer.stdout.split())


def test_public_names_are_locked():
    assert set(rumu.__all__) == PUBLIC


@pytest.mark.parametrize("name", sorted(PUBLIC))
def test_every_public_name_can_be_had(name):
    assert getattr(rumu, name).__doc__


def sections_of(docstring: str) -> set[str]:
    """Headings of a numpydoc docstring: lines that dashes of the same length underline."""
    lines = inspect.cleandoc(docstring).splitlines()
    return {line for line, below in itertools.pairwise(lines) if line and below == "-" * len(line)}


@pytest.mark.parametrize("name", sorted(PUBLIC))
def test_every_public_name_is_documented_for_an_ide(name):
    thing = getattr(rumu, name)
    sections = sections_of(thing.__doc__)
    if isinstance(thing, type):
        assert sections & {"Attributes", "Parameters"}
        return
    assert {"Parameters", "Returns", "Raises"} <= sections
    for parameter in inspect.signature(thing).parameters:
        entry = rf"^ *([a-z, ]+, )?{parameter}\b( :|,|$)"
        assert re.search(entry, thing.__doc__, re.MULTILINE), parameter


def test_a_server_marks_nothing_itself():
    """It stores what its workers have marked: what they need for that made its start a third longer."""
    assert not {"scipy", "cv2", "skimage", "numba", "PIL"} & loaded_by(
        "import rumu.web.app, rumu.studio.attempts as a; a.MarkedCopy"
    )


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = rumu.nothing


def test_imports_go_down_only():
    lint = Path(sys.executable).with_name("lint-imports")
    answer = subprocess.run([lint, "--no-cache"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert answer.returncode == 0, answer.stdout + answer.stderr


HEAVY = {"numpy", "scipy", "cv2", "skimage", "trimesh", "matplotlib", "jinja2", "PIL", "tifffile"}


def test_importing_rumu_loads_nothing_heavy():
    assert not loaded_by("import rumu") & HEAVY


def test_the_command_line_starts_without_anything_heavy():
    assert not loaded_by("import rumu.cli") & (HEAVY | {"rich", "webbrowser", "multiprocessing"})


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.relative_to(SRC).as_posix())
def test_files_are_short_and_named_for_what_they_hold(path):
    assert path.stem not in {"utils", "util", "helpers", "helper", "common", "misc"}
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 400


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.relative_to(SRC).as_posix())
def test_modules_and_public_functions_say_what_they_are(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    kinds = (ast.FunctionDef, ast.ClassDef)
    public = [n for n in tree.body if isinstance(n, kinds) and not n.name.startswith("_")]
    silent = [n.name for n in public if not ast.get_docstring(n) and n.name not in ("main", "register")]
    assert ast.get_docstring(tree), "a module without a docstring"
    assert not silent


def test_no_two_classes_share_a_name():
    places = {}
    for path in FILES:
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef):
                places.setdefault(node.name, []).append(path.relative_to(SRC).as_posix())
    assert {name: found for name, found in places.items() if len(found) > 1} == {}


def test_every_module_of_a_test_has_a_module_to_test():
    """tests/<package>/test_<module>.py mirrors src/rumu/<package>/<module>.py, or a script's name."""
    packages = [package for package in (ROOT / "tests").iterdir() if (SRC / package.name).is_dir()]
    without_module = [
        test.relative_to(ROOT).as_posix()
        for package in packages
        for test in package.glob("test_*.py")
        for name in [f"{test.stem.removeprefix('test_')}.py"]
        if not (SRC / package.name / name).exists() and not (ROOT / "scripts" / name).exists()
    ]
    assert not without_module


def test_the_pages_address_the_service_relative_to_themselves():
    """'/api/works' would leave the path under which a proxy shows the service; 'api/works' stays below it."""
    sources = [one for part in ("src", "standalone") for one in (ROOT / "frontend" / part).rglob("*.ts*")]
    absolute = [
        f"{source.relative_to(ROOT).as_posix()}:{number}"
        for source in sources
        for number, line in enumerate(source.read_text("utf-8").splitlines(), start=1)
        if re.search(r"[\"'`]/(api|iiif|assets)/", line)
    ]
    assert sources and not absolute


def test_no_frontend_test_replaces_a_module():
    """All their files run in one page: what another file has loaded stays, a replacement has no effect."""
    tests = list((ROOT / "frontend/tests").rglob("*.test.ts*"))
    assert tests and not [test.name for test in tests if "vi.mock(" in test.read_text("utf-8")]


def test_the_pages_are_asked_again_by_functions():
    """An expression is compiled anew at each look, which the pages' content security policy forbids after
    the first: such a test fails only where the page was slower than the test."""
    tests = list((ROOT / "tests").rglob("*.py"))
    asked = re.compile(r"wait_for_function\(\s*[\"'](?!\(\) =>)")
    assert tests and not [test.name for test in tests if asked.search(test.read_text("utf-8"))]
