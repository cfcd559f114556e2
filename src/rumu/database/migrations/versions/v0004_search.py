"""The texts that searches look through stand in one column for each meaning, with the version of their rules.

The gallery makes the texts when it is opened, as the rules are its own.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"

_TEXTS = ("search_character", "search_title", "search_hand", "search_more")


def upgrade() -> None:
    """Replace the one text by four."""
    op.drop_column("works", "search")
    for name in _TEXTS:
        op.add_column("works", sa.Column(name, sa.Text(), nullable=False, server_default=""))
    op.add_column("works", sa.Column("search_version", sa.Integer(), nullable=False, server_default="0"))


def downgrade() -> None:
    """Bring the one text back, empty."""
    for name in (*_TEXTS, "search_version"):
        op.drop_column("works", name)
    op.add_column("works", sa.Column("search", sa.Text(), nullable=False, server_default=""))
