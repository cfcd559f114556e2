#!/usr/bin/env python3
"""Renders the starter gallery, once, from fonts that may be shared: src/rumu/gallery/starter/.

    .venv/bin/python scripts/make_starter.py [--fonts FOLDER]

FOLDER (default: fonts/ in RUMU_DATA, or ../shared/data/fonts) holds LXGWSeal-Regular.ttf and
TW-MOE-Li_eduli.woff2; the regular, running and cursive hands come from Debian's fonts-kouzan-mouhitsu.
A font that lacks a character fails the script: nothing is written, and no substitute becomes a work.
"""

from __future__ import annotations

import argparse
import functools
import hashlib
import io
import json
import logging
import os
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from fontTools.pens.recordingPen import DecomposingRecordingPen
from fontTools.ttLib import TTFont
from PIL import Image, ImageDraw, ImageFont

from rumu.errors import GalleryError
from rumu.gallery.works import Bilingual
from rumu.outputs import whole_folder
from rumu.simulation.copies import DEGREES, copy_at

ROOT = Path(__file__).resolve().parents[1]
STARTER = ROOT / "src" / "rumu" / "gallery" / "starter"
DATA = Path(os.environ.get("RUMU_DATA", ROOT / ".." / "shared" / "data"))
KOUZAN = Path("/usr/share/fonts/truetype/kouzan-mouhitsu")

SIDE = 512  # pixels of a work's picture
SHARE = 0.76  # of the side that the longer side of the ink's box fills
AREA = 0.42  # of the picture that the box may cover: a full-sized 日 would shout down its neighbours
OVERSAMPLING = 4

CHARACTERS = {
    "天": ("tian", "heaven"),
    "人": ("ren", "person"),
    "水": ("shui", "water"),
    "書": ("shu", "to write, writing"),
    "日": ("ri", "sun"),
    "月": ("yue", "moon"),
}
# Characters that no small font holds, beside one of the private area: what a font draws for them is its
# substitute, whatever its table of characters claims.
SURELY_MISSING = "龘䶮𠀀𰻞\ue0ff\U0010fffd"

# The copies are made of hands in the public domain alone: a faulty glyph is a changed one, and the
# clerical hand may not be changed (CC BY-ND).
SAMPLED = ("regular-shui", "regular-tian")
SAMPLE_SEEDS = {"regular-shui": 11, "regular-tian": 5}
SAMPLE_NOTE = Bilingual(
    zh="這是程式模擬的臨本：由範字按已知的毛病改成，並非真人所寫，也沒有人評過分。",
    en="A simulated copy: made by a program from the master with known faults. "
    "Nobody wrote it and nobody marked it.",
)


@dataclass(frozen=True)
class Hand:
    """A font that stands for a script, and all that is known about it from its own files."""

    script: str
    script_zh: str
    font: str
    hand: Bilingual
    period: Bilingual
    source: str
    licence: str
    attribution: str


_KOUZAN = Bilingual(zh="青柳衡山", en="Aoyagi Kouzan (青柳衡山)")
_KOUZAN_CREDIT = "青柳衡山 (Kouzan Aoyagi); copyright waived by the author"


def _kouzan(*, script: str, script_zh: str, font: str, name: str, version: str, page: str) -> Hand:
    return Hand(
        script=script,
        script_zh=script_zh,
        font=str(KOUZAN / font),
        hand=_KOUZAN,
        period=Bilingual(
            zh=f"當代（字型版本 {version}；Debian 套件 2017 年版）",
            en=f"contemporary (font version {version}; Debian's package of 2017)",
        ),
        source=f"{name}, {font} of Debian's fonts-kouzan-mouhitsu 20170411-3, {page}",
        licence="public domain (as declared by the author)",
        attribution=_KOUZAN_CREDIT,
    )


