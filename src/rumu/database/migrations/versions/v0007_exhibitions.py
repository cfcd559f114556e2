"""The cover and the tour of a collection."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"


def upgrade() -> None:
    """Add the columns."""
    for name in ("cover_id", "tour_id"):
        op.add_column("collections", sa.Column(name, sa.String(64), nullable=False, server_default=""))


def downgrade() -> None:
    """Take them away."""
    for name in ("cover_id", "tour_id"):
        op.drop_column("collections", name)
