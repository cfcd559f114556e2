"""What is known of a work before it is kept, and the row that it becomes."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

from rumu.database.tables import now
from rumu.gallery.terms import dynasty_name, script_name
from rumu.gallery.variants import folded
from rumu.values import Bilingual

if TYPE_CHECKING:
    from sqlalchemy.orm import Session

NOTHING = Bilingual(zh="", en="")
NO_LICENCE = "none stated"

_SIZES = {"title": 200, "hand": 200, "period": 200}  # what the columns hold, in characters


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """The facts of one work as people state them. Empty where nobody said; licence: 'none stated' likewise.

    dynasty: key for browsing, see terms.dynasty_key. origin: where it came from, within its collection.
    """

    title: Bilingual
    character: str = ""
    script: str = ""
    hand: Bilingual = NOTHING
    dynasty: str = ""
    period: Bilingual = NOTHING
    material: Bilingual = NOTHING
    source: str = ""
    licence: str = NO_LICENCE
    attribution: str = ""
    origin: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Kept:
    """The files of one work as they lie in the store, and what they are; see tables.Work."""

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
class Room:
    """The collection that works go to."""

    id: str
    title: Bilingual
    note: Bilingual = NOTHING
    source: str = ""
    licence: str = NO_LICENCE
    facts: Mapping[str, Any] = field(default_factory=dict)

    def row(self) -> dict[str, Any]:
        return {"id": self.id, "source": self.source, "licence": self.licence} | _columns(
            title=self.title, note=self.note
        )


def work_row(entry: Entry, kept: Kept, *, work_id: str, room: Room, position: int) -> dict[str, Any]:
    """The columns of tables.Work."""
    names = ("title", "hand", "period", "material")
    row = (
        {"id": work_id, "collection_id": room.id, "position": position}
        | _columns(**{name: getattr(entry, name) for name in names})
        | {
            name: getattr(entry, name)
            for name in ("character", "script", "dynasty", "source", "licence", "attribution", "origin")
        }
        | asdict(kept)
    )
    stamp = now()  # one for both: whoever is changed later is told from the others
    return row | {"search": search_text(row, collection=room.title), "created": stamp, "changed": stamp}


def search_text(row: Mapping[str, Any], *, collection: Bilingual) -> str:
    """What a search looks through: title, character, hand, period, dynasty, script and collection, folded."""
    dynasty, script = dynasty_name(row["dynasty"]), script_name(row["script"])
    told: Sequence[str] = (
        *(row[f"{name}_{language}"] for name in ("title", "hand", "period") for language in ("zh", "en")),
        row["character"],
        row["dynasty"],
        *((dynasty.zh, dynasty.en) if row["dynasty"] else ()),
        *((script.zh, script.en) if row["script"] else ()),
        collection.zh,
        collection.en,
        row["id"],
    )
    return "\n".join(dict.fromkeys(folded(text) for text in told if text))


def digest_of(content: bytes | str, *label: str) -> str:
    """sha256 of content and label: the same picture under the same label is one work.

    content: the bytes, or their own digest where there are several files.
    """
    kept = hashlib.sha256(content if isinstance(content, bytes) else content.encode())
    for part in label:
        kept.update(b"\0" + part.encode())
    return kept.hexdigest()


def slug(text: str, *, otherwise: str = "works") -> str:
    """ASCII letters, digits and hyphens, at most 40, for an id."""
    plain = re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")[:40].strip("-")
    return plain or f"{otherwise}-{hashlib.sha256(text.encode()).hexdigest()[:8]}"


def put_works(session: Session, rows: Sequence[Mapping[str, Any]]) -> frozenset[str]:
    """Put in the works that are not there yet, by id and digest; the ids of those that went in."""
    from rumu.database.tables import Work

    return _put(session, Work, rows)


def put_collection(session: Session, room: Room) -> None:
    """Put in a collection, unless there is one of its id."""
    from rumu.database.tables import Collection

    _put(session, Collection, [room.row()])


def put_others(session: Session, table: Any, rows: Iterable[Mapping[str, Any]]) -> frozenset[str]:
    """Annotations, tours or collections with their ids, unless they are there; the ids of those that went
    in."""
    return _put(session, table, list(rows))


def _put(session: Session, table: Any, rows: Sequence[Mapping[str, Any]]) -> frozenset[str]:
    from sqlalchemy.dialects import postgresql, sqlite

    if not rows:
        return frozenset()
    dialect = sqlite if session.get_bind().dialect.name == "sqlite" else postgresql
    statement = dialect.insert(table).on_conflict_do_nothing().returning(table.id)
    return frozenset(session.execute(statement, [dict(row) for row in rows]).scalars())


def _columns(**texts: Bilingual) -> dict[str, str]:
    return {
        f"{name}_{language}": getattr(text, language)[: _SIZES.get(name)]
        for name, text in texts.items()
        for language in ("zh", "en")
    }
