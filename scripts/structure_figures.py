"""Print the figures of the code's structure: `python scripts/structure_figures.py`.

Lines and files, files that a copy passes on its way to a mark, circles of imports, classes whose name another
class has, functions of one or two lines, and seconds to start. `--list` names what is counted.
"""

from __future__ import annotations

import argparse
import ast
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGES = {"rumu": ROOT / "src" / "rumu", "rumu_lab": ROOT / "lab" / "src" / "rumu_lab"}
START = ("rumu.pipeline", "assess")
GROUND = ("rumu.errors", "rumu.values")
"""Modules that hold no step of the way: what is raised and what travels."""
NOT_TO_A_MARK = (
    "rumu.pipeline._read_folder",
    "rumu.assessment.remarks.write_remarks",
    "rumu.characters.stroke_data.find_character",
)
"""Where other ways part from a copy's to its mark: photographs under lamps, a written surface, remarks."""

Function = ast.FunctionDef | ast.AsyncFunctionDef


@dataclass
class Module:
    """One file. names: what a name in it stands for, 'module' or 'module.name'."""

    name: str
    path: Path
    tree: ast.Module
    names: dict[str, str] = field(default_factory=dict)

    @cached_property
    def definitions(self) -> dict[str, ast.AST]:
        """Functions and classes at the top level, and constants that are built of names."""
        found: dict[str, ast.AST] = {}
        for node in self.tree.body:
            if isinstance(node, Function | ast.ClassDef):
                found[node.name] = node
            elif isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                found |= {target.id: node.value for target in targets if isinstance(target, ast.Name)}
        return found


def read_modules(packages: dict[str, Path]) -> dict[str, Module]:
    """Every module of the packages by its dotted name, with what its imports bind."""
    modules = {}
    for package, root in packages.items():
        for path in sorted(root.rglob("*.py")):
            inside = path.relative_to(root).with_suffix("")
            parts = [part for part in inside.parts if part != "__init__"]
            name = ".".join([package, *parts])
            modules[name] = Module(name, path, ast.parse(path.read_text("utf-8")))
    for module in modules.values():
        for node in ast.walk(module.tree):
            if isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
                for alias in node.names:
                    module.names[alias.asname or alias.name] = f"{node.module}.{alias.name}"
            elif isinstance(node, ast.Import):
                for alias in node.names:
                    module.names[alias.asname or alias.name] = alias.name
    return modules


def imports(module: Module, modules: dict[str, Module]) -> set[str]:
    """Modules of ours that a module imports, anywhere in it."""
    found = set()
    for target in module.names.values():
        owner = target if target in modules else target.rpartition(".")[0]
        if owner in modules and owner != module.name:
            found.add(owner)
    return found


def circles(modules: dict[str, Module]) -> list[list[str]]:
    """Groups of modules that import one another in a loop (Tarjan's strongly connected components)."""
    graph = {name: imports(module, modules) for name, module in modules.items()}
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for target in graph[node]:
            if target not in index:
                visit(target)
                low[node] = min(low[node], low[target])
            elif target in stack:
                low[node] = min(low[node], index[target])
        if low[node] == index[node]:
            group = stack[stack.index(node) :]
            del stack[stack.index(node) :]
            if len(group) > 1:
                found.append(sorted(group))

    for node in graph:
        if node not in index:
            visit(node)
    return found


def way_of_a_copy(modules: dict[str, Module]) -> dict[str, set[str]]:
    """Return the definitions of each module that `pipeline.assess` may call for a picture.

    Names are followed through imports. A method counts when its class is reached and its name is used.
    """
    reached: dict[str, set[str]] = defaultdict(set)
    waiting: list[tuple[str, str, ast.AST]] = []
    methods: dict[str, list[tuple[str, str, ast.AST]]] = defaultdict(list)
    used: set[str] = set()

    def reach(name: str, definition: str) -> None:
        if definition in reached.get(name, ()) or f"{name}.{definition}" in NOT_TO_A_MARK:
            return
        reached[name].add(definition)
        node = modules[name].definitions[definition]
        if not isinstance(node, ast.ClassDef):
            waiting.append((name, definition, node))
            return
        for part in [*node.bases, *node.decorator_list, *node.body]:
            if not isinstance(part, Function) or part.name.startswith("__"):
                waiting.append((name, definition, part))
            elif part.name in used:
                waiting.append((name, f"{definition}.{part.name}", part))
            else:
                methods[part.name].append((name, f"{definition}.{part.name}", part))

    def use(attribute: str) -> None:
        used.add(attribute)
        waiting.extend(methods.pop(attribute, []))

    reach(*START)
    while waiting:
        name, definition, node = waiting.pop()
        reached[name].add(definition)
        module = modules[name]
        for part in ast.walk(node):
            if isinstance(part, ast.Attribute):
                use(part.attr)
                owner = module.names.get(part.value.id, "") if isinstance(part.value, ast.Name) else ""
                if owner in modules and part.attr in modules[owner].definitions:
                    reach(owner, part.attr)
            elif isinstance(part, ast.Name) and part.id in module.definitions:
                reach(name, part.id)
            elif isinstance(part, ast.Name) and part.id in module.names:
                owner, _, target = module.names[part.id].rpartition(".")
                if owner in modules and target in modules[owner].definitions:
                    reach(owner, target)
    return {name: found for name, found in reached.items() if name not in GROUND}


