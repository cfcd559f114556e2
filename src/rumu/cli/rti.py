"""rti: photographs of a capture as a relightable image for RTIViewer, RelightLab and OpenLIME."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import typer

from rumu.cli.lighting import (
    AlignOption,
    CardOption,
    EncodingOption,
    FlatFieldOption,
    InsideOutOption,
    LampSource,
    LampsUnknownOption,
    LeaveOutOption,
    NearLampsOption,
    SphereOption,
    read_lit_capture,
)
from rumu.cli.options import AsJson, check_writable, finite
from rumu.cli.run_time import rti_stages
from rumu.cli.terminal import Outcome, counted, print_outcome, stages

Basis = Literal["ptm", "hsh"]
Channels = Literal["lrgb", "rgb"]
_BASIS_OF: dict[str, Basis] = {".ptm": "ptm", ".rti": "hsh"}


@print_outcome
def rti(
    *,
    capture_dir: Annotated[
        Path,
        typer.Argument(
            metavar="CAPTURE_DIR", help="Folder of photographs of one sheet, each under one lamp."
        ),
    ],
    out: Annotated[
        Path,
        typer.Option(
            "-o",
            "--out",
            help="FILE.ptm or FILE.rti for RTIViewer, or a folder of JPEGs with info.json for OpenLIME.",
        ),
    ],
    basis: Annotated[
        Basis | None,
        typer.Option(
            help="ptm: a polynomial; hsh: hemispherical harmonics (default: as -o is named, else ptm)."
        ),
    ] = None,
    order: Annotated[int, typer.Option(min=1, max=3, help="Of the harmonics: 4, 9 or 16 terms.")] = 2,
    channels: Annotated[
        Channels | None,
        typer.Option(
            help="lrgb: one luminance lights a colour; rgb: each channel by itself (default: lrgb of ptm, "
            "rgb of hsh)."
        ),
    ] = None,
    leave_out: LeaveOutOption = None,
    sphere: SphereOption = None,
    card: CardOption = False,
    lamps_unknown: LampsUnknownOption = False,
    inside_out: InsideOutOption = False,
    near_lamps: NearLampsOption = False,
    flat_field: FlatFieldOption = None,
    align: AlignOption = False,
    encoding: EncodingOption = "auto",
    mm_per_pixel: Annotated[
        float | None, typer.Option(min=1e-6, help="Scale of the photographs, for info.json.")
    ] = None,
    as_json: AsJson = False,
) -> Outcome:
    """Photographs of one sheet under many lamps -> a relightable image (.ptm, .rti, info.json)."""
    from rumu.outputs import whole_file, whole_folder
    from rumu.rti.exchange import write_rti
    from rumu.rti.fitting import fit_rti
    from rumu.rti.planes import INFO
    from rumu.surface.encoding_check import encoding_notes

    implied = _BASIS_OF.get(out.suffix.lower())
    if implied and basis not in (None, implied):
        raise typer.BadParameter(f"{out.suffix} holds {implied}, not {basis}", param_hint="'--basis'")
    if out.suffix.lower() == ".rti" and channels == "lrgb":
        raise typer.BadParameter(".rti holds each channel by itself, not lrgb", param_hint="'--channels'")
    chosen = basis or implied or "ptm"
    check_writable(whole_file(out) if implied else whole_folder(out, marker=INFO))
    with stages(rti_stages(channels or chosen, align=align, near=near_lamps, card=card)) as progress:
        capture = read_lit_capture(
            capture_dir,
            LampSource(tuple(sphere or ()), card, lamps_unknown, inside_out, near_lamps),
            flat_field=flat_field,
            align=align,
            leave_out=leave_out or (),
            mm_per_pixel=None if mm_per_pixel is None else finite(mm_per_pixel),
            encoding=encoding,
            progress=progress,
        ).capture
        fit = fit_rti(capture, basis=chosen, order=order, channels=channels, progress=progress)
        progress("Writing files", 0, 1)
        write_rti(fit.image, out, capture=capture)
    height, width, count, terms = fit.image.coefficients.shape
    notes = (*capture.notes, *encoding_notes(capture), *fit.notes)
    facts = {
        "out": out,
        "basis": chosen,
        "channels": "rgb" if count == 3 else "lrgb",
        "terms": terms,
        "told": fit.told,
        "shape": [height, width],
        "lamps": len(capture.lights),
        "residual": fit.residual,
        "notes": [note._asdict() for note in notes],
    }
    kind = "polynomial" if chosen == "ptm" else "harmonics"
    text = (
        f"{out}: {width} x {height} pixels, {kind} of {terms} terms, {facts['channels']}, from "
        f"{counted(len(capture.lights), 'photograph')}\n  residual: {fit.residual:.4f} of white (rms)"
    )
    return Outcome(facts, text + "".join(f"\n  note: {note.en}" for note in notes))
