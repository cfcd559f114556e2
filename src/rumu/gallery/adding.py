"""One work more: from a picture, from photographs under several lamps, or from a font.

The files are written before the row that names them, so a work is there whole or not at all; what an
interrupted run leaves in the store is named by its content, found again by the next, and harmless.
"""

from __future__ import annotations

import hashlib
import io
import json
import shutil
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args

from sqlalchemy import func, select

from rumu.database.tables import Work
from rumu.errors import GalleryError
from rumu.gallery.entries import (
    NO_LICENCE,
    NOTHING,
    Entry,
    Kept,
    Room,
    digest_of,
    put_collection,
    put_works,
    slug,
    work_row,
)
from rumu.gallery.gallery import Gallery
from rumu.gallery.originals import picture_key
from rumu.gallery.store import Store
from rumu.values import Bilingual

if TYPE_CHECKING:
    from rumu.gallery.fonts import Face
    from rumu.values import Capture, Surface

SUFFIXES = (".png", ".jpg", ".jpeg", ".webp", ".tif", ".tiff", ".bmp", ".gif", ".pgm", ".ppm", ".exr")
OWN_WORKS = Room(id="own", title=Bilingual(zh="自己收入", en="Added here"))

_OF_SURFACE = ("height.tif", "normals.tif", "albedo.tif", "confidence.tif", "mask.png", "surface.json")


@dataclass(frozen=True, slots=True)
class Added:
    """id: of the work. new: False when the same content under the same label was there before."""

    id: str
    new: bool


def add_picture(
    gallery: Gallery,
    path: str | Path,
    *,
    entry: Entry,
    room: Room = OWN_WORKS,
    method: str = "inflation",
    spacing: float | None = None,
) -> Added:
    """Keep one picture as a work; its height is computed from its ink whenever it is asked for.

    method: 'inflation' or 'density', how. spacing: millimetres per pixel, None unknown.
    Raises ImageError for what is no picture, RefusedImage where there is no writing in it, SurfaceError for
    another method.
    """
    from rumu.surface.relief import Method, check_choice, read_with_ink

    path = Path(path)
    check_choice(method, get_args(Method), "method")
    rows, columns = read_with_ink(path)[0].shape[:2]  # a sheet without writing is refused now
    return _keep_picture(
        gallery,
        path.read_bytes(),
        size=(columns, rows),
        suffix=suffix_of(path),
        entry=replace(entry, origin=entry.origin or path.name),
        room=room,
        height_source=method,
        spacing=spacing,
    )


def add_capture(
    gallery: Gallery,
    path: str | Path,
    *,
    entry: Entry,
    room: Room = OWN_WORKS,
    solver: str = "robust",
    rectify: str = "none",
) -> Added:
    """Reconstruct a capture folder (see `read_capture`) and keep photographs, lamps and surface as a work.

    The picture of the work is the mean of its photographs. Raises CaptureError, ImageError or SurfaceError.
    """
    from rumu.capture.folder import read_capture
    from rumu.pipeline import reconstruct

    path = Path(path)
    capture = read_capture(path)
    folder = path if path.is_dir() else path.parent
    with tempfile.TemporaryDirectory(prefix="rumu-") as place:
        photographs, reconstructed = Path(place) / "capture", Path(place) / "surface"
        content = _copy_capture(capture, folder, photographs)
        surface = reconstruct(read_capture(photographs), solver=solver, rectify=rectify)
        _write_surface(surface, reconstructed)
        picture = _mean_photograph(capture)
        made = hashlib.sha256(f"{content} {solver} {rectify}".encode()).hexdigest()
        keys = f"captures/{content[:2]}/{content}", f"surfaces/{made[:2]}/{made}"
        for key, files in zip(keys, (photographs, reconstructed), strict=True):
            _put_folder(gallery.store, files, key)
    key = picture_key(picture, suffix=".png")
    gallery.store.write(key, picture)
    kept = Kept(
        picture=key,
        digest=digest_of(made, *_label(entry)),
        width=surface.height.shape[1],
        height=surface.height.shape[0],
        kind="capture",
        height_source=surface.source,
        surface=keys[1],
        capture=keys[0],
        spacing=capture.spacing,
    )
    return keep(gallery, replace(entry, origin=entry.origin or folder.name), kept, room=room)


def add_glyphs(
    gallery: Gallery, font: str | Path, characters: Iterable[str], *, entry: Entry, room: Room = OWN_WORKS
) -> tuple[Added, ...]:
    """Keep a font's drawings of characters as works, all or none; what entry does not say the font may.

    Raises GalleryError when there is no such font, or it lacks one of the characters, whatever it claims.
    """
    from rumu.gallery.fonts import SIDE, Face

    face = Face(Path(font))
    wanted = tuple(dict.fromkeys(character for character in characters if not character.isspace()))
    if not wanted:
        raise GalleryError("expected characters to take from the font, got none")
    drawn = []
    for character in wanted:
        packed = io.BytesIO()
        face.picture(character).save(packed, "PNG", optimize=True)
        drawn.append(packed.getvalue())
    return tuple(
        _keep_picture(
            gallery,
            data,
            size=(SIDE, SIDE),
            suffix=".png",
            entry=_of_font(entry, face, character),
            room=room,
        )
        for character, data in zip(wanted, drawn, strict=True)
    )