HANDS = (
    Hand(
        script="seal",
        script_zh="篆書",
        font="LXGWSeal-Regular.ttf",
        hand=Bilingual(zh="落霞孤鶩（霞鶩篆書）", en="LXGW (the typeface LXGW Seal)"),
        period=Bilingual(zh="當代（字型版本 0.001，2026 年）", en="contemporary (font version 0.001, 2026)"),
        source="LXGW Seal 霞鶩篆書, LXGWSeal-Regular.ttf, https://github.com/lxgw/LxgwSeal",
        licence="OFL-1.1 (the font; a picture made with it is free)",
        attribution="Copyright 2026 LXGW; 2020 The Klee Project Authors; "
        "2024 The Batang and Gungsuh Project Authors",
    ),
    Hand(
        script="clerical",
        script_zh="隸書",
        font="TW-MOE-Li_eduli.woff2",
        hand=Bilingual(
            zh="中華民國教育部（教育部隸書字形）",
            en="Ministry of Education, R.O.C. (Taiwan) (the typeface TW-MOE-Li)",
        ),
        period=Bilingual(
            zh="當代（字型版本 3.00，2019 年 6 月）", en="contemporary (font version 3.00, June 2019)"
        ),
        source="TW-MOE-Li 教育部隸書, version 3.00, TW-MOE-Li_eduli.woff2",
        licence="CC-BY-ND-3.0-TW",
        attribution="中華民國教育部 (Ministry of Education, R.O.C. (Taiwan)); shown unchanged",
    ),
    _kouzan(
        script="regular",
        script_zh="楷書",
        font="kouzan-mouhitsu.ttf",
        name="衡山毛筆フォント",
        version="1.1",
        page="https://opentype.jp/kouzanmouhitufont.htm",
    ),
    _kouzan(
        script="running",
        script_zh="行書",
        font="kouzan-mouhitsu-gyosho.ttf",
        name="衡山毛筆フォント行書",
        version="2.1",
        page="https://opentype.jp/kouzangyousho.htm",
    ),
    _kouzan(
        script="cursive",
        script_zh="草書",
        font="KouzanBrushFontSousyo.ttf",
        name="衡山毛筆フォント草書",
        version="1.2",
        page="https://opentype.jp/kouzansousho.htm",
    ),
)
MATERIAL = Bilingual(
    zh="數位字形繪成的圖像（無紙無墨，非原跡照片）",
    en="picture drawn from a digital letterform (no paper, no ink; not a photograph of an original)",
)


