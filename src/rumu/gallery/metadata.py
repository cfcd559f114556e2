"""Metadata of a work and of a collection before they are stored, and the rows that they become."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from sqlalchemy import ColumnElement, and_, func, select

from rumu.database.tables import Collection, Work, now
from rumu.gallery.rows import CollectionRow, WorkRow, check_row
from rumu.gallery.search_text import search_columns
from rumu.values import Bilingual

if TYPE_CHECKING:
    from sqlalchemy.orm import Session

EMPTY = Bilingual(zh="", en="")
NO_LICENCE = "none stated"

_MAX_LENGTH = 200  # characters of the columns for titles, hands and periods


@dataclass(frozen=True, slots=True, kw_only=True)
class WorkMetadata:
    """What people state about a work; empty where unknown, and licence 'none stated'.

    dynasty: key for browsing, see vocabulary.dynasty_key. origin: where it comes from, within its collection.
    """

    title: Bilingual
    character: str = ""
    script: str = ""
    hand: Bilingual = EMPTY
    dynasty: str = ""
    period: Bilingual = EMPTY
    material: Bilingual = EMPTY
    source: str = ""
    licence: str = NO_LICENCE
    attribution: str = ""
    origin: str = ""

    def digest(self, content: bytes | str) -> str:
        """The digest by which a work is stored once: of its content and of these metadata.

        content: the bytes, or their own digest where there are several files.
        """
        return work_digest(content, self.character, self.script, self.hand.zh, self.hand.en, self.title.zh)


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredFiles:
    """The keys of a work's files in the store, and what the files are; see tables.Work."""

    picture: str
    digest: str
    width: int
    height: int
    kind: str = "image"
    height_source: str = "inflation"
    surface: str | None = None
    capture: str | None = None
    spacing: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class CollectionMetadata:
    """What people state about a collection."""

    id: str
    title: Bilingual
    note: Bilingual = EMPTY
    source: str = ""
    licence: str = NO_LICENCE

    def row(self) -> dict[str, Any]:
        """The columns of tables.Collection. Raises GalleryError when one is not as it must be."""
        plain = {"id": self.id, "source": self.source, "licence": self.licence[:200]}
        row = plain | _columns("title", self.title) | _columns("note", self.note, max_length=None)
        check_row(CollectionRow, row | {"created": now()}, name=self.title.en or self.id)
        return row


def work_row(
    metadata: WorkMetadata,
    files: StoredFiles,
    *,
    collection: CollectionMetadata,
    position: int,
    work_id: str | None = None,
    **more: Any,
) -> dict[str, Any]:
    """The columns of tables.Work. work_id: by default it is made of the collection and the digest.

    more: further columns, or others than the metadata give, such as those of a character within a page.
    Raises GalleryError when one of them is not as rumu.gallery.rows has it, such as with control characters.
    """
    plain = ("character", "script", "dynasty", "source", "licence", "attribution", "origin")
    row = (
        {
            "id": work_id or f"{collection.id}-{files.digest[:12]}",
            "collection_id": collection.id,
            "position": position,
        }
        | _columns("title", metadata.title)
        | _columns("hand", metadata.hand)
        | _columns("period", metadata.period)
        | _columns("material", metadata.material, max_length=None)
        | {name: getattr(metadata, name) for name in plain}
        | {"dynasty": metadata.dynasty[:40], "licence": metadata.licence[:200]}
        | asdict(files)
        | {"parent_id": None, "occurrence": 0, "place": None, "text": "", "record": None}
        | more
    )
    time = now()  # the same for both columns: an archive's import sees by it that nobody has changed the work
    row |= search_columns(row, collection=collection.title) | {"created": time, "changed": time}
    columns = {name: value for name, value in row.items() if not name.startswith("search_")}
    check_row(WorkRow, columns, name=metadata.origin or str(row["id"]))
    return row


def _columns(name: str, text: Bilingual, *, max_length: int | None = _MAX_LENGTH) -> dict[str, str]:
    return {f"{name}_zh": text.zh[:max_length], f"{name}_en": text.en[:max_length]}


def next_position(session: Session, collection_id: str) -> int:
    """The position after the last work of a collection; characters stand on their pages, and do not count."""
    after_last = select(func.coalesce(func.max(Work.position) + 1, 0))
    return session.execute(after_last.where(is_whole_of(collection_id))).scalar_one()


def is_whole_of(collection_id: str) -> ColumnElement[bool]:
    """The condition that a work is of a collection and no character within a page."""
    return and_(Work.collection_id == collection_id, Work.parent_id.is_(None))


def work_digest(content: bytes | str, *label: str) -> str:
    """SHA-256 of content and label: the same picture with the same label is one work."""
    digest = hashlib.sha256(content if isinstance(content, bytes) else content.encode())
    for part in label:
        digest.update(b"\0" + part.encode())
    return digest.hexdigest()


def slug(text: str, *, default: str) -> str:
    """ASCII letters, digits and hyphens, at most 40, for an id. default: its start where a text has none."""
    plain = re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")[:40].strip("-")
    return plain or f"{default}-{hashlib.sha256(text.encode()).hexdigest()[:8]}"


# --- inserting -------------------------------------------------------------------------------------


def insert_works(
    session: Session, collection: CollectionMetadata, rows: Sequence[Mapping[str, Any]]
) -> frozenset[str]:
    """Insert a collection and works of it, except those that exist, by id or digest; the ids inserted."""
    insert_rows(session, Collection, [collection.row()])
    return insert_rows(session, Work, rows)


def insert_rows(session: Session, table: Any, rows: Sequence[Mapping[str, Any]]) -> frozenset[str]:
    """Insert the rows that do not exist yet; the ids of those that were inserted."""
    from sqlalchemy.dialects import postgresql, sqlite

    if not rows:
        return frozenset()
    dialect = sqlite if session.get_bind().dialect.name == "sqlite" else postgresql
    statement = dialect.insert(table).on_conflict_do_nothing().returning(table.id)
    return frozenset(session.execute(statement, [dict(row) for row in rows]).scalars())
