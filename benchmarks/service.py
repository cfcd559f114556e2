"""How the service bears a class: readers and writers at once, from a process of their own.

    python benchmarks/service.py [--seconds 60] [--readers 50] [--writers 5] [--pause 1.0]

Starts `rumu serve` on loopback with a gallery in a temporary folder. Each reader opens pages as a browser
does: a list
with its thumbnails, then a work with what the viewer loads; a page counts when all of it has come. Between
pages a
reader looks for `pause` seconds on average. Each writer sends a 512 x 512 copy to be marked and kept, and
sends the next
once it is marked. Prints errors, the times of pages and marks, and the server's memory before and after.
The machine's
load is printed with them: what else runs counts, too.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import multiprocessing
import os
import random
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

import httpx
import numpy as np

from rumu.gallery.catalog import open_gallery
from rumu.gallery.works import starter_samples
from rumu.studio.people import create_person

PASSWORD = "a long password"
SHOWN = ("heights", "normals", "albedo", "picture", "mask")


class Visit:
    """One client with its own connection, cookies and what it has loaded already."""

    def __init__(self, url: str, times: dict[str, list[float]], errors: Counter[str]) -> None:
        self.client = httpx.AsyncClient(
            base_url=url, timeout=30, trust_env=False, limits=httpx.Limits(max_connections=6)
        )
        self.times, self.errors, self.seen = times, errors, set[str]()

    async def get(self, url: str) -> Any:
        """Once, where it may be kept for ever."""
        if url in self.seen:
            return None
        answer = await self.client.get(url)
        if answer.status_code != 200:
            self.errors[f"{answer.status_code} {url.split('?', maxsplit=1)[0]}"] += 1
        if "immutable" in answer.headers.get("cache-control", ""):
            self.seen.add(url)
        return answer.json() if "json" in answer.headers.get("content-type", "") else None

    async def page(self, kind: str, load: Any) -> Any:
        started = time.perf_counter()
        try:
            told = await load
        except httpx.HTTPError as error:
            self.errors[type(error).__name__] += 1
            return None
        self.times[kind].append(time.perf_counter() - started)
        return told

    async def listed(self) -> list[dict[str, Any]]:
        page, _ = await asyncio.gather(self.get("/api/works?limit=30"), self.get("/api/facets"))
        await asyncio.gather(*(self.get(card["thumb"]) for card in page["items"]))
        return list(page["items"])

    async def work(self, work_id: str) -> None:
        _, viewer = await asyncio.gather(
            self.get(f"/api/works/{work_id}"), self.get(f"/api/works/{work_id}/viewer")
        )
        urls = [viewer["heights"]["url"], *(viewer[name] for name in SHOWN[1:])]
        await asyncio.gather(*map(self.get, urls))

    async def log_in(self, name: str) -> dict[str, str]:
        token = (await self.client.get("/api/session")).json()["csrf"]
        told = {"name": name, "password": PASSWORD}
        answer = await self.client.post("/api/login", json=told, headers={"X-CSRF-Token": token})
        return {"X-CSRF-Token": answer.json()["csrf"]}

    async def mark(self, headers: dict[str, str], sample: Any, data: bytes) -> None:
        answer = await self.client.post(
            "/api/marks", data={"work": sample.work}, files={"picture": ("a.png", data)}, headers=headers
        )
        if answer.status_code != 201:
            self.errors[f"{answer.status_code} /api/marks"] += 1


async def read(visit: Visit, until: float, pause: float) -> None:
    await asyncio.sleep(random.random() * pause)
    while time.perf_counter() < until:
        cards = await visit.page("page", visit.listed())
        for card in random.sample(cards or [], min(3, len(cards or []))):
            await asyncio.sleep(random.expovariate(1 / pause))
            await visit.page("page", visit.work(card["id"]))
        await asyncio.sleep(random.expovariate(1 / pause))
        if random.random() < 0.2:
            visit.seen.clear()  # somebody new sits down


async def write(visit: Visit, name: str, until: float) -> None:
    headers = await visit.log_in(name)
    samples = [(sample, sample.path.read_bytes()) for sample in starter_samples()]
    while time.perf_counter() < until:
        await visit.page("mark", visit.mark(headers, *random.choice(samples)))
        await asyncio.sleep(0.2)


async def load(url: str, asked: argparse.Namespace) -> dict[str, Any]:
    times: dict[str, list[float]] = {"page": [], "mark": []}
    errors: Counter[str] = Counter()
    until = time.perf_counter() + asked.seconds
    visits = [Visit(url, times, errors) for _ in range(asked.readers + asked.writers)]
    work = [read(visit, until, asked.pause) for visit in visits[: asked.readers]]
    work += [write(visit, f"pupil{k}", until) for k, visit in enumerate(visits[asked.readers :])]
    await asyncio.gather(*work)
    await asyncio.gather(*(visit.client.aclose() for visit in visits))
    return {"times": times, "errors": dict(errors)}


def in_own_process(url: str, asked: argparse.Namespace) -> dict[str, Any]:
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(_loaded, (url, asked))


def _loaded(url: str, asked: argparse.Namespace) -> dict[str, Any]:
    return asyncio.run(load(url, asked))


def memory(pid: int) -> float:
    """MB that a process and all below it hold, each shared page counted for its share."""
    total = 0.0
    for one in _family(pid):
        try:
            rows = Path(f"/proc/{one}/smaps_rollup").read_text().splitlines()
        except OSError:
            continue
        total += sum(int(row.split()[1]) for row in rows if row.startswith("Pss:")) / 1024
    return total


def _family(pid: int) -> list[int]:
    found = [pid]
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = int(stat.read_text().rsplit(")", 1)[1].split()[1])
        except OSError:
            continue
        if parent == pid:
            found += _family(int(stat.parent.name))
    return found


def told(name: str, seconds: list[float]) -> str:
    if not seconds:
        return f"{name}: none"
    p50, p95 = np.percentile(seconds, (50, 95)) * 1000
    return f"{name}: {len(seconds)}, p50 {p50:.0f} ms, p95 {p95:.0f} ms, worst {max(seconds) * 1000:.0f} ms"


def main() -> None:
    parser = argparse.ArgumentParser(description="Readers and writers at once on one service.")
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--readers", type=int, default=50)
    parser.add_argument("--writers", type=int, default=5)
    parser.add_argument("--pause", type=float, default=1.0)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="rumu-bench-") as folder:
        database, files = f"{folder}/rumu.sqlite", f"{folder}/files"
        gallery = open_gallery(database=database, files=files)
        with gallery.database.writing() as session:
            for k in range(asked.writers):
                create_person(session, name=f"pupil{k}", password=PASSWORD, role="pupil")
        gallery.database.close()
        command = ("serve", "--port", "0", "--json", "--database", database, "--files", files)
        server = subprocess.Popen(
            [sys.executable, "-m", "rumu.cli", *command], stdout=subprocess.PIPE, text=True
        )
        try:
            url = json.loads(server.stdout.readline())["url"]
            measured(url, server.pid, asked)
        finally:
            server.terminate()
            server.wait(30)


def measured(url: str, pid: int, asked: argparse.Namespace) -> None:
    with httpx.Client(base_url=url, trust_env=False, timeout=60) as client:
        client.get("/api/works")
    time.sleep(20)  # the first start makes thumbnails, maps and samples
    print(f"load average before: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    warm = argparse.Namespace(**vars(asked) | {"seconds": min(10.0, asked.seconds)})
    in_own_process(url, warm)
    before = memory(pid)
    found = in_own_process(url, asked)
    after = memory(pid)
    print(f"{asked.readers} readers, {asked.writers} writers, {asked.seconds:.0f} s")
    print(told("pages", found["times"]["page"]))
    print(told("marks", found["times"]["mark"]))
    print(f"errors: {sum(found['errors'].values())} {found['errors'] or ''}")
    print(f"memory of the service: {before:.0f} MB before, {after:.0f} MB after")
    print(f"load average after: {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