def keep(gallery: Gallery, entry: Entry, kept: Kept, *, room: Room) -> Added:
    """Put the row of a work whose files are in the store, last in its collection; the one there is, if it
    is."""
    work_id = f"{room.id}-{kept.digest[:12]}"
    with gallery.database.writing() as session:
        put_collection(session, room)
        found = session.scalar(select(Work.id).where(Work.digest == kept.digest))
        if found is not None:
            return Added(found, new=False)
        last = session.scalar(select(func.max(Work.position)).where(Work.collection_id == room.id))
        position = 0 if last is None else last + 1
        row = work_row(entry, kept, work_id=work_id, room=room, position=position)
        return Added(work_id, new=bool(put_works(session, [row])))


def room_named(collection: str | None, *, title: Bilingual | None = None, **facts: Any) -> Room:
    """The collection of a name that a person gave; its id is an ASCII slug of that."""
    if collection is None:
        return OWN_WORKS
    return Room(
        id=slug(collection, otherwise="collection"), title=title or Bilingual(collection, collection), **facts
    )


def suffix_of(path: Path) -> str:
    """The end of a picture's name in the store: one that is known, lower case."""
    suffix = path.suffix.lower()
    return suffix if suffix in SUFFIXES else ".image"


def _label(entry: Entry) -> tuple[str, ...]:
    return (entry.character, entry.script, entry.hand.zh, entry.hand.en, entry.title.zh)


def _keep_picture(
    gallery: Gallery,
    data: bytes,
    *,
    size: tuple[int, int],
    suffix: str,
    entry: Entry,
    room: Room,
    height_source: str = "inflation",
    spacing: float | None = None,
) -> Added:
    key = picture_key(data, suffix=suffix)
    gallery.store.write(key, data)
    kept = Kept(
        picture=key,
        digest=digest_of(data, *_label(entry)),
        width=size[0],
        height=size[1],
        height_source=height_source,
        spacing=spacing,
    )
    return keep(gallery, entry, kept, room=room)


def _of_font(entry: Entry, face: Face, character: str) -> Entry:
    family = face.says("family") or face.path.stem
    drawn_by = face.says("designer")
    designer = f"{drawn_by} ({family})" if drawn_by else family
    name = (
        entry.title
        if entry.title != NOTHING
        else Bilingual(f"{family}「{character}」", f"{character}, {family}")
    )
    return replace(
        entry,
        title=name,
        character=character,
        hand=entry.hand if entry.hand != NOTHING else Bilingual(designer, designer),
        material=Bilingual(
            zh="數位字形繪成的圖像（無紙無墨，非原跡照片）",
            en="picture drawn from a digital letterform (no paper, no ink; not a photograph of an original)",
        ),
        source=entry.source or " ".join(filter(None, (family, face.says("version"), face.path.name))),
        licence=entry.licence if entry.licence != NO_LICENCE else face.says("licence")[:200] or NO_LICENCE,
        attribution=entry.attribution or face.says("copyright"),
        origin=f"{face.path.name} U+{ord(character):04X}",
    )


# --- captures --------------------------------------------------------------------------------------


def _copy_capture(capture: Capture, folder: Path, target: Path) -> str:
    """Write the photographs under plain names, with all that is needed to read them again; the digest of all.

    A capture may name files anywhere and in any script; the store's own copy is photographs, lights.lp,
    mask.png, ambient and capture.json side by side. names.json keeps what the files were called.
    """
    import numpy as np
    from PIL import Image

    target.mkdir(parents=True)
    names, lines = {}, [str(len(capture.names))]
    for number, (name, light) in enumerate(zip(capture.names, capture.lights, strict=True), start=1):
        plain = f"{number:03d}{Path(name).suffix.lower()}"
        shutil.copyfile(folder / name, target / plain)
        names[plain] = Path(name).name
        lines.append(f"{plain} " + " ".join(f"{value:.9g}" for value in light))
    (target / "lights.lp").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (target / "names.json").write_text(json.dumps(names, ensure_ascii=False), encoding="utf-8")
    if not capture.mask.all():
        Image.fromarray(capture.mask.astype(np.uint8) * 255).save(target / "mask.png")
    for dark in sorted(folder.glob("[aA]mbient.*")):
        shutil.copyfile(dark, target / f"ambient{dark.suffix.lower()}")
    (target / "capture.json").write_text(json.dumps(_description(capture, folder)), encoding="utf-8")
    kept = hashlib.sha256()
    for file in sorted(target.iterdir()):
        kept.update(file.name.encode() + b"\0" + hashlib.sha256(file.read_bytes()).digest())
    return kept.hexdigest()


def _description(capture: Capture, folder: Path) -> dict[str, Any]:
    from rumu.capture.light_files import read_description

    told = {} if capture.spacing is None else {"spacing_mm": capture.spacing}
    if (folder / "capture.json").is_file():
        encoding = read_description(folder / "capture.json").encoding
        return told | ({} if encoding is None else {"encoding": encoding})
    return told


def _write_surface(surface: Surface, folder: Path) -> None:
    """What reading it needs; pictures and meshes are made when they are asked for."""
    from rumu.surface.folder import write_surface

    write_surface(surface, folder)
    for file in folder.iterdir():
        if file.name not in _OF_SURFACE:
            file.unlink()


def _mean_photograph(capture: Capture) -> bytes:
    import numpy as np
    from PIL import Image

    from rumu.surface.mesh import albedo_srgb

    mean = capture.images.mean(axis=0)
    bright = float(np.percentile(mean[capture.mask], 99.5)) or 1.0
    packed = io.BytesIO()
    Image.fromarray(albedo_srgb(np.clip(mean / bright, 0, 1))).save(packed, "PNG", optimize=True)
    return packed.getvalue()


def _put_folder(store: Store, folder: Path, key: str) -> None:
    for file in sorted(folder.iterdir()):
        store.write(f"{key}/{file.name}", file.read_bytes())
