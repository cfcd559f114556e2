"""All tables of the database. Pictures, surfaces and other files lie in the store; a table holds their keys.

Times are UTC. Texts in two languages stand in two columns, `_zh` (traditional Chinese) and `_en`; an
attribute without the ending holds both. Positions on a work are fractions of its size, origin top left.
"""

from __future__ import annotations

import uuid
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import JSON, DateTime, Float, ForeignKey, Index, Integer, String, Text, UniqueConstraint
from sqlalchemy.engine import Dialect
from sqlalchemy.orm import DeclarativeBase, Mapped, composite, mapped_column
from sqlalchemy.types import TypeDecorator

from rumu.values import Bilingual


def new_id() -> str:
    """A new id: 32 hexadecimal digits that nobody can guess."""
    return uuid.uuid4().hex


def now() -> datetime:
    """The present time in UTC."""
    return datetime.now(UTC)


def reject_control_characters(text: str) -> str:
    """A text that every database can store: no control characters but line breaks and tabs, no surrogates.

    Raises ValueError for others.
    """
    if any((ord(c) < 32 and c not in "\n\r\t") or ord(c) == 127 or 0xD800 <= ord(c) <= 0xDFFF for c in text):
        raise ValueError("expected text without control characters")
    return text


class UtcTime(TypeDecorator[datetime]):
    """A time in UTC: SQLite stores no time zone, and PostgreSQL returns times in its own."""

    impl = DateTime(timezone=True)
    cache_ok = True

    def process_bind_param(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        if value is None:
            return None
        if value.tzinfo is None:
            raise ValueError(f"expected a time with its zone, got {value}")
        return value.astimezone(UTC)

    def process_result_value(self, value: datetime | None, dialect: Dialect) -> datetime | None:
        if value is None:
            return None
        return value.astimezone(UTC) if value.tzinfo else value.replace(tzinfo=UTC)


class Base(DeclarativeBase):
    """Base of the tables. Constraints have fixed names, so that migrations can name them on any database."""

    type_annotation_map = {datetime: UtcTime, dict[str, Any]: JSON, list[Any]: JSON}  # noqa: RUF012


Base.metadata.naming_convention = {
    "ix": "ix_%(table_name)s_%(column_0_N_name)s",
    "uq": "uq_%(table_name)s_%(column_0_N_name)s",
    "fk": "fk_%(table_name)s_%(column_0_N_name)s",
    "pk": "pk_%(table_name)s",
}

Id = String(64)
ID_PATTERN = r"^[A-Za-z0-9][A-Za-z0-9._~-]{0,63}$"
"""The form of an id, which stands in addresses and file names as it is."""


class Collection(Base):
    """Works that belong together: a stele, an exhibition. cover_id, tour_id: '' for none."""

    __tablename__ = "collections"

    id: Mapped[str] = mapped_column(Id, primary_key=True)
    title_zh: Mapped[str] = mapped_column(String(200))
    title_en: Mapped[str] = mapped_column(String(200))
    note_zh: Mapped[str] = mapped_column(Text, default="")
    note_en: Mapped[str] = mapped_column(Text, default="")
    source: Mapped[str] = mapped_column(Text, default="")
    licence: Mapped[str] = mapped_column(String(200), default="")
    cover_id: Mapped[str] = mapped_column(Id, default="", server_default="")
    tour_id: Mapped[str] = mapped_column(Id, default="", server_default="")
    created: Mapped[datetime] = mapped_column(default=now)
    title: Mapped[Bilingual] = composite("title_zh", "title_en")
    note: Mapped[Bilingual] = composite("note_zh", "note_en")


class Work(Base):
    """One work: a character, a whole page or scroll, or a character within one.

    id: ASCII slug. parent_id: of a character within a page or scroll, that page; its position is its place in
    the reading order, and `place` where it stands there (rows.PlaceRow). occurrence: how many times the same
    character stands before it on that page. character: '' for a sheet of several. script: seal, clerical,
    regular, running, cursive, or '' if unknown. hand: its writer. dynasty: key for browsing, e.g. 'Tang', ''
    if unknown; period: in words. kind: 'image' (one picture; its height is computed) or 'capture'
    (photographs under several lamps). height_source: 'photometric', 'inflation' or 'density'. picture: store
    key of the picture as uploaded; surface: store key of the folder of a reconstructed surface, None if it is
    computed from the picture. capture: store key of the photographs of a capture, None for an image. digest:
    SHA-256 of content and label, so that the same picture with the same label is stored once. origin: where
    it was imported from, within its collection. text: what is written on a page or scroll, as it was given.
    record: what a museum says of it, in the museum's words and languages (rows.RecordRow), None otherwise.
    spacing: mm per pixel, None if unknown. search_character to search_more: the texts that searches look
    through; search_version: of the rules that they were made by, 0 when they were not.
    """

    __tablename__ = "works"
    __table_args__ = (
        Index(None, "script", "position"),
        Index(None, "character"),
        Index(None, "collection_id", "position"),
        Index(None, "parent_id", "position"),
    )

    id: Mapped[str] = mapped_column(Id, primary_key=True)
    collection_id: Mapped[str] = mapped_column(ForeignKey("collections.id", ondelete="CASCADE"))
    parent_id: Mapped[str | None] = mapped_column(ForeignKey("works.id"), default=None)
    occurrence: Mapped[int] = mapped_column(Integer, default=0)
    place: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True), default=None)
    position: Mapped[int] = mapped_column(Integer, default=0)
    title_zh: Mapped[str] = mapped_column(String(200))
    title_en: Mapped[str] = mapped_column(String(200))
    character: Mapped[str] = mapped_column(String(16), default="")
    script: Mapped[str] = mapped_column(String(16), default="")
    hand_zh: Mapped[str] = mapped_column(String(200), default="")
    hand_en: Mapped[str] = mapped_column(String(200), default="")
    dynasty: Mapped[str] = mapped_column(String(40), default="")
    period_zh: Mapped[str] = mapped_column(String(200), default="")
    period_en: Mapped[str] = mapped_column(String(200), default="")
    material_zh: Mapped[str] = mapped_column(Text, default="")
    material_en: Mapped[str] = mapped_column(Text, default="")
    source: Mapped[str] = mapped_column(Text, default="")
    licence: Mapped[str] = mapped_column(String(200), default="")
    attribution: Mapped[str] = mapped_column(Text, default="")
    kind: Mapped[str] = mapped_column(String(16), default="image")
    height_source: Mapped[str] = mapped_column(String(16), default="inflation")
    picture: Mapped[str] = mapped_column(String(300))
    surface: Mapped[str | None] = mapped_column(String(300), default=None)
    capture: Mapped[str | None] = mapped_column(String(300), default=None)
    digest: Mapped[str] = mapped_column(String(64), unique=True)
    origin: Mapped[str] = mapped_column(String(500), default="")
    width: Mapped[int] = mapped_column(Integer)
    height: Mapped[int] = mapped_column(Integer)
    spacing: Mapped[float | None] = mapped_column(Float, default=None)
    text: Mapped[str] = mapped_column(Text, default="")
    record: Mapped[dict[str, Any] | None] = mapped_column(JSON(none_as_null=True), default=None)
    search_character: Mapped[str] = mapped_column(Text, default="")
    search_title: Mapped[str] = mapped_column(Text, default="")
    search_hand: Mapped[str] = mapped_column(Text, default="")
    search_more: Mapped[str] = mapped_column(Text, default="")
    search_version: Mapped[int] = mapped_column(Integer, default=0)
    created: Mapped[datetime] = mapped_column(default=now)
    changed: Mapped[datetime] = mapped_column(default=now, onupdate=now)
    title: Mapped[Bilingual] = composite("title_zh", "title_en")
    hand: Mapped[Bilingual] = composite("hand_zh", "hand_en")
    period: Mapped[Bilingual] = composite("period_zh", "period_en")
    material: Mapped[Bilingual] = composite("material_zh", "material_en")


