"""A sample of mutated inputs: each is read or refused on purpose, by the readers and by the service."""

from __future__ import annotations

import importlib.util
import random
import subprocess
import sys
import zlib
from pathlib import Path
from types import ModuleType

import pytest
from starlette.testclient import TestClient

from rumu.errors import ImageError

SCRIPT = Path(__file__).parents[1] / "scripts" / "mutate_inputs.py"
pytestmark = pytest.mark.skipif(
    not Path("/proc/self/clear_refs").exists(), reason="only Linux tells the peak"
)


@pytest.fixture(scope="module")
def mutations() -> ModuleType:
    spec = importlib.util.spec_from_file_location("mutate_inputs", SCRIPT)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(("kind", "count"), [("images", 200), ("captures", 40), ("exports", 8)])
def test_a_sample_is_read_or_refused(tmp_path: Path, kind: str, count: int) -> None:
    command = [sys.executable, str(SCRIPT), "--count", str(count), "--kind", kind, "--seed", "11"]
    done = subprocess.run([*command, "--faults", str(tmp_path)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"seed 11: {count} inputs, " in done.stdout and ", 0 faulty; " in done.stdout
    assert not list(tmp_path.iterdir())


def test_a_fault_is_found_and_kept(
    mutations: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(kind: str, number: int, folder: Path) -> None:
        raise ZeroDivisionError("no such thing") if number else ImageError("broken")

    monkeypatch.setattr(mutations, "read_case", broken)
    monkeypatch.setattr(mutations, "_peak_megabytes", lambda: 100.0)  # else that of all tests before this one
    (tmp_path / "a").mkdir(), (tmp_path / "b").mkdir()
    assert mutations.outcome_of("images", 0, 1, tmp_path / "a")[0] == "refused"
    assert mutations.outcome_of("images", 1, 1, tmp_path / "b")[0] == "ZeroDivisionError: no such thing"
    mutations._keep("images", 1, 1, tmp_path / "faults", "ZeroDivisionError")
    (kept,) = (tmp_path / "faults" / "images-1-1").iterdir()
    assert kept.read_bytes() == next((tmp_path / "b").iterdir()).read_bytes()


def test_every_mutation_of_a_seed_is_the_same(mutations: ModuleType) -> None:
    data = bytes(range(256)) * 4
    first, second = ([mutations.mutate(data, random.Random(seed)) for seed in range(60)] for _ in range(2))
    assert first == second and sum(changed != data for changed in first) > 50


def test_routes_of_marks_and_works_never_fail(mutations: ModuleType, tmp_path: Path) -> None:
    from tests.web.conftest import World

    from rumu.studio.people import create_person
    from rumu.studio.storage import Storage
    from rumu.web.app import create_app
    from rumu.web.rate_limits import RateLimitSettings
    from rumu.web.settings import ServiceSettings

    storage = Storage(database=str(tmp_path / "rumu.sqlite"), files=str(tmp_path / "files"))
    limits = RateLimitSettings(tries="9999/minute", uploads="9999/hour")
    app = create_app(ServiceSettings(storage, processes=0, prepare=False, rate_limits=limits))
    rng = random.Random(5)
    with TestClient(app) as server:
        service = app.state.service
        with service.gallery.database.writing() as session:
            teacher = create_person(session, name="林", password="a long password", role="teacher").id
        world = World(server, {})
        visitor = world.browser()
        logged_in = world.browser().log_in(service, teacher)
        for name, data in mutations.images().items():
            files = {"picture": (name, mutations.mutate(data, rng))}
            fields = {"work": "regular-ren", "keep": "false"}
            for answer in (
                visitor("POST", "/api/marks", data=fields, files=files),
                logged_in("POST", "/api/works", files=files),
            ):
                assert answer.status_code < 500, (name, answer.text)
                if answer.status_code >= 400:
                    error = answer.json()["error"]
                    assert error["zh"] and error["en"] and "/tmp" not in error["zh"] + error["en"]


def test_half_of_the_broken_pngs_have_checksums_that_fit(mutations: ModuleType) -> None:
    whole = mutations.images()["gray.png"]
    mended = bytearray(whole)
    mutations.mend_checksums(mended)
    assert mended == whole
    mended[20] ^= 1  # of the width, in IHDR
    broken = bytes(mended)
    mutations.mend_checksums(mended)
    assert mended[29:33] == zlib.crc32(mended[12:29]).to_bytes(4, "big") and mended[:29] == broken[:29]
    for other in (bytearray(b""), bytearray(broken[:30]), bytearray(b"II*\0" + broken)):
        before = bytes(other)
        mutations.mend_checksums(other)
        assert other == before

    changed = [mutations.mutate(whole, random.Random(seed)) for seed in range(400)]
    fit = 0
    for data in changed:
        again = bytearray(data)
        mutations.mend_checksums(again)
        fit += bytes(again) == data
    assert 160 < fit < 320  # what does not fit is seen as such; a few changes hit no checksum
