"""Whole works taken into a gallery with their texts: `python benchmarks/scroll.py [--pages] [--names]`.

Without `--pages`: a scroll laid out from the 324 crops of the Lanting Xu (`masters/running-lantingxu`) on
silk, with a mount around it. With it: the printed pages of `pages/printed`. Printed for each: its characters,
how many works stand within it, how many of the text are there under their right names, in order (of the
scroll also where each was put), how many of these a search finds, and how many were opened as surfaces (none
with `--names`); the seconds from the picture until all are works with boxes, and until all are surfaces, too,
which `--jobs` processes make that run already; and the seconds of processors for the one and for the other.
`--out FILE` keeps the scroll and its text as files.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import Executor
from dataclasses import dataclass
from difflib import SequenceMatcher
from functools import partial
from pathlib import Path

import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter

from rumu.errors import RumuError
from rumu.executors import cores, in_order, open_executor
from rumu.gallery.add_page import add_page
from rumu.gallery.assets import assets_of
from rumu.gallery.catalog import open_gallery, work, works
from rumu.gallery.metadata import WorkMetadata
from rumu.gallery.store import Gallery
from rumu.gallery.whole_works import CharacterWithin, characters_within
from rumu.pages.text_alignment import read_text
from rumu.values import Bilingual

DATA = Path(os.environ.get("RUMU_DATA", Path(__file__).parents[2] / "shared" / "data"))
CELL = 120  # pixels from one character to the next in a column
COLUMN = 150  # pixels from one column to the next
ROWS = 12
_AT_ONCE = 32  # surfaces that a process makes before it is asked for the next
MARGIN = 110  # pixels of silk around the writing
MOUNT = (90, 160)  # pixels of the mount at the sides, and above and below
SILK = np.array([214.0, 196.0, 160.0])
BROCADE = np.array([120.0, 132.0, 118.0])


def crops(version: str) -> list[tuple[str, Path]]:
    """(character, file) of one version of the Lanting Xu, in the order of the text."""
    folder = DATA / "masters" / "running-lantingxu"
    with (folder / "labels.csv").open(encoding="utf-8") as stream:
        rows = [row for row in csv.DictReader(stream) if row["file"].startswith(f"{version}/")]
    rows.sort(key=lambda row: int(row["text_index"]))
    return [(row["character"], folder / row["file"]) for row in rows]


def weave(shape: tuple[int, int], colour: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """(H, W, 3) float64, 0-255: cloth of a colour, with threads and slow stains."""
    height, width = shape
    threads = 5 * np.sin(np.arange(height) * 2.1)[:, None] + 4 * np.sin(np.arange(width) * 2.4)[None]
    stains = gaussian_filter(rng.normal(size=shape), 60)
    grain = rng.normal(size=shape)
    shade = threads + 9 * stains / np.abs(stains).max() + 3 * grain
    return np.clip(colour + shade[..., None], 0, 255)


def ink_of(path: Path) -> np.ndarray:
    """(h, w) float64 in [0, 1]: how much light the ink lets through, 1 where there is none."""
    gray = np.asarray(Image.open(path).convert("L"), dtype=np.float64)
    paper = float(np.percentile(gray, 80))
    return np.clip(gray / paper, 0, 1) ** 1.5


def draw_scroll(
    version: str, *, seed: int = 1, first: int = 0, count: int | None = None
) -> tuple[Image.Image, str]:
    """The scroll, of so many characters from the first on, and its text with a line for each column."""
    rng = np.random.default_rng(seed)
    characters = crops(version)[first:][:count]
    columns = [characters[at : at + ROWS] for at in range(0, len(characters), ROWS)]
    height = ROWS * CELL + 2 * MARGIN
    width = len(columns) * COLUMN + 2 * MARGIN
    silk = weave((height, width), SILK, rng)
    for number, column in enumerate(columns):
        x = width - MARGIN - number * COLUMN - COLUMN / 2
        for row, (_, path) in enumerate(column):
            ink = ink_of(path)
            scale = min(1.0, 0.9 * CELL / ink.shape[0], 0.9 * COLUMN / ink.shape[1])
            size = max(1, round(ink.shape[1] * scale)), max(1, round(ink.shape[0] * scale))
            reduced = Image.fromarray((ink * 255).astype(np.uint8)).resize(size, Image.Resampling.LANCZOS)
            drawn = np.asarray(reduced) / 255
            top = round(MARGIN + (row + 0.5) * CELL - drawn.shape[0] / 2)
            left = round(x - drawn.shape[1] / 2 + rng.uniform(-4, 4))
            silk[top : top + drawn.shape[0], left : left + drawn.shape[1]] *= drawn[..., None]
    side, above = MOUNT
    whole = weave((height + 2 * above, width + 2 * side), BROCADE, rng)
    whole[above : above + height, side : side + width] = silk
    picture = Image.fromarray(np.clip(whole, 0, 255).astype(np.uint8))
    return picture, "\n".join("".join(one for one, _ in column) for column in columns)


def printed_pages() -> Iterator[tuple[Path, str]]:
    """(picture, text) of each printed page: registers from the top, columns from the right."""
    for page in json.loads((DATA / "pages" / "text.json").read_text(encoding="utf-8")):
        lines = (column["text"] for register in page["registers"] for column in register)
        yield DATA / "pages" / page["file"], "\n".join(lines)


def in_their_places(matches: list[tuple[int, CharacterWithin]]) -> list[tuple[int, CharacterWithin]]:
    """Those that stand where the scroll has the character of the text with this number.

    The page may have been laid flat: one affine map is fitted to all, twice, the second time without those
    that are far off.
    """
    laid = np.array([divmod(number, ROWS) for number, _ in matches], dtype=float)
    found = np.array([[*np.mean(one.place["polygon"], axis=0), 1] for _, one in matches])
    near = np.ones(len(matches), dtype=bool)
    for _ in range(2):
        places = found @ np.linalg.lstsq(found[near], laid[near], rcond=None)[0]
        near = np.abs(places - laid).max(axis=1) < 0.5
    return [one for one, is_near in zip(matches, near, strict=True) if is_near]


@dataclass(frozen=True)
class Makers:
    """Processes that make surfaces. executor: None where this process makes them."""

    gallery: Gallery
    folder: Path
    processes: int
    executor: Executor | None

    def open_all(self, ids: list[str]) -> tuple[set[str], float]:
        """The works whose surfaces are made, with ink that stands out, and the seconds of processors."""
        parts = [ids[first : first + _AT_ONCE] for first in range(0, len(ids), _AT_ONCE)]
        work = partial(open_some, self.folder)
        found = list(in_order(work, parts, processes=self.processes, executor=self.executor))
        return {one for opened, _ in found for one in opened}, sum(seconds for _, seconds in found)


def open_some(folder: Path, ids: list[str]) -> tuple[list[str], float]:
    """Which of some works can be opened as surfaces, and the seconds of processor time that took."""
    started = time.process_time()
    gallery = gallery_in(folder)
    opened = [one for one in ids if opens(gallery, one)]
    return opened, time.process_time() - started


def figures(makers: Makers, path: Path, text: str, *, open_them: bool, laid_out: bool) -> dict[str, float]:
    """Add a page and count what became of its characters. laid_out: whether it is the scroll."""
    gallery, started, used = makers.gallery, time.perf_counter(), time.process_time()
    metadata = WorkMetadata(title=Bilingual(path.stem, path.stem), script="running")
    added = add_page(gallery, path, text=text, metadata=metadata)
    within = characters_within(gallery, added.id)
    boxes, busy = time.perf_counter() - started, time.process_time() - used
    opened, opening = makers.open_all([one.id for one in within] if open_them else [])
    surfaces = time.perf_counter() - started
    given = read_text(text).characters
    blocks = SequenceMatcher(None, given, [one.character for one in within], autojunk=False)
    ranges = [(block.a, block.b, block.size) for block in blocks.get_matching_blocks()]
    matches = [(a + k, within[b + k]) for a, b, size in ranges for k in range(size)]
    right = [one for _, one in (in_their_places(matches) if laid_out else matches)]
    found = {
        character: {one.id for one in works(gallery, within=added.id, query=character, limit=1000).items}
        for character in {one.character for one in right}
    }
    return {
        "characters": len(given),
        "works": added.characters,
        "right": len(right),
        "searched": sum(one.id in found[one.character] for one in right),
        "opened": sum(one.id in opened for one in right),
        "boxes": boxes,
        "surfaces": surfaces,
        "busy boxes": busy,
        "busy surfaces": opening,
    }


def gallery_in(folder: Path) -> Gallery:
    """The gallery of a run."""
    return open_gallery(database=folder / "a.sqlite", files=folder / "files", starter=False)


def opens(gallery: Gallery, work_id: str) -> bool:
    """Whether a work's surface is made, with ink that stands out."""
    try:
        return bool(assets_of(gallery.store, work(gallery, work_id)).surface().height.max() > 0)
    except RumuError:
        return False