class Annotation(Base):
    """A text on a point of a work. x, y: fractions of the picture, origin top left."""

    __tablename__ = "annotations"

    id: Mapped[str] = mapped_column(Id, primary_key=True, default=new_id)
    work_id: Mapped[str] = mapped_column(ForeignKey("works.id", ondelete="CASCADE"), index=True)
    x: Mapped[float] = mapped_column(Float)
    y: Mapped[float] = mapped_column(Float)
    title_zh: Mapped[str] = mapped_column(String(200), default="")
    title_en: Mapped[str] = mapped_column(String(200), default="")
    text_zh: Mapped[str] = mapped_column(Text, default="")
    text_en: Mapped[str] = mapped_column(Text, default="")
    position: Mapped[int] = mapped_column(Integer, default=0)
    author_id: Mapped[str | None] = mapped_column(ForeignKey("people.id", ondelete="SET NULL"), default=None)
    created: Mapped[datetime] = mapped_column(default=now)
    title: Mapped[Bilingual] = composite("title_zh", "title_en")
    text: Mapped[Bilingual] = composite("text_zh", "text_en")


class Tour(Base):
    """A guided tour through works.

    steps: a list of {work, view (a permalink's query), title_zh, title_en, text_zh, text_en}.
    """

    __tablename__ = "tours"

    id: Mapped[str] = mapped_column(Id, primary_key=True, default=new_id)
    title_zh: Mapped[str] = mapped_column(String(200))
    title_en: Mapped[str] = mapped_column(String(200))
    steps: Mapped[list[Any]] = mapped_column(default=list)
    position: Mapped[int] = mapped_column(Integer, default=0)
    author_id: Mapped[str | None] = mapped_column(ForeignKey("people.id", ondelete="SET NULL"), default=None)
    created: Mapped[datetime] = mapped_column(default=now)
    title: Mapped[Bilingual] = composite("title_zh", "title_en")


