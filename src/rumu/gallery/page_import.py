"""Pages with their texts in a folder: found beside each other, and added one by one.

A picture is a page where a text file of the same name lies beside it (`leaf-01.jpg`, `leaf-01.txt`), or where
its row in labels.csv names one, or holds the text itself, in the column `text`. Each page is added whole or
not at all, and one that is there already is passed over, so that an import that was ended goes on.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rumu.capture.photographs import PICTURE_SUFFIXES
from rumu.containment import FolderFiles
from rumu.encodings import decode_text
from rumu.errors import GalleryError, RumuError
from rumu.gallery.add_page import AddedPage, add_page
from rumu.gallery.archive import ImportResult, Progress
from rumu.gallery.labels import LabelledPicture, SharedMetadata
from rumu.gallery.metadata import CollectionMetadata
from rumu.gallery.store import Gallery
from rumu.gallery.vocabulary import file_in_other_characters
from rumu.inputs import read_file
from rumu.values import Bilingual

TEXT_SUFFIX = ".txt"
_LONGEST_FILE = 10**6  # bytes of a text: the longest page holds a few thousand characters


@dataclass(frozen=True, slots=True)
class LabelledPage:
    """A picture of a page with its text. given: by its row, else it lies in a file beside the picture."""

    picture: LabelledPicture
    given: str = ""


def read_text_file(path: Path) -> str:
    """The text of a file in any encoding. Raises GalleryError when it is none."""
    content = read_file(path, error_type=GalleryError, expected="a text file", most=_LONGEST_FILE)
    decoded = decode_text(content)
    if decoded is None:
        raise GalleryError("expected a text file", name=path.name, zh=f"{path.name} 不是文字檔。")
    return decoded.text


def part_pages(
    folder: Path, pictures: Sequence[LabelledPicture]
) -> tuple[list[LabelledPicture], list[LabelledPage]]:
    """The rows of labels.csv that are single pictures, and those that are pages with a text."""
    files, single, pages = FolderFiles(folder), [], []
    for picture in pictures:
        beside = files.find(_name_of_text(picture.file))
        if picture.text:
            pages.append(LabelledPage(picture, picture.text))
        elif beside is not None and not picture.metadata.character:
            pages.append(LabelledPage(picture))
        else:
            single.append(picture)
    return single, pages


def _name_of_text(name: str) -> str:
    """The name of the text that lies beside a picture."""
    return os.path.splitext(name)[0] + TEXT_SUFFIX  # noqa: PTH122  whatever a table holds is no error here


def find_pages(folder: Path, shared: SharedMetadata) -> list[LabelledPage]:
    """The pictures of a folder that a text lies beside, in the order of their names."""
    names = sorted(
        os.path.relpath(os.path.join(top, name), folder)  # noqa: PTH118  names below the folder
        for top, _, files in os.walk(folder)
        for name in files
        if Path(name).suffix.lower() in PICTURE_SUFFIXES
        and Path(top, name).with_suffix(TEXT_SUFFIX).is_file()
    )
    pages = []
    for number, name in enumerate(names, start=1):
        stem = Path(name).stem
        metadata = shared.work_metadata(title=Bilingual(stem, stem), origin=name[:500])
        pages.append(LabelledPage(LabelledPicture(number, name, metadata)))
    return pages


def import_pages(
    gallery: Gallery,
    folder: Path,
    pages: Sequence[LabelledPage],
    collection: CollectionMetadata,
    *,
    progress: Progress | None = None,
) -> ImportResult:
    """Add pages of a folder with their characters. progress: called with (done, total) after each.

    A page whose picture or text cannot be used is left out with the reason, and the import goes on.
    """
    added = existing = 0
    left_out: list[tuple[str, Bilingual]] = []
    for done, (page, result) in enumerate(_add_each(gallery, folder, pages, collection), start=1):
        if isinstance(result, AddedPage):
            added, existing = added + result.new, existing + (not result.new)
        else:
            left_out.append((page.picture.file, result))
        if progress is not None:
            progress(done, len(pages))
    return ImportResult((collection.id,), added, existing, tuple(left_out))


def _add_each(
    gallery: Gallery, folder: Path, pages: Sequence[LabelledPage], collection: CollectionMetadata
) -> Iterator[tuple[LabelledPage, AddedPage | Bilingual]]:
    files = FolderFiles(folder)
    for page in pages:
        try:
            yield page, _add(gallery, folder, files, page, collection)
        except OSError as error:
            yield page, Bilingual(f"讀不到（{error.strerror}）。", f"cannot be read ({error.strerror})")
        except RumuError as error:
            yield page, Bilingual(error.zh or f"無法使用：{error.en}", error.en)


def _add(
    gallery: Gallery, folder: Path, files: FolderFiles, page: LabelledPage, collection: CollectionMetadata
) -> AddedPage:
    name = page.picture.file
    path = files.find(name) or file_in_other_characters(folder, name)
    if path is None:
        raise GalleryError(
            f"{name}: expected a picture within the folder, there is none",
            zh=f"{name}：資料夾裡沒有這個檔案。",
        )
    text = page.given
    named = text if text.lower().endswith(TEXT_SUFFIX) else _name_of_text(name)
    if not text or text == named:
        file = files.find(named) or files.find(named, beside=path.parent)
        if file is None:
            raise GalleryError(
                f"{named}: expected the text of {name}, there is none", zh=f"沒有釋文檔 {named}。"
            )
        text = read_text_file(file)
    metadata = replace(page.picture.metadata, character="")
    return add_page(
        gallery, path, text=text, metadata=metadata, collection=collection, position=page.picture.number
    )
