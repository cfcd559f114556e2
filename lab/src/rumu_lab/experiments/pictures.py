"""Figures 4, 5 and 6 as picture files: a work as surface, texture and mesh; the five scripts; four levels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rumu.errors import OutputError
from rumu.values import Bilingual, Surface
from rumu_lab.experiments.figures import sheet
from rumu_lab.experiments.findings import Findings
from rumu_lab.experiments.levels import DEGREES, level_number
from rumu_lab.experiments.marked_copies import TABLES, Copy, read_copies
from rumu_lab.experiments.run_settings import RunSettings
from rumu_lab.experiments.simulated_copies import AtDegree

LANTING = "masters/running-lantingxu"
_CHARACTER = "天"  # in all five scripts, and open enough to be read small


class CaptionedFile(NamedTuple):
    """A figure's file with its caption."""

    file: str
    caption: Bilingual


class Example(NamedTuple):
    """A copy of Figure 6: its level and mark, whose mark it is, and its picture."""

    level: str
    mark: float
    copy: Any


def run(settings: RunSettings) -> Findings:
    """Write the three figures under OUT/figures. Raises OutputError when there is no OUT."""
    if settings.out is None:
        raise OutputError("the pictures need a folder to be written to: -o OUT")
    folder = settings.out / "figures"
    steps = (_figure_4, _figure_5, _figure_6)
    shown = []
    for number, step in enumerate(steps, start=1):
        shown.append(step(folder, settings))
        settings.progress(number, len(steps))
    facts = {"figures": [{"file": s.file, "zh": s.caption.zh, "en": s.caption.en} for s in shown]}
    words = "\n".join(f"{settings.out / s.file}: {s.caption.en}" for s in shown)
    return Findings("pictures", facts, words=words)


def _figure_4(folder: Path, settings: RunSettings) -> CaptionedFile:
    """A photograph of ink on old paper where there is one, else a starter work."""
    from rumu import pipeline

    path, zh, en = _photograph(settings)
    tiles = _views(pipeline.surface_of(path))
    sheet([tiles], folder / "figure-4.png", above=("picture", "surface", "texture, lit", "mesh"))
    return CaptionedFile(
        "figures/figure-4.png",
        Bilingual(
            f"圖四：{zh}：原圖、曲面、帶紋理的曲面、網格。高度由墨跡算出，不是實測。",
            f"Figure 4: {en}: picture, surface, textured surface, mesh. The height is computed from the "
            "ink, not measured.",
        ),
    )


def _photograph(settings: RunSettings) -> tuple[Path, str, str]:
    from rumu.gallery.starter import find_work

    photos = sorted((settings.data / LANTING).glob("shenlong/*永*.jpg"))
    if photos:
        return (
            photos[0],
            "蘭亭序（神龍本）的「永」",
            "a character of the Lanting Xu (Shenlong copy, a photograph)",
        )
    return find_work("running-shui").path, "行書「水」（館藏起始作品）", "a starter work in running script"


def _figure_5(folder: Path, settings: RunSettings) -> CaptionedFile:
    from rumu import pipeline
    from rumu.gallery.starter import starter_works

    works = starter_works(character=_CHARACTER)
    tiles = [_views(pipeline.surface_of(work.path)) for work in works]
    columns = [[row[k] for row in tiles] for k in (0, 1, 3)]  # ink that is black has no texture to show
    sheet(
        columns,
        folder / "figure-5.png",
        above=tuple(work.script for work in works),
        beside=("picture", "surface", "mesh"),
    )
    return CaptionedFile(
        "figures/figure-5.png",
        Bilingual(
            "圖五：五體的「天」：原圖、曲面、網格。", "Figure 5: one work of each of the five scripts."
        ),
    )


def _figure_6(folder: Path, settings: RunSettings) -> CaptionedFile:
    """Copies that people marked where they are there, else simulated ones, and says which."""
    from rumu import pipeline
    from rumu.gallery.starter import find_work

    copies = read_copies(settings.data) if all((settings.data / t).is_file() for t in TABLES) else []
    chosen = four_levels(copies, settings.protocol.cut_offs)
    if chosen:
        template, examples = chosen
        about = Bilingual("真人臨作，分數為評委平均分", "copies by learners, with the mark of the panel")
        labels = [f"{e.level}, panel {e.mark:.0f}" for e in examples]
    else:
        work = find_work("regular-tian")
        template, examples = (
            work.path,
            [Example(d, float("nan"), AtDegree(work.path, d, 11).picture()) for d in reversed(DEGREES)],
        )
        about = Bilingual("模擬臨作，並非真人書寫，也無評分", "simulated copies: nobody wrote or marked them")
        labels = [f"made as {e.level}" for e in examples]
    rows = [_views(pipeline.surface_of(thing)) for thing in (template, *(e.copy for e in examples))]
    columns = [[row[k] for row in rows] for k in (0, 1, 3)]
    beside = ("picture", "surface", "mesh")
    sheet(columns, folder / "figure-6.png", above=("master", *labels), beside=beside)
    return CaptionedFile(
        "figures/figure-6.png",
        Bilingual(
            f"圖六：範字與優、良、中、差四級的臨作（{about.zh}）。",
            f"Figure 6: a master with copies that are excellent, good, medium and bad ({about.en}).",
        ),
    )


def four_levels(copies: Sequence[Copy], cuts: Mapping[str, float]) -> tuple[Path, list[Example]] | None:
    """The character with most copies that has all four levels; of each level the copy of the middle mark."""
    by_character: dict[str, list[Copy]] = {}
    for copy in copies:
        by_character.setdefault(copy.character, []).append(copy)
    for found in sorted(by_character.values(), key=len, reverse=True):
        of_level = {
            d: sorted((c for c in found if DEGREES[level_number(c.mark, cuts)] == d), key=lambda c: c.mark)
            for d in reversed(DEGREES)
        }
        if all(of_level.values()):
            middles = {d: own[len(own) // 2] for d, own in of_level.items()}
            return found[0].template, [Example(d, c.mark, c.image) for d, c in middles.items()]
    return None


def _views(surface: Surface) -> list[np.ndarray]:
    """Picture, surface, texture and mesh of one surface."""
    from rumu.report.mesh_picture import MeshView, mesh_picture
    from rumu.report.pictures import albedo_picture, shaded_picture, srgb
    from rumu.surface.relight import relight

    lit = relight(surface, tilt=135.0, slant=40.0)
    bright = max(float(np.percentile(lit, 99)), 1e-6)
    return [
        albedo_picture(surface),
        shaded_picture(surface, tilt=135.0),
        srgb(np.asarray(lit / bright, dtype=np.float32)),
        mesh_picture(surface, view=MeshView(width=520))[0],
    ]
