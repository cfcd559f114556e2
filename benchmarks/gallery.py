"""Time the gallery with 11,000 works: `python benchmarks/gallery.py [DATA]`; RUMU_DATABASE for PostgreSQL.

It imports three sets of masters into a new gallery, twice (then all works exist), queries works and
facets, computes derived files, exports everything and imports it again. Beside each time stands the
processor time of this process, which other work on the machine moves less; PostgreSQL has its own.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import rumu
from rumu.gallery.archive import export_gallery
from rumu.gallery.bulk_import import import_folder
from rumu.gallery.catalog import open_gallery, works
from rumu.gallery.derived import derived_file
from rumu.gallery.filters import Filters, count_facets
from rumu.gallery.iiif_image import image_response
from rumu.gallery.starter import starter_works
from rumu.gallery.store import Gallery

SETS = ("regular", "running-lantingxu", "cursive")
ASKED: tuple[dict[str, object], ...] = (
    {},
    {"query": "蘭亭序 之"},
    {"query": "顏真卿 唐"},
    {"query": "颜真卿"},
    {"query": "書"},
    {"query": "永"},
    {"query": "yong"},
    {"query": "Lanting"},
    {"query": "Wang Xizhi"},
    {"query": "王羲之"},
    {"query": "regular script"},
    {"query": "nowhere"},
    {"character": "书"},
    {"script": "cursive"},
    {"dynasty": "Tang", "hand": "歐陽詢"},
)


def import_all(gallery: Gallery, data: Path, name: str) -> None:
    """Print how many works a second go in."""
    began, busy, total = time.perf_counter(), time.process_time(), 0
    for folder in SETS:
        done = import_folder(gallery, data / "masters" / folder)
        total += done.added + done.existing
    seconds, busy = time.perf_counter() - began, time.process_time() - busy
    print(f"{name}: {total} works in {seconds:.1f} s, {total / seconds:.0f} a second; processor {busy:.1f} s")


def timed(work: Callable[[], object], *, times: int = 9) -> str:
    """Median and longest in ms, once it is warm, and the median of the processor's time."""
    work()
    taken, busy = [], []
    for _ in range(times):
        began, before = time.perf_counter(), time.process_time()
        work()
        taken.append(1e3 * (time.perf_counter() - began))
        busy.append(1e3 * (time.process_time() - before))
    return f"{np.median(taken):6.1f} ms, longest {max(taken):6.1f} ms; processor {np.median(busy):6.1f} ms"


def queries(gallery: Gallery) -> None:
    for asked in ASKED:
        query = ", ".join(f"{name} {value}" for name, value in asked.items()) or "everything"
        print(f"  {query}: {works(gallery, **asked).total} works")  # type: ignore[arg-type]
        print(f"    works  {timed(lambda asked=asked: works(gallery, **asked))}")  # type: ignore[misc]
        print(f"    facets {timed(lambda asked=asked: count_facets(gallery, Filters(**asked)))}")  # type: ignore[misc]
    print(f"  the last page: {timed(lambda: works(gallery, offset=11_200))}")


def files(gallery: Gallery) -> None:
    """Print how long derived files of the starter works take, and how large they are."""
    for kind in ("thumb", "thumb-normals", "normals", "heights", "glb"):
        taken, sizes = [], []
        for work in starter_works():
            began = time.perf_counter()
            sizes.append(len(derived_file(gallery, work.id, kind).data))
            taken.append(1e3 * (time.perf_counter() - began))
        print(
            f"  {kind:<13} first {np.median(taken):6.1f} ms; {np.median(sizes) / 1e3:7.1f} kB, "
            f"at most {max(sizes)} bytes"
        )
    print(f"  stored thumb   {timed(lambda: derived_file(gallery, 'regular-shui', 'thumb'))}")
    tile = ("128,128,256,256", "256,256", "0", "default", "jpg")
    print(f"  IIIF tile     {timed(lambda: image_response(gallery, 'regular-shui', *tile))}")


def main() -> None:
    data = Path(sys.argv[1] if len(sys.argv) > 1 else os.environ.get("RUMU_DATA", "../shared/data"))
    with tempfile.TemporaryDirectory(prefix="rumu-bench-") as folder:
        home = Path(folder)
        database = os.environ.get("RUMU_DATABASE") or home / "one.sqlite"
        gallery = open_gallery(database=database, files=home / "one")
        kind = gallery.database.engine.dialect.name
        print(f"rumu {rumu.__version__}, {kind}, {os.cpu_count()} cores")
        import_all(gallery, data, "import")
        import_all(gallery, data, "import again")
        queries(gallery)
        files(gallery)
        began = time.perf_counter()
        count = export_gallery(gallery, home / "out")
        print(f"export: {count} works in {time.perf_counter() - began:.1f} s")
        other = open_gallery(database=home / "two.sqlite", files=home / "two", starter=False)
        began = time.perf_counter()
        done = import_folder(other, home / "out")
        print(f"imported again: {done.added} works in {time.perf_counter() - began:.1f} s")
        for one in (gallery, other):
            one.database.close()


if __name__ == "__main__":
    main()
