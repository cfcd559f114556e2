"""How well photographs of our own sheets are read: `python benchmarks/sheets.py --count 500`.

Sheets of 24 learners' copies (e3c and e3c-more of RUMU_DATA), of every grid, help and paper, are printed,
written on, and photographed by the simulated camera of the laboratory, whose map is known. Printed are: the
share of cells that are found and right; how far their corners lie from the truth, of photographs of 12
megapixels; the overlap of the ink; by how much marks differ from those of the unphotographed copies; what was
refused. With --marks 0 nothing is marked; --save FOLDER writes a picture of each cell whose mark differs by
more than 3 points, beside the copy in it; --every-copy writes each of the copies once, instead of drawing
them, and --seed draws other sheets of them; --time measures one photograph of 24 cells instead, whole and, in
one process with one thread, by its parts.
"""

from __future__ import annotations

import argparse
import csv
import os
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field, replace
from pathlib import Path

import cv2
import numpy as np
import pypdfium2
from PIL import Image

from rumu import pipeline
from rumu.errors import RefusedImage
from rumu.gallery.sheet_masters import SheetMasters, choose_masters
from rumu.pages.sheet_layout import GRIDS, HELPS, PAPERS, SheetPage, lay_out
from rumu.pages.sheet_pdf import sheet_pdf
from rumu.pages.sheet_reading import WrittenCell, locate_sheet, read_cells
from rumu.studio.sheet_marks import prepared_master, surface_of_cell
from rumu.surface.ink import find_ink
from rumu_lab.simulation.camera import Conditions, draw_conditions, take_photograph

DATA = Path(os.environ.get("RUMU_DATA", Path(__file__).parents[1] / ".." / "shared" / "data"))
CELLS, DPI, INK = 24, 300, 0.9
Copies = dict[tuple[int, int], Path]
"""The copy that is written in each cell of a page, by its row and column."""


@dataclass
class Figures:
    """What is counted over all photographs."""

    photographs: int = 0
    cells: int = 0
    right: int = 0
    wrong: int = 0
    corners: list[float] = field(default_factory=list)
    overlaps: list[float] = field(default_factory=list)
    off: list[float] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)
    refused: Counter[str] = field(default_factory=Counter)


def read_copies() -> tuple[dict[str, list[Path]], dict[str, Path]]:
    """The copies of each character, and its template."""
    copies: dict[str, list[Path]] = {}
    templates: dict[str, Path] = {}
    for folder in ("e3c", "e3c-more"):
        with (DATA / folder / "scores.csv").open(encoding="utf-8-sig", newline="") as stream:
            for row in csv.DictReader(stream):
                template = templates.setdefault(row["character"], DATA / folder / row["template"])
                if template == DATA / folder / row["template"]:
                    copies.setdefault(row["character"], []).append(DATA / folder / row["image"])
    return copies, templates


def draw_copies(
    page: SheetPage, copies: dict[str, list[Path]], rng: np.random.Generator, *, blank: float = 0.1
) -> Copies:
    """A copy by chance for each cell to write in but a share `blank`."""
    drawn = {}
    for cell in page.cells:
        if cell.is_for_writing and rng.random() >= blank:
            drawn[cell.row, cell.column] = copies[cell.character][rng.integers(len(copies[cell.character]))]
    return drawn


