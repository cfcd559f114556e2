"""The options that say where the lamps of photographs stood, and the capture that they make."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rumu.capture.spheres import Sphere
    from rumu.card.capture import CardCapture
    from rumu.image_stack import Progress
    from rumu.values import Capture, FloatArray

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
    *,
    sphere: Sequence[str] | None,
    card: bool,
    flat_field: Path | None,
    align: bool,
    leave_out: Sequence[str],
    progress: Progress,
) -> LitCapture:
    """The capture of a folder, its lamps told by a file, by mirror spheres, or by the card.

    flat_field: of --flat-field, by which the photographs are divided. align: of --align.
    Raises wrong usage for options that exclude each other.
    """
    from rumu.capture.flat_frames import divide_by_flat_frames
    from rumu.capture.folder import read_capture
    from rumu.capture.sphere_capture import read_sphere_capture
    from rumu.card.capture import read_card_capture
    from rumu.surface.alignment import align_photographs

    made = None
    if card and (sphere or flat_field):
        raise typer.BadParameter("--card tells the lamps and their fall-off already", param_hint="'--card'")
    if card:
        made = read_card_capture(folder, leave_out=leave_out, progress=progress)
        capture = made.capture
    elif sphere:
        spheres = spheres_of(sphere)
        capture = read_sphere_capture(folder, spheres=spheres, leave_out=leave_out, progress=progress)
    else:
        capture = read_capture(folder, leave_out=leave_out, progress=progress)
    moved = None
    if align:
        done = align_photographs(capture, progress=progress)
        capture, moved = done.capture, done.moved
    if flat_field is not None:
        capture = divide_by_flat_frames(capture, flat_field)
    return LitCapture(capture, moved, made)


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
