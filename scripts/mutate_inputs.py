#!/usr/bin/env python
"""Mutate valid inputs and read them: `python scripts/mutate_inputs.py --count 30000 --seed 1`.

Pictures of every format, captures and exports are changed (bits, truncation, fields of headers, blocks that
change places, fields of JSON and lines of text) and given to the readers, in processes of their own. Whatever
is read, or refused with a RumuError, is right. Printed are the seed and the counts; what ends in anything
else, takes longer than SECONDS or more memory than MEGABYTES is a fault, and is kept in --faults.
"""

from __future__ import annotations

import argparse
import collections
import io
import json
import multiprocessing
import os
import random
import resource
import shutil
import sys
import tempfile
import time
import warnings
import zlib
from collections.abc import Callable
from functools import cache
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

KINDS = ("images", "captures", "exports")
SHARES = (0.85, 0.12, 0.03)  # of the kinds, when none is named: an export takes long to import
SECONDS, MEGABYTES = 10.0, 1400  # 1000 MB of a decoded picture and what the program itself takes
_ADDRESS_SPACE = 6 * 2**30
_PNG = b"\x89PNG\r\n\x1a\n"
_INTERESTING = (0, 1, 2, 3, 4, 7, 8, 9, 15, 16, 127, 128, 254, 255)


# --- valid inputs ----------------------------------------------------------------------------------


def ink() -> np.ndarray:
    """(40, 48) uint8: strokes on paper."""
    page = np.full((40, 48), 230, np.uint8)
    page[8:32, 20:26] = 40
    page[16:22, 8:40] = 60
    return page


