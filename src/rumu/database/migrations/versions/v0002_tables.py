"""All tables of rumu.database.tables as they were at the first release.

The number is 0002 because databases of the last development version have it, and the same tables. Names of
constraints and indexes follow the naming convention of rumu.database.tables.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = None

_ID, _TIME = sa.String(64), sa.DateTime(timezone=True)
_column = partial(sa.Column, nullable=False)


def _bilingual(name: str, kind: Any) -> tuple[sa.Column[str], ...]:
    """The columns of a text in Chinese and in English."""
    return tuple(_column(f"{name}_{language}", kind) for language in ("zh", "en"))


def _reference(
    name: str, table: str, *, ondelete: str = "CASCADE", nullable: bool = False, **options: bool
) -> sa.Column[str]:
    """A column with the id of a row of a table."""
    key = sa.ForeignKey(f"{table}.id", ondelete=ondelete)
    return sa.Column(name, _ID, key, nullable=nullable, **options)  # type: ignore[arg-type]


def upgrade() -> None:
    """Create the tables."""
    op.create_table(
        "collections",
        _column("id", _ID, primary_key=True),
        *_bilingual("title", sa.String(200)),
        *_bilingual("note", sa.Text()),
        _column("source", sa.Text()),
        _column("licence", sa.String(200)),
        _column("created", _TIME),
    )
    op.create_table(
        "people",
        _column("id", _ID, primary_key=True),
        _column("name", sa.String(80)),
        _column("name_key", sa.String(80), unique=True),
        _column("role", sa.String(16)),
        _column("password", sa.String(200), nullable=True),
        _column("language", sa.String(8)),
        _column("epoch", sa.Integer()),
        _column("active", sa.Boolean()),
        _column("created", _TIME),
    )
    op.create_table(
        "settings",
        _column("name", sa.String(80), primary_key=True),
        _column("value", sa.Text()),
    )
    op.create_table(
        "classes",
        _column("id", _ID, primary_key=True),
        _column("name", sa.String(120)),
        _reference("teacher_id", "people", index=True),
        _column("created", _TIME),
    )
    op.create_table(
        "jobs",
        _column("id", _ID, primary_key=True),
        _column("kind", sa.String(40)),
        _column("payload", sa.JSON()),
        _column("state", sa.String(16)),
        _column("done", sa.Integer()),
        _column("total", sa.Integer()),
        _column("message", sa.Text()),
        _column("result", sa.JSON()),
        *_bilingual("error", sa.Text()),
        _column("tries", sa.Integer()),
        _reference("person_id", "people", nullable=True),
        _column("created", _TIME),
        _column("changed", _TIME),
        sa.Index(None, "state", "created"),
    )
    op.create_table(
        "tours",
        _column("id", _ID, primary_key=True),
        *_bilingual("title", sa.String(200)),
        _column("steps", sa.JSON()),
        _column("position", sa.Integer()),
        _reference("author_id", "people", ondelete="SET NULL", nullable=True),
        _column("created", _TIME),
    )
    op.create_table(
        "works",
        _column("id", _ID, primary_key=True),
        _reference("collection_id", "collections"),
        _column("position", sa.Integer()),
        *_bilingual("title", sa.String(200)),
        _column("character", sa.String(16), index=True),
        _column("script", sa.String(16)),
        *_bilingual("hand", sa.String(200)),
        _column("dynasty", sa.String(40)),
        *_bilingual("period", sa.String(200)),
        *_bilingual("material", sa.Text()),
        _column("source", sa.Text()),
        _column("licence", sa.String(200)),
        _column("attribution", sa.Text()),
        _column("kind", sa.String(16)),
        _column("height_source", sa.String(16)),
        _column("picture", sa.String(300)),
        _column("surface", sa.String(300), nullable=True),
        _column("capture", sa.String(300), nullable=True),
        _column("digest", sa.String(64), unique=True),
        _column("origin", sa.String(500)),
        _column("width", sa.Integer()),
        _column("height", sa.Integer()),
        _column("spacing", sa.Float(), nullable=True),
        _column("search", sa.Text()),
        _column("created", _TIME),
        _column("changed", _TIME),
        sa.Index(None, "collection_id", "position"),
        sa.Index(None, "script", "position"),
    )
    op.create_table(
        "annotations",
        _column("id", _ID, primary_key=True),
        _reference("work_id", "works", index=True),
        _column("x", sa.Float()),
        _column("y", sa.Float()),
        *_bilingual("title", sa.String(200)),
        *_bilingual("text", sa.Text()),
        _column("position", sa.Integer()),
        _reference("author_id", "people", ondelete="SET NULL", nullable=True),
        _column("created", _TIME),
    )
    op.create_table(
        "invitations",
        _column("token", sa.String(64), primary_key=True),
        _column("role", sa.String(16)),
        _reference("class_id", "classes", nullable=True),
        _reference("author_id", "people", nullable=True),
        _column("expires", _TIME),
        _column("used", _TIME, nullable=True),
        _column("created", _TIME),
    )
    op.create_table(
        "memberships",
        _reference("class_id", "classes", primary_key=True),
        _reference("person_id", "people", primary_key=True, index=True),
        _column("created", _TIME),
    )
    op.create_table(
        "tasks",
        _column("id", _ID, primary_key=True),
        _reference("class_id", "classes", index=True),
        _reference("work_id", "works"),
        _column("title", sa.String(200)),
        _column("note", sa.Text()),
        _column("due", _TIME, nullable=True),
        _column("created", _TIME),
    )
    op.create_table(
        "attempts",
        _column("id", _ID, primary_key=True),
        _reference("person_id", "people", nullable=True),
        _reference("work_id", "works"),
        _reference("task_id", "tasks", ondelete="SET NULL", nullable=True, index=True),
        _column("kind", sa.String(16)),
        _column("grid", sa.String(8)),
        _column("picture", sa.String(300)),
        _column("strokes", sa.String(300), nullable=True),
        _column("score", sa.Float(), nullable=True),
        _column("level", sa.String(16), nullable=True),
        _column("mark", sa.JSON()),
        _column("version", sa.String(20)),
        _column("created", _TIME),
        sa.Index(None, "person_id", "created"),
        sa.Index(None, "work_id", "created"),
    )
    op.create_table(
        "comparisons",
        _column("id", _ID, primary_key=True),
        _reference("judge_id", "people", index=True),
        _reference("work_id", "works"),
        _reference("first_id", "attempts"),
        _reference("second_id", "attempts"),
        _reference("left_id", "attempts"),
        _column("winner", sa.String(8)),
        _column("seconds", sa.Float(), nullable=True),
        _column("created", _TIME),
        sa.UniqueConstraint("judge_id", "first_id", "second_id"),
    )
    op.create_table(
        "teacher_marks",
        _reference("attempt_id", "attempts", primary_key=True),
        _reference("teacher_id", "people", primary_key=True),
        _column("mark", sa.Float()),
        _column("note", sa.Text()),
        _column("created", _TIME),
    )


def downgrade() -> None:
    """Drop the tables, those that refer to others first."""
    for name in ("teacher_marks", "comparisons", "attempts", "tasks", "memberships", "invitations"):
        op.drop_table(name)
    for name in ("annotations", "works", "tours", "jobs", "classes", "settings", "people", "collections"):
        op.drop_table(name)
