"""Add one work to the gallery: from a picture, from photographs under several lamps, or from a font.

Files are written before the row that names them, so that a work is complete or absent. Files that an
interrupted run leaves in the store are named by their content; the next run uses them, or `delete_orphans`
deletes them.
"""

from __future__ import annotations

import io
import json
import shutil
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any, get_args

from sqlalchemy import select

from rumu.database.tables import Work
from rumu.errors import GalleryError
from rumu.gallery.assets import (
    capture_key,
    folder_digest,
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
    from rumu.values import Capture

SUFFIXES = (
    ".png", ".jpg", ".jpeg", ".mpo", ".webp", ".heic", ".heif", ".avif", ".tif", ".tiff", ".bmp", ".gif",
    ".pgm", ".ppm", ".exr",
)  # fmt: skip
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
    return _add_picture_bytes(
        gallery,
        path.read_bytes(),
        size=(columns, rows),
        suffix=store_suffix(path),
        metadata=replace(metadata, origin=metadata.origin or path.name),
        collection=collection,
        height_source=method,
        spacing=spacing,
    )


def add_capture(
    gallery: Gallery,
    path: str | Path,
    *,
    metadata: WorkMetadata,
    collection: CollectionMetadata = OWN_WORKS,
    solver: str = "robust",
    rectify: str = "none",
    within: Path | None = None,
) -> AddedWork:
    """Reconstruct a capture folder (see `read_capture`) and add photographs, lamps and surface as a work.

    The picture of the work is the mean of its photographs. within: the folder of an upload, which alone is
    read. Raises CaptureError, ImageError or SurfaceError.
    """
    from rumu.capture.folder import read_capture
    from rumu.pipeline import reconstruct
    from rumu.surface.frame_check import exposure_notes

    path = Path(path)
    capture = read_capture(path, within=within)
    folder = path if path.is_dir() else path.parent
    with temporary_folder() as temporary:
        photographs = temporary / "capture"
        capture_digest = _copy_capture(capture, folder, photographs)
        surface = reconstruct(read_capture(photographs, within=photographs), solver=solver, rectify=rectify)
        photographs_key = capture_key(capture_digest)
        reconstructed = surface_key(capture_digest, solver=solver, rectify=rectify)
        with gallery.store.whole_folder(photographs_key):
            store_files(gallery.store, photographs_key, sorted(photographs.iterdir()))
            store_surface(gallery.store, reconstructed, surface)
    picture = _mean_photograph(capture)
    key = picture_key(picture, suffix=".png")
    gallery.store.write(key, picture)
    stored = StoredFiles(
        picture=key,
        digest=metadata.digest(PurePosixPath(reconstructed).name),
        width=surface.height.shape[1],
        height=surface.height.shape[0],
        kind="capture",
        height_source=surface.source,
        surface=reconstructed,
        capture=photographs_key,
        spacing=capture.spacing,
    )
    metadata = replace(metadata, origin=metadata.origin or folder.name)
    added = add_stored_work(gallery, metadata, stored, collection=collection)
    return replace(added, notes=(*capture.notes, *exposure_notes(capture, surface)))


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
    return tuple(
        _add_picture_bytes(
            gallery,
            data,
            size=(SIDE, SIDE),
            suffix=".png",
            metadata=_glyph_metadata(metadata, face, character),
            collection=collection,
        )
        for character, data in zip(wanted, pictures, strict=True)
    )


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
    return suffix if suffix in SUFFIXES else ".image"


def _add_picture_bytes(
    gallery: Gallery,
    data: bytes,
    *,
    size: tuple[int, int],
    suffix: str,
    metadata: WorkMetadata,
    collection: CollectionMetadata,
    height_source: str = "inflation",
    spacing: float | None = None,
) -> AddedWork:
    key = picture_key(data, suffix=suffix)
    gallery.store.write(key, data)
    stored = StoredFiles(
        picture=key,
        digest=metadata.digest(data),
        width=size[0],
        height=size[1],
        height_source=height_source,
        spacing=spacing,
    )
    return add_stored_work(gallery, metadata, stored, collection=collection)


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


# --- captures --------------------------------------------------------------------------------------


def _copy_capture(capture: Capture, folder: Path, target: Path) -> str:
    """Copy the photographs under plain names, with all that is needed to read them again; the digest of all.

    A capture may name files anywhere and in any script. The copy in the store has photographs, lights.lp (of
    lamps near the sheet lights.dome, which tells their places), mask.png, ambient and capture.json in one
    folder; names.json holds the original names.
    """
    import numpy as np
    from PIL import Image

    from rumu.capture.description import description_of
    from rumu.capture.dome import dome_text

    target.mkdir(parents=True)
    names, lines = {}, [str(len(capture.names))]
    told = capture.lights
    if capture.strengths is not None:
        told = np.column_stack([told, capture.strengths])
    for number, (name, values) in enumerate(zip(capture.names, told, strict=True), start=1):
        plain = f"{number:03d}{Path(name).suffix.lower()}"
        shutil.copyfile(folder / name, target / plain)
        names[plain] = Path(name).name
        lines.append(f"{plain} " + " ".join(f"{value:.9g}" for value in values))
    if capture.positions is None:
        (target / "lights.lp").write_text("\n".join(lines) + "\n", encoding="utf-8")
    else:  # the photographs are numbered in the order of the lamps, which is how a .dome names them
        spacing, columns = capture.spacing or 1.0, capture.mask.shape[1]
        text = dome_text(capture.positions, capture.strengths, spacing=spacing, columns=columns)
        (target / "lights.dome").write_text(text, encoding="utf-8")
    (target / "names.json").write_text(json.dumps(names, ensure_ascii=False), encoding="utf-8")
    if not capture.mask.all():
        Image.fromarray(capture.mask.astype(np.uint8) * 255).save(target / "mask.png")
    for dark in sorted(folder.glob("[aA]mbient.*")):
        shutil.copyfile(dark, target / f"ambient{dark.suffix.lower()}")
    description: dict[str, Any] = {"spacing_mm": capture.spacing, "orientation": capture.orientation}
    description["lamps_as_given"] = capture.lamps_as_given or None
    description = {key: value for key, value in description.items() if value is not None}
    encoding = description_of(folder).encoding
    description |= {} if encoding is None else {"encoding": encoding}
    (target / "capture.json").write_text(json.dumps(description), encoding="utf-8")
    return folder_digest({file.name: file for file in target.iterdir()})


def _mean_photograph(capture: Capture) -> bytes:
    import numpy as np
    from PIL import Image

    from rumu.surface.mesh import albedo_srgb

    mean = np.zeros(capture.photographs.shape[1:], np.float32)
    for photograph in capture.photographs:
        mean += photograph / np.float32(len(capture.photographs))
    bright = float(np.percentile(mean[capture.mask], 99.5)) or 1.0
    png = io.BytesIO()
    Image.fromarray(albedo_srgb(np.clip(mean / bright, 0, 1))).save(png, "PNG", optimize=True)
    return png.getvalue()