def functions(modules: dict[str, Module]) -> Iterator[tuple[str, Function, int]]:
    """(module, function, lines of its body without the docstring) of every function."""
    for module in modules.values():
        for node in ast.walk(module.tree):
            if isinstance(node, Function):
                body = node.body[1:] if ast.get_docstring(node) is not None else node.body
                lines = body[-1].end_lineno - body[0].lineno + 1 if body else 0  # type: ignore[operator]
                yield module.name, node, lines


def only_renames(function: Function) -> bool:
    """Whether all that a function does is to call another with its own parameters, in their order."""
    body = function.body[1:] if ast.get_docstring(function) is not None else function.body
    if len(body) != 1 or function.decorator_list or not isinstance(body[0], ast.Return):
        return False
    call, own = body[0].value, function.args
    if not isinstance(call, ast.Call) or not isinstance(call.func, ast.Name | ast.Attribute):
        return False
    if isinstance(call.func, ast.Attribute) and not isinstance(call.func.value, ast.Name):
        return False
    parameters = [argument.arg for argument in [*own.posonlyargs, *own.args, *own.kwonlyargs]]
    given = [*call.args, *(keyword.value for keyword in call.keywords)]
    names = [value.id for value in given if isinstance(value, ast.Name)]
    return len(names) == len(given) > 0 and names == parameters


def same_names(modules: dict[str, Module]) -> dict[str, list[str]]:
    """Class names that are defined more than once, with where."""
    homes = defaultdict(list)
    for module in modules.values():
        for node in ast.walk(module.tree):
            if isinstance(node, ast.ClassDef):
                homes[node.name].append(module.name)
    return {name: found for name, found in sorted(homes.items()) if len(found) > 1}


def seconds(*command: str) -> float:
    """Seconds of the quickest of five runs."""
    best = float("inf")
    for _ in range(5):
        start = time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        best = min(best, time.perf_counter() - start)
    return best


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--list", action="store_true", help="name what is counted, too")
    listed = parser.parse_args().list
    modules = read_modules(PACKAGES)
    product = {name: module for name, module in modules.items() if name.split(".")[0] == "rumu"}
    lines = sum(len(module.path.read_text("utf-8").splitlines()) for module in product.values())
    print(f"src/rumu: {lines} lines, {len(product)} files")
    way = way_of_a_copy(product)
    print(f"files that a copy passes to its mark: {len(way)}")
    loops = circles(modules)
    print(f"circles of Python files: {len(loops)}")
    every = list(functions(product))
    short = [(module, f.name) for module, f, size in every if size <= 2]
    renaming = [(module, f.name) for module, f, _ in every if only_renames(f)]
    print(f"functions of one or two lines: {len(short)} of {len(every)}, {len(short) / len(every):.1%}")
    print(f"functions that only rename another: {len(renaming)}")
    twice = same_names(modules)
    print(f"class names defined more than once: {len(twice)}")
    rumu = str(Path(sys.executable).with_name("rumu"))
    print(f"import rumu: {seconds(sys.executable, '-c', 'import rumu'):.3f} s")
    print(f"rumu --help: {seconds(rumu, '--help'):.3f} s")
    if listed:
        for name, found in sorted(way.items()):
            print(f"  way: {name}: {', '.join(sorted(found))}")
        for loop in loops:
            print(f"  circle: {', '.join(loop)}")
        for name, homes in twice.items():
            print(f"  twice: {name}: {', '.join(homes)}")
        for module, name in renaming:
            print(f"  renames: {module}.{name}")
        by_module: dict[str, list[str]] = defaultdict(list)
        for module, name in short:
            by_module[module].append(name)
        for module, names in sorted(by_module.items()):
            print(f"  short: {module}: {', '.join(names)}")


if __name__ == "__main__":
    main()
