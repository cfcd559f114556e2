"""Characters within a page or scroll are works of their own, and works keep what a museum says of them.

The foreign key is made by the statement that adds its column: SQLite can add it in no other way without
making the table anew, and with it everything that hangs on its rows would go.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"


def upgrade() -> None:
    """Add the columns."""
    if "parent_id" not in {column["name"] for column in sa.inspect(op.get_bind()).get_columns("works")}:
        op.execute(
            "ALTER TABLE works ADD COLUMN parent_id VARCHAR(64) "
            "CONSTRAINT fk_works_parent_id REFERENCES works (id)"
        )
    op.add_column("works", sa.Column("occurrence", sa.Integer(), nullable=False, server_default="0"))
    op.add_column("works", sa.Column("place", sa.JSON(), nullable=True))
    op.add_column("works", sa.Column("text", sa.Text(), nullable=False, server_default=""))
    op.add_column("works", sa.Column("record", sa.JSON(), nullable=True))
    op.create_index("ix_works_parent_id_position", "works", ["parent_id", "position"])


def downgrade() -> None:
    """Drop them; characters within pages become works like all others."""
    op.drop_index("ix_works_parent_id_position", "works")
    for name in ("record", "text", "place", "occurrence"):
        op.drop_column("works", name)
    if op.get_bind().dialect.name == "sqlite":  # it drops no column that refers to a row, and here it stays
        op.execute("UPDATE works SET parent_id = NULL")
        return
    op.drop_column("works", "parent_id")
