"""Whose writing a practice sheet shows: strokes of copybooks, works, pictures of a folder, a font.

The code of a sheet names its masters. Strokes and starter works are part of the package; other masters are
kept in RUMU_HOME under the digest of their pictures, so that a sheet is read against what was printed.
"""

from __future__ import annotations

import functools
import hashlib
import io
import json
import zipfile
import zlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from rumu.errors import GalleryError, RumuError
from rumu.values import SCRIPTS, Script

if TYPE_CHECKING:
    from rumu.database.tables import Work
    from rumu.gallery.store import Store

STROKES = "strokes"
"""The name of the strokes that copybooks print, of 9,574 characters."""
SIDE = 512  # pixels of a master's picture
SHARE = 0.76  # of the side that the longer side of its ink fills
STROKES_SHARE = 0.84  # of the cell that the square of the copybooks' strokes fills
AREA = 0.42  # of the picture that the box of the ink may cover, or 日 would look too large beside others
_FOLDER = "sheets"  # in RUMU_HOME
_FONTS = frozenset({".ttf", ".otf", ".ttc", ".woff", ".woff2"})
_MOST = 32 * 2**20  # bytes of a file of masters
_DATE = (1980, 1, 1, 0, 0, 0)  # of every file in it: equal pictures give equal files

Gray = npt.NDArray[np.uint8]
FindMasters = Callable[[str], "dict[str, SheetMaster]"]
"""Those masters of a text that a source has, by character."""
Place = tuple[float, float, float, float]
SAME_PLACE: Place = (1.0, 1.0, 0.0, 0.0)


class MissingMasters(GalleryError):  # noqa: N818
    """No source has a master of some characters."""

    def __init__(self, characters: str, en: str = "", *, zh: str | None = None) -> None:
        super().__init__(en, zh=zh)
        self.characters = characters


@dataclass(frozen=True, slots=True, eq=False)
class SheetMaster:
    """What is copied: one character.

    picture: (SIDE, SIDE) gray, black ink on white, the whole cell. work: id of the work that it shows, ""
    where it is of none. in_work: (sx, sy, tx, ty), by which fractions (x, y) of the cell are fractions
    (sx x + tx, sy y + ty) of the work's picture.
    """

    character: str
    picture: Gray
    script: Script | None = None
    work: str = ""
    in_work: Place = SAME_PLACE

    @property
    def ink(self) -> npt.NDArray[np.float32]:
        """(SIDE, SIDE): 1 on ink, 0 on paper."""
        return np.asarray(1 - self.picture.astype(np.float32) / 255, np.float32)


@dataclass(frozen=True)
class SheetMasters:
    """The masters of a sheet, by character. name: by which the code of the sheet names them."""

    name: str
    by_character: Mapping[str, SheetMaster]

    @cached_property
    def shapes(self) -> dict[str, Any]:
        """Their shapes as a sheet prints them, by character."""
        from rumu.characters.stroke_data import STROKE_SCRIPTS
        from rumu.pages.sheet_models import MasterShape

        return {
            character: MasterShape(master.ink, in_strokes=master.script in STROKE_SCRIPTS)
            for character, master in self.by_character.items()
        }


def choose_masters(text: str, sources: Sequence[str] = (), *, script: Script | None = None) -> SheetMasters:
    """The masters of the characters of a text, from the first of the sources that has each.

    sources: 'strokes' (the strokes of copybooks; where nothing is given), a script ('regular': starter
        works), the id of a work or of a collection of the gallery, a font, a picture (of the one character),
        a folder of pictures or a labels.csv. script: of fonts and pictures, which do not say it.
    Raises GalleryError that names the characters that no source has.
    """
    names = tuple(sources) or (STROKES,)
    return gather_masters(text, {name: functools.partial(_find, name, script=script) for name in names})


def gather_masters(text: str, sources: Mapping[str, FindMasters]) -> SheetMasters:
    """The masters of the characters of a text, from the first source that has each.

    sources: by name, each finds those masters of a text that it has. Raises MissingMasters.
    """
    chosen: dict[str, SheetMaster] = {}
    wanted = "".join(dict.fromkeys(text))
    for find in sources.values():
        left = "".join(character for character in wanted if character not in chosen)
        if left:
            chosen |= find(left)
    missing = "".join(character for character in wanted if character not in chosen)
    names = tuple(sources)
    if missing:
        raise MissingMasters(
            missing,
            f"no master of {missing} in {', '.join(names)}; --master strokes has 9,574 characters, "
            "and may be given after another",
            zh=f"{'、'.join(names)} 裡沒有「{missing}」的範字。",
        )
    if len(names) == 1 and (names[0] == STROKES or names[0] in SCRIPTS):
        return SheetMasters(names[0], chosen)
    return _keep(chosen)


