"""Which files of a capture folder are photographs, and which one a lamp file means by a name.

Lamp files come from other machines and other programs: they hold paths of a disk that is not here, names in
another case or with accents composed otherwise, and names of the raw files that were developed since.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Collection, Sequence
from functools import cached_property
from pathlib import Path, PurePath, PurePosixPath

from rumu.capture.formats import RAW_SUFFIXES
from rumu.containment import FolderFiles
from rumu.errors import CaptureError
from rumu.values import Bilingual

PICTURE_SUFFIXES = (
    ".png", ".jpg", ".jpeg", ".jpe", ".jfif", ".mpo", ".tif", ".tiff", ".exr", ".webp", ".heic", ".heif",
    ".avif", ".bmp", ".gif", ".pgm", ".ppm",
)  # fmt: skip
"""What ends the names of pictures that are read, in a folder that holds other files, too."""
SUFFIX = re.compile(r"\.[A-Za-z][A-Za-z0-9]{1,4}$")
"""What ends the name of a file of any kind; not the .1 of `shot.1`."""
FLAT = re.compile(r"flat([ _-]?(field|frame))?s?", re.IGNORECASE)
"""What a flat-field frame is called, without its suffix; it is no photograph of the sheet."""
_ASIDE = re.compile(r"(.*\.)?(mask|ambient)|normals?(_gt)?", re.IGNORECASE)
_LISTED = 3  # images that a message names


def place(path: Path, line: int | None = None) -> Bilingual:
    """Where a fault is: the file's name, without the folders above it, and the line, counted from 1."""
    name = path.name or path.resolve().name
    return Bilingual(name, name) if line is None else Bilingual(f"{name} 第 {line} 行", f"{name} line {line}")


def capture_error(where: Bilingual | Path, *, en: str, zh: str) -> CaptureError:
    """The error that begins with where the fault is."""
    at = place(where) if isinstance(where, Path) else where
    return CaptureError(f"{at.en}: {en}", zh=f"{at.zh}：{zh}。")


class FolderImages:
    """The images of one capture folder, found by what a lamp file calls them.

    within: a folder outside which nothing is read, such as that of an upload; None where that is allowed.
    """

    def __init__(self, folder: Path, *, within: Path | None = None) -> None:
        self.folder = folder
        self._within = None if within is None else FolderFiles(within)
        self._listings: dict[Path, list[Path]] = {}

    def check_links(self) -> None:
        """Raise CaptureError for a link in the folder of an upload that leads out of it."""
        for path in self.folder.iterdir() if self._within is not None else ():
            if path.is_symlink() and not self.may_read(path):
                raise capture_error(path, en="leads out of the capture", zh="指向這組照片以外的檔案")

    def may_read(self, path: Path) -> bool:
        """Whether this is a file, and one that may be read."""
        if self._within is not None:
            return self._within.holds(path)
        try:
            return path.is_file()
        except (OSError, ValueError):  # such as a name that is too long
            return False

    @cached_property
    def photographs(self) -> list[Path]:
        """Images in natural order (2 before 10) but masks, the ambient and flat-field frames, normal maps."""
        return self.photographs_in(self.folder)

    def photographs_in(self, folder: Path) -> list[Path]:
        """The same of another folder."""
        return sorted(
            (p for p in self.images(folder) if not (_ASIDE.fullmatch(p.stem) or FLAT.fullmatch(p.stem))),
            key=lambda p: [(text, int(digits or 0)) for text, digits in re.findall(r"(\D*)(\d*)", p.name)],
        )

    @cached_property
    def _raw_files(self) -> list[Path]:
        """Raw files of a camera in the folder."""
        return [p for p in files(self.folder) if p.suffix.lower() in RAW_SUFFIXES]

    def besides(self, found: Collection[Path]) -> list[Path]:
        """The photographs that lie in one folder with those found and are as they by their suffix."""
        kinds = {(path.parent, path.suffix.lower()) for path in found}
        places = sorted({path.parent for path in found})
        beside = [path for place in places for path in self.photographs_in(place)]
        known = {path.resolve() for path in found}
        return [p for p in beside if (p.parent, p.suffix.lower()) in kinds and p.resolve() not in known]

    def images(self, folder: Path | None = None) -> list[Path]:
        """The files of the folder, or of another one, that images may be, by their suffix."""
        place = self.folder if folder is None else folder
        if place not in self._listings:
            self._listings[place] = [p for p in files(place) if p.suffix.lower() in PICTURE_SUFFIXES]
        return self._listings[place]

    def by_stem(self, stem: str) -> Path | None:
        """The one image of this name with any suffix, None when there is none."""
        found = [p for p in self.images() if _plain(p.stem) == _plain(stem)]
        return _only(self.folder, stem, found)

    def find(self, name: str, *, any_suffix: bool = True) -> Path | None:
        """The image that a lamp file names; None when there is none.

        Tried in turn: the path as written; the ends of the path inside this folder, longest first, as from
        another machine; the same with letters in another case or composed otherwise (NFC, NFD); with
        `any_suffix` the same with another suffix, as when raw files were developed. Then all this in the
        folders within, and where no image lies here in the folder above and those beside this one.
        Raises CaptureError when several images fit.
        """
        parts = named_path(name).parts
        ends = ["/".join(parts[i:]) for i in range(len(parts))]
        tried = [[self.folder], self._folders(self.folder)]
        if not self.images() and not self._raw_files:
            above = self.folder.absolute().parent
            tried += [[above], self._folders(above)]
        for places in tried:
            for loosely in (False, True) if any_suffix else (False,):
                near = [self._find_in(place, name, ends, any_suffix=loosely) for place in places]
                image = _only(self.folder, name, [path for path in near if path is not None])
                if image is not None:
                    return image
        return None

    def is_there(self, name: str) -> bool:
        """Whether a lamp file means an image by this name."""
        try:
            return self.find(name) is not None
        except (CaptureError, ValueError, OSError):  # a wrong encoding makes names that no disk bears
            return False

    def _find_in(self, folder: Path, name: str, ends: list[str], *, any_suffix: bool) -> Path | None:
        """The image of a name in one folder; ends: of its path, longest first."""
        for end in (name, *ends):
            path = folder / end if self._within is None else self._within.find(end, beside=folder)
            if path is not None and self.may_read(path):
                return path
        for end in ends:
            place = (folder / end).parent
            wanted = PurePosixPath(end).name
            near = [path for path in self._listing(place) if self.may_read(path)]
            found = [path for path in near if _plain(path.name) == _plain(wanted)]
            if any_suffix:
                found = found or [
                    path for path in near if _plain(path.stem) == _plain(SUFFIX.sub("", wanted))
                ]
            image = _only(place, name, found)
            if image is not None:
                return image
        return None

    def _folders(self, folder: Path) -> list[Path]:
        """The folders within one, none where they cannot be listed."""
        try:
            return folders(folder)
        except CaptureError:
            return []

    def _listing(self, folder: Path) -> list[Path]:
        try:
            return self.images(folder) if folder.is_dir() else []
        except (CaptureError, OSError, ValueError):
            return []

    def left_out(self, where: Bilingual, name: str, leave_out: Collection[str]) -> set[str]:
        """Those names to leave out that mean a photograph which is named, and is not there.

        Raises CaptureError, which begins with where it is named, when none does.
        """
        path = named_path(name)
        meant = {one for one in leave_out if is_called(path, one)}
        if meant:
            return meant
        raw = next((p for p in self._raw_files if _plain(p.stem) == _plain(SUFFIX.sub("", path.name))), None)
        if raw is not None:
            raise capture_error(
                where,
                en=f"{raw.name} is a raw file of a camera, which is not read; develop it to a linear TIFF",
                zh=f"{raw.name} 是相機原始檔，不能讀；請先轉成線性的 TIFF",
            )
        names = ", ".join(p.name for p in self.photographs[:_LISTED]) or "-"
        more = "..." if len(self.photographs) > _LISTED else ""
        raise capture_error(
            where,
            en=f"expected the image {name}, there is no such file; here are {names}{more} "
            f"(--leave-out {as_argument(path.name)} does without it)",
            zh=f"這裡應是照片檔 {name}，卻沒有這個檔案；這裡有 {names}{more}"
            f"（--leave-out {as_argument(path.name)} 可略過它）",
        )