def print_and_write(
    page: SheetPage, masters: SheetMasters, chosen: Copies
) -> tuple[np.ndarray, dict[tuple[int, int], np.ndarray]]:
    """A printed page with these copies in its cells, and those copies (400, 400) by cell."""
    document = pypdfium2.PdfDocument(sheet_pdf([page], masters.shapes))
    flat = np.asarray(document[0].render(scale=DPI / 72).to_pil().convert("RGB")).astype(np.float32)
    # the picture has whole pixels, the paper not
    (sx, sy), written = np.array(flat.shape[1::-1]) / page.size, {}
    for cell in page.cells:
        path = chosen.get((cell.row, cell.column))
        if path is None:
            continue
        with Image.open(path) as picture:
            copy = np.asarray(picture.convert("L"))
        left, top = int(cell.box.left * sx), int(cell.box.top * sy)
        fx, fy = cell.box.width * sx / len(copy), cell.box.height * sy / len(copy)
        side = int(cell.box.width * sx) + 2
        place = np.array(
            [
                [fx, 0, cell.box.left * sx - left + 0.5 * fx - 0.5],
                [0, fy, cell.box.top * sy - top + 0.5 * fy - 0.5],
            ]
        )
        ink = cv2.GaussianBlur(255 - copy, (0, 0), 0.4 / fx)
        laid = cv2.warpAffine(ink, place, (side, side)).astype(np.float32) / 255
        flat[top : top + side, left : left + side] *= 1 - INK * laid[..., None]
        written[cell.row, cell.column] = copy
    return np.clip(flat, 0, 255).astype(np.uint8), written