def main() -> None:
    """Print the figures of the scroll, or of the printed pages."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--out", type=Path)
    parser.add_argument("--version", default="shenlong", choices=["shenlong", "yu", "chu"])
    parser.add_argument("--first", type=int, default=0, help="character of the text that it begins at")
    parser.add_argument("--count", type=int, help="how many characters it holds")
    parser.add_argument("--pages", action="store_true")
    parser.add_argument("--names", action="store_true", help="open no surfaces")
    parser.add_argument("--jobs", type=int, default=cores(), help="processes that make surfaces")
    options = parser.parse_args()
    with (
        tempfile.TemporaryDirectory() as folder,
        open_executor(options.jobs) as (executor, processes),
    ):
        makers = Makers(gallery_in(Path(folder)), Path(folder), processes, executor)
        makers.open_all([""] * _AT_ONCE * processes)  # they load their libraries
        if options.pages:
            pages = list(printed_pages())
        else:
            path = options.out or Path(folder, "scroll.png")
            picture, text = draw_scroll(options.version, first=options.first, count=options.count)
            picture.save(path)
            path.with_suffix(".txt").write_text(text + "\n", encoding="utf-8")
            pages = [(path, text)]
        print(
            f"{'page':<28}{'text':>6}{'works':>7}{'right':>7}{'found':>7}{'opened':>8}{'boxes':>8}{'surfaces':>10}"
            f"{'of processors':>18}"
        )
        rows = []
        for path, text in pages:
            rows.append(figures(makers, path, text, open_them=not options.names, laid_out=not options.pages))
            print(f"{path.stem:<28}" + line_of(rows[-1]), flush=True)
        total = {name: sum(row[name] for row in rows) for name in rows[0]}
        print(f"{'all':<28}" + line_of(total))
        share = 100 * total["right"] / total["characters"]
        print(f"under their right names: {share:.1f} % of the text's characters")


def line_of(row: dict[str, float]) -> str:
    """The figures of a page as a line."""
    counts = "".join(
        f"{row[name]:>{width}.0f}"
        for name, width in (("characters", 6), ("works", 7), ("right", 7), ("searched", 7), ("opened", 8))
    )
    seconds = f"{row['boxes']:>7.1f}s{row['surfaces']:>9.1f}s"
    return f"{counts}{seconds}{row['busy boxes']:>9.1f} +{row['busy surfaces']:>5.1f} s"


if __name__ == "__main__":
    main()