class Face:
    """An opened font that refuses to draw what it does not have."""

    def __init__(self, path: Path) -> None:
        if not path.is_file():
            package = " (Debian: apt install fonts-kouzan-mouhitsu)" if path.parent == KOUZAN else ""
            raise GalleryError(f"{path}: expected a font there{package}")
        self.path = path
        self._font = TTFont(path, recalcBBoxes=False)
        self._glyphs = self._font.getGlyphSet()
        self._names = self._font.getBestCmap()

    def outline(self, character: str) -> list[Any]:
        """What the font draws for a character, its substitute included."""
        pen = DecomposingRecordingPen(self._glyphs)
        self._glyphs[self._names.get(ord(character), ".notdef")].draw(pen)
        return pen.value

    def check(self, character: str) -> None:
        """Raises GalleryError unless the font holds a drawing of its own for this character."""
        refusal = f"{self.path.name}: has no {character}"
        if ord(character) not in self._names:
            raise GalleryError(f"{refusal}: it is not in its table of characters")
        own = self.outline(character)
        if not own:
            raise GalleryError(f"{refusal}: the glyph is empty")
        for other in SURELY_MISSING:
            if other != character and own == self.outline(other):
                raise GalleryError(f"{refusal}: it draws its substitute for missing characters")

    def picture(self, character: str) -> Image.Image:
        """(SIDE, SIDE) gray: black ink on white, its box centred and sized by SHARE and AREA."""
        self.check(character)
        big = SIDE * OVERSAMPLING
        draft = self._drawn(character, size=big, side=2 * big).getbbox()
        if draft is None:
            raise GalleryError(f"{self.path.name}: draws nothing for {character}")
        width, height = draft[2] - draft[0], draft[3] - draft[1]
        size = round(
            big * min(SHARE * big / max(width, height), (AREA * big * big / (width * height)) ** 0.5)
        )
        drawn = self._drawn(character, size=size, side=3 * big)
        left, top, right, bottom = drawn.getbbox()
        x, y = (left + right - big) // 2, (top + bottom - big) // 2
        ink = drawn.crop((x, y, x + big, y + big)).resize((SIDE, SIDE), Image.Resampling.BOX)
        return Image.eval(ink, lambda value: 255 - value)

    @functools.cached_property
    def _plain(self) -> bytes:
        """The font as the rasteriser reads it: a woff2 becomes a plain font, in memory."""
        if self._font.flavor is None:
            return self.path.read_bytes()
        self._font.flavor = None
        plain = io.BytesIO()
        self._font.save(plain)
        return plain.getvalue()

    def _drawn(self, character: str, *, size: int, side: int) -> Image.Image:
        image = Image.new("L", (side, side), 0)
        font = ImageFont.truetype(io.BytesIO(self._plain), size, layout_engine=ImageFont.Layout.BASIC)
        ImageDraw.Draw(image).text((side // 2, side // 2), character, font=font, fill=255, anchor="mm")
        return image


def render_works(folder: Path, *, fonts: Path) -> list[dict[str, Any]]:
    """Write the picture of every work under `folder` and return their entries for works.json."""
    entries = []
    for hand in HANDS:
        face = Face(fonts / hand.font)  # an absolute font path stands for itself
        for character, (name, meaning) in CHARACTERS.items():
            entry = {
                "id": f"{hand.script}-{name}",
                "title": {
                    "zh": f"{hand.script_zh}「{character}」",
                    "en": f"{character} {name} ({meaning}), {hand.script} script",
                },
                "character": character,
                "script": hand.script,
                "hand": asdict(hand.hand),
                "period": asdict(hand.period),
                "material": asdict(MATERIAL),
                "source": hand.source,
                "licence": hand.licence,
                "attribution": hand.attribution,
            }
            entries.append(entry | _saved(face.picture(character), folder, f"works/{entry['id']}.png"))
    return entries


def simulate_samples(folder: Path, works: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Write four copies of each sampled work, best first, and return their entries for samples.json."""
    entries = []
    for work in (w for w in works if w["id"] in SAMPLED):
        # Made at twice the size, so that the edges of the small picture come out soft.
        master = Image.open(folder / work["file"]).resize((2 * SIDE, 2 * SIDE), Image.Resampling.BICUBIC)
        for degree in DEGREES:
            copy = copy_at(np.asarray(master) < 128, degree, seed=SAMPLE_SEEDS[work["id"]])
            gray = Image.fromarray((255 * (1 - copy.ink)).round().astype(np.uint8))
            entry = {
                "id": f"{work['id']}-{degree}",
                "work": work["id"],
                "degree": degree,
                "simulated": True,
                "note": asdict(SAMPLE_NOTE),
                "licence": work["licence"],
                "attribution": f"changed by rumu from a work of {work['attribution']}",
                "faults": [
                    {
                        "fault": fault.fault,
                        "severity": fault.severity,
                        "size": round(fault.size, 2),
                        "unit": fault.unit,
                        "region": [round(side, 3) for side in fault.region],
                        "description": {"zh": fault.description_zh, "en": fault.description},
                    }
                    for fault in copy.faults
                ],
            }
            small = gray.resize((SIDE, SIDE), Image.Resampling.BOX)
            entries.append(entry | _saved(small, folder, f"samples/{entry['id']}.png"))
    return entries


def _saved(image: Image.Image, folder: Path, name: str) -> dict[str, str]:
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    image.save(path, optimize=True)
    return {"file": name, "sha256": hashlib.sha256(path.read_bytes()).hexdigest()}


def main(arguments: list[str] | None = None) -> int:
    """Render everything, or say in one line what is missing and write nothing."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fonts", type=Path, default=DATA / "fonts")
    parser.add_argument("--output", type=Path, default=STARTER)
    options = parser.parse_args(arguments)
    logging.getLogger("fontTools").setLevel(logging.ERROR)  # old fonts have odd dates; they do no harm
    try:
        with whole_folder(options.output, marker="works.json") as folder:
            works = render_works(folder, fonts=options.fonts)
            samples = simulate_samples(folder, works)
            for name, entries in (("works.json", works), ("samples.json", samples)):
                text = json.dumps(entries, ensure_ascii=False, indent=1)
                (folder / name).write_text(text + "\n", encoding="utf-8")
    except GalleryError as error:
        print(f"make_starter: {error}", file=sys.stderr)
        return 1
    print(f"{len(works)} works and {len(samples)} samples in {options.output}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