class Person(Base):
    """A user with a login.

    name_key: the name as it is compared. role: owner, teacher or pupil. password: an Argon2 hash or None.
    """

    __tablename__ = "people"

    id: Mapped[str] = mapped_column(Id, primary_key=True, default=new_id)
    name: Mapped[str] = mapped_column(String(80))
    name_key: Mapped[str] = mapped_column(String(80), unique=True)
    role: Mapped[str] = mapped_column(String(16))
    password: Mapped[str | None] = mapped_column(String(200), default=None)
    language: Mapped[str] = mapped_column(String(8), default="zh")
    active: Mapped[bool] = mapped_column(default=True)
    created: Mapped[datetime] = mapped_column(default=now)


class LoginSession(Base):
    """A session of a person who is logged in; it ends when this row is deleted.

    id: SHA-256 of the serial in the session's cookie, so that the table alone opens no session.
    """

    __tablename__ = "sessions"

    id: Mapped[str] = mapped_column(Id, primary_key=True)
    person_id: Mapped[str] = mapped_column(ForeignKey("people.id", ondelete="CASCADE"), index=True)
    created: Mapped[datetime] = mapped_column(default=now)


class Invitation(Base):
    """A link that creates one login, once. token: SHA-256 of the token in the link."""

    __tablename__ = "invitations"

    token: Mapped[str] = mapped_column(String(64), primary_key=True)
    role: Mapped[str] = mapped_column(String(16))
    class_id: Mapped[str | None] = mapped_column(ForeignKey("classes.id", ondelete="CASCADE"), default=None)
    author_id: Mapped[str | None] = mapped_column(ForeignKey("people.id", ondelete="CASCADE"), default=None)
    expires: Mapped[datetime]
    used: Mapped[datetime | None] = mapped_column(default=None)
    created: Mapped[datetime] = mapped_column(default=now)


class SchoolClass(Base):
    """A teacher's class."""

    __tablename__ = "classes"

    id: Mapped[str] = mapped_column(Id, primary_key=True, default=new_id)
    name: Mapped[str] = mapped_column(String(120))
    teacher_id: Mapped[str] = mapped_column(ForeignKey("people.id", ondelete="CASCADE"), index=True)
    created: Mapped[datetime] = mapped_column(default=now)


class Membership(Base):
    """A pupil of a class."""

    __tablename__ = "memberships"

    class_id: Mapped[str] = mapped_column(ForeignKey("classes.id", ondelete="CASCADE"), primary_key=True)
    person_id: Mapped[str] = mapped_column(
        ForeignKey("people.id", ondelete="CASCADE"), primary_key=True, index=True
    )
    created: Mapped[datetime] = mapped_column(default=now)


class Task(Base):
    """A task of a class: a master to copy, until a day."""

    __tablename__ = "tasks"

    id: Mapped[str] = mapped_column(Id, primary_key=True, default=new_id)
    class_id: Mapped[str] = mapped_column(ForeignKey("classes.id", ondelete="CASCADE"), index=True)
    work_id: Mapped[str] = mapped_column(ForeignKey("works.id", ondelete="CASCADE"))
    title: Mapped[str] = mapped_column(String(200), default="")
    note: Mapped[str] = mapped_column(Text, default="")
    due: Mapped[datetime | None] = mapped_column(default=None)
    created: Mapped[datetime] = mapped_column(default=now)


class Attempt(Base):
    """A copy that a person wrote, with its mark.

    person_id: None for the simulated samples, which nobody wrote. kind: 'photo', 'pen' or 'simulated'.
    grid: behind the pen's strokes: 'mi' (米字格), 'jiu' (九宮格), 'tian' (田字格) or ''. picture: store key;
    strokes: store key of the pen's path as JSON, None for a photo. mark: as the API returned it; score:
    0-100, None when it was refused. version: of the rumu that marked it.
    """

    __tablename__ = "attempts"
    __table_args__ = (Index(None, "person_id", "created"), Index(None, "work_id", "created"))

    id: Mapped[str] = mapped_column(Id, primary_key=True, default=new_id)
    person_id: Mapped[str | None] = mapped_column(ForeignKey("people.id", ondelete="CASCADE"), default=None)
    work_id: Mapped[str] = mapped_column(ForeignKey("works.id", ondelete="CASCADE"))
    task_id: Mapped[str | None] = mapped_column(
        ForeignKey("tasks.id", ondelete="SET NULL"), default=None, index=True
    )
    kind: Mapped[str] = mapped_column(String(16))
    grid: Mapped[str] = mapped_column(String(8), default="")
    picture: Mapped[str] = mapped_column(String(300))
    strokes: Mapped[str | None] = mapped_column(String(300), default=None)
    score: Mapped[float | None] = mapped_column(Float, default=None)
    level: Mapped[str | None] = mapped_column(String(16), default=None)
    mark: Mapped[dict[str, Any]] = mapped_column(default=dict)
    version: Mapped[str] = mapped_column(String(20))
    created: Mapped[datetime] = mapped_column(default=now)


