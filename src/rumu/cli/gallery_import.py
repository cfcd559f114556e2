"""gallery import: many works at once, from a folder, or from a museum by its IIIF manifest."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from rumu.cli.gallery import (
    Attribution,
    Collection,
    Dynasty,
    Hand,
    Licence,
    Material,
    ScriptOf,
    Source,
    TitleEn,
    TitleZh,
    shared_metadata,
)
from rumu.cli.options import AsJson
from rumu.cli.terminal import Outcome, bar, counted, print_outcome

if TYPE_CHECKING:
    from rumu.gallery.archive import ImportResult
    from rumu.gallery.labels import SharedMetadata

_MILLION = 1_000_000


@print_outcome
def import_works(
    source: Annotated[
        str,
        typer.Argument(
            metavar="FOLDER|MANIFEST",
            help="Folder with labels.csv, with pages and texts (a.jpg, a.txt), or that export wrote; or the "
            "address or file of a IIIF manifest or collection.",
        ),
    ],
    *,
    collection: Collection = None,
    title_zh: TitleZh = None,
    title_en: TitleEn = None,
    script: ScriptOf = None,
    hand: Hand = None,
    dynasty: Dynasty = None,
    material: Material = None,
    source_of: Source = None,
    licence: Licence = None,
    attribution: Attribution = None,
    pause: Annotated[
        float, typer.Option(min=0, help="Of a manifest: seconds between two requests to one host.")
    ] = 0.5,
    max_megapixels: Annotated[
        float, typer.Option(min=0.01, help="Of a manifest: larger pictures come reduced.")
    ] = 40.0,
    allow_private: Annotated[
        bool,
        typer.Option("--allow-private", help="Of a manifest: fetch from machines of the inner network, too."),
    ] = False,
    as_json: AsJson = False,
) -> Outcome:
    """Many works; run it again to go on where it was ended. Options say what labels or museum leave open."""
    shared = shared_metadata(
        title_zh=title_zh, title_en=title_en, script=script, hand=hand, dynasty=dynasty, material=material,
        source=source_of, licence=licence, attribution=attribution, id=collection,
    )  # fmt: skip
    from rumu.gallery.iiif_import import is_web_address

    if is_web_address(source) or Path(source).suffix.lower() == ".json":
        done = _import_manifest(
            source, shared, pause=pause, max_pixels=round(max_megapixels * _MILLION), private=allow_private
        )
    else:
        done = _import_folder(Path(source), shared)
    lines = [
        f"{counted(done.added, 'work')} added, {done.existing} were there already: "
        + ", ".join(done.collections)
    ]
    if done.left_out:
        lines.append(
            f"{len(done.left_out)} left out, such as {done.left_out[0][0]}: {done.left_out[0][1].en}"
        )
    if done.read_as:
        lines.append(f"labels.csv read as {done.read_as.en}")
    left_out = [{"file": file, "reason": reason.en} for file, reason in done.left_out]
    facts = {"collections": list(done.collections), "added": done.added, "there": done.existing}
    facts |= {"read_as": done.read_as.en if done.read_as else ""}
    return Outcome({**facts, "left_out": left_out}, "\n".join(lines))


def _import_folder(folder: Path, shared: SharedMetadata) -> ImportResult:
    from rumu.gallery.archive_import import holds_starter
    from rumu.gallery.assets import delete_orphans
    from rumu.gallery.bulk_import import import_folder
    from rumu.gallery.catalog import open_gallery

    gallery = open_gallery(starter=not holds_starter(folder))
    with bar("Importing") as advance:
        done = import_folder(gallery, folder, shared=shared, progress=advance)
    delete_orphans(gallery)
    return done


def _import_manifest(
    source: str, shared: SharedMetadata, *, pause: float, max_pixels: int, private: bool
) -> ImportResult:
    from rumu.gallery.catalog import open_gallery
    from rumu.gallery.iiif_import import import_manifest
    from rumu.gallery.museum_web import FetchSettings

    settings = FetchSettings(pause=pause, private=private)
    with bar("Fetching") as advance:
        return import_manifest(
            open_gallery(), source, shared=shared, settings=settings, max_pixels=max_pixels, progress=advance
        )