@cache
def images() -> dict[str, bytes]:
    """A picture in every format and depth that is read, by name."""
    import tifffile
    from PIL import Image, ImageCms

    gray = ink()
    colour = np.stack([gray, gray // 2 + 90, gray // 3 + 120], axis=2)
    alpha = np.dstack([colour, np.where(gray > 100, 255, 128).astype(np.uint8)])
    profile = ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()
    exif = Image.Exif()
    exif[0x0112] = 6
    made: dict[str, bytes] = {}

    def save(name: str, array: np.ndarray, kind: str, **options: Any) -> None:
        stream, mode = io.BytesIO(), options.pop("mode", None)
        picture = Image.fromarray(array)
        (picture.convert(mode) if mode else picture).save(stream, kind, **options)
        made[name] = stream.getvalue()

    for kind in ("PNG", "JPEG", "WEBP", "BMP", "GIF", "PPM", "TIFF", "AVIF"):
        save(f"colour.{kind.lower()}", colour, kind)
        save(f"gray.{kind.lower()}", gray, kind)
    for kind in ("PNG", "WEBP", "TIFF", "GIF"):
        save(f"alpha.{kind.lower()}", alpha, kind)
    save("progressive.jpeg", colour, "JPEG", progressive=True)
    save("cmyk.jpeg", colour, "JPEG", mode="CMYK")
    save("turned.jpeg", colour, "JPEG", exif=exif, icc_profile=profile)
    save("two.mpo", colour, "MPO", save_all=True, append_images=[Image.fromarray(colour[::-1].copy())])
    save("profile.png", colour, "PNG", icc_profile=profile)
    save("bits.png", gray, "PNG", mode="1")
    save("palette.png", colour, "PNG", mode="P")
    deep = gray.astype(np.uint16) * 257
    for name, samples, options in (
        ("gray16", deep, {}),
        ("zlib16", deep, {"compression": "zlib", "predictor": True}),
        ("tiled16", deep, {"tile": (16, 16)}),
        ("big16", deep, {"bigtiff": True}),
        ("float", gray / np.float32(255), {"compression": "zlib"}),
        ("planes", np.stack([deep] * 3), {"photometric": "rgb", "planarconfig": "separate"}),
        (
            "gray+alpha",
            np.dstack([deep, deep]),
            {"photometric": "minisblack", "extrasamples": ["unassalpha"]},
        ),
        ("pages", np.stack([deep] * 3), {"photometric": "minisblack"}),
    ):
        stream = io.BytesIO()
        tifffile.imwrite(stream, samples, **options)
        made[f"{name}.tif"] = stream.getvalue()
    save("lzw.tif", gray, "TIFF", compression="tiff_lzw")
    save("jpeg.tif", colour, "TIFF", compression="jpeg")
    save("packbits.tif", gray, "TIFF", compression="packbits")
    import cv2

    made["deep.png"] = cv2.imencode(".png", np.dstack([deep] * 3))[1].tobytes()
    made |= _exr_files(gray / np.float32(255))
    try:
        from pillow_heif import from_pillow
    except ImportError:
        return made
    stream = io.BytesIO()
    from_pillow(Image.fromarray(colour)).save(stream)
    return made | {"colour.heic": stream.getvalue()}


def _exr_files(gray: np.ndarray) -> dict[str, bytes]:
    import OpenEXR

    made = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, packing in (("zip", OpenEXR.ZIP_COMPRESSION), ("plain", OpenEXR.NO_COMPRESSION)):
            header = {"compression": packing, "type": OpenEXR.scanlineimage}
            path = Path(folder) / f"{name}.exr"
            OpenEXR.File(header, {"R": gray, "G": gray.astype(np.float16), "B": gray}).write(str(path))
            made[path.name] = path.read_bytes()
    return made


@cache
def capture_files() -> dict[str, bytes]:
    """The files of a capture under six lamps, with mask, ambient frame and description."""
    from PIL import Image

    files, lines = {}, ["6"]
    rows, columns = np.mgrid[:24, :30] / 12 - 1
    slope = np.dstack([-columns * 0.4, rows * 0.4, np.ones_like(rows)])
    normals = slope / np.linalg.norm(slope, axis=2, keepdims=True)

    def png(array: np.ndarray) -> bytes:
        stream = io.BytesIO()
        Image.fromarray(array).save(stream, "PNG")
        return stream.getvalue()

    for number in range(6):
        tilt = np.radians(60 * number)
        lamp = np.array([np.cos(tilt) * 0.6, np.sin(tilt) * 0.6, 0.8])
        files[f"p{number}.png"] = png((np.clip(normals @ lamp, 0, 1) * 200).astype(np.uint8))
        lines.append(f"p{number}.png " + " ".join(f"{x:.4f}" for x in lamp))
    files["mask.png"] = png(np.full((24, 30), 255, np.uint8))
    files["ambient.png"] = png(np.full((24, 30), 3, np.uint8))
    files["lights.lp"] = "\n".join(lines).encode()
    files["capture.json"] = json.dumps({"spacing_mm": 0.1, "encoding": "linear"}).encode()
    return files


@cache
def export_files() -> dict[str, bytes]:
    """The files of an exported gallery with two works."""
    from rumu.gallery.add_work import add_picture
    from rumu.gallery.archive import export_gallery
    from rumu.gallery.catalog import open_gallery
    from rumu.gallery.metadata import WorkMetadata
    from rumu.gallery.starter import starter_works
    from rumu.values import Bilingual

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        gallery = open_gallery(database=folder / "g.sqlite", files=folder / "files", starter=False)
        for work in starter_works(script="regular")[:2]:
            add_picture(gallery, work.path, metadata=WorkMetadata(title=Bilingual(work.id, work.id)))
        export_gallery(gallery, folder / "out")
        gallery.database.close()
        found = sorted(path for path in (folder / "out").rglob("*") if path.is_file())
        return {path.relative_to(folder / "out").as_posix(): path.read_bytes() for path in found}


# --- mutations -------------------------------------------------------------------------------------


def mutate(data: bytes, rng: random.Random) -> bytes:
    """The data with one to four changes of random kinds; half of the PNGs have checksums that fit."""
    changed = bytearray(data)
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        if changed:
            rng.choice(_CHANGES)(changed, rng)
    if rng.random() < 0.5:
        mend_checksums(changed)
    return bytes(changed)


def mend_checksums(data: bytearray) -> None:
    """Let the checksum of every chunk of a PNG fit what it holds, so that the decoder gets to see it."""
    if data[:8] != _PNG:
        return
    at = 8
    while at + 12 <= len(data):
        end = at + 8 + int.from_bytes(data[at : at + 4], "big")
        if end + 4 > len(data):
            return
        data[end : end + 4] = zlib.crc32(data[at + 4 : end]).to_bytes(4, "big")
        at = end + 4


def _flip_bits(data: bytearray, rng: random.Random) -> None:
    for _ in range(rng.choice((1, 1, 3, 16))):
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)


def _set_head(data: bytearray, rng: random.Random) -> None:
    """A field of one, two, four or eight bytes near the beginning, or anywhere."""
    size = rng.choice((1, 2, 4, 8))
    start = rng.randrange(min(len(data), rng.choice((64, 512, len(data)))))
    value = rng.choice((0, 1, 2**31 - 1, 2**32 - 1, 2**16, 10_000, 65_535, rng.getrandbits(8 * size)))
    data[start : start + size] = (value % 2 ** (8 * size)).to_bytes(size, rng.choice(("big", "little")))


def _set_byte(data: bytearray, rng: random.Random) -> None:
    data[rng.randrange(len(data))] = rng.choice(_INTERESTING)


def _cut(data: bytearray, rng: random.Random) -> None:
    del data[rng.randrange(len(data)) :]


def _cut_few(data: bytearray, rng: random.Random) -> None:
    del data[max(1, len(data) - rng.randrange(1, 20)) :]


def _remove(data: bytearray, rng: random.Random) -> None:
    start = rng.randrange(len(data))
    del data[start : start + rng.randrange(1, 64)]


def _repeat(data: bytearray, rng: random.Random) -> None:
    start = rng.randrange(len(data))
    data[start:start] = data[start : start + rng.randrange(1, 200)] * rng.choice((1, 2, 30))


def _swap(data: bytearray, rng: random.Random) -> None:
    """Two blocks change places."""
    size = rng.randrange(1, 40)
    a, b = rng.randrange(len(data)), rng.randrange(len(data))
    first, second = bytes(data[a : a + size]), bytes(data[b : b + size])
    data[a : a + size] = second
    data[b : b + size] = first


_CHANGES: tuple[Callable[[bytearray, random.Random], None], ...] = (
    _flip_bits, _flip_bits, _set_head, _set_head, _set_byte, _cut, _cut_few, _remove, _repeat, _swap,
)  # fmt: skip


def mutate_text(data: bytes, rng: random.Random) -> bytes:
    """JSON with another value in one of its fields, or lines of text in another order; else bytes."""
    if rng.random() < 0.3:
        return mutate(data, rng)
    try:
        if data.lstrip()[:1] in (b"{", b"["):
            return json.dumps(_mutate_json(json.loads(data), rng)).encode()
        lines = data.decode().splitlines()
    except ValueError:
        return mutate(data, rng)
    at = rng.randrange(len(lines))
    if lines[at].lstrip()[:1] == "{":
        lines[at] = json.dumps(_mutate_json(json.loads(lines[at]), rng))
    else:
        words = lines[at].split(" ")
        words[rng.randrange(len(words))] = rng.choice(
            ("", "nan", "1e400", "-0", "../a.png", "水", "0", "\0", "1,5")
        )
        lines[at] = " ".join(words)
    if rng.random() < 0.2:
        rng.shuffle(lines)
    return "\n".join(lines).encode("utf-8", "surrogatepass")


def _mutate_json(value: Any, rng: random.Random) -> Any:
    if isinstance(value, dict) and value and rng.random() < 0.85:
        name = rng.choice(list(value))
        if rng.random() < 0.15:
            return {key: held for key, held in value.items() if key != name}
        return value | {name: _mutate_json(value[name], rng)}
    if isinstance(value, list) and value and rng.random() < 0.85:
        at = rng.randrange(len(value))
        return [*value[:at], _mutate_json(value[at], rng), *value[at + 1 :]]
    odd = (
        None,
        True,
        -1,
        0,
        10**30,
        1.5,
        float("nan"),
        "",
        "x" * 5000,
        "\ud800",
        "../../etc/passwd",
        [],
        {},
        [[]],
    )
    return rng.choice(odd)


# --- cases -----------------------------------------------------------------------------------------


def make_case(kind: str, number: int, seed: int, folder: Path) -> str:
    """Write the mutated input of a number into a folder; what it was made of."""
    rng = random.Random(f"{seed} {kind} {number}")
    if kind == "images":
        name = rng.choice(list(images()))
        (folder / name).write_bytes(mutate(images()[name], rng))
        return name
    files = dict(capture_files() if kind == "captures" else export_files())
    name = rng.choice(list(files))
    change = mutate if name.endswith(".png") else mutate_text
    files[name] = change(files[name], rng)
    if rng.random() < 0.05:
        del files[rng.choice(list(files))]
    for path, data in files.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(data)
    return name


def read_case(kind: str, number: int, folder: Path) -> None:
    """Read what `make_case` wrote, by one of the ways that it may come in."""
    from rumu.capture.folder import read_capture
    from rumu.capture.image import read_image, read_linear, read_mask
    from rumu.gallery.bulk_import import import_folder
    from rumu.gallery.catalog import open_gallery
    from rumu.pipeline import reconstruct
    from rumu.studio.pictures import normalise_picture
    from rumu.surface.relief import relief

    if kind == "images":
        (path,) = folder.iterdir()
        readers = (
            read_image,
            read_linear,
            read_mask,
            lambda path: normalise_picture(path.read_bytes()),
            relief,
        )
        readers[number % len(readers)](path)
    elif kind == "captures":
        capture = read_capture(folder)
        if number % 5 == 0:
            reconstruct(capture)
    else:
        with tempfile.TemporaryDirectory() as home:
            gallery = open_gallery(
                database=Path(home) / "g.sqlite", files=Path(home) / "files", starter=False
            )
            try:
                import_folder(gallery, folder)
            finally:
                gallery.database.close()


def outcome_of(kind: str, number: int, seed: int, folder: Path) -> tuple[str, str]:
    """('read' or 'refused', '') of a case, or its fault and what it was made of."""
    from rumu.errors import RumuError

    made_of = make_case(kind, number, seed, folder)
    started = time.process_time()  # of this process alone, however busy the machine is
    _forget_peak()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            read_case(kind, number, folder)
        outcome = "read"
    except RumuError:
        outcome = "refused"
    except BaseException as error:
        return f"{type(error).__name__}: {error}", made_of
    peak, seconds = _peak_megabytes(), time.process_time() - started
    if peak > MEGABYTES:
        return f"took {peak:.0f} MB", made_of
    return (outcome, made_of) if seconds <= SECONDS else (f"took {seconds:.1f} s", made_of)


def _forget_peak() -> None:
    Path("/proc/self/clear_refs").write_text("5")


def _peak_megabytes() -> float:
    return int(Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0]) / 1000


