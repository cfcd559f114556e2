"""Add one work to the gallery: from a picture, from photographs under several lamps, or from a font.

Files are written before the row that names them, so that a work is complete or absent. Files that an
interrupted run leaves in the store are named by their content; the next run uses them, or `delete_orphans`
deletes them.
"""

from __future__ import annotations

import io
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, get_args

from sqlalchemy import select

from rumu.capture.photographs import PICTURE_SUFFIXES
from rumu.database.tables import Work
from rumu.errors import GalleryError
from rumu.gallery.assets import (
    capture_key,
    picture_key,
    store_files,
    store_surface,
    surface_key,
)
from rumu.gallery.metadata import (
    EMPTY,
    NO_LICENCE,
    CollectionMetadata,
    StoredFiles,
    WorkMetadata,
    insert_works,
    next_position,
    slug,
    work_row,
)
from rumu.gallery.store import Gallery
from rumu.gallery.tile_maps import make_large_tiles
from rumu.values import Bilingual
from rumu.workspaces import temporary_folder

if TYPE_CHECKING:
    from rumu.gallery.fonts import Face

OWN_WORKS = CollectionMetadata(id="own", title=Bilingual(zh="自己收入", en="Added here"))


@dataclass(frozen=True, slots=True)
class AddedWork:
    """The id of a work.

    new: False when the same content with the same label existed before. notes: on how a capture was read.
    """

    id: str
    new: bool
    notes: tuple[Bilingual, ...] = ()


def add_picture(
    gallery: Gallery,
    path: str | Path,
    *,
    metadata: WorkMetadata,
    collection: CollectionMetadata = OWN_WORKS,
    method: str = "inflation",
    spacing: float | None = None,
) -> AddedWork:
    """Add a picture as a work. Its height is computed from its ink when it is needed.

    method: how, 'inflation' or 'density'. spacing: millimetres per pixel, None if unknown.
    Raises ImageError for a file that is no picture, RefusedImage for one without writing, SurfaceError for
    another method.
    """
    from rumu.surface.relief import Method, check_choice, read_with_ink

    path = Path(path)
    check_choice(method, get_args(Method), "method")
    columns, rows = read_with_ink(path)[2]  # refuses a sheet without writing
    metadata = replace(metadata, origin=metadata.origin or path.name)
    key, digest = _store_picture(gallery, path.read_bytes(), metadata, suffix=store_suffix(path))
    files = StoredFiles(
        picture=key, digest=digest, width=columns, height=rows, height_source=method, spacing=spacing
    )
    return add_stored_work(gallery, metadata, files, collection=collection)


def add_capture(
    gallery: Gallery,
    path: str | Path,
    *,
    metadata: WorkMetadata,
    collection: CollectionMetadata = OWN_WORKS,
    solver: str = "robust",
    rectify: str = "none",
    within: Path | None = None,
    card: bool = False,
) -> AddedWork:
    """Reconstruct a capture folder (see `read_capture`) and add photographs, lamps and surface as a work.

    The picture of the work is the mean of its photographs. within: the folder of an upload, which alone is
    read. card: whether the photographs show the printed card, which tells lamps, scale and place (see
    `rumu.card.capture.read_card_capture`); what they show in its window is then kept, laid flat. Raises
    CaptureError, ImageError or SurfaceError.
    """
    from rumu.capture.folder import read_capture
    from rumu.card.capture import read_card_capture
    from rumu.gallery.capture_copy import copy_capture, copy_card_capture, mean_photograph
    from rumu.pipeline import reconstruct
    from rumu.surface.encoding_check import encoding_notes
    from rumu.surface.frame_check import exposure_notes
    from rumu.surface.gloss_check import gloss_notes

    path = Path(path)
    folder = path if path.is_dir() else path.parent
    made = read_card_capture(path) if card else None
    capture = read_capture(path, within=within) if made is None else made.capture
    notes, spacing = capture.notes, capture.spacing
    with temporary_folder() as temporary:
        photographs = temporary / "capture"
        if made is None:
            capture_digest = copy_capture(capture, folder, photographs)
        else:
            capture_digest = copy_card_capture(made, folder, photographs)
        picture = mean_photograph(capture)
        del capture, made  # large photographs are in memory once only
        capture = read_capture(photographs, within=photographs)
        surface = reconstruct(capture, solver=solver, rectify=rectify)
        notes = (
            *notes,
            *exposure_notes(capture, surface),
            *encoding_notes(capture, surface),
            *gloss_notes(capture, surface),
        )
        del capture
        photographs_key = capture_key(capture_digest)
        reconstructed = surface_key(capture_digest, solver=solver, rectify=rectify)
        with gallery.store.whole_folder(photographs_key):
            store_files(gallery.store, photographs_key, sorted(photographs.iterdir()))
            store_surface(gallery.store, reconstructed, surface)
    height, width = surface.height.shape
    del surface  # its tiles are made of its files
    key = picture_key(picture, suffix=".png")
    gallery.store.write(key, picture)
    stored = StoredFiles(
        picture=key,
        digest=metadata.digest(PurePosixPath(reconstructed).name),
        width=width,
        height=height,
        kind="capture",
        height_source="photometric",
        surface=reconstructed,
        capture=photographs_key,
        spacing=spacing,
    )
    metadata = replace(metadata, origin=metadata.origin or folder.name)
    added = add_stored_work(gallery, metadata, stored, collection=collection)
    return replace(added, notes=notes)


