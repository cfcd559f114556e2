"""Schemas of the home page and of collections."""

from __future__ import annotations

from typing import Any

from pydantic import Field, model_validator

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


class TourSummary(Schema):
    """A tour that belongs to a collection."""

    id: str
    title: BilingualText


class ExhibitionRead(CollectionRead):
    """A collection with what its page shows.

    cover: the work that its owner chose, or its first; null when it has none. tour: null when it has none.
    """

    cover: CoverRead | None
    chosen: bool
    tour: TourSummary | None


class OrderUpdate(Schema):
    """works: ids of the works that come first, in this order; the others follow as they stand."""

    works: list[ShortText] = Field(max_length=10_000)


class CollectionUpdate(Schema):
    """Fields that are left out stay as they are. note: a description.

    cover: the id of a work of the collection, or '' to leave the choice to the service. tour: the id of a
    tour, or '' for none.
    """

    title: ShortBilingualInput | None = None
    note: BilingualInput | None = None
    source: LongText | None = None
    licence: ShortText | None = None
    cover: ShortText | None = None
    tour: ShortText | None = None
