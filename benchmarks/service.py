"""Performance of the service: readers and writers at once, from a process of their own.

    python benchmarks/service.py [--seconds 60] [--readers 50] [--writers 5] [--pause 3.0]

Starts `rumu serve` on loopback with a gallery in a temporary folder. Each reader opens pages as a browser
does: a list with its thumbnails, then a work with the files that the viewer loads. A page counts when all of
it has arrived, and between pages a reader waits for `pause` seconds on average. Each writer sends a 512 x 512
copy to be marked and kept, and sends the next one when the mark arrives. Prints errors, the times of pages
and marks, and the server's memory before and after, with the machine's load: other programs slow it down.
"""

from __future__ import annotations

import argparse
import asyncio
import gzip
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
from rumu.gallery.starter import starter_samples
from rumu.studio.people import create_person

PASSWORD = "a long password"
SHOWN = ("heights", "normals", "albedo", "picture", "mask")


class Connection:
    """One kept-alive connection, in plain code: the service is measured, not an HTTP client.

    A server may end a connection that waits; the request that finds it ended is sent again, as by browsers.
    """

    def __init__(self, port: int) -> None:
        self.port, self.busy = port, asyncio.Lock()
        self.reader: asyncio.StreamReader | None = None
        self.writer: asyncio.StreamWriter | None = None

    async def get(self, url: str) -> tuple[int, bytes, bytes]:
        """(status, head, body as it came)."""
        async with self.busy:
            if self.reader is not None and self.reader.at_eof():
                self.close()
            try:
                return await self._ask(url)
            except (OSError, EOFError):
                self.close()
                return await self._ask(url)

    async def _ask(self, url: str) -> tuple[int, bytes, bytes]:
        if self.reader is None or self.writer is None:
            self.reader, self.writer = await asyncio.open_connection("127.0.0.1", self.port)
        request = f"GET {url} HTTP/1.1\r\nHost: 127.0.0.1\r\nAccept-Encoding: gzip\r\n\r\n"
        self.writer.write(request.encode())
        head = (await self.reader.readuntil(b"\r\n\r\n")).lower()
        length = int(head.split(b"content-length:")[1].split(b"\r\n")[0])
        return int(head[9:12]), head, await self.reader.readexactly(length)

    def close(self) -> None:
        if self.writer is not None:
            self.writer.close()
        self.reader = self.writer = None


class Visit:
    """One browser: six connections, and the files that it has already. A writer logs in and sends."""

    def __init__(self, url: str, times: dict[str, list[float]], errors: Counter[str]) -> None:
        self.url, self.times, self.errors, self.seen = url, times, errors, set[str]()
        self.connections = [Connection(int(url.rstrip("/").rpartition(":")[2])) for _ in range(6)]

    async def get(self, url: str) -> Any:
        """The JSON at a URL, None for a file. An immutable file is fetched once."""
        if url in self.seen:
            return None
        best = min(self.connections, key=lambda one: one.busy.locked() or one.writer is None)
        connection = random.choice(self.connections) if best.busy.locked() else best
        status, head, body = await connection.get(url)
        if status != 200:
            self.errors[f"{status} {url.split('?', maxsplit=1)[0]}"] += 1
        if b"immutable" in head:
            self.seen.add(url)
        if b"application/json" not in head:
            return None
        return json.loads(gzip.decompress(body) if b"content-encoding: gzip" in head else body)

    async def page(self, kind: str, load: Any) -> Any:
        started = time.perf_counter()
        try:
            result = await load
        except (httpx.HTTPError, OSError, EOFError) as error:
            self.errors[type(error).__name__] += 1
            return None
        self.times[kind].append(time.perf_counter() - started)
        return result

    async def load_list(self) -> list[dict[str, Any]]:
        page, _ = await asyncio.gather(self.get("/api/works?limit=30"), self.get("/api/facets"))
        await asyncio.gather(*(self.get(card["thumb"]) for card in page["items"]))
        return list(page["items"])

    async def load_work(self, work_id: str) -> None:
        _, viewer = await asyncio.gather(
            self.get(f"/api/works/{work_id}"), self.get(f"/api/works/{work_id}/viewer")
        )
        urls = [viewer["heights"]["url"], *(viewer[name] for name in SHOWN[1:])]
        await asyncio.gather(*map(self.get, urls))

    def log_in(self, name: str) -> None:
        self.client = httpx.AsyncClient(base_url=self.url, timeout=60, trust_env=False)
        self.name = name

    async def headers(self) -> dict[str, str]:
        token = (await self.client.get("/api/session")).json()["csrf"]
        credentials = {"name": self.name, "password": PASSWORD}
        answer = await self.client.post("/api/login", json=credentials, headers={"X-CSRF-Token": token})
        return {"X-CSRF-Token": answer.json()["csrf"]}

    async def mark(self, headers: dict[str, str], sample: Any, data: bytes) -> None:
        answer = await self.client.post(
            "/api/marks", data={"work": sample.work}, files={"picture": ("a.png", data)}, headers=headers
        )
        if answer.status_code != 201:
            self.errors[f"{answer.status_code} /api/marks"] += 1

    async def close(self) -> None:
        for line in self.connections:
            line.close()


