"""lamps: where the lamps stood, from mirror spheres in the photographs, as an .lp file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rumu.cli.lighting import EncodingOption, SphereOption, spheres_of
from rumu.cli.options import AsJson, check_writable
from rumu.cli.terminal import Outcome, print_outcome, stages
from rumu.errors import OutputError

if TYPE_CHECKING:
    from rumu.capture.spheres import FoundLamps, Sphere


@print_outcome
def lamps(
    *,
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="PHOTOGRAPHS", help="Folder of photographs that show one or more mirror spheres."
        ),
    ],
    sphere: SphereOption = None,
    encoding: EncodingOption = "auto",
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help=".lp to write (default: lamps.lp in the folder).")
    ] = None,
    as_json: AsJson = False,
) -> Outcome:
    """Photographs with a mirror sphere -> the direction of each lamp, as an .lp file."""
    from rumu.capture.frames import read_frames
    from rumu.capture.light_files import lp_text
    from rumu.capture.photographs import FolderImages, capture_error
    from rumu.capture.spheres import find_spheres, lamps_of_spheres
    from rumu.outputs import whole_file

    given = spheres_of(sphere or ["auto"])
    target = out or folder / "lamps.lp"
    if target.suffix.lower() != ".lp":
        raise typer.BadParameter(f"expected a name that ends in .lp, got {target}", param_hint="'-o'")
    if out is None and target.exists():
        raise OutputError(
            "is there already; name another file with -o, or this one to replace it", name=target
        )
    images = FolderImages(folder)
    paths = tuple(images.photographs)
    if not paths:
        raise capture_error(folder, en="expected photographs, found none", zh="這裡應有照片，卻沒有")
    check_writable(whole_file(target))
    with stages() as progress:
        frames = read_frames(
            paths, as_shown=False, ambient=None, encoding=encoding, orientation="stored", progress=progress
        )
        progress("Looking for spheres", 0, 1)
        spheres = given or find_spheres(frames.stack)
        found = lamps_of_spheres(frames.stack, spheres)
    names = [path.name for path in paths]
    with whole_file(target) as part:
        part.write_text(lp_text(names, found.lights), encoding="utf-8")
    return _outcome(target, names, spheres, found)


def _outcome(target: Path, names: list[str], spheres: list[Sphere], found: FoundLamps) -> Outcome:
    from rumu.capture.lights import tilt_slant
    from rumu.capture.sphere_capture import sphere_notes

    rows, left_out = [], []
    for name, light, apart in zip(names, found.lights, found.apart, strict=True):
        if light[2] != light[2]:
            left_out.append(name)
            continue
        tilt, slant = tilt_slant(light)
        rows.append({"name": name, "direction": light, "tilt": tilt, "slant": slant, "apart": float(apart)})
    notes = [note.en for note in sphere_notes(names, found)]
    if len(rows) < 3:
        notes.append(f"{len(rows)} lamps are too few for a surface, which takes three")
    text = "\n".join(
        [
            f"{target}: {len(rows)} lamps",
            *(f"  sphere at {one.x:.1f}, {one.y:.1f}, radius {one.radius:.1f} pixels" for one in spheres),
            *(f"  {row['name']}: tilt {row['tilt']:.1f}°, slant {row['slant']:.1f}°" for row in rows),
            *(f"  note: {note}" for note in notes),
        ]
    )
    facts = {"file": target, "spheres": spheres, "lamps": rows, "left_out": left_out, "notes": notes}
    return Outcome(facts, text)
