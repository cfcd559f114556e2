"""Schemas of people, works and the gallery: what requests and responses hold, with examples."""

from __future__ import annotations

import math
from collections.abc import Iterable
from datetime import datetime
from typing import Annotated, Any, Literal
from urllib.parse import quote

from pydantic import AliasPath, BaseModel, ConfigDict, Field, model_validator

from rumu.database.tables import Work
from rumu.gallery.assets import VERSION
from rumu.gallery.vocabulary import HEIGHT_SOURCES
from rumu.studio.passwords import MAX_PASSWORD
from rumu.values import Script
from rumu.web.addresses import service_url
from rumu.web.dependencies import Id, LongText, ShortText

RoleName = Literal["owner", "teacher", "pupil"]
LanguageName = Literal["zh", "en"]
ScriptName = Literal["", Script]
Fraction = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
Spacing = Annotated[float, Field(gt=0, le=1000, allow_inf_nan=False)]


class Schema(BaseModel):
    """Base: responses are read from the attributes of rows.

    Unknown fields of a request are refused, and so are NaN and infinity, which Python's JSON lets in.
    """

    model_config = ConfigDict(extra="forbid", from_attributes=True, allow_inf_nan=False)


class Extended:
    """A row, or another object, with further attributes that a schema reads."""

    def __init__(self, base: Any, **attributes: Any) -> None:
        self._base = base
        self.__dict__.update(attributes)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._base, name)


class BilingualText(Schema):
    """The same in traditional Chinese and in English."""

    zh: str = Field(examples=["水"])
    en: str = Field(examples=["Water"])


class BilingualInput(Schema):
    """A text in both languages, as a request brings it."""

    zh: LongText = ""
    en: LongText = ""


class ShortBilingualInput(Schema):
    """A short text in both languages, as a request brings it."""

    zh: ShortText = ""
    en: ShortText = ""


class Reference(Schema):
    """A person or a class by id and name."""

    id: str
    name: str


# --- people ----------------------------------------------------------------------------------------


class PersonRead(Schema):
    """A person with a login."""

    id: str
    name: str = Field(examples=["林老師"])
    role: RoleName
    language: LanguageName
    active: bool = True


class SessionRead(Schema):
    """Who is logged in. csrf: to be sent as X-CSRF-Token with every request that changes something."""

    person: PersonRead | None
    csrf: str
    owner_exists: bool
    languages: list[str]
    version: str


class Credentials(Schema):
    """Name and password."""

    name: ShortText = Field(examples=["林老師"])
    password: str = Field(max_length=2 * MAX_PASSWORD, examples=["a long password"])


class InvitationCreate(Schema):
    """For whom a link is. class_id: the class that a pupil joins with it."""

    role: RoleName = "pupil"
    class_id: Id | None = None


class InvitationLink(Schema):
    """link: path of the page, to be put behind this service's address. Works once."""

    link: str = Field(examples=["/#/join/TOKEN"])
    token: str
    role: RoleName
    expires: datetime


class InvitationRead(Schema):
    """What an invitation is for."""

    role: RoleName
    school_class: Reference | None = Field(alias="class")
    expires: datetime


class PersonUpdate(Schema):
    """What an owner changes of a person. password: a new one for a person who forgot theirs."""

    name: ShortText | None = None
    role: RoleName | None = None
    language: LanguageName | None = None
    active: bool | None = None
    password: str | None = Field(default=None, max_length=2 * MAX_PASSWORD)


class SessionUpdate(Schema):
    """What people change of themselves."""

    language: LanguageName


class PasswordUpdate(Schema):
    """old: the present password."""

    old: str = Field(max_length=2 * MAX_PASSWORD)
    new: str = Field(max_length=2 * MAX_PASSWORD)


# --- works -----------------------------------------------------------------------------------------

_FILES = {
    **{name: name for name in ("picture", "albedo", "normals", "mask", "glb", "stl", "ply")},
    "normals16": "normals-16",
    "height": "height16",
    "heights": "heights",
}


def file_version(work: Work) -> str:
    """A version that changes whenever a file of the work may have changed."""
    return f"{work.digest[:8]}{int(work.changed.timestamp()):x}-{VERSION}"


def file_urls(work: Work, kinds: Iterable[str]) -> list[str]:
    """The URLs of files of a work, with their version, so that clients may keep the files for ever."""
    version = file_version(work)
    work_id = quote(work.id, safe="")
    return [service_url(f"/api/works/{work_id}/files/{kind}?v={version}") for kind in kinds]


def _usable_numbers(work: Any) -> dict[str, Any]:
    """The numbers of a work; unknown in place of what imports once stored unchecked, such as 'abc'.

    One work must not end the list of all.
    """
    numbers: dict[str, Any] = {}
    for name in ("width", "height"):
        value = getattr(work, name)
        numbers[name] = value if isinstance(value, int) else 0
    spacing = work.spacing
    usable = isinstance(spacing, float | int) and math.isfinite(spacing) and spacing > 0
    known = work.height_source in HEIGHT_SOURCES
    return numbers | {
        "spacing": spacing if usable else None,
        "height_source": work.height_source if known else "inflation",
    }