def as_argument(name: str) -> str:
    """A name as it is written in a command: in quotes where it holds a blank or a sign of the shell."""
    return f'"{name}"' if re.search(r"[\s()&;'*?\[\]$!#]", name) else name


def files(folder: Path) -> list[Path]:
    """Files of a folder, by name, without hidden ones: copying from a Mac leaves a ._NAME beside each."""
    return _shown(folder, Path.is_file)


def folders(folder: Path) -> list[Path]:
    """Folders within a folder, by name, without hidden ones."""
    return _shown(folder, Path.is_dir)


def _shown(folder: Path, kind: Callable[[Path], bool]) -> list[Path]:
    """What a folder shows of a kind, by name. Raises CaptureError when it cannot be read."""
    try:
        return sorted(p for p in folder.iterdir() if kind(p) and not p.name.startswith("."))
    except OSError as error:
        raise capture_error(
            folder, en=f"cannot be read ({error.strerror})", zh=f"無法讀取（{error.strerror}）"
        ) from error


def named_path(name: str) -> PurePosixPath:
    """The path that a lamp file names, which may have been written on Windows."""
    return PurePosixPath(name.replace("\\", "/"))


def is_called(photograph: PurePath, name: str) -> bool:
    """Whether this is the name of a photograph, with or without its suffix."""
    return Path(name).name in (photograph.name, photograph.stem)


def photographs_without(where: Path, paths: Sequence[Path], names: Collection[str]) -> list[Path]:
    """The photographs but those of these names, with or without suffix.

    Raises CaptureError, which begins with where they are listed, for a name of none.
    """
    left_out = set()
    for name in names:
        found = {path for path in paths if is_called(path, name)}
        if not found:
            raise capture_error(
                where,
                en=f"expected the name of a photograph to leave out, got {name}",
                zh=f"要除去的照片 {name} 不在這組照片裡",
            )
        left_out |= found
    return [path for path in paths if path not in left_out]


def _only(folder: Path, name: str, found: list[Path]) -> Path | None:
    if len(found) > 1:
        names = ", ".join(
            p.relative_to(folder).as_posix() if p.is_relative_to(folder) else f"{p.parent.name}/{p.name}"
            for p in found[:_LISTED]
        )
        names += ", ..." if len(found) > _LISTED else ""
        raise capture_error(
            folder,
            en=f"expected one image named {name}, found {names}",
            zh=f"名為 {name} 的照片應只有一張，卻有 {names}",
        )
    return found[0] if found else None


def _plain(name: str) -> str:
    """A name as it is compared: letters composed, without their case."""
    return unicodedata.normalize("NFC", name).casefold()