def open_masters(name: str, text: str) -> SheetMasters:
    """The masters that a sheet's code names, of the characters of a text.

    Raises GalleryError when they are not kept on this machine.
    """
    if name == STROKES or name in SCRIPTS:
        return choose_masters(text, (name,))
    path = masters_file(name)
    if not path.is_file():
        raise GalleryError(
            f"the sheet's masters are not on this machine: expected {path}, which `rumu sheet` wrote "
            "where the sheet was printed",
            zh="這台電腦上沒有這張練習紙的範字；請在印練習紙的電腦上讀，或把那裡存的範字檔複製過來。",
        )
    return SheetMasters(name, _read_bundle(path, text))


def masters_file(name: str) -> Path:
    """Where masters of this name are kept. Raises GalleryError for a name that is none of ours."""
    from rumu.homes import user_home

    if not name.startswith("#") or not name[1:].isalnum():
        raise GalleryError(f"expected masters of a sheet, got {name!r}")
    return user_home() / _FOLDER / f"masters-{name[1:]}.zip"


# --- sources ---------------------------------------------------------------------------------------


def _find(name: str, text: str, *, script: Script | None) -> dict[str, SheetMaster]:
    """Those masters of a text that one source has."""
    if name == STROKES:
        return masters_of_strokes(text)
    if name in SCRIPTS:
        return masters_of_starter(name, text)
    path = Path(name)
    if path.suffix.lower() in _FONTS and path.is_file():
        return _from_font(path, text, script)
    if path.is_dir() or (path.suffix.lower() == ".csv" and path.is_file()):
        return _from_folder(path, text, script)
    if path.is_file():
        if len(text) > 1:
            raise GalleryError(
                f"{name}: expected a sheet of the one character that the picture shows, got {text}; "
                "give a folder whose pictures are named by their characters"
            )
        return {text: _of_picture(text, path, script)}
    return _from_gallery(name, text)


def masters_of_strokes(text: str) -> dict[str, SheetMaster]:
    """The characters of a text as the strokes of copybooks, those that are known."""
    import cv2

    from rumu.characters.stroke_data import find_character

    masters = {}
    for letter in text:
        known = find_character(letter)
        if known is None:
            continue
        big = np.zeros((4 * SIDE, 4 * SIDE), np.uint8)
        for stroke in known.strokes:  # one by one: where two cross, ink stays ink
            within = (stroke.polygon() - 0.5) * STROKES_SHARE + 0.5
            cv2.fillPoly(big, [np.round(within * 4 * SIDE).astype(np.int32)], 255)
        ink = cv2.resize(big, (SIDE, SIDE), interpolation=cv2.INTER_AREA)
        masters[letter] = SheetMaster(letter, np.asarray(255 - ink, np.uint8), "regular")
    return masters


def masters_of_starter(script: str, text: str) -> dict[str, SheetMaster]:
    """The characters of a text that the starter works of a script have."""
    from rumu.gallery.starter import starter_works

    works = {work.character: work for work in starter_works(script=script)}
    return {c: _of_picture(c, works[c].path, works[c].script, works[c].id) for c in text if c in works}


def masters_of_works(works: Iterable[Work], store: Store, text: str) -> dict[str, SheetMaster]:
    """The characters of a text that works of the gallery have, each from the first that has it."""
    masters: dict[str, SheetMaster] = {}
    for one in works:
        if len(one.character) == 1 and one.character in text and one.character not in masters:
            script = one.script if one.script in SCRIPTS else None
            with store.local(one.picture) as path:
                masters[one.character] = _of_picture(one.character, path, script, one.id)  # type: ignore[arg-type]
    return masters


def _from_font(path: Path, text: str, script: Script | None) -> dict[str, SheetMaster]:
    from rumu.gallery.fonts import Face

    face, masters = Face(path), {}
    for letter in text:
        try:
            picture = np.asarray(face.picture(letter), np.uint8)
        except GalleryError:
            continue  # told of together with all that are missing
        masters[letter] = SheetMaster(letter, picture, script)
    return masters


def _from_folder(path: Path, text: str, script: Script | None) -> dict[str, SheetMaster]:
    from rumu.gallery.masters import read_masters

    pictures: dict[str, Path] = {}
    for master in read_masters(path):
        pictures.setdefault(master.character or master.path.stem, master.path)
    return {c: _of_picture(c, pictures[c], script) for c in text if c in pictures}


