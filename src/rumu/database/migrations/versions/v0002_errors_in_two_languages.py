"""Why a job failed stands in two columns, one for each language; before it was one text with both in it."""

from __future__ import annotations

import re

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"

_BOTH = re.compile(r"(?P<zh>.*[^\x00-\xff].*?[。！？]) (?P<en>[A-Z].*)", re.DOTALL)
_JOBS = sa.table("jobs", *(sa.column(name, sa.Text) for name in ("id", "error_zh", "error_en")))


def upgrade() -> None:
    """To this state."""
    op.alter_column("jobs", "error", new_column_name="error_en")
    op.add_column("jobs", sa.Column("error_zh", sa.Text(), nullable=False, server_default=""))
    rows = sa.select(_JOBS.c.id, _JOBS.c.error_en).where(_JOBS.c.error_en != "")
    for job_id, told in op.get_bind().execute(rows).all():
        parts = _BOTH.fullmatch(told)  # what was told in English alone is kept for both
        zh, en = (parts["zh"], parts["en"]) if parts else (told, told)
        op.execute(sa.update(_JOBS).where(_JOBS.c.id == job_id).values(error_zh=zh, error_en=en))


def downgrade() -> None:
    """Back to the state before."""
    both = _JOBS.c.error_zh + " " + _JOBS.c.error_en
    op.execute(sa.update(_JOBS).where(_JOBS.c.error_zh != _JOBS.c.error_en).values(error_en=both))
    with op.batch_alter_table("jobs") as jobs:
        jobs.drop_column("error_zh")
    op.alter_column("jobs", "error_en", new_column_name="error")
