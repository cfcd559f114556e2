"""Photographs of practice sheets that people send, with what was read in them."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"


def upgrade() -> None:
    """Add the table."""
    op.create_table(
        "sheet_uploads",
        sa.Column("id", sa.String(64), nullable=False),
        sa.Column("person_id", sa.String(64), nullable=False),
        sa.Column("class_id", sa.String(64), nullable=True),
        sa.Column("photos", sa.JSON(), nullable=False),
        sa.Column("files", sa.String(300), nullable=True),
        sa.Column("created", sa.DateTime(timezone=True), nullable=False),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_sheet_uploads")),
        sa.ForeignKeyConstraint(
            ["person_id"], ["people.id"], name=op.f("fk_sheet_uploads_person_id_people"), ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["class_id"], ["classes.id"], name=op.f("fk_sheet_uploads_class_id_classes"), ondelete="SET NULL"
        ),
    )
    for column in ("person_id", "class_id"):
        op.create_index(op.f(f"ix_sheet_uploads_{column}_created"), "sheet_uploads", [column, "created"])


def downgrade() -> None:
    """Take it away."""
    op.drop_table("sheet_uploads")
