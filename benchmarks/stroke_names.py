"""Whether the strokes of masters get their right numbers and names: `python benchmarks/stroke_names.py`.

Canonical strokes are laid on the 25 masters of the E3C copies and on 25 characters of each of four steles,
evenly spread over the list. Somebody looked at each picture that `--draw FOLDER` makes, every stroke in a
colour of its own with its number, and wrote down where each stroke truly lies: stroke_places.json holds
what was seen, places in fractions of the picture, null where there is no such stroke or none can be made
out. A stroke is told rightly when it is laid where it was seen and has the name that it should have, see
NAMES. A master whose strokes are not named at all, since it is written otherwise than copybooks print it,
and a stroke that is never spoken of, since too little of it was found, are counted apart. `--write` takes
today's places of the masters that the file does not hold yet, to be looked at and mended; `--list` names
each wrong one.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

import cv2
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from rumu.assessment.thresholds import RemarkThresholds
from rumu.executors import cores
from rumu.outputs import whole_file
from rumu.pipeline import prepare_master
from rumu.values import FloatArray
from rumu_lab.experiments.marked_copies import read_copies

DATA = Path(os.environ.get("RUMU_DATA", Path(__file__).parents[2] / "shared" / "data"))
SEEN = Path(__file__).with_name("stroke_places.json")
STELES = ("zhiyong-qianziwen", "ouyang-jiuchenggong", "yan-duobaota", "zhao-sanmenji")
OF_EACH = 25
NAMES = {"德": {5: "豎"}, "質": {4: "豎"}, "寧": {11: "豎"}, "讀": {13: "豎"}}
"""Strokes, by their number, whose name was found wrong, and what they are called."""
POINTS = 5
"""Places that are kept of a stroke, evenly spread along it."""
NEAR = 0.06
"""Mean distance, fractions of the picture, up to which a stroke is laid where it was seen."""
SIDE, ACROSS = 320, 5
COLOURS = (
    (214, 39, 40), (31, 119, 180), (44, 160, 44), (255, 127, 14), (148, 103, 189), (140, 86, 75),
    (227, 119, 194), (0, 150, 160), (160, 160, 0), (80, 80, 80),
)  # fmt: skip

Places = list[list[float]]


@dataclass(frozen=True, slots=True)
class Named:
    """One master. key: its file under DATA. strokes: by number, POINTS places each; empty when not named.

    silent: numbers of the strokes that are never spoken of.
    """

    key: str
    character: str
    names: tuple[str, ...]
    strokes: dict[str, Places]
    silent: tuple[int, ...] = ()

    @property
    def spoken_of(self) -> list[int]:
        """Numbers of the others."""
        return [number for number in map(int, self.strokes) if number not in self.silent]


def masters() -> list[tuple[str, str]]:
    """(file under DATA, character) of every master that is asked."""
    templates = {copy.template.relative_to(DATA).as_posix(): copy.character for copy in read_copies(DATA)}
    folder = DATA / "masters" / "regular"
    with (folder / "labels.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    chosen = sorted(templates.items())
    for stele in STELES:
        own = [row for row in rows if row["file"].startswith(stele)]
        spread = np.linspace(0, len(own) - 1, OF_EACH).astype(int)
        chosen += [(f"masters/regular/{own[k]['file']}", own[k]["character"]) for k in spread]
    return chosen


def lay(master: tuple[str, str]) -> Named:
    """Where the strokes of one master are laid."""
    cv2.setNumThreads(1)
    key, character = master
    model = prepare_master(DATA / key, character=character).stroke_model
    if model.laid is None:
        return Named(key, character, (), {})
    strokes = {}
    for number in range(1, len(model.laid.character.strokes) + 1):
        legs = [line.points for line in model.laid.lines.lines if line.number == number]
        strokes[str(number)] = spread(model.framed.on_picture(np.concatenate(legs)))
    names = tuple(s.name.zh for s in model.laid.character.strokes)
    dim = np.flatnonzero(model.laid.confidence <= RemarkThresholds().confident) + 1
    return Named(key, character, names, strokes, tuple(dim.tolist()))


def spread(path: FloatArray) -> Places:
    """POINTS places evenly along a path, (n, 2)."""
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    at = np.linspace(0.0, arc[-1], POINTS)
    return np.column_stack([np.interp(at, arc, path[:, k]) for k in (0, 1)]).round(3).tolist()


def wrong_strokes(named: Named, seen: dict[str, Places | None]) -> list[int]:
    """Numbers of the strokes that are laid elsewhere than they were seen, or called by another name."""
    wrong = []
    for number in named.spoken_of:
        true, name = seen.get(str(number)), named.names[number - 1]
        places = np.array(named.strokes[str(number)])
        apart = np.inf if true is None else np.hypot(*(places - np.array(true)).T).mean()
        if apart > NEAR or name != NAMES.get(named.character, {}).get(number, name):
            wrong.append(number)
    return wrong


def draw(every: list[Named], folder: Path) -> None:
    """Sheets of pictures, a stroke in a colour, its number where it begins."""
    folder.mkdir(parents=True, exist_ok=True)
    font = ImageFont.truetype("DejaVuSans-Bold.ttf", 15)
    for start in range(0, len(every), 2 * ACROSS):
        sheet = Image.new("RGB", (ACROSS * SIDE, 2 * (SIDE + 20)), "white")
        pen = ImageDraw.Draw(sheet)
        for k, named in enumerate(every[start : start + 2 * ACROSS]):
            x, y = (k % ACROSS) * SIDE, (k // ACROSS) * (SIDE + 20)
            ink = np.asarray(Image.open(DATA / named.key).convert("L").resize((SIDE, SIDE)))
            sheet.paste(Image.fromarray(np.uint8(190 + ink.astype(float) * 65 / 255)), (x, y))
            pen.text((x + 4, y + SIDE), f"{start + k}  {Path(named.key).stem}", fill="black", font=font)
            for number, places in named.strokes.items():
                at = [(x + SIDE * u, y + SIDE * v) for u, v in places]
                colour = COLOURS[int(number) % len(COLOURS)]
                pen.line(at, fill=colour, width=3)
                pen.text((at[0][0] - 6, at[0][1] - 9), number, fill=colour, font=font)
            pen.rectangle((x, y, x + SIDE - 1, y + SIDE + 19), outline="black")
        sheet.save(folder / f"strokes_{start // (2 * ACROSS):02d}.png")


def main() -> None:
    """Lay, compare, print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--draw", type=Path, help="folder for the pictures")
    parser.add_argument("--write", action="store_true", help="add masters that were not looked at yet")
    parser.add_argument("--list", action="store_true", help="each stroke that is wrong")
    options = parser.parse_args()
    with ProcessPoolExecutor(cores(), mp_context=get_context("spawn")) as pool:
        every = list(pool.map(lay, masters(), chunksize=5))
    if options.draw:
        draw(every, options.draw)
    seen = json.loads(SEEN.read_text("utf-8")) if SEEN.exists() else {}
    if options.write:
        seen = {named.key: named.strokes for named in every if named.strokes} | seen
        with whole_file(SEEN) as part:
            rows = ",\n".join(f"{json.dumps(key)}: {json.dumps(value)}" for key, value in seen.items())
            part.write_text("{\n" + rows + "\n}\n", "utf-8")
    for name, first, last in (("E3C templates", 0, len(every) - len(STELES) * OF_EACH), *(
        (stele, len(every) - (len(STELES) - k) * OF_EACH, len(every) - (len(STELES) - k - 1) * OF_EACH)
        for k, stele in enumerate(STELES)
    )):  # fmt: skip
        some = [named for named in every[first:last] if named.strokes]
        report(name, last - first, some, seen)
    report("all", len(every), [named for named in every if named.strokes], seen)
    if options.list:
        for named in every:
            for number in wrong_strokes(named, seen.get(named.key, {})):
                print(named.character, named.key, f"stroke {number}", named.names[number - 1])
        print("not named: " + " ".join(named.character for named in every if not named.strokes))


def report(name: str, count: int, named: list[Named], seen: dict[str, dict[str, Places | None]]) -> None:
    """One line of figures."""
    strokes = sum(len(one.spoken_of) for one in named)
    wrong = sum(len(wrong_strokes(one, seen.get(one.key, {}))) for one in named)
    print(
        f"{name:20s} {len(named)} of {count} masters named; "
        f"{strokes - wrong} of {strokes} strokes right ({(strokes - wrong) / max(strokes, 1):.1%}), "
        f"{sum(len(one.silent) for one in named)} not spoken of"
    )


if __name__ == "__main__":
    main()