def _from_gallery(name: str, text: str) -> dict[str, SheetMaster]:
    from rumu.gallery.catalog import open_gallery, work, works

    gallery = open_gallery()
    found = works(gallery, collection=name, limit=100_000).items
    if not found:
        try:
            found = (work(gallery, name),)
        except GalleryError as error:
            raise GalleryError(f"{name}: there is no such file or folder, and {error}") from error
    return masters_of_works(found, gallery.store, text)


def _of_picture(character: str, picture: Path, script: Script | None, work: str = "") -> SheetMaster:
    """A master from a picture of it, wherever it stands there."""
    centred, place = _centred(picture)
    return SheetMaster(character, centred, script, work, place)


def _centred(picture: Path) -> tuple[Gray, Place]:
    """The ink of a picture, black on white in the middle of the cell, sized as masters are; its place."""
    import cv2

    from rumu.capture.image import bounding_box
    from rumu.surface.relief import read_with_ink

    ink = read_with_ink(picture)[1]
    y0, y1, x0, x1 = bounding_box(ink.mask)
    height, width = y1 - y0, x1 - x0
    factor = min(SHARE * SIDE / max(width, height), (AREA * SIDE * SIDE / (width * height)) ** 0.5)
    place = np.array(
        [
            [factor, 0, (SIDE - 1) / 2 - factor * (x0 + (width - 1) / 2)],
            [0, factor, (SIDE - 1) / 2 - factor * (y0 + (height - 1) / 2)],
        ]
    )
    shown = np.where(ink.mask, 255, 0).astype(np.uint8)
    if factor < 1:  # area averaging, which a warp does not do
        shown = cv2.GaussianBlur(shown, (0, 0), 0.5 / factor)
    drawn = cv2.warpAffine(shown, place, (SIDE, SIDE), flags=cv2.INTER_CUBIC)
    tall, wide = ink.mask.shape
    in_work = (
        SIDE / (factor * wide),
        SIDE / (factor * tall),
        (0.5 - (0.5 + place[0, 2]) / factor) / wide,
        (0.5 - (0.5 + place[1, 2]) / factor) / tall,
    )
    return np.asarray(255 - drawn, np.uint8), in_work


# --- masters that are kept -------------------------------------------------------------------------


def _keep(masters: dict[str, SheetMaster]) -> SheetMasters:
    """Keep masters under the digest of their pictures."""
    from PIL import Image

    from rumu.outputs import whole_file

    files: dict[str, bytes] = {}
    listed = []
    for character, master in sorted(masters.items()):
        stream = io.BytesIO()
        Image.fromarray(master.picture).save(stream, "PNG")
        files[f"{ord(character):x}.png"] = stream.getvalue()
        pixels = hashlib.sha256(master.picture.tobytes()).hexdigest()
        facts: dict[str, Any] = {"character": character, "script": master.script, "sha256": pixels}
        if master.work:
            facts |= {"work": master.work, "in_work": [round(value, 6) for value in master.in_work]}
        listed.append(facts)
    table = json.dumps(listed, ensure_ascii=False).encode()
    files["masters.json"] = table
    name = "#" + hashlib.sha256(table).hexdigest()[:8]
    path = masters_file(name)
    if not path.is_file():
        with whole_file(path) as part, zipfile.ZipFile(part, "w") as archive:
            for file, data in files.items():
                archive.writestr(zipfile.ZipInfo(file, _DATE), data)
    return SheetMasters(name, masters)


def _read_bundle(path: Path, text: str) -> dict[str, SheetMaster]:
    """Those kept masters that are among the characters of a text; pictures of others are not decoded."""
    from PIL import Image

    from rumu.inputs import read_file

    data = read_file(path, error_type=GalleryError, expected="masters of a sheet", most=_MOST)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            masters = {}
            for entry in json.loads(archive.read("masters.json")):
                letter = str(entry["character"])
                if letter not in text:
                    continue
                with Image.open(io.BytesIO(archive.read(f"{ord(letter):x}.png")), formats=["PNG"]) as picture:
                    if picture.size != (SIDE, SIDE):
                        raise ValueError(f"a picture of {picture.size}")
                    shown = np.asarray(picture.convert("L"))
                sx, sy, tx, ty = map(float, entry.get("in_work", SAME_PLACE))
                work = str(entry.get("work", ""))
                masters[letter] = SheetMaster(letter, shown, entry["script"], work, (sx, sy, tx, ty))
            return masters
    except (OSError, ValueError, KeyError, TypeError, RumuError, zipfile.BadZipFile, zlib.error) as error:
        raise GalleryError(f"{path}: expected masters of a sheet, cannot read them ({error})") from error
