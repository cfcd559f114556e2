"""Schemas of the home page and of collections."""

from __future__ import annotations

from typing import Any

from pydantic import model_validator

from rumu.web.dependencies import LongText, ShortText
from rumu.web.schemas import (
    BilingualInput,
    BilingualText,
    Extended,
    Schema,
    ShortBilingualInput,
    WorkSummary,
    file_urls,
)


class CoverRead(WorkSummary):
    """The work on the home page. picture, normals: URLs of files small enough for a phone; y up."""

    picture: str
    normals: str

    @model_validator(mode="before")
    @classmethod
    def _add_maps(cls, work: Any) -> Any:
        picture, normals = file_urls(work, ("cover", "cover-normals"))
        return Extended(work, picture=picture, normals=normals)


class HomeRead(Schema):
    """What the home page shows. cover: null in an empty gallery; chosen: whether an owner chose it."""

    cover: CoverRead | None
    chosen: bool
    works: int


class CoverUpdate(Schema):
    """work: the id of a work, or null to leave the choice to the service."""

    work: ShortText | None


class CollectionRead(Schema):
    """Works that belong together. works: how many there are."""

    id: str
    title: BilingualText
    note: BilingualText
    source: str
    licence: str
    works: int


class CollectionUpdate(Schema):
    """Fields that are left out stay as they are. note: a description."""

    title: ShortBilingualInput | None = None
    note: BilingualInput | None = None
    source: LongText | None = None
    licence: ShortText | None = None
