"""The files of an export: each is checked, and stored so that none of another work is ever replaced."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path, PurePosixPath
from typing import Any

from sqlalchemy import or_, select

from rumu.containment import FolderFiles
from rumu.database.tables import Work, now
from rumu.errors import GalleryError, RumuError
from rumu.gallery.archive import BATCH, FILES, Progress, split
from rumu.gallery.assets import folder_digest
from rumu.gallery.metadata import work_digest
from rumu.gallery.rows import ExportedWork
from rumu.gallery.store import Gallery

_THREADS = 4  # read and decode; both release the interpreter's lock


class ArchiveFiles:
    """The files of an export on their way into the store.

    folder: of the export. only_add: the export is not trusted: nothing that it claims of its files counts.
    """

    def __init__(self, gallery: Gallery, folder: Path, *, only_add: bool) -> None:
        self._gallery, self._store, self._only_add = gallery, gallery.store, only_add
        self._folder, self._files = folder / FILES, FolderFiles(folder / FILES)
        self._written: list[str] = []  # keys that were not in the store before

    def store_all(
        self, works: Sequence[ExportedWork], progress: Progress | None
    ) -> dict[str, dict[str, Any]]:
        """Store the files of works; the columns of each by its id, with the keys and sizes of its files.

        Raises GalleryError for a file that is missing, cannot be read, or is not what its name says.
        """
        for work in works:  # before the first is stored
            for key in work.files:
                self._find(key)
        rows: dict[str, dict[str, Any]] = {}
        with ThreadPoolExecutor(_THREADS) as threads:
            for some in split(works, 4 * _THREADS):
                images = [work for work in some if work.kind == "image"]
                done = [*threads.map(self._store_work, images)]  # a capture takes much memory: one at a time
                done += [self._store_work(work) for work in some if work.kind != "image"]
                rows |= {row["id"]: row for row in done}
                if progress is not None:
                    progress(len(rows), len(works))
        return rows

    def delete_unused(self) -> None:
        """Delete what was stored for an import that failed, unless a work has come to use it meanwhile."""
        for some in split(self._written, BATCH):
            keys = [key if key.startswith("pictures/") else key.rpartition("/")[0] for key in some]
            shares_one = or_(Work.picture.in_(keys), Work.surface.in_(keys), Work.capture.in_(keys))
            with self._gallery.database.reading() as session:
                rows = session.execute(select(Work.picture, Work.surface, Work.capture).where(shares_one))
                used = {key for row in rows for key in row}
            for file, key in zip(some, keys, strict=True):
                if key not in used:
                    self._store.delete_file(file)

    def _store_work(self, work: ExportedWork) -> dict[str, Any]:
        row = work.columns()
        try:
            content, row["width"], row["height"] = self._store_picture(work.picture)
            if work.surface is not None and work.capture is not None:
                content, row["width"], row["height"] = self._check_capture(work)
                for name in ("surface", "capture"):
                    row[name] = self._store_folder(row[name], self._of_folder(work, row[name]))
        except OSError as error:
            why = error.strerror
            raise GalleryError(
                f"{work.id}: a file cannot be read ({why})", zh=f"{work.id}：有檔案讀不到（{why}）。"
            ) from error
        except RumuError as error:
            raise GalleryError(f"{work.id}: {error}", zh=error.zh and f"{work.id}：{error.zh}") from error
        if self._only_add:
            label = [work.character, work.script, work.hand_zh, work.hand_en, work.title_zh]
            if work.parent_id is not None:  # the same ink may stand on two pages
                label += ["within", work.parent_id, str(work.position)]
            time = now()
            row |= {"digest": work_digest(content, *label), "created": time, "changed": time}
        return row

    def _store_picture(self, key: str) -> tuple[bytes | str, int, int]:
        """The content of a picture, which is stored, its width and its height."""
        from rumu.capture.formats import decode

        path = self._find(key)
        data = path.read_bytes()
        if hashlib.sha256(data).hexdigest() != PurePosixPath(key).stem:
            raise GalleryError(
                f"{key}: its content is not what its name says", zh=f"{key} 的內容與檔名不符。"
            )
        height, width = decode(path).values.shape[:2]
        if not self._store.exists(key):
            self._written.append(key)
            self._store.write(key, data)
        return data, width, height

    def _check_capture(self, work: ExportedWork) -> tuple[str, int, int]:
        """The digest of a capture's files, and the width and height of its surface, if both can be read."""
        from rumu.capture.folder import read_capture
        from rumu.surface.surface_bands import SurfaceBands

        folders = [self._folder / str(key) for key in (work.surface, work.capture)]
        listed = {
            path.resolve()
            for key in (work.surface, work.capture)
            for path in self._of_folder(work, key).values()
        }
        if {path.resolve() for folder in folders for path in folder.iterdir()} != listed:
            raise GalleryError(
                "expected the files of its surface and capture that works.jsonl lists, and no others",
                zh="它的表面與照片的檔案與 works.jsonl 所列的不同。",
            )
        surface = SurfaceBands(folders[0])
        surface.check()
        height, width = surface.shape
        read_capture(folders[1], within=folders[1])
        digests = (folder_digest(self._of_folder(work, key)) for key in (work.surface, work.capture))
        return " ".join(digests), width, height

    def _of_folder(self, work: ExportedWork, folder: str | None) -> dict[str, Path]:
        """The files of a surface or capture by their names."""
        keys = [PurePosixPath(key) for key in work.files]
        return {key.name: self._find(str(key)) for key in keys if str(key.parent) == folder}

    def _store_folder(self, key: str, files: Mapping[str, Path]) -> str:
        """Store the files of a surface or capture; the key where they lie.

        It is the exported key only where a trusted export brings it and nothing else lies there.
        """
        there = self._names(key)
        if self._only_add or (there and not self._holds(key, there, files)):
            digest = folder_digest(files)
            key = f"{key.partition('/')[0]}/{digest[:2]}/{digest}"
            there = self._names(key)
        for name in sorted(set(files) - there):
            self._written.append(f"{key}/{name}")
            with files[name].open("rb") as stream:
                self._store.write(f"{key}/{name}", stream)
        return key

    def _names(self, key: str) -> set[str]:
        return {PurePosixPath(file).name for file in self._store.keys(key)}

    def _holds(self, key: str, there: set[str], files: Mapping[str, Path]) -> bool:
        """Whether exactly these files lie at a key."""
        return there == set(files) and all(
            self._store.read(f"{key}/{name}") == path.read_bytes() for name, path in files.items()
        )

    def _find(self, key: str) -> Path:
        path = self._files.find(key)
        if path is None:
            raise GalleryError(
                f"{key}: expected a file of the export, there is none", zh=f"匯出檔裡缺了 {key}。"
            )
        return path
