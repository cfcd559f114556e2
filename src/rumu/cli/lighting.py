"""The options that say where the lamps of photographs stood, and the capture that they make."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

if TYPE_CHECKING:
    from rumu.capture.spheres import Sphere
    from rumu.card.capture import CardCapture
    from rumu.image_stack import Progress
    from rumu.values import Bilingual, Capture, FloatArray

_CIRCLE = re.compile(r"\s*([\d.]+)\s*,\s*([\d.]+)\s*,\s*([\d.]+)\s*")

SphereOption = Annotated[
    list[str] | None,
    typer.Option(
        "--sphere",
        help="Mirror spheres in the photographs tell the lamps: auto finds them; x,y,r gives one, centre "
        "from the top left corner and radius, in pixels. May be repeated.",
    ),
]

LeaveOutOption = Annotated[
    list[str] | None,
    typer.Option("--leave-out", help="Name of a photograph that is not used; may be repeated."),
]

FlatFieldOption = Annotated[
    Path | None,
    typer.Option(
        "--flat-field",
        help="A photograph of a blank, even sheet, or a folder of them, by which photographs are divided.",
    ),
]

Encoding = Literal["auto", "linear", "srgb"]
EncodingOption = Annotated[
    Encoding,
    typer.Option(
        "--encoding",
        help="What the values of the photographs are: light (linear), or made for a screen (srgb); auto "
        "tells it from the files.",
    ),
]

AlignOption = Annotated[
    bool,
    typer.Option("--align", help="Lay the photographs on each other first, where the camera moved a little."),
]

CardOption = Annotated[
    bool,
    typer.Option(
        "--card",
        help="The printed card (rumu card) lies in the photographs: it tells lamps, scale, and where the "
        "writing is.",
    ),
]

LampsUnknownOption = Annotated[
    bool,
    typer.Option(
        "--lamps-unknown",
        help="Nothing tells the lamps: find them from the photographs of a flat sheet alone.",
    ),
]

InsideOutOption = Annotated[
    bool,
    typer.Option("--inside-out", help="With --lamps-unknown: take the other reading, hollows for ridges."),
]


NearLampsOption = Annotated[
    bool,
    typer.Option(
        "--near-lamps",
        help="The lamps stood near a flat sheet: find from the photographs how far away each was.",
    ),
]


@dataclass(frozen=True, slots=True)
class LampSource:
    """What tells the lamps of photographs: a file in their folder, unless one of these does.

    sphere: texts of --sphere. card: of --card. unknown: of --lamps-unknown. inside_out: of --inside-out.
    near: of --near-lamps, by which the photographs tell how far away the lamps of a file or a sphere are.
    """

    sphere: tuple[str, ...] = ()
    card: bool = False
    unknown: bool = False
    inside_out: bool = False
    near: bool = False

    def check(self, *, flat_field: Path | None) -> None:
        """Raise wrong usage for options that exclude each other."""
        if self.card and (self.sphere or flat_field):
            raise typer.BadParameter(
                "--card tells the lamps and their fall-off already", param_hint="'--card'"
            )
        if self.unknown and (self.sphere or self.card):
            raise typer.BadParameter("a sphere or the card tells the lamps", param_hint="'--lamps-unknown'")
        if self.near and (self.card or self.unknown or flat_field):
            raise typer.BadParameter(
                "only where a file or a sphere tells the directions, and without --flat-field",
                param_hint="'--near-lamps'",
            )
        if self.inside_out and not self.unknown:
            raise typer.BadParameter("only with --lamps-unknown", param_hint="'--inside-out'")

    @property
    def words(self) -> Bilingual:
        """Where the directions of the lamps come from."""
        from rumu.values import Bilingual

        if self.card:
            return Bilingual("拍攝卡", "the capture card")
        if self.sphere:
            return Bilingual("反光球", "mirror spheres in the photographs")
        if self.unknown:
            return Bilingual("照片本身", "the photographs alone")
        return Bilingual("資料夾裡的檔案", "a file in the folder")


@dataclass(frozen=True, slots=True, eq=False)
class LitCapture:
    """A capture, and what is known of how it was made.

    moved: (N,) pixels by which each photograph was moved; None without --align. card: what the card told;
    None without --card.
    """

    capture: Capture
    moved: FloatArray | None = None
    card: CardCapture | None = None


def read_lit_capture(
    folder: Path,
    source: LampSource,
    *,
    flat_field: Path | None,
    align: bool,
    leave_out: Sequence[str],
    mm_per_pixel: float | None,
    encoding: Encoding,
    progress: Progress,
) -> LitCapture:
    """The capture of a folder.

    flat_field: of --flat-field, by which the photographs are divided. align: of --align. mm_per_pixel: the
    scale, instead of what the folder or the card says. encoding: of --encoding, also of flat-field frames.
    Raises wrong usage for options that exclude each other.
    """
    from rumu.capture.flat_frames import divide_by_flat_frames, unused_flat_notes
    from rumu.capture.folder import read_capture
    from rumu.capture.sphere_capture import read_sphere_capture
    from rumu.card.capture import read_card_capture
    from rumu.surface.alignment import align_photographs
    from rumu.surface.lamp_positions import place_lamps

    source.check(flat_field=flat_field)
    made = None
    if source.card:
        made = read_card_capture(folder, leave_out=leave_out, encoding=encoding, progress=progress)
        capture = made.capture
    elif source.sphere:
        spheres = spheres_of(source.sphere)
        capture = read_sphere_capture(
            folder, spheres=spheres, leave_out=leave_out, encoding=encoding, progress=progress
        )
    elif source.unknown:
        capture = _without_lamps(folder, source, leave_out, encoding, progress)
    else:
        capture = read_capture(
            folder, encoding=encoding, leave_out=leave_out, mm_per_pixel=mm_per_pixel, progress=progress
        )
    if mm_per_pixel is not None:
        capture = capture.changed(spacing=mm_per_pixel)
    moved = None
    if align:
        done = align_photographs(capture, progress=progress)
        capture, moved = done.capture, done.moved
    if flat_field is None:
        place = folder if folder.is_dir() else folder.parent
        capture = capture.changed(notes=(*capture.notes, *unused_flat_notes(place)))
    else:
        capture = divide_by_flat_frames(capture, flat_field, encoding=encoding)
    if source.near:
        progress("Placing the lamps", 0, 1)
        capture = place_lamps(capture)
    return LitCapture(capture, moved, made)


def _without_lamps(
    folder: Path, source: LampSource, leave_out: Sequence[str], encoding: Encoding, progress: Progress
) -> Capture:
    """The capture of photographs whose lamps nothing tells."""
    from rumu.capture.unlit import read_unlit_photographs
    from rumu.surface.unknown_lamps import find_lamps
    from rumu.values import Bilingual

    read = read_unlit_photographs(
        folder,
        show=Bilingual("同一張紙、燈在各處的", "of one sheet, with the lamp in several places"),
        leave_out=leave_out,
        encoding=encoding,
        progress=progress,
    )
    found = find_lamps(
        read.frames.stack, mask=read.mask, names=read.names, inside_out=source.inside_out, progress=progress
    ).capture
    return found.changed(
        spacing=read.description.spacing_mm,
        orientation=read.frames.orientation,
        notes=(*found.notes, *read.frames.notes),
    )


def spheres_of(texts: Sequence[str]) -> list[Sphere]:
    """The spheres of --sphere options; none where they are to be found."""
    return [one for one in map(_circle, texts) if one is not None]


def _circle(text: str) -> Sphere | None:
    """A sphere from x,y,r; None for 'auto'."""
    from rumu.capture.spheres import Sphere

    if text.strip().lower() == "auto":
        return None
    numbers = _CIRCLE.fullmatch(text)
    try:
        return Sphere(*(float(one) for one in numbers.groups())) if numbers else _wrong(text)
    except ValueError:
        return _wrong(text)


def _wrong(text: str) -> Sphere:
    raise typer.BadParameter(f"expected auto or x,y,r in pixels, got {text!r}", param_hint="'--sphere'")