class WorkSummary(Schema):
    """A work in a list. thumb, thumb_normals: URLs of pictures. parent: the page that it stands on."""

    id: str = Field(examples=["regular-shui"])
    title: BilingualText
    character: str = Field(examples=["水"])
    script: str = Field(examples=["regular"])
    hand: BilingualText
    dynasty: str
    period: BilingualText
    collection: str = Field(validation_alias="collection_id", examples=["starter"])
    parent: str | None = Field(validation_alias="parent_id")
    kind: str = Field(examples=["image"])
    height_source: Literal["photometric", "inflation", "density"]
    width: int = Field(examples=[512])
    height: int = Field(examples=[512])
    thumb: str
    thumb_normals: str

    @model_validator(mode="before")
    @classmethod
    def _add_urls(cls, work: Any) -> Any:
        thumb, thumb_normals = file_urls(work, ("thumb", "thumb-normals"))
        return Extended(work, thumb=thumb, thumb_normals=thumb_normals, **_usable_numbers(work))


class AnnotationRead(Schema):
    """A note on a point of a work. x, y: fractions of the picture, origin top left."""

    id: str
    x: float
    y: float
    title: BilingualText
    text: BilingualText


class AnnotationCreate(Schema):
    """As AnnotationRead; at least one of the texts is not empty."""

    x: Fraction = Field(examples=[0.42])
    y: Fraction = Field(examples=[0.3])
    title: ShortBilingualInput = ShortBilingualInput()
    text: BilingualInput = BilingualInput()


class AnnotationUpdate(Schema):
    """Fields that are left out stay as they are."""

    x: Fraction | None = None
    y: Fraction | None = None
    title: ShortBilingualInput | None = None
    text: BilingualInput | None = None


class PlaceRead(Schema):
    """Where a character stands on its page.

    polygon: fractions of the page's width and height, origin top left. register, column, row: from 0 in
    reading order. small: 0 or 1 in the right or left line of a double row, null in the main text.
    certainty: 0 to 1, that it is one whole character under its right name.
    """

    polygon: list[list[float]]
    register_: int = Field(alias="register")
    column: int
    row: int
    small: int | None
    certainty: float
    direction: Literal["vertical", "horizontal"]


class CharacterWithinRead(Schema):
    """A character of a page, in reading order: the id of its own work, and its place."""

    id: str
    character: str = Field(examples=["永"])
    place: PlaceRead


class WithinRead(Schema):
    """The page that a character stands on, and how often it stands there, with this one."""

    id: str
    title: BilingualText
    place: PlaceRead
    same: list[str] = Field(description="Ids of the works of the same character there, in reading order.")


class WorkRead(WorkSummary):
    """All that is known of a work. files: URLs.

    previous, next: ids in the same collection, or on the same page. characters: how many stand on this page;
    text: what is written on it; within: the page that this character stands on. record: what a museum says
    of it in its IIIF manifest, by language.
    """

    material: BilingualText
    source: str
    licence: str
    attribution: str
    collection_title: BilingualText
    files: dict[str, str]
    annotations: list[AnnotationRead]
    spacing: float | None
    created: datetime
    previous: str | None
    next: str | None
    characters: int
    text: str
    within: WithinRead | None
    record: dict[str, Any] | None

    @model_validator(mode="before")
    @classmethod
    def _add_files(cls, work: Any) -> Any:
        files = dict(zip(_FILES, file_urls(work, _FILES.values()), strict=True))
        files["manifest"] = service_url(f"/iiif/works/{work.id}/manifest.json")
        return Extended(work, files=files)


class WorkUpdate(Schema):
    """Fields that are left out stay as they are. spacing: mm for each pixel; null if it is not known."""

    title: ShortBilingualInput | None = None
    hand: ShortBilingualInput | None = None
    period: ShortBilingualInput | None = None
    material: BilingualInput | None = None
    character: Annotated[ShortText, Field(max_length=16)] | None = None
    script: ScriptName | None = None
    dynasty: Annotated[ShortText, Field(max_length=40)] | None = None
    source: LongText | None = None
    licence: ShortText | None = None
    attribution: LongText | None = None
    position: Annotated[int, Field(ge=0, le=10**6)] | None = None
    spacing: Spacing | None = None


class HeightsFile(Schema):
    """url: of raw float32 values, little endian, row by row from the top, in `unit`."""

    url: str
    width: int
    height: int
    min: float
    max: float


class SurfaceRead(Schema):
    """What the viewer needs of a surface. width, height: pixels of normals and albedo; spacing: of those."""

    model_config = ConfigDict(extra="allow")

    width: int = Field(validation_alias=AliasPath("pixels", 0))
    height: int = Field(validation_alias=AliasPath("pixels", 1))
    aspect: float
    unit: Literal["mm", "px"]
    spacing: float
    source: Literal["photometric", "inflation", "density"]
    source_text: BilingualText
    heights: HeightsFile = Field(validation_alias="height")
    normals: str
    albedo: str
    picture: str
    mask: str
    three_lamps: dict[str, Any] | None
    glb: str
    tiles: dict[str, str] | None = Field(
        None,
        description="Of a work of more than 1024 pixels: image services (level 0) of albedo, normals and "
        "heights, of a measured one of its picture, and of its three photographs (lamp-a, lamp-b, lamp-c), "
        "where it has them; and their version, as `?v=` of their addresses.",
    )