def plan_sheet(number: int, text: str, masters: SheetMasters) -> tuple[SheetPage, ...]:
    """The pages of a sheet of a text: grid, help and paper go by its number."""
    grid, help_ = GRIDS[number % 5], HELPS[number // 5 % 5]
    paper = sorted(PAPERS)[number % 2]
    return lay_out(
        SheetPage(text, masters.name, paper=paper, grid=grid, help=help_, times=1, cell=28, strokes=False)
    )


def read_drawn(
    number: int, figures: Figures, copies: dict[str, list[Path]], folder: Path, asked: argparse.Namespace
) -> None:
    """Read one sheet of characters and copies by chance."""
    rng = np.random.default_rng(number)
    text = "".join(rng.choice(sorted(copies), CELLS))
    masters = choose_masters(text, (str(folder),), script="regular")
    # a sheet that shows masters beside the cells has two cells for each character, and is as long as its page
    page = plan_sheet(number, text, masters)[0]
    read_one(number, page, masters, draw_copies(page, copies, rng), figures=figures, rng=rng, asked=asked)


def read_every_copy(
    figures: Figures, copies: dict[str, list[Path]], folder: Path, asked: argparse.Namespace
) -> None:
    """Read sheets in which every copy is written once; of these sheets the asked ones."""
    every = [(character, path) for character in sorted(copies) for path in copies[character]]
    np.random.default_rng(asked.seed).shuffle(every)
    sheets = [every[k : k + CELLS] for k in range(0, len(every), CELLS)]
    for number in range(asked.first, min(asked.first + asked.count, len(sheets))):
        rng = np.random.default_rng([asked.seed, number])
        text = "".join(character for character, _ in sheets[number])
        masters = choose_masters(text, (str(folder),), script="regular")
        waiting = [path for _, path in sheets[number]]
        for page in plan_sheet(number, text, masters):
            places = [(cell.row, cell.column) for cell in page.cells if cell.is_for_writing]
            chosen = {place: waiting.pop(0) for place in places}
            read_one(number, page, masters, chosen, figures=figures, rng=rng, asked=asked)


def read_one(
    number: int,
    page: SheetPage,
    masters: SheetMasters,
    chosen: Copies,
    *,
    figures: Figures,
    rng: np.random.Generator,
    asked: argparse.Namespace,
) -> None:
    """Print, write, photograph and read one page."""
    flat, written = print_and_write(page, masters, chosen)
    conditions = draw_conditions(rng)
    turn = float(rng.choice([0, 90, 180, 270])) + conditions.turn
    conditions = replace(conditions, turn=turn, gamma=asked.gamma)
    if asked.bend is not None:
        conditions = replace(conditions, bend=asked.bend)
    photograph = take_photograph(flat, conditions, seed=number)
    figures.photographs += 1
    figures.cells += len(written)
    started = time.perf_counter()
    try:
        sheet = locate_sheet(photograph.picture)
        found = read_cells(sheet, masters.shapes)
    except RefusedImage as error:
        figures.refused[error.reason] += 1
        print(number, error.reason, page.grid, page.help, conditions, flush=True)
        return
    figures.seconds.append(time.perf_counter() - started)
    corners = np.concatenate([cell.box.corners for cell in page.cells])
    true = photograph.points(corners * (np.array(flat.shape[1::-1]) / page.size) - 0.5)
    off = np.hypot(*(sheet.places.pixels(corners) - true).T)
    if conditions.megapixels == 12:
        figures.corners.extend(off.tolist())
    places = {(one.cell.row, one.cell.column) for one in found}
    right = places & set(written) if sheet.page == page else set()
    figures.right += len(right)
    figures.wrong += len(places - right)
    if off.max() > 2 or places != set(written):
        print(
            number,
            f"{off.max():.1f} px",
            sorted(places ^ set(written)),
            page.grid,
            page.help,
            conditions,
            flush=True,
        )
    for k, one in enumerate(found):
        if (one.cell.row, one.cell.column) in right:
            copy = written[one.cell.row, one.cell.column]
            off = _compare(one, copy, page.master if k < asked.marks else None, figures)
            if asked.save and off > 3:
                size = (len(copy), len(copy))
                pair = np.hstack([cv2.resize(one.picture, size, interpolation=cv2.INTER_CUBIC), copy])
                asked.save.mkdir(parents=True, exist_ok=True)
                cv2.imwrite(str(asked.save / f"{number}-{page.number}-{k}.png"), pair)


def _compare(one: WrittenCell, copy: np.ndarray, masters: str | None, figures: Figures) -> float:
    """Ink and, with masters, mark of a photographed cell against its copy; by how much the mark is off."""
    side, character = len(copy), one.cell.character
    surface = surface_of_cell(one.picture)
    if isinstance(surface, np.ndarray):
        print(f"{character} {len(one.picture)} px: nothing written is seen", flush=True)
        figures.overlaps.append(0.0)
        if masters is not None:
            figures.off.append(100.0)
        return 100.0
    ink = cv2.resize(surface.mask.astype(np.float32), (side, side)) > 0.5
    true = find_ink(copy).mask
    figures.overlaps.append(float(np.count_nonzero(ink & true) / np.count_nonzero(ink | true)))
    if masters is not None:
        prepared, _ = prepared_master(masters, character)
        both = [pipeline.assess(each, prepared, framed=True, remarks=False).score for each in (surface, copy)]
        if None not in both:
            figures.off.append(abs(both[0] - both[1]))
            if figures.off[-1] > 3:
                pixels = len(one.picture)
                print(f"{character} {pixels} px: {both[0]:.1f}, unphotographed {both[1]:.1f}", flush=True)
            return figures.off[-1]
        if both[0] != both[1]:
            figures.off.append(100.0)
            return 100.0
    return 0.0


def main() -> None:
    """Read many sheets and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--marks", type=int, default=4, help="cells of each sheet that are marked")
    parser.add_argument("--save", type=Path, help="folder for pictures of cells whose marks differ")
    parser.add_argument("--gamma", type=float, help="of the camera's tone curve; that of sRGB unless given")
    parser.add_argument("--bend", type=float, help="height of the wave of every sheet, in its widths")
    parser.add_argument("--every-copy", action="store_true")
    parser.add_argument("--seed", type=int, default=1, help="of the sheets of every copy")
    parser.add_argument("--time", action="store_true")
    asked = parser.parse_args()
    copies, templates = read_copies()
    with tempfile.TemporaryDirectory(prefix="rumu-") as home:
        os.environ["RUMU_HOME"] = home
        folder = Path(home) / "templates"
        folder.mkdir()
        for character, template in templates.items():
            (folder / f"{character}.png").write_bytes(template.read_bytes())
        if asked.time:
            measure_time(copies, folder, Path(home))
            return
        figures = Figures()
        if asked.every_copy:
            read_every_copy(figures, copies, folder, asked)
        else:
            for number in range(asked.first, asked.first + asked.count):
                read_drawn(number, figures, copies, folder, asked)
    corners, overlaps, off = (
        np.array(v or [np.nan]) for v in (figures.corners, figures.overlaps, figures.off)
    )
    print(f"{figures.photographs} photographs, refused {dict(figures.refused)}")
    print(f"cells found and right {figures.right} of {figures.cells}, wrong {figures.wrong}")
    print(f"corners at 12 MP: median {np.median(corners):.2f} px, 99 % {np.quantile(corners, 0.99):.2f}")
    print(f"overlap of ink: median {np.median(overlaps):.3f}, 5 % {np.quantile(overlaps, 0.05):.3f}")
    if figures.off:
        print(
            f"marks: median difference {np.median(off):.2f}, within 3 points {np.mean(off <= 3):.3f} "
            f"of {len(off)}, largest {off.max():.1f}"
        )
    print(f"finding and cutting: median {np.median(figures.seconds):.2f} s")


def measure_time(copies: dict[str, list[Path]], folder: Path, home: Path) -> None:
    """Seconds from a photograph of 12 megapixels and 24 cells to its marks, of few and of many characters."""
    from rumu.studio.sheet_marks import mark_sheets

    for count in (4, 24):
        rng = np.random.default_rng(1)
        text = "".join(rng.choice(sorted(copies), count, replace=False))
        masters = choose_masters(text, (str(folder),), script="regular")
        (page,) = lay_out(SheetPage(text, masters.name, times=CELLS // count, strokes=False))
        flat, _ = print_and_write(page, masters, draw_copies(page, copies, rng, blank=0.0))
        photograph = take_photograph(flat, Conditions(tilt=20, towards=40, blur=1, noise=3), seed=1)
        Image.fromarray(photograph.picture).save(home / "photo.jpg", quality=92)
        started, used = time.perf_counter(), os.times()
        (facts,) = mark_sheets([home / "photo.jpg"], home / f"out{count}")
        busy = sum(os.times()[:4]) - sum(used[:4])
        seconds = time.perf_counter() - started
        print(
            f"{len(facts['cells'])} cells of {count} characters: {seconds:.2f} s, {busy:.2f} s of processors "
            "(two new processes and their libraries among them)"
        )
    measure_parts(home / "photo.jpg")


def measure_parts(path: Path) -> None:
    """Processor seconds of the parts of a photograph's way to its marks; run with OMP_NUM_THREADS=1."""
    from rumu.gallery.sheet_masters import open_masters
    from rumu.studio.sheet_inputs import SheetPhoto, read_photo
    from rumu.studio.sheet_marks import CellTask, assess_cell, prepared_master

    cv2.setNumThreads(1)
    used = [time.process_time()]
    picture = read_photo(SheetPhoto(path.name, path))
    used.append(time.process_time())
    sheet = locate_sheet(picture)
    cells = read_cells(sheet, open_masters(sheet.page.master, sheet.page.text).shapes)
    used.append(time.process_time())
    tasks = [CellTask(one.picture, sheet.page.master, one.cell.character, {}) for one in cells]
    assess_cell(tasks[0])  # loads the libraries
    prepared_master.cache_clear()
    marking = []
    for _ in range(2):
        started = time.process_time()
        for task in tasks:
            assess_cell(task)
        marking.append(time.process_time() - started)
    reading = used[2] - used[0]
    print(
        f"processor time in one thread: decoding {used[1] - used[0]:.2f} s, finding and cutting "
        f"{used[2] - used[1]:.2f} s; {len(tasks)} cells {marking[0]:.2f} s where each is the first of its "
        f"character, {marking[1]:.2f} s where none is; in two processes that run already "
        f"{reading + marking[0] / 2:.2f} and {reading + marking[1] / 2:.2f} s from photograph to marks"
    )


if __name__ == "__main__":
    main()