# --- processes -------------------------------------------------------------------------------------


def work(connection: Connection, seed: int) -> None:
    """Run the cases that come through the connection, with little priority, until it ends."""
    os.nice(19)
    resource.setrlimit(resource.RLIMIT_AS, (_ADDRESS_SPACE, _ADDRESS_SPACE))
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 2)  # libraries in C complain there
    for number in range(5):  # loads what is needed, so that it is not counted
        with tempfile.TemporaryDirectory() as folder:
            outcome_of("images", number, seed, Path(folder))
    while True:
        try:
            kind, number = connection.recv()
        except EOFError:
            return
        with tempfile.TemporaryDirectory(prefix="rumu-mutation-") as folder:
            connection.send(outcome_of(kind, number, seed, Path(folder)))


class Worker:
    """A process that runs cases; it is replaced when one of them kills it or takes too long."""

    def __init__(self, seed: int) -> None:
        context = multiprocessing.get_context("spawn")
        self.connection, there = context.Pipe()
        self.process = context.Process(target=work, args=(there, seed), daemon=True)
        self.process.start()
        there.close()
        self.case: tuple[str, int] | None = None
        self.since = self.busy = 0.0

    def give(self, case: tuple[str, int]) -> None:
        """Hand a case over."""
        self.case, self.since, self.busy = case, time.monotonic(), self._busy()
        self.connection.send(case)

    def outcome(self) -> str | None:
        """What became of the case; None while it runs."""
        try:
            if self.connection.poll():
                return str(self.connection.recv()[0])
            # the worker measures for itself; this is for what does not return, or waits for something
            worked, waited = self._busy() - self.busy, time.monotonic() - self.since
            return "never ended" if worked > 6 * SECONDS or waited > 60 * SECONDS else None
        except (EOFError, OSError):
            return "the process ended"

    def _busy(self) -> float:
        """Seconds of processor time that the process has taken."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return sum(map(int, fields[11:13])) / os.sysconf("SC_CLK_TCK")

    def stop(self) -> None:
        """End the process."""
        self.process.kill()
        self.process.join()
        self.connection.close()


def run(cases: list[tuple[str, int]], *, seed: int, processes: int, faults: Path) -> dict[str, int]:
    """Run cases; how many were 'read', 'refused' and 'faulty'. Faulty inputs are kept in a folder."""
    counts: collections.Counter[str] = collections.Counter()
    waiting, workers = collections.deque(cases), [Worker(seed) for _ in range(processes)]
    while waiting or any(worker.case for worker in workers):
        for at, worker in enumerate(workers):
            if worker.case is None:
                if waiting:
                    worker.give(waiting.popleft())
                continue
            outcome = worker.outcome()
            if outcome is None:
                continue
            kind, number = worker.case
            worker.case = None
            counts[outcome if outcome in ("read", "refused") else "faulty"] += 1
            if outcome not in ("read", "refused"):
                _keep(kind, number, seed, faults, outcome)
            if outcome in ("the process ended", "never ended"):
                worker.stop()
                workers[at] = Worker(seed)
        time.sleep(0.001)
    for worker in workers:
        worker.stop()
    return dict(counts)


def _keep(kind: str, number: int, seed: int, faults: Path, outcome: str) -> None:
    folder = faults / f"{kind}-{seed}-{number}"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    print(f"{kind} {number} (of {make_case(kind, number, seed, folder)}): {outcome}", flush=True)


def main() -> None:
    """Mutate, read, count."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=1000, help="how many inputs")
    parser.add_argument("--seed", type=int, default=1, help="of the random changes")
    parser.add_argument("--kind", choices=KINDS, help="of one kind alone")
    parser.add_argument("--first", type=int, default=0, help="number of the first input")
    parser.add_argument("--processes", type=int, default=2, help="that read")
    parser.add_argument("--faults", type=Path, default=Path(tempfile.gettempdir()) / "rumu-faults")
    options = parser.parse_args()
    rng = random.Random(options.seed)
    numbers = range(options.first, options.first + options.count)
    kinds = [options.kind or rng.choices(KINDS, SHARES)[0] for _ in numbers]
    started = time.monotonic()
    counts = run(
        list(zip(kinds, numbers, strict=True)),
        seed=options.seed,
        processes=options.processes,
        faults=options.faults,
    )
    seconds = time.monotonic() - started
    said = ", ".join(f"{counts.get(name, 0)} {name}" for name in ("read", "refused", "faulty"))
    print(f"seed {options.seed}: {options.count} inputs, {said}; {seconds:.0f} s")
    if counts.get("faulty"):
        print(f"the faulty inputs are in {options.faults}")
        sys.exit(1)


if __name__ == "__main__":
    main()