async def read(visit: Visit, until: float, pause: float) -> None:
    await asyncio.sleep(random.random() * pause)
    while time.perf_counter() < until:
        cards = await visit.page("page", visit.load_list())
        for card in random.sample(cards or [], min(3, len(cards or []))):
            await asyncio.sleep(random.expovariate(1 / pause))
            await visit.page("page", visit.load_work(card["id"]))
        await asyncio.sleep(random.expovariate(1 / pause))
        if random.random() < 0.2:
            visit.seen.clear()  # a new reader, with an empty cache


async def write(visit: Visit, until: float) -> None:
    headers = await visit.headers()
    samples = [(sample, sample.path.read_bytes()) for sample in starter_samples()]
    while time.perf_counter() < until:
        await visit.page("mark", visit.mark(headers, *random.choice(samples)))
        await asyncio.sleep(0.35)  # a person may send 120 in a minute
    await visit.client.aclose()


async def load(url: str, options: argparse.Namespace) -> dict[str, Any]:
    times: dict[str, list[float]] = {"page": [], "mark": []}
    errors: Counter[str] = Counter()
    visits = [Visit(url, times, errors) for _ in range(options.readers + options.writers)]
    for k, visit in enumerate(visits[options.readers :]):
        visit.log_in(f"pupil{k}")
    until = time.perf_counter() + options.seconds
    work = [read(visit, until, options.pause) for visit in visits[: options.readers]]
    work += [write(visit, until) for visit in visits[options.readers :]]
    await asyncio.gather(*work)
    await asyncio.gather(*(visit.close() for visit in visits))
    return {"times": times, "errors": dict(errors)}


def load_in_process(url: str, options: argparse.Namespace) -> dict[str, Any]:
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(_run_load, (url, options))


def _run_load(url: str, options: argparse.Namespace) -> dict[str, Any]:
    return asyncio.run(load(url, options))


def memory(pid: int) -> float:
    """Proportional set size in MB of a process and its descendants."""
    total = 0.0
    for one in _process_tree(pid):
        try:
            rows = Path(f"/proc/{one}/smaps_rollup").read_text().splitlines()
        except OSError:
            continue
        total += sum(int(row.split()[1]) for row in rows if row.startswith("Pss:")) / 1024
    return total


def _process_tree(pid: int) -> list[int]:
    results = [pid]
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = int(stat.read_text().rsplit(")", 1)[1].split()[1])
        except OSError:
            continue
        if parent == pid:
            results += _process_tree(int(stat.parent.name))
    return results


def describe(name: str, seconds: list[float]) -> str:
    if not seconds:
        return f"{name}: none"
    p50, p95 = np.percentile(seconds, (50, 95)) * 1000
    return f"{name}: {len(seconds)}, p50 {p50:.0f} ms, p95 {p95:.0f} ms, worst {max(seconds) * 1000:.0f} ms"


def main() -> None:
    parser = argparse.ArgumentParser(description="Readers and writers at once on one service.")
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--readers", type=int, default=50)
    parser.add_argument("--writers", type=int, default=5)
    parser.add_argument("--pause", type=float, default=3.0)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="rumu-bench-") as folder:
        database, files = f"{folder}/rumu.sqlite", f"{folder}/files"
        gallery = open_gallery(database=database, files=files)
        with gallery.database.writing() as session:
            for k in range(options.writers):
                create_person(session, name=f"pupil{k}", password=PASSWORD, role="pupil")
        gallery.database.close()
        command = ("serve", "--port", "0", "--json", "--database", database, "--files", files)
        server = subprocess.Popen(
            [sys.executable, "-m", "rumu.cli", *command], stdout=subprocess.PIPE, text=True
        )
        try:
            url = json.loads(server.stdout.readline())["url"]
            measure(url, server.pid, options)
        finally:
            server.terminate()
            server.wait(30)


def measure(url: str, pid: int, options: argparse.Namespace) -> None:
    with httpx.Client(base_url=url, trust_env=False, timeout=60) as client:
        client.get("/api/works")
    time.sleep(20)  # the first start makes thumbnails, maps and samples
    print(f"load average before: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    warm = argparse.Namespace(**vars(options) | {"seconds": min(10.0, options.seconds)})
    load_in_process(url, warm)
    before = memory(pid)
    results = load_in_process(url, options)
    after = memory(pid)
    print(f"{options.readers} readers, {options.writers} writers, {options.seconds:.0f} s")
    print(describe("pages", results["times"]["page"]))
    print(describe("marks", results["times"]["mark"]))
    print(f"errors: {sum(results['errors'].values())} {results['errors'] or ''}")
    print(f"memory of the service: {before:.0f} MB before, {after:.0f} MB after")
    print(f"load average after: {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
