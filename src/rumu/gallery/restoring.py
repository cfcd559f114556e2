"""A folder that `export` wrote becomes part of a gallery again: same ids, facts, annotations, tours,
bytes."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime
from pathlib import Path, PurePosixPath
from typing import Any

from sqlalchemy import DateTime, select, update

from rumu.database.tables import Annotation, Base, Collection, Tour, UtcTime, Work
from rumu.errors import GalleryError
from rumu.gallery.catalog import Gallery
from rumu.gallery.entries import Room, put_others, put_works, search_text
from rumu.gallery.exporting import FILES, FORMAT, KIND, WORKS
from rumu.gallery.importing import BATCH, EXPORTED, Imported, Progress, grouped
from rumu.values import Bilingual

_PLACES = ("pictures", "captures", "surfaces")


def restore(
    gallery: Gallery, folder: Path, *, room: Room | None = None, progress: Progress | None = None
) -> Imported:
    """Put an exported folder into a gallery. What is there keeps its facts, but for a work that nobody
    changed.

    room: where new works go instead of into their own collections; what is there then stays as it is.
    Raises GalleryError when the folder is not whole: a line that is no work, a file that is missing or whose
    content is not what its name says.
    """
    facts = _facts(folder)
    rooms = facts["collections"] if room is None else [room.row()]
    titles = {one["id"]: Bilingual(one["title_zh"], one["title_en"]) for one in rooms}
    entries = [entry if room is None else entry | {"collection_id": room.id} for entry in _entries(folder)]
    done = Imported(tuple(titles))
    with gallery.database.writing() as session:
        put_others(session, Collection, [_row(Collection, one) for one in rooms])
    for batch in grouped(entries, BATCH):
        done = done.and_then(_put_batch(gallery, folder, batch, titles, renew=room is None))
        if progress is not None:
            progress(done.added + done.there + len(done.left_out), len(entries))
    with gallery.database.writing() as session:
        put_others(session, Tour, [_row(Tour, tour) for tour in facts["tours"]])
    return done


def holds_starter(folder: Path) -> bool:
    """Whether an export holds the starter gallery: then an empty gallery need not begin with it."""
    return (folder / EXPORTED).is_file() and any(r["id"] == "starter" for r in _facts(folder)["collections"])


def _put_batch(
    gallery: Gallery,
    folder: Path,
    batch: Sequence[Mapping[str, Any]],
    titles: Mapping[str, Bilingual],
    *,
    renew: bool,
) -> Imported:
    there = _there(gallery, batch)
    new = [entry for entry in batch if entry["id"] not in there]
    for entry in new:
        for key in entry["files"]:
            gallery.store.write(key, _file(folder, key))
    rows = [_work(entry, titles) for entry in batch]
    same = [row for row in rows if renew and there.get(row["id"]) == (row["digest"], True)]
    with gallery.database.writing() as session:
        added = put_works(session, [row for row in rows if row["id"] not in there])
        for row in same:  # such as a starter work that was renamed before the export
            session.execute(update(Work).where(Work.id == row["id"]).values(row))
        taken = {name for name, (digest, _) in there.items() if digest}
        said = [
            _row(Annotation, one)
            for entry in batch
            if entry["id"] in added or entry["id"] in taken
            for one in entry["annotations"]
        ]
        put_others(session, Annotation, said)
    strangers = tuple(
        (entry["id"], "another work has this id")
        for entry in batch
        if there.get(entry["id"], (entry["digest"],))[0] != entry["digest"]
    )
    return Imported((), len(added), len(batch) - len(added) - len(strangers), strangers)


def _there(gallery: Gallery, batch: Sequence[Mapping[str, Any]]) -> dict[str, tuple[str, bool]]:
    """Digest of each work of the batch that the gallery has, and whether nobody changed it since."""
    names = [entry["id"] for entry in batch]
    with gallery.database.reading() as session:
        found = session.execute(
            select(Work.id, Work.digest, Work.changed == Work.created).where(Work.id.in_(names))
        )
        return {row[0]: (row[1], bool(row[2])) for row in found}


def _work(entry: Mapping[str, Any], titles: Mapping[str, Bilingual]) -> dict[str, Any]:
    row = _row(Work, entry)
    if row["collection_id"] not in titles:
        named = row["collection_id"]
        raise GalleryError(f"{entry['id']}: expected a collection of {EXPORTED}, got {named!r}")
    return row | {"search": search_text(row, collection=titles[row["collection_id"]])}


def _row(table: type[Base], told: Mapping[str, Any]) -> dict[str, Any]:
    """Columns of a table from JSON, times as times."""
    row = {}
    for column in table.__table__.columns:
        if column.name in told:
            value = told[column.name]
            is_time = isinstance(column.type, UtcTime | DateTime) and isinstance(value, str)
            row[column.name] = datetime.fromisoformat(value) if is_time else value
    return row


def _facts(folder: Path) -> dict[str, Any]:
    path = folder / EXPORTED
    try:
        facts = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise GalleryError(f"{path}: expected JSON, cannot read it ({error})") from error
    if not isinstance(facts, dict) or (facts.get("kind"), facts.get("format")) != (KIND, FORMAT):
        raise GalleryError(f"{path}: expected a gallery of format {FORMAT}, got something else")
    return facts


def _entries(folder: Path) -> Iterator[dict[str, Any]]:
    path = folder / WORKS
    needed = {"id", "collection_id", "picture", "digest", "files", "annotations"}
    try:
        with path.open(encoding="utf-8") as lines:
            for number, line in enumerate(lines, start=1):
                entry = json.loads(line)
                if not isinstance(entry, dict) or not needed <= set(entry):
                    told = ", ".join(sorted(needed))
                    raise GalleryError(f"{path} line {number}: expected a work with {told}")
                yield entry
    except (OSError, ValueError) as error:
        raise GalleryError(f"{path}: expected one work a line, cannot read it ({error})") from error


def _file(folder: Path, key: str) -> bytes:
    """A file of the export; a picture is named by its content, and that is checked."""
    if key.split("/", maxsplit=1)[0] not in _PLACES or ".." in key.split("/"):
        raise GalleryError(f"expected a file in {', '.join(_PLACES)}, got {key!r}")
    try:
        data = (folder / FILES / key).read_bytes()
    except OSError as error:
        raise GalleryError(f"{folder / FILES / key}: expected a file of the export, there is none") from error
    if key.startswith("pictures/") and hashlib.sha256(data).hexdigest() != PurePosixPath(key).stem:
        raise GalleryError(f"{folder / FILES / key}: its content is not what its name says")
    return data
