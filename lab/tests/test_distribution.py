"""The laboratory is a distribution of its own: it registers its commands, and rumu knows nothing of it."""

from __future__ import annotations

import ast
import importlib
from importlib import metadata, resources
from pathlib import Path

import rumu

ROOT = Path(__file__).parents[2]


def test_the_experiments_are_registered_by_the_entry_point():
    (point,) = [p for p in metadata.entry_points(group="rumu.commands") if p.name == "experiments"]
    importlib.import_module("rumu.cli")  # loads what is registered, as the program does
    assert point.value == "rumu_lab.cli:register" and callable(point.load())


def test_no_module_of_the_product_imports_the_laboratory():
    for path in Path(rumu.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not any(name.split(".")[0] == "rumu_lab" for name in names), path


def test_the_laboratory_brings_its_data():
    for name in ("protocol.json", "templates/experiments.html"):
        assert (resources.files("rumu_lab.experiments") / name).is_file(), name
