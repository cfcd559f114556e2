"""Self-contained HTML pages: nothing is fetched, every picture lies in the page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import groupby
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from rumu.pages.page import Page, PageCharacter
from rumu.report import wording
from rumu.report.mesh_picture import MeshView, mesh_picture
from rumu.report.overlay import MISSING, OverlaySettings, overlay_picture, uncovered_share
from rumu.report.pictures import (
    HEIGHT_STOPS,
    RESIDUAL_STOPS,
    Picture,
    PictureSettings,
    albedo_picture,
    css_gradient,
    data_uri,
    height_picture,
    normals_picture,
    shaded_picture,
    share_picture,
)
from rumu.report.remark_drawing import remark_rows
from rumu.surface.reduction import reduce_surface
from rumu.values import Assessment, Bilingual, Level, Registration, Surface

if TYPE_CHECKING:
    from jinja2 import Environment

    from rumu.gallery.starter import StarterWork

# Upper left, as a reader expects the light on a page.
_LAMP_TILT = 135.0

_LARGE_WRITING = MeshView(width=1000, cells=110)
_LARGE_RELIEF = MeshView(width=1000, cells=110, elevation=62.0)  # deep objects hide themselves from lower

_DRAWN = 2_000_000  # most pixels that the pictures of a surface are drawn from, several times their own
_PAGE_SIDE = 1800  # longest side, in pixels, of a page of writing as a report shows it
_UNSURE = 0.35  # certainty below which a character is marked as doubtful


class CaptionedPicture(NamedTuple):
    """One picture with its alternative text and caption."""

    uri: str
    alt: str
    caption: Bilingual


@dataclass(frozen=True, slots=True)
class IndexSample:
    """One sample of the demo: whose copy it is, how bad it was made and how, its mark, its page."""

    work: Bilingual
    degree: Level
    faults: tuple[Bilingual, ...]
    assessment: Assessment
    href: str
    copy: Surface | None


def assessment_page(
    assessment: Assessment,
    *,
    copy: Surface | None,
    master: Surface,
    title: str,
    copy_name: str,
    master_name: str,
    levels: Mapping[str, float] | None = None,
    note: Bilingual | None = None,
) -> str:
    """The mark of one copy as a page: what it is, what it rests on, and what to do next.

    levels: level -> lowest score of it, drawn on the scale; None draws none. note: a line that must not be
    overlooked, e.g. that the sample is simulated. copy may be None only when the copy was refused.
    """
    context: dict[str, Any] = {
        "title": title,
        "copy_name": copy_name,
        "master_name": master_name,
        "note": note,
        "a": assessment,
    }
    if assessment.refused is not None or copy is None or assessment.registration is None:
        en = assessment.refused or "there is nothing to compare"
        reason = Bilingual(assessment.refused_zh or "沒有可比的內容。", en)
        pictures = [_captioned(albedo_picture(master), Bilingual("範字", "Master"), "master")]
        if copy is not None:
            pictures.insert(0, _captioned(albedo_picture(copy), Bilingual("臨作", "Copy"), "copy"))
        return _render("refused.html", **context, reason=reason, pictures=pictures)
    marks = assessment.parts
    return _render(
        "assessment.html",
        **context,
        level=wording.LEVELS[assessment.level] if assessment.level else None,
        zones=level_zones(levels or {}),
        basis=wording.basis(assessment),
        parts=[(*words, marks[name]) for name, words in wording.PARTS.items() if name in marks],
        pose=_pose(assessment.registration),
        remarks=remark_rows(assessment.remarks),
        sheets=[
            ("copy", Bilingual("臨作", "Copy"), data_uri(albedo_picture(copy))),
            ("master", Bilingual("範字", "Master"), data_uri(albedo_picture(master))),
        ],
        pictures=_side_by_side(copy, master),
        overlay=_overlay(assessment.registration, master),
        # each once: copy and master mostly share theirs
        sources=[wording.SOURCES[source] for source in dict.fromkeys(assessment.source or ())],
    )


def surface_page(
    surface: Surface, *, title: str, notes: Sequence[Bilingual] = (), shown: Surface | None = None
) -> str:
    """A surface as a page: its maps, its form under four lamps, its mesh, and how far to trust it.

    shown: the surface as `reduce_surface` makes it, where it was needed before.
    """
    size = f"{surface.height.shape[1]} × {surface.height.shape[0]}"
    spacing = f"{surface.spacing:.4g} {surface.unit}"
    surface = reduce_surface(shown or surface, pixels=_DRAWN)
    heights, (low, high) = height_picture(surface)
    return _render(
        "surface.html",
        title=title,
        notes=notes,
        source=wording.SOURCES[surface.source],
        measured=surface.source == "photometric",
        size=size,
        spacing=spacing,
        maps=_maps(surface),
        heights=data_uri(heights),
        height_bar={"gradient": css_gradient(HEIGHT_STOPS), "low": low, "high": high, "unit": surface.unit},
        lit=[(f"{tilt}°", data_uri(shaded_picture(surface, tilt=tilt))) for tilt in (0, 90, 180, 270)],
        mesh=_mesh(surface, view=_LARGE_RELIEF if surface.source == "photometric" else _LARGE_WRITING),
        quality=[(wording.quality_meaning(n), n, f"{v:.4g}") for n, v in surface.quality.items()],
    )


def demo_index(
    samples: Sequence[IndexSample], works: Sequence[tuple[StarterWork, Surface]], *, title: str
) -> str:
    """The first page of the demo: the marks of the samples, and the starter works as a contact sheet."""
    small = PictureSettings(side=200)
    cards = [
        (
            sample,
            wording.LEVELS[sample.degree],
            wording.LEVELS[sample.assessment.level] if sample.assessment.level else None,
            data_uri(albedo_picture(sample.copy, settings=PictureSettings(side=320)))
            if sample.copy
            else None,
        )
        for sample in samples
    ]
    sheet = [
        (
            work,
            data_uri(albedo_picture(surface, settings=small), settings=small),
            data_uri(shaded_picture(surface, tilt=_LAMP_TILT, settings=small), settings=small),
        )
        for work, surface in works
    ]
    return _render("demo.html", title=title, cards=cards, sheet=sheet, simulated=wording.SIMULATED)


def characters_page(page: Page, *, title: str) -> str:
    """A page of writing with a box around each character that was found on it."""
    from rumu.capture.image import shrink

    height, width = page.picture.shape[:2]
    columns = [list(one) for _, one in groupby(page.characters, lambda c: (c.register, c.column))]
    named = sum(one.character is not None for one in page.characters)
    in_rows = page.direction == "horizontal"
    return _render(
        "characters.html",
        title=title,
        facts=[
            Bilingual(f"{len(columns)} 行", f"{len(columns)} {'rows' if in_rows else 'columns'}"),
            Bilingual(f"{len(page.characters)} 字", f"{len(page.characters)} characters"),
            Bilingual(f"其中 {named} 字有名", f"{named} of them named"),
        ],
        width=width,
        height=height,
        picture=data_uri(shrink(page.picture, side=_PAGE_SIDE)),
        columns=[_found_column(column, in_rows) for column in columns],
        text=page.text if named else "",
    )


def _found_column(characters: list[PageCharacter], in_rows: bool) -> dict[str, Any]:
    """What the report draws of one column: its number beside its first character, and all of its boxes."""
    left, top, right, bottom = characters[0].box
    sides = [max(one.box[2] - one.box[0], one.box[3] - one.box[1]) for one in characters]
    size = 0.45 * float(np.median(sides))
    return {
        "number": characters[0].column + 1,
        "x": f"{left - 0.6 * size if in_rows else (left + right) / 2:.0f}",
        "y": f"{bottom if in_rows else top - 0.3 * size:.0f}",
        "size": f"{size:.0f}",
        "characters": [
            {
                "points": " ".join(f"{x:.1f},{y:.1f}" for x, y in one.polygon),
                "small": one.small is not None,
                "unsure": one.certainty < _UNSURE,
                "name": one.character,
                "x": f"{one.box[2] - 0.1 * size:.0f}",
                "y": f"{one.box[1] + 0.5 * size:.0f}",
                "size": f"{0.8 * size:.0f}",
                "title": f"{one.character or '〓'} {one.row + 1} · {100 * one.certainty:.0f}%",
            }
            for one in characters
        ],
    }


def level_zones(levels: Mapping[str, float]) -> list[dict[str, Any]]:
    """The scale from 0 to 100 cut by `levels` (level -> lowest score): name, low, high, from low to high."""
    cuts = sorted((low, name) for name, low in levels.items() if name in wording.LEVELS and name != "bad")
    if not cuts:
        return []
    names: list[Level] = ["bad", *(name for _, name in cuts)]  # type: ignore[list-item]
    edges = [0.0, *(low for low, _ in cuts), 100.0]
    return [
        {"level": name, "text": wording.LEVELS[name], "low": low, "high": high}
        for name, low, high in zip(names, edges[:-1], edges[1:], strict=True)
    ]


def _pose(registration: Registration) -> list[tuple[Bilingual, str, Bilingual]]:
    """Lean, position and size of the copy as written, and in which direction they are off."""
    lean, scale = registration.angle, registration.scale
    right, up = (float(v) * 100 for v in registration.shift)
    centred = Bilingual("正", "centred")
    facts = (
        # name, value, what is shown of it; below which size it is none; the words for plus, minus and none
        (Bilingual("傾斜", "Lean"), lean, f"{abs(lean):.1f}°", 0.05,
         Bilingual("右傾", "clockwise"), Bilingual("左傾", "anticlockwise"), Bilingual("正", "upright")),
        (Bilingual("左右", "Across"), right, f"{abs(right):.0f}%", 0.5,
         Bilingual("偏右", "to the right"), Bilingual("偏左", "to the left"), centred),
        (Bilingual("上下", "Up and down"), up, f"{abs(up):.0f}%", 0.5,
         Bilingual("偏高", "too high"), Bilingual("偏低", "too low"), centred),
        (Bilingual("大小", "Size"), scale - 1, f"{scale * 100:.0f}%", 0.005,
         Bilingual("為範字之比，偏大", "of the master's, larger"),
         Bilingual("為範字之比，偏小", "of the master's, smaller"),
         Bilingual("與範字同大", "of the master's")),
    )  # fmt: skip
    return [
        (name, shown, none if abs(value) < still else plus if value > 0 else minus)
        for name, value, shown, still, plus, minus, none in facts
    ]


def _side_by_side(copy: Surface, master: Surface) -> list[tuple[CaptionedPicture, CaptionedPicture]]:
    """Copy and master as written, shaded, and as mesh."""
    written = Bilingual("原圖", "As written")
    lit = Bilingual("曲面（左上來光）", "Surface, lit from the upper left")
    columns = [
        [
            _captioned(albedo_picture(surface), written, subject),
            _captioned(shaded_picture(surface, tilt=_LAMP_TILT), lit, subject),
            _mesh(surface, subject),
        ]
        for surface, subject in ((copy, "copy"), (master, "master"))
    ]
    return list(zip(*columns, strict=True))


def _captioned(picture: Picture, caption: Bilingual, subject: str) -> CaptionedPicture:
    return CaptionedPicture(data_uri(picture), f"{caption.en}: {subject}", caption)


def _mesh(
    surface: Surface, subject: str = "the surface", *, view: MeshView | None = None
) -> CaptionedPicture:
    picture, raised = mesh_picture(surface, view=view)
    zh, en = (f"（高度放大 {raised:.1f} 倍）", f", height × {raised:.1f}") if raised > 1.05 else ("", "")
    return CaptionedPicture(data_uri(picture), f"Mesh: {subject}", Bilingual(f"網格{zh}", f"Mesh{en}"))


def _overlay(registration: Registration, master: Surface) -> dict[str, Any]:
    settings = OverlaySettings()
    return {
        "uri": data_uri(overlay_picture(registration, master=master, settings=settings)),
        "gradient": css_gradient(RESIDUAL_STOPS),
        "full": settings.full,
        "missing": settings.missing,
        "missing_colour": "rgb({} {} {})".format(*MISSING),
        "uncovered": f"{100 * uncovered_share(registration, settings=settings):.0f}%",
    }


def _maps(surface: Surface) -> list[CaptionedPicture]:
    albedo = Bilingual("反照率", "Albedo: the sheet without its light")
    normals = Bilingual("法線：紅 x，綠 y，藍 z", "Normals: red x, green y, blue z")
    confidence = Bilingual("可信度：白為可信，黑為填補", "Confidence: white is sure, black was filled in")
    return [
        CaptionedPicture(data_uri(albedo_picture(surface)), "Albedo", albedo),
        CaptionedPicture(data_uri(normals_picture(surface)), "Normals", normals),
        CaptionedPicture(data_uri(share_picture(surface.confidence)), "Confidence", confidence),
    ]


def _render(template: str, **context: Any) -> str:
    import rumu

    context |= {"means": wording.MEANS, "means_not": wording.MEANS_NOT, "advice": wording.REFUSED_ADVICE}
    return _environment().get_template(template).render(**context, version=rumu.__version__)


@lru_cache(maxsize=1)
def _environment() -> Environment:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    return Environment(
        loader=PackageLoader("rumu.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
