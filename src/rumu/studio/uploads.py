"""Uploaded works: one picture at once; a zip of many, or of photographs under lamps, as a job."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any, Literal

from rumu.capture.folder import check_capture_files
from rumu.capture.photographs import PICTURE_SUFFIXES, FolderImages
from rumu.capture.unlit import FEWEST
from rumu.card.finding import shows_card
from rumu.errors import DiskFull
from rumu.gallery.add_page import add_page
from rumu.gallery.add_work import add_capture, add_picture, named_collection
from rumu.gallery.archive import MANIFEST, ImportResult
from rumu.gallery.bulk_import import import_folder
from rumu.gallery.catalog import collections
from rumu.gallery.iiif_import import import_manifest
from rumu.gallery.labels import SharedMetadata
from rumu.gallery.masters import LABELS
from rumu.gallery.metadata import NO_LICENCE, CollectionMetadata, WorkMetadata
from rumu.gallery.page_import import find_pages
from rumu.gallery.store import Gallery
from rumu.studio.errors import Unusable, without_folders
from rumu.studio.job_queue import Progress
from rumu.studio.pictures import format_of
from rumu.studio.unpacking import unpack
from rumu.values import Bilingual
from rumu.workspaces import temporary_folder

Content = Literal["works", "capture", "card"]
"""What a zip holds: works with a table or texts, photographs with their lamps, or those of the card."""

TEXTS = ("title", "hand", "period", "material")
WORDS = ("character", "script", "dynasty", "source", "licence", "attribution")
_LAMPS = re.compile(
    r".+\.(lp|dome)|light_directions.*\.txt|capture\.json"
    r"|(lamp|light|led)s?([ _-]?(direction|position)s?)?\.(csv|tsv)"
)
"""The files that make a folder a capture, in lower case; see rumu.capture.folder."""
_MAX_LISTED = 20  # skipped pictures that are listed one by one


def metadata_of(facts: Mapping[str, str]) -> WorkMetadata:
    """Return the metadata of uploaded facts: title_zh, title_en, hand_zh, ... and WORDS.

    Where one language is empty the other stands for both.
    """
    texts: dict[str, Any] = {}
    for name in TEXTS:
        zh, en = facts.get(f"{name}_zh", ""), facts.get(f"{name}_en", "")
        texts[name] = Bilingual(zh or en, en or zh)
    words: dict[str, Any] = {name: facts.get(name, "") for name in WORDS}
    words["licence"] = words["licence"] or NO_LICENCE
    if not texts["title"].zh:
        texts["title"] = Bilingual(words["character"] or "無題", words["character"] or "Untitled")
    return WorkMetadata(**texts, **words)


def add_work(gallery: Gallery, data: bytes, facts: Mapping[str, str], *, spacing: float | None) -> str:
    """Add a picture as a work and return its id.

    Raises Unusable, ImageError or RefusedImage when it is no writing.
    """
    method = facts.get("method") or "inflation"
    with temporary_folder() as folder:
        path = folder / f"picture.{format_of(data)}"
        path.write_bytes(data)
        collection = find_or_name_collection(gallery, facts.get("collection", ""))
        return add_picture(
            gallery, path, metadata=metadata_of(facts), collection=collection, method=method, spacing=spacing
        ).id


def add_page_upload(
    gallery: Gallery, picture: Path, facts: Mapping[str, str], *, text: str, spacing: float | None
) -> dict[str, Any]:
    """Add a page with its characters; what was added, as `import_zip` says it.

    Raises ImageError, RefusedImage or GalleryError when it is no page with writing.
    """
    added = add_page(
        gallery,
        picture,
        text=text,
        metadata=metadata_of(facts),
        collection=find_or_name_collection(gallery, facts.get("collection", "")),
        spacing=spacing,
    )
    note = Bilingual(
        zh=f"頁上找到 {added.characters} 個字，其中 {added.named} 個對上了釋文。",
        en=f"{added.characters} characters were found on the page; {added.named} are named by the text.",
    )
    counts = {"added": int(added.new), "there": int(not added.new)}
    return {"work": added.id, **counts, "notes": [note._asdict()]}


def import_from_museum(gallery: Gallery, url: str, collection: str, progress: Progress) -> dict[str, Any]:
    """Import a IIIF manifest or collection from its address; what was done, as `import_zip` says it.

    Only public machines are asked. Raises GalleryError for others, and for what is no manifest.
    """
    shared = _shared_metadata(gallery, {"collection": collection})
    done = import_manifest(gallery, url, shared=shared, progress=progress)
    return {
        "collections": list(done.collections),
        "added": done.added,
        "there": done.existing,
        **_left_out(done),
    }


def _left_out(done: ImportResult) -> dict[str, Any]:
    """What an import left out: the first ones with the reason, and how many."""
    return {
        "left_out": [
            [file, without_folders(reason.en), without_folders(reason.zh)]
            for file, reason in done.left_out[:_MAX_LISTED]
        ],
        "left_out_count": len(done.left_out),
    }


def find_or_name_collection(gallery: Gallery, name: str) -> CollectionMetadata:
    """Return the collection of this id or title, a new one if there is none, the default one for no name."""
    for row, _ in collections(gallery):
        if name and name in (row.id, row.title_zh, row.title_en):
            return CollectionMetadata(id=row.id, title=Bilingual(row.title_zh, row.title_en))
    return named_collection(name or None)


def check_capture(packed: Path) -> None:
    """Raise CaptureError for a zip of a capture whose lamps, names of photographs or mask are refused.

    No photograph is unpacked, so this takes no time and a person is told at once. Any other zip is left to
    `import_zip`, as is what only the photographs themselves show.
    """
    with temporary_folder() as temporary:
        try:
            unpacked = unpack(packed, temporary / "sent", written=_tells_of_a_capture)
            folder, kind = _find_content(unpacked.folder)
        except (Unusable, DiskFull):
            return
        if kind == "capture":
            check_capture_files(folder, within=unpacked.folder)


def _tells_of_a_capture(name: str) -> bool:
    return _LAMPS.fullmatch(PurePosixPath(name).name.lower()) is not None


def import_zip(
    gallery: Gallery,
    packed: Path,
    facts: Mapping[str, str],
    *,
    name: str = "collection",
    owner: bool = False,
    progress: Progress,
) -> dict[str, Any]:
    """Import a zip: a folder with labels.csv, an export of `rumu gallery export`, or one capture.

    facts: the collection that its works go into, and the metadata of a capture. name: of the collection when
    nothing else names one, fit for a folder. owner: whether an owner sent it, whose export may do more than
    add works, see `import_archive`. Works that exist already are counted and left unchanged, so that an
    import can be repeated. `assumed` of the result says what had to be assumed of the zip, if anything.
    """
    with temporary_folder() as temporary:
        progress(0, 0, "解開 Unpacking")
        unpacked = unpack(packed, temporary / name)
        assumed = {} if unpacked.assumed is None else {"assumed": unpacked.assumed._asdict()}
        folder, kind = _find_content(unpacked.folder, told=facts.get("lamps", ""))
        if kind == "works":
            progress(0, 0, "收入 Putting in")
            done = import_folder(
                gallery,
                folder,
                shared=_shared_metadata(gallery, facts),
                only_add=not owner,
                progress=progress,
            )
            return assumed | {
                "collections": list(done.collections),
                "added": done.added,
                "there": done.existing,
                "read_as": done.read_as._asdict() if done.read_as else None,
                **_left_out(done),
            }
        progress(0, 0, "重建表面 Reconstructing")
        collection = find_or_name_collection(gallery, facts.get("collection", ""))
        added = add_capture(
            gallery,
            folder,
            metadata=metadata_of(facts),
            collection=collection,
            within=unpacked.folder,
            card=kind == "card",
        )
        notes = [note._asdict() for note in added.notes]
        counts = {"added": int(added.new), "there": int(not added.new)}
        return assumed | {"work": added.id, **counts, "notes": notes}


def _find_content(top: Path, *, told: str = "") -> tuple[Path, Content]:
    """The folder of a zip that holds what is imported, the outermost one, and what it holds.

    told: 'card' where a person said that the printed card lies in the photographs; it is also looked for in
    photographs with which nothing tells the lamps. Raises Unusable when there is nothing, or several.
    """
    if told == "card":
        return _folder_of_photographs(top) or top, "card"
    found: dict[int, list[tuple[Path, Content]]] = {}
    names: list[str] = []
    for folder, _, files in os.walk(top):
        names += files
        lower = {file.lower(): file for file in files}
        tables = [lower[table] for table in (LABELS, MANIFEST) if table in lower]
        for table in tables:
            Path(folder, table).replace(Path(folder, table.lower()))
        if tables or any(map(_LAMPS.fullmatch, lower)):
            depth = len(Path(folder).relative_to(top).parts)
            found.setdefault(depth, []).append((Path(folder), "works" if tables else "capture"))
    if not found and find_pages(top, SharedMetadata()):
        return top, "works"
    photographs = None if found else _folder_of_photographs(top)
    if photographs is not None and shows_card(FolderImages(photographs).photographs[0]):
        return photographs, "card"
    if not found:
        raise _nothing_to_import(names)
    outermost = found[min(found)]
    if len(outermost) > 1:
        folders = ", ".join(sorted(folder.name for folder, _ in outermost)[:5])
        raise Unusable(
            "several",
            zh=f"zip 檔裡有 {len(outermost)} 組（{folders}）；請一組壓成一個 zip。",
            en=f"The zip holds {len(outermost)} sets ({folders}); send each as a zip of its own.",
        )
    return outermost[0]


def _folder_of_photographs(top: Path) -> Path | None:
    """The outermost folder with as many photographs as a surface takes, None where there is none."""
    folders = sorted((len(Path(one).parts), one) for one, _, _ in os.walk(top))
    enough = (Path(one) for _, one in folders if len(FolderImages(Path(one)).photographs) >= FEWEST)
    return next(enough, None)


def _nothing_to_import(names: list[str]) -> Unusable:
    """What is missing in a zip with these files."""
    suffixes = {PurePosixPath(name).suffix.lower() for name in names}
    if not names:
        return Unusable("no_works", zh="zip 檔是空的。", en="The zip file is empty.")
    if suffixes <= {".zip", ".rar", ".7z"}:
        return Unusable(
            "zip_nested",
            zh="zip 檔裡只有別的壓縮檔；請解開它，再直接壓縮裡面的檔案。",
            en="The zip holds only other archives; unpack them and pack the files themselves.",
        )
    if suffixes & set(PICTURE_SUFFIXES):
        return Unusable(
            "no_labels",
            zh="zip 檔裡有圖片，卻沒有 labels.csv，"
            "也沒有燈位檔（.lp、light_directions.txt、lamps.csv 或 capture.json）或同名的釋文（.txt）。"
            "要收入多件作品，請附上 labels.csv，第一行寫 file,character,script，以下每張圖片一行；"
            "同一張紙在多盞燈下的照片，請附上燈位檔，或在照片裡放印好的拍攝卡（這裡第一張裡沒有）；"
            "整頁的字，請附上與圖片同名的釋文。",
            en="The zip holds pictures, but no labels.csv, no file of lamps (.lp, light_directions.txt, "
            "lamps.csv or capture.json) and no text of the same name (.txt). For many works, add a "
            "labels.csv: file,character,script in its first line, then a line for each picture. For "
            "photographs of one sheet under several lamps, add the file of lamps, or lay the printed card "
            "beside the sheet (the first picture here does not show it). For whole pages, add the text of "
            "each, named as its picture.",
        )
    return Unusable(
        "no_works",
        zh="zip 檔裡沒有可收入的圖片。",
        en="The zip holds no pictures that could be put in.",
    )


def _shared_metadata(gallery: Gallery, facts: Mapping[str, str]) -> SharedMetadata | None:
    if not facts.get("collection"):
        return None
    collection = find_or_name_collection(gallery, facts["collection"])
    return SharedMetadata({"id": collection.id}, {"title": collection.title})
