"""Which file of a capture folder tells the lamps."""

from __future__ import annotations

import re
from pathlib import Path

from rumu.capture.description import DESCRIPTION, Description
from rumu.capture.photographs import FolderImages, capture_error, files, folders

TABLE_SUFFIXES = (".csv", ".tsv")
"""Of tables of lamps."""
LAMP_SUFFIXES = (".lp", ".dome", ".txt", ".json", *TABLE_SUFFIXES)
"""Of files that say where lamps stood."""
_KINDS = (r".+\.lp(\.txt)?", r".+\.dome", r"light_directions.*\.txt")
_TABLES = (r"(lamp|light|led)s?([ _-]?(direction|position)s?)?\.(csv|tsv)(\.txt)?", r".+\.(csv|tsv)(\.txt)?")
_BOOKS = r".+\.(xlsx?|ods|numbers)"
_MARKER = "surface.json"


def split_path(path: Path) -> tuple[Path, Path | None]:
    """The folder of a capture, and the file in it when that was given.

    Raises CaptureError for what is neither.
    """
    if path.is_dir():
        return path, None
    if not path.exists():
        raise capture_error(
            path,
            en="expected a capture folder or its .lp file, there is no such file",
            zh="這裡應是多燈照片的資料夾或其中的 .lp 檔，卻找不到",
        )
    if path.suffix.lower() in LAMP_SUFFIXES:
        return path.parent, path
    raise capture_error(
        path,
        en="expected a capture folder or its .lp file, got another kind of file",
        zh="這裡應是多燈照片的資料夾或其中的 .lp 檔，卻是別種檔案",
    )


def kind_of(file: Path) -> str:
    """The suffix that says how a file of lamps is read; Windows hides a .txt that an editor hung on it."""
    suffixes = [one.lower() for one in file.suffixes[-2:]]
    hidden = len(suffixes) == 2 and suffixes[1] == ".txt" and suffixes[0] in (".lp", *TABLE_SUFFIXES)
    return suffixes[0] if hidden else file.suffix.lower()


def lamp_file(images: FolderImages, description: Description) -> Path:
    """The file that tells the lamps: .lp, .dome, light_directions.txt, capture.json with a slant, a table.

    Where the folder has none, the .lp of one of its folders, as RTIBuilder and other programs keep lamps
    (assembly-files) and photographs (jpeg-exports) side by side.
    Raises CaptureError when there is none, or several of a kind.
    """
    folder = images.folder
    for kind in _KINDS:
        found = _named(kind, [folder], images)
        if found:
            return _one(folder, found)
    if description.slant is not None:
        return folder / DESCRIPTION
    for kind in _TABLES:
        found = _named(kind, [folder], images)
        if found:
            return _one(folder, found)
    within = lamp_files_within(images)
    if within:
        return _one(folder, within)
    books = ", ".join(book.name for book in _named(_BOOKS, [folder], images))
    raise capture_error(
        folder,
        en=f"expected an .lp file, light_directions.txt, a .csv of lamps, or {DESCRIPTION} with a slant, "
        f"found {books + ', a workbook: save it as CSV UTF-8' if books else 'none'}; without "
        "them, reconstruct takes --card, --sphere auto, or --lamps-unknown",
        zh=f"這裡應有 .lp 檔、light_directions.txt、燈位表 .csv，或寫有 slant 的 {DESCRIPTION}，"
        f"卻{'只有活頁簿 ' + books + '（請另存為 CSV UTF-8）' if books else '都沒有'}；"
        "沒有這些檔案時，reconstruct 可用 --card、--sphere auto 或 --lamps-unknown",
    )


def lamp_files_within(images: FolderImages) -> list[Path]:
    """Each .lp in a folder of the capture, but those beside a surface that was made of one."""
    places = [place for place in folders(images.folder) if not (place / _MARKER).exists()]
    return _named(_KINDS[0], places, images)


def _named(kind: str, places: list[Path], images: FolderImages) -> list[Path]:
    """The files of these folders whose name is of a kind."""
    found = [p for place in places for p in files(place) if re.fullmatch(kind, p.name, re.IGNORECASE)]
    return [p for p in found if images.may_read(p)]


def _one(folder: Path, found: list[Path]) -> Path:
    if len(found) > 1:
        names = ", ".join(p.relative_to(folder).as_posix() for p in found)
        raise capture_error(
            folder,
            en=f"found {names}; expected one, or the path of the one to use",
            zh=f"有 {names}；應只有一個，或指明要用哪一個",
        )
    return found[0]