class TeacherMark(Base):
    """A teacher's mark of an attempt, 0-100."""

    __tablename__ = "teacher_marks"

    attempt_id: Mapped[str] = mapped_column(ForeignKey("attempts.id", ondelete="CASCADE"), primary_key=True)
    teacher_id: Mapped[str] = mapped_column(ForeignKey("people.id", ondelete="CASCADE"), primary_key=True)
    mark: Mapped[float] = mapped_column(Float)
    note: Mapped[str] = mapped_column(Text, default="")
    created: Mapped[datetime] = mapped_column(default=now, onupdate=now)


class SheetUpload(Base):
    """Photographs of practice sheets, and what was read in each (see `studio.sheet_uploads`).

    class_id, files (store key of the folder of tables and PDFs): None for those of the sender's own writing.
    """

    __tablename__ = "sheet_uploads"
    __table_args__ = (Index(None, "person_id", "created"), Index(None, "class_id", "created"))

    id: Mapped[str] = mapped_column(Id, primary_key=True, default=new_id)
    person_id: Mapped[str] = mapped_column(ForeignKey("people.id", ondelete="CASCADE"))
    class_id: Mapped[str | None] = mapped_column(ForeignKey("classes.id", ondelete="SET NULL"), default=None)
    photos: Mapped[list[Any]] = mapped_column(default=list)
    files: Mapped[str | None] = mapped_column(String(300), default=None)
    created: Mapped[datetime] = mapped_column(default=now)


class Comparison(Base):
    """A judgement which of two copies of one master is better. winner: 'left', 'right' or 'same'.

    A judge sees a pair once: first and second are the attempts' ids in alphabetical order, left is the id of
    the one that was shown on the left.
    """

    __tablename__ = "comparisons"
    __table_args__ = (UniqueConstraint("judge_id", "first_id", "second_id"),)

    id: Mapped[str] = mapped_column(Id, primary_key=True, default=new_id)
    judge_id: Mapped[str] = mapped_column(ForeignKey("people.id", ondelete="CASCADE"), index=True)
    work_id: Mapped[str] = mapped_column(ForeignKey("works.id", ondelete="CASCADE"))
    first_id: Mapped[str] = mapped_column(ForeignKey("attempts.id", ondelete="CASCADE"))
    second_id: Mapped[str] = mapped_column(ForeignKey("attempts.id", ondelete="CASCADE"))
    left_id: Mapped[str] = mapped_column(ForeignKey("attempts.id", ondelete="CASCADE"))
    winner: Mapped[str] = mapped_column(String(8))
    seconds: Mapped[float | None] = mapped_column(Float, default=None)
    created: Mapped[datetime] = mapped_column(default=now)


class Job(Base):
    """A job that runs in the background.

    state: queued, running, done, failed or cancelled. payload: what is needed to run it again after a
    restart. done, total: progress; total 0 while unknown. error: why it failed, else empty.
    """

    __tablename__ = "jobs"
    __table_args__ = (Index(None, "state", "created"),)

    id: Mapped[str] = mapped_column(Id, primary_key=True, default=new_id)
    kind: Mapped[str] = mapped_column(String(40))
    payload: Mapped[dict[str, Any]] = mapped_column(default=dict)
    state: Mapped[str] = mapped_column(String(16), default="queued")
    done: Mapped[int] = mapped_column(Integer, default=0)
    total: Mapped[int] = mapped_column(Integer, default=0)
    message: Mapped[str] = mapped_column(Text, default="")
    result: Mapped[dict[str, Any]] = mapped_column(default=dict)
    error_zh: Mapped[str] = mapped_column(Text, default="")
    error_en: Mapped[str] = mapped_column(Text, default="")
    tries: Mapped[int] = mapped_column(Integer, default=0)
    person_id: Mapped[str | None] = mapped_column(ForeignKey("people.id", ondelete="CASCADE"), default=None)
    created: Mapped[datetime] = mapped_column(default=now)
    changed: Mapped[datetime] = mapped_column(default=now, onupdate=now)
    error: Mapped[Bilingual] = composite("error_zh", "error_en")


class Setting(Base):
    """A setting of the service, such as the key that signs its cookies."""

    __tablename__ = "settings"

    name: Mapped[str] = mapped_column(String(80), primary_key=True)
    value: Mapped[str] = mapped_column(Text)