def add_glyphs(
    gallery: Gallery,
    font: str | Path,
    characters: Iterable[str],
    *,
    metadata: WorkMetadata,
    collection: CollectionMetadata = OWN_WORKS,
) -> tuple[AddedWork, ...]:
    """Add a font's drawings of characters as works, all or none.

    Where the metadata are empty, those of the font are taken. Raises GalleryError when there is no such font,
    or it lacks one of the characters, even if its character map lists it.
    """
    from rumu.gallery.fonts import SIDE, Face

    face = Face(Path(font))
    wanted = tuple(dict.fromkeys(character for character in characters if not character.isspace()))
    if not wanted:
        raise GalleryError("expected characters to take from the font, got none")
    pictures = []
    for character in wanted:
        png = io.BytesIO()
        face.picture(character).save(png, "PNG", optimize=True)
        pictures.append(png.getvalue())
    added = []
    for character, data in zip(wanted, pictures, strict=True):
        glyph = _glyph_metadata(metadata, face, character)
        key, digest = _store_picture(gallery, data, glyph, suffix=".png")
        files = StoredFiles(picture=key, digest=digest, width=SIDE, height=SIDE)
        added.append(add_stored_work(gallery, glyph, files, collection=collection))
    return tuple(added)


def add_stored_work(
    gallery: Gallery,
    metadata: WorkMetadata,
    files: StoredFiles,
    *,
    collection: CollectionMetadata,
    **more: Any,
) -> AddedWork:
    """Add the row of a work whose files are stored, at the end of its collection, unless it exists.

    more: further columns. A large work gets its tiles.
    """
    added = _add_row(gallery, metadata, files, collection=collection, **more)
    make_large_tiles(gallery, added.id)
    return added


def _add_row(
    gallery: Gallery,
    metadata: WorkMetadata,
    files: StoredFiles,
    *,
    collection: CollectionMetadata,
    **more: Any,
) -> AddedWork:
    with gallery.database.writing() as session:
        insert_works(session, collection, [])
        existing = session.scalar(select(Work.id).where(Work.digest == files.digest))
        if existing is not None:
            return AddedWork(existing, new=False)
        position = next_position(session, collection.id)
        row = work_row(metadata, files, collection=collection, position=position, **more)
        return AddedWork(row["id"], new=bool(insert_works(session, collection, [row])))


def named_collection(name: str | None) -> CollectionMetadata:
    """The collection with a name that a person gave; its id is an ASCII slug of the name."""
    if name is None:
        return OWN_WORKS
    return CollectionMetadata(id=slug(name, default="collection"), title=Bilingual(name, name))


def store_suffix(path: Path) -> str:
    """The suffix of a picture's key in the store: a known one in lower case, else '.image'."""
    suffix = path.suffix.lower()
    return suffix if suffix in PICTURE_SUFFIXES else ".image"


def _store_picture(gallery: Gallery, data: bytes, metadata: WorkMetadata, *, suffix: str) -> tuple[str, str]:
    """(key, digest of the work) of a picture that is stored."""
    key = picture_key(data, suffix=suffix)
    gallery.store.write(key, data)
    return key, metadata.digest(data)


def _glyph_metadata(metadata: WorkMetadata, face: Face, character: str) -> WorkMetadata:
    """The metadata of a glyph; what is empty comes from the font's own names."""
    family = face.name("family") or face.path.stem
    designer = face.name("designer")
    hand = f"{designer} ({family})" if designer else family
    title = Bilingual(f"{family}「{character}」", f"{character}, {family}")
    licence = metadata.licence if metadata.licence != NO_LICENCE else face.name("licence")[:200]
    return replace(
        metadata,
        title=metadata.title if metadata.title != EMPTY else title,
        character=character,
        hand=metadata.hand if metadata.hand != EMPTY else Bilingual(hand, hand),
        material=Bilingual(
            zh="數位字形繪成的圖像（無紙無墨，非原跡照片）",
            en="picture drawn from a digital letterform (no paper, no ink; not a photograph of an original)",
        ),
        source=metadata.source or " ".join(filter(None, (family, face.name("version"), face.path.name))),
        licence=licence or NO_LICENCE,
        attribution=metadata.attribution or face.name("copyright"),
        origin=f"{face.path.name} U+{ord(character):04X}",
    )
