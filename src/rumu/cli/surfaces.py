"""relief, relight, stl, mesh: one image into a surface, light on it, meshes of it; a surface as a folder."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from rumu.cli.options import AsJson, check_writable, finite, not_an_input
from rumu.cli.terminal import Outcome, print_outcome, working
from rumu.errors import GalleryError, SurfaceError

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from rumu.image_stack import Progress
    from rumu.report.pictures import Picture
    from rumu.surface.folder import Processing
    from rumu.values import Bilingual, Surface

Method = Literal["inflation", "density"]
Mode = Literal["inhomogeneous", "homogeneous", "hybrid"]

REPORT = "report.html"
SurfaceSource = Annotated[
    str,
    typer.Argument(
        metavar="SURFACE",
        help="Folder written by reconstruct or relief, an image, or the id of a work of the gallery.",
    ),
]
Exaggeration = Annotated[float, typer.Option(min=0.01, max=100, help="By how much the height is multiplied.")]
_SHEETS = ("glb", "usdz", "obj", "ply")
_STL_VERTICES = 250_000  # of a solid for a printer: half a million triangles, 25 MB

Folder = Annotated[
    Path, typer.Option("-o", "--out", help="Folder to write; an earlier result there is replaced.")
]


@print_outcome
def relief(
    *,
    image: Annotated[
        Path,
        typer.Argument(metavar="IMAGE", help="Scan or photograph of ink on paper, silk or stone rubbing."),
    ],
    out: Folder,
    method: Annotated[Method, typer.Option(help="Where the height comes from.")] = "inflation",
    mode: Annotated[Mode, typer.Option(help="Wide strokes high, all alike, or between.")] = "inhomogeneous",
    floats: Annotated[
        bool, typer.Option("--floats", help="Also write the arrays as TIFFs of 32-bit floats.")
    ] = False,
    as_json: AsJson = False,
) -> Outcome:
    """One image of ink -> a surface computed from the ink (not measured relief)."""
    from rumu.outputs import whole_folder
    from rumu.surface.folder import FLOATS, MARKER, MESH, PICTURES
    from rumu.surface.relief import relief as raised

    check_writable(whole_folder(out, marker=MARKER))
    with working("Raising the ink"):
        surface = raised(image, method=method, mode=mode)
        notes = _reduction_notes(surface)
        files = (*PICTURES, MESH, REPORT, *(FLOATS if floats else ()))
        return write_result(surface, out, title=image.stem, notes=notes, files=files)


def _reduction_notes(surface: Surface) -> list[Bilingual]:
    """At which size a large picture was worked; empty for one that was worked at its own."""
    from rumu.values import Bilingual

    reduced = surface.quality.get("reduced")
    if reduced is None:
        return []
    rows, columns = surface.height.shape
    return [
        Bilingual(
            f"圖片很大，先縮小到 {columns} × {rows} 像素（邊長除以 {reduced:.3g}）再計算。",
            f"The picture is large; it was reduced to {columns} x {rows} pixels, its sides divided by "
            f"{reduced:.3g}.",
        )
    ]


@print_outcome
def relight(
    *,
    surface_dir: Annotated[
        Path,
        typer.Argument(
            metavar="OUT",
            help="Folder written by reconstruct or relief; or a relightable image: .ptm, .rti, info.json.",
        ),
    ],
    tilt: Annotated[
        float, typer.Option(help="Degrees counter-clockwise from the right: 90 is from the top.")
    ],
    slant: Annotated[float, typer.Option(min=0, max=90, help="Degrees from straight above: 90 grazes.")],
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", help="PNG to write (default: named after OUT, in this folder)."),
    ] = None,
    bits: Annotated[int, typer.Option(help="8 or 16 bits for each channel.")] = 8,
    as_json: AsJson = False,
) -> Outcome:
    """A surface, or the relightable image of an RTI program, under any lamp, as an sRGB PNG."""
    from rumu.outputs import whole_file
    from rumu.report.pictures import png_bytes

    finite(tilt), finite(slant)
    name = surface_dir.resolve().name if surface_dir.is_dir() else surface_dir.stem
    target = out or Path(f"{name}-tilt{tilt:g}-slant{slant:g}.png")
    if target.suffix.lower() != ".png":
        raise typer.BadParameter(f"expected a name that ends in .png, got {target}", param_hint="'-o'")
    if bits not in (8, 16):
        raise typer.BadParameter(f"expected 8 or 16, got {bits}", param_hint="'--bits'")
    lit, source = _lit(surface_dir, tilt, slant, bits)
    with whole_file(target) as part:
        part.write_bytes(png_bytes(lit))
    facts = {"file": target, "tilt": tilt, "slant": slant, "bits": bits, "source": source}
    return Outcome(facts, f"{target}: tilt {tilt:g}°, slant {slant:g}°")


def _lit(path: Path, tilt: float, slant: float, bits: int) -> tuple[Picture, str]:
    """A surface folder or a relightable image under a lamp, as sRGB, and where it comes from."""
    import numpy as np

    from rumu.capture.lights import direction
    from rumu.report.pictures import srgb
    from rumu.rti.exchange import is_rti, read_rti
    from rumu.rti.image import relight_rti
    from rumu.surface.folder import read_surface
    from rumu.surface.relight import relight as light

    if is_rti(path):
        image = read_rti(path)
        shown = relight_rti(image, direction(tilt=tilt, slant=slant))
        return np.round(shown * (2**bits - 1)).astype(np.uint8 if bits == 8 else np.uint16), image.basis
    surface = read_surface(path)
    return srgb(light(surface, tilt=tilt, slant=slant), bits=bits), surface.source


@print_outcome
def stl(
    *,
    source: SurfaceSource,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", help="STL to write (default: named after SURFACE, in this folder)."),
    ] = None,
    width: Annotated[
        float | None,
        typer.Option(
            min=5,
            max=2000,
            help="Millimetres from left to right (default: as the sheet, or 100 long).",
        ),
    ] = None,
    base: Annotated[
        float, typer.Option(min=0.2, max=100, help="Millimetres of material below the lowest point.")
    ] = 2.0,
    exaggeration: Exaggeration = 1.0,
    as_json: AsJson = False,
) -> Outcome:
    """A surface as a closed solid on a flat base, in millimetres, for a 3-D printer."""
    from rumu.outputs import whole_file
    from rumu.report.wording import SOURCES
    from rumu.surface.mesh import MeshSettings, solid_mesh
    from rumu.surface.mesh_files import stl_bytes

    for number in (width or 0.0, base, exaggeration):
        finite(number)
    given = Path(source).resolve()
    target = out or Path(f"{given.name if given.is_dir() else given.stem}.stl")
    if target.suffix.lower() != ".stl":
        raise typer.BadParameter(f"expected a name that ends in .stl, got {target}", param_hint="'-o'")
    not_an_input(target, source)
    check_writable(whole_file(target))
    settings = MeshSettings(exaggeration=exaggeration, vertices=_STL_VERTICES, width=width, base=base)
    with working("Building the solid"):
        surface = _surface_of(source)
        vertices, faces = solid_mesh(surface, settings=settings)
        with whole_file(target) as part:
            part.write_bytes(stl_bytes(vertices, faces, source=surface.source))
    size = vertices.max(axis=0) - vertices.min(axis=0)
    facts = {"file": target, "size_mm": size, "base_mm": base, "exaggeration": exaggeration}
    text = (
        f"{target}: {size[0]:.1f} x {size[1]:.1f} x {size[2]:.1f} mm, base {base:g} mm, {len(faces)} faces\n"
        f"  {SOURCES[surface.source].en}"
    )
    return Outcome({**facts, "faces": len(faces), "source": surface.source}, text)


@print_outcome
def mesh(
    *,
    source: SurfaceSource,
    out: Annotated[
        Path,
        typer.Option(
            "-o", "--out", help="File to write; its ending says as what: .glb, .usdz, .obj or .ply."
        ),
    ],
    exaggeration: Exaggeration = 1.0,
    triangles: Annotated[
        int, typer.Option(min=100, max=20_000_000, help="Most triangles of the mesh.")
    ] = 120_000,
    texture: Annotated[
        int, typer.Option(min=16, max=16_384, help="Longest side of the pictures on it, in pixels.")
    ] = 2048,
    as_json: AsJson = False,
) -> Outcome:
    """A surface as an open sheet of triangles, to look at and to exchange."""
    from rumu.outputs import whole_file
    from rumu.report.wording import SOURCES
    from rumu.surface.mesh import MeshSettings
    from rumu.surface.mesh_files import mesh_bytes, obj_files

    finite(exaggeration)
    kind = out.suffix.lower().removeprefix(".")
    if kind not in _SHEETS:
        other = " (a solid for a printer: rumu stl)" if kind == "stl" else ""
        endings = ", ".join(f".{one}" for one in _SHEETS)
        raise typer.BadParameter(
            f"expected a name that ends in {endings}, got {out}{other}", param_hint="'-o'"
        )
    not_an_input(out, source)
    check_writable(whole_file(out))
    settings = MeshSettings(exaggeration=exaggeration, vertices=triangles // 2, texture=texture)
    with working("Building the mesh"):
        surface = _surface_of(source)
        if kind == "obj":
            files = obj_files(surface, out.stem, settings=settings)
        else:
            files = {out.name: mesh_bytes(surface, kind=kind, settings=settings)}  # type: ignore[arg-type]
        with ExitStack() as all_whole:
            for name, content in files.items():
                all_whole.enter_context(whole_file(out.with_name(name))).write_bytes(content)
    written, size = [out.with_name(name) for name in files], sum(map(len, files.values()))
    facts = {"files": written, "bytes": size, "exaggeration": exaggeration, "source": surface.source}
    text = f"{', '.join(map(str, written))}: {size / 1e6:.1f} MB\n  {SOURCES[surface.source].en}"
    return Outcome(facts, text)


def _surface_of(source: str) -> Surface:
    """The surface of a folder or an image, or of a work of the gallery by its id."""
    if Path(source).exists():
        from rumu.pipeline import surface_of

        return surface_of(Path(source))
    from rumu.gallery.assets import assets_of
    from rumu.gallery.catalog import open_gallery, work

    gallery = open_gallery()
    try:
        return assets_of(gallery.store, work(gallery, source)).surface()
    except GalleryError as error:
        raise SurfaceError(f"{source}: there is no such file or folder, and {error}") from error


def write_result(
    surface: Surface,
    out: Path,
    *,
    title: str,
    notes: Sequence[Bilingual] = (),
    files: Collection[str],
    beside: Mapping[str, str | bytes] | None = None,
    processing: Processing | None = None,
    progress: Progress | None = None,
) -> Outcome:
    """Write a surface as a folder with its report, and say what was written.

    files: which, and REPORT. beside: more files by name. processing: how it was made, for surface.json.
    """
    from rumu.image_stack import begin
    from rumu.report.pages import surface_page
    from rumu.report.wording import SOURCES, quality_meaning
    from rumu.surface.folder import MESH, write_surface
    from rumu.surface.reduction import reduce_surface

    if {REPORT, MESH} & set(files):
        begin("Drawing the mesh and the report", progress)
    shown = reduce_surface(surface) if {REPORT, MESH} & set(files) else None
    report = {REPORT: surface_page(surface, title=title, notes=notes, shown=shown)} if REPORT in files else {}
    written = [name for name in files if name != REPORT]
    extra = {**report, **(beside or {})}
    write_surface(
        surface, out, files=written, extra=extra, processing=processing, shown=shown, progress=progress
    )
    facts = {
        "out": out,
        "report": out / REPORT if report else None,
        "source": surface.source,
        "shape": surface.height.shape,
        "spacing": surface.spacing,
        "unit": surface.unit,
        "height": {"low": surface.height.min(), "high": surface.height.max()},
        "mask_share": surface.mask.mean(),
        "quality": surface.quality,
        "notes": [note._asdict() for note in notes],
    }
    rows, columns = surface.height.shape
    low, high = float(surface.height.min()), float(surface.height.max())
    quality = "".join(
        f"\n  {quality_meaning(name).en}: {value:.4g}" for name, value in surface.quality.items()
    )
    text = (
        f"{out}: {columns} x {rows} pixels, height {low:.3g} to {high:.3g} {surface.unit}\n"
        f"  {SOURCES[surface.source].en}{quality}" + (f"\n  report: {out / REPORT}" if report else "")
    )
    return Outcome(facts, text + "".join(f"\n  note: {note.en}" for note in notes))
