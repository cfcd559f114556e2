"""The schema of rows has the columns of the tables, no more and no fewer, and bounds each of them."""

from __future__ import annotations

import json

import pytest
from sqlalchemy import String

from rumu.database.tables import Annotation, Collection, Tour, Work, now
from rumu.errors import GalleryError
from rumu.gallery.archive import NOT_EXPORTED
from rumu.gallery.metadata import CollectionMetadata, StoredFiles, WorkMetadata, work_row
from rumu.gallery.rows import AnnotationRow, CollectionRow, StepRow, TourRow, WorkRow, read_row
from rumu.gallery.tours import _STEP
from rumu.values import Bilingual

TABLES = [(Work, WorkRow), (Annotation, AnnotationRow), (Collection, CollectionRow), (Tour, TourRow)]
HERE = Bilingual("這裡", "here")


@pytest.mark.parametrize(("table", "model"), TABLES, ids=lambda one: one.__name__)
def test_each_column_of_a_table_is_checked_by_its_schema(table, model):
    columns = {column.name for column in table.__table__.columns}
    assert set(model.model_fields) == columns - NOT_EXPORTED
    assert set(StepRow.model_fields) == set(_STEP)


def values_of(table) -> dict:
    """A row that is as it must be."""
    digest, time = "ab" * 32, now().isoformat()
    texts = {"title_zh": "題", "title_en": "Title"}
    return {
        Work: texts
        | {"id": "a", "collection_id": "b", "picture": f"pictures/ab/{digest}.png", "digest": digest}
        | {"width": 9, "height": 9, "created": time, "changed": time},
        Annotation: {"id": "a", "work_id": "b", "x": 0, "y": 1, "created": time},
        Collection: texts | {"id": "a", "created": time},
        Tour: texts | {"id": "a", "steps": [], "created": time},
    }[table]


@pytest.mark.parametrize(("table", "model"), TABLES, ids=lambda one: one.__name__)
def test_no_text_is_longer_than_its_column(table, model):
    row = values_of(table)
    assert read_row(model, json.dumps(row), where=HERE)
    for column in table.__table__.columns:
        if not isinstance(column.type, String) or column.type.length is None or column.name in NOT_EXPORTED:
            continue
        long = row | {column.name: "長" * (column.type.length + 1)}
        if column.name in ("dynasty", "licence") and table is Work:
            cut = read_row(model, json.dumps(long), where=HERE)
            assert len(getattr(cut, column.name)) == column.type.length
            continue
        with pytest.raises(GalleryError, match=f"here: {column.name}: ") as refused:
            read_row(model, json.dumps(long), where=HERE)
        assert f"這裡「{column.name}」" in refused.value.zh


@pytest.mark.parametrize("character", ["\0", "\x1b", "\x7f"])
def test_a_work_with_control_characters_is_not_made(character):
    files = StoredFiles(picture=f"pictures/ab/{'ab' * 32}.png", digest="ab" * 32, width=9, height=9)
    collection = CollectionMetadata(id="a", title=Bilingual("集", "Set"))
    good = WorkMetadata(title=Bilingual("題", "Title"), origin="row 3", dynasty="d" * 60, licence="l" * 300)
    row = work_row(good, files, collection=collection, position=0)
    assert (len(row["dynasty"]), len(row["licence"])) == (40, 200)
    bad = WorkMetadata(title=Bilingual("題", f"a{character}b"), origin="row 3")
    with pytest.raises(GalleryError, match="row 3: title_en"):
        work_row(bad, files, collection=collection, position=0)
