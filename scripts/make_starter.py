#!/usr/bin/env python3
"""Render the starter gallery from fonts that may be redistributed: src/rumu/gallery/starter/.

    .venv/bin/python scripts/make_starter.py [--fonts FOLDER]
    .venv/bin/python scripts/make_starter.py --brush --fonts FOLDER

FOLDER (default: fonts/ in RUMU_DATA, or ../shared/data/fonts) holds LXGWSeal-Regular.ttf and
TW-MOE-Li_eduli.woff2; the regular, running and cursive hands come from Debian's fonts-kouzan-mouhitsu.
With --brush the works by brush hands are rendered, src/rumu/gallery/starter_brush/, and FOLDER holds the
fonts NAME-chinese-simplified-400-normal.woff2 of the npm packages @fontsource/NAME for ma-shan-zheng,
long-cang, zhi-mang-xing and liu-jian-mao-cao.
If a font lacks a character the script fails and writes nothing; no substitute glyph becomes a work.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from rumu.errors import GalleryError
from rumu.gallery.fonts import SIDE
from rumu.gallery.fonts import Face as Drawn
from rumu.outputs import whole_folder
from rumu.values import Bilingual
from rumu_lab.simulation.copies import DEGREES, copy_at

ROOT = Path(__file__).resolve().parents[1]
STARTER = ROOT / "src" / "rumu" / "gallery" / "starter"
BRUSH = ROOT / "src" / "rumu" / "gallery" / "starter_brush"
DATA = Path(os.environ.get("RUMU_DATA", ROOT / ".." / "shared" / "data"))
KOUZAN = Path("/usr/share/fonts/truetype/kouzan-mouhitsu")


CHARACTERS = {
    "天": ("tian", "heaven"),
    "人": ("ren", "person"),
    "水": ("shui", "water"),
    "書": ("shu", "to write, writing"),
    "日": ("ri", "sun"),
    "月": ("yue", "moon"),
}
BRUSH_CHARACTERS = {"永": ("yong", "forever"), "之": ("zhi", "of, this")}
# Copies are simulated only of hands in the public domain: a glyph with faults is a derivative, which the
# licence of the clerical hand (CC BY-ND) does not allow.
SAMPLED = ("regular-shui", "regular-tian")
SAMPLE_SEEDS = {"regular-shui": 11, "regular-tian": 5}
SAMPLE_NOTE = Bilingual(
    zh="這是程式模擬的臨本：由範字按已知的毛病改成，並非真人所寫，也沒有人評過分。",
    en="A simulated copy: made by a program from the master with known faults. "
    "Nobody wrote it and nobody marked it.",
)


@dataclass(frozen=True)
class Hand:
    """A font for a script, with what its own files say about it. name: how ids of its works begin."""

    name: str
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
        name=script,
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
        name="seal",
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
        name="clerical",
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


def _brush(
    *, name: str, script: str, script_zh: str, hand: Bilingual, version: str, credit: str, page: str
) -> Hand:
    font = f"{name}-chinese-simplified-400-normal.woff2"
    return Hand(
        name=name,
        script=script,
        script_zh=script_zh,
        font=font,
        hand=hand,
        period=Bilingual(zh=f"當代（字型版本 {version}）", en=f"contemporary (font version {version})"),
        source=f"{font} of the npm package @fontsource/{name}, {page}",
        licence="OFL-1.1 (the font; a picture made with it is free)",
        attribution=f"Copyright 2018 {credit}",
    )


BRUSH_HANDS = (
    _brush(
        name="ma-shan-zheng",
        script="regular",
        script_zh="楷書",
        hand=Bilingual(zh="馬善政楷書（字型）", en="Ma Shan Zheng (the typeface)"),
        version="2.003",
        credit="The MaShanZheng Project Authors",
        page="https://github.com/googlefonts/mashanzheng",
    ),
    _brush(
        name="long-cang",
        script="running",
        script_zh="行書",
        hand=Bilingual(zh="龍藏體（字型）", en="Long Cang (the typeface)"),
        version="2.001",
        credit="The LongCang Project Authors",
        page="https://github.com/googlefonts/longcang",
    ),
    _brush(
        name="zhi-mang-xing",
        script="running",
        script_zh="行書",
        hand=Bilingual(zh="鍾齊志莽行書（字型）", en="Zhi Mang Xing (the typeface)"),
        version="2.001",
        credit="The ZhiMangXing Project Authors",
        page="https://github.com/googlefonts/zhimangxing",
    ),
    _brush(
        name="liu-jian-mao-cao",
        script="cursive",
        script_zh="草書",
        hand=Bilingual(zh="鍾齊流江毛草（字型）", en="Liu Jian Mao Cao (the typeface)"),
        version="1.003",
        credit="The Liu Jian Mao Cao Project Authors",
        page="https://github.com/googlefonts/liujianmaocao",
    ),
)
MATERIAL = Bilingual(
    zh="數位字形繪成的圖像（無紙無墨，非原跡照片）",
    en="picture drawn from a digital letterform (no paper, no ink; not a photograph of an original)",
)


class Face(Drawn):
    """A font of the starter gallery; the error for a missing one names its Debian package."""

    def __init__(self, path: Path) -> None:
        package = " (Debian: apt install fonts-kouzan-mouhitsu)" if path.parent == KOUZAN else ""
        super().__init__(path, hint=package)


def render_works(
    folder: Path, hands: tuple[Hand, ...], characters: dict[str, tuple[str, str]], *, fonts: Path
) -> list[dict[str, Any]]:
    """Write the picture of every work under `folder` and return their entries for works.json."""
    entries = []
    for hand in hands:
        face = Face(fonts / hand.font)  # an absolute font path stands for itself
        for character, (name, meaning) in characters.items():
            entry = {
                "id": f"{hand.name}-{name}",
                "title": {
                    "zh": f"{hand.script_zh}「{character}」",
                    "en": f"{character} {name} ({meaning}), {hand.script} script",
                },
                "character": character,
                "script": hand.script,
                "hand": hand.hand._asdict(),
                "period": hand.period._asdict(),
                "material": MATERIAL._asdict(),
                "source": hand.source,
                "licence": hand.licence,
                "attribution": hand.attribution,
            }
            entries.append(entry | _save(face.picture(character), folder, f"works/{entry['id']}.png"))
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
                "note": SAMPLE_NOTE._asdict(),
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
            entries.append(entry | _save(small, folder, f"samples/{entry['id']}.png"))
    return entries


def _save(image: Image.Image, folder: Path, name: str) -> dict[str, str]:
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    image.save(path, optimize=True)
    return {"file": name, "sha256": hashlib.sha256(path.read_bytes()).hexdigest()}


def main(arguments: list[str] | None = None) -> int:
    """Render everything, or say in one line what is missing and write nothing."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fonts", type=Path, default=DATA / "fonts")
    parser.add_argument("--brush", action="store_true", help="the works by brush hands instead")
    parser.add_argument("--output", type=Path, help="instead of the folder in the package")
    options = parser.parse_args(arguments)
    try:
        with whole_folder(
            options.output or (BRUSH if options.brush else STARTER), marker="works.json"
        ) as folder:
            if options.brush:
                works = render_works(folder, BRUSH_HANDS, BRUSH_CHARACTERS, fonts=options.fonts)
                lists = {"works.json": works}
            else:
                works = render_works(folder, HANDS, CHARACTERS, fonts=options.fonts)
                lists = {"works.json": works, "samples.json": simulate_samples(folder, works)}
            for name, entries in lists.items():
                text = json.dumps(entries, ensure_ascii=False, indent=1)
                (folder / name).write_text(text + "\n", encoding="utf-8")
    except GalleryError as error:
        print(f"make_starter: {error}", file=sys.stderr)
        return 1
    print(", ".join(f"{len(entries)} entries in {name}" for name, entries in lists.items()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
