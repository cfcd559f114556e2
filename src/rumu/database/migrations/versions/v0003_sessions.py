"""Sessions as rows, so that they can be ended one by one; before, a number of the person ended them all.

Everybody logs in once more after this migration.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    """Create the table of sessions."""
    op.create_table(
        "sessions",
        sa.Column("id", sa.String(64), primary_key=True, nullable=False),
        sa.Column(
            "person_id",
            sa.String(64),
            sa.ForeignKey("people.id", ondelete="CASCADE"),
            nullable=False,
            index=True,
        ),
        sa.Column("created", sa.DateTime(timezone=True), nullable=False),
    )
    op.drop_column("people", "epoch")


def downgrade() -> None:
    """Drop the table; all sessions end."""
    op.add_column("people", sa.Column("epoch", sa.Integer(), nullable=False, server_default="0"))
    op.drop_table("sessions")
