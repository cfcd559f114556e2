"""What goes over the wire about people, works and the gallery; examples stand in the documentation."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from rumu.studio.passwords import LONGEST
from rumu.web.dependencies import Id, LongText, ShortText

RoleName = Literal["owner", "teacher", "pupil"]
LanguageName = Literal["zh", "en"]
Number = Annotated[float, Field(allow_inf_nan=False)]
Share = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]


class Schema(BaseModel):
    """Base: unknown fields are refused, so that a slip of the pen is told."""

    model_config = ConfigDict(extra="forbid")


class BilingualText(Schema):
    """The same in traditional Chinese and in English."""

    zh: str = Field(examples=["水"])
    en: str = Field(examples=["Water"])


class BilingualInput(Schema):
    """A text in both languages, as somebody sends it."""

    zh: LongText = ""
    en: LongText = ""


class ShortBilingualInput(Schema):
    """A short text in both languages, as somebody sends it."""

    zh: ShortText = ""
    en: ShortText = ""


# --- people ----------------------------------------------------------------------------------------


class PersonRead(Schema):
    """CurrentUser with a login."""

    id: str
    name: str = Field(examples=["林老師"])
    role: RoleName
    language: LanguageName
    active: bool = True


class SessionRead(Schema):
    """Who is logged in. csrf: to be sent back as X-CSRF-Token with everything that changes something."""

    person: PersonRead | None
    csrf: str
    owner_exists: bool
    languages: list[str]
    version: str


class Credentials(Schema):
    """Name and password."""

    name: ShortText = Field(examples=["林老師"])
    password: str = Field(max_length=2 * LONGEST, examples=["a long password"])


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


class Reference(Schema):
    """A person or a class by id and name."""

    id: str
    name: str


class InvitationRead(Schema):
    """What an invitation is for."""

    model_config = ConfigDict(populate_by_name=True, extra="forbid")

    role: RoleName
    school_class: Reference | None = Field(alias="class")
    expires: datetime


class PersonUpdate(Schema):
    """What an owner changes of a person; password: a new one for somebody who forgot theirs."""

    name: ShortText | None = None
    role: RoleName | None = None
    language: LanguageName | None = None
    active: bool | None = None
    password: str | None = Field(default=None, max_length=2 * LONGEST)


class SessionUpdate(Schema):
    """What people change of themselves."""

    language: LanguageName


class PasswordUpdate(Schema):
    """old: as it was."""

    old: str = Field(max_length=2 * LONGEST)
    new: str = Field(max_length=2 * LONGEST)


# --- works -----------------------------------------------------------------------------------------


class WorkSummary(Schema):
    """What a list shows of a work. thumb, thumb_normals: addresses of pictures."""

    id: str = Field(examples=["regular-shui"])
    title: BilingualText
    character: str = Field(examples=["水"])
    script: str = Field(examples=["regular"])
    hand: BilingualText
    dynasty: str
    period: BilingualText
    collection: str = Field(examples=["starter"])
    kind: str = Field(examples=["image"])
    height_source: Literal["photometric", "inflation", "density"]
    width: int = Field(examples=[512])
    height: int = Field(examples=[512])
    thumb: str
    thumb_normals: str


class WorkPage(Schema):
    """A part of all that match."""

    total: int
    items: list[WorkSummary]


class AnnotationRead(Schema):
    """Something said of a point. x, y: fractions of the picture, origin top left."""

    id: str
    x: float
    y: float
    title: BilingualText
    text: BilingualText


class AnnotationCreate(Schema):
    """As AnnotationRead; one of the texts must say something."""

    x: Share = Field(examples=[0.42])
    y: Share = Field(examples=[0.3])
    title: ShortBilingualInput = ShortBilingualInput()
    text: BilingualInput = BilingualInput()


class AnnotationUpdate(Schema):
    """What is left out stays."""

    x: Share | None = None
    y: Share | None = None
    title: ShortBilingualInput | None = None
    text: BilingualInput | None = None


class WorkRead(WorkSummary):
    """All that is known of a work. files: addresses. previous, next: ids in the same collection."""

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


class WorkUpdate(Schema):
    """What is left out stays. spacing: millimetres for each pixel; null where it is not known any more."""

    title: ShortBilingualInput | None = None
    hand: ShortBilingualInput | None = None
    period: ShortBilingualInput | None = None
    material: BilingualInput | None = None
    character: Annotated[ShortText, Field(max_length=16)] | None = None
    script: Literal["", "seal", "clerical", "regular", "running", "cursive"] | None = None
    dynasty: Annotated[ShortText, Field(max_length=40)] | None = None
    source: LongText | None = None
    licence: ShortText | None = None
    attribution: LongText | None = None
    position: Annotated[int, Field(ge=0, le=10**6)] | None = None
    spacing: Annotated[float, Field(gt=0, le=1000, allow_inf_nan=False)] | None = None


class FacetValueRead(Schema):
    """One choice and how many works it leaves."""

    value: str
    zh: str
    en: str
    count: int


class CollectionRead(Schema):
    """Works that belong together."""

    id: str
    title: BilingualText
    note: BilingualText
    source: str
    licence: str
    works: int


class HeightsFile(Schema):
    """url: raw float32, little endian, row by row from the top, in `unit`."""

    url: str
    width: int
    height: int
    min: float
    max: float


class SurfaceRead(Schema):
    """What the viewer needs of a surface. width, height: pixels of normals and albedo; spacing: of those."""

    model_config = ConfigDict(extra="allow")

    width: int
    height: int
    aspect: float
    unit: Literal["mm", "px"]
    spacing: float
    source: Literal["photometric", "inflation", "density"]
    source_text: BilingualText
    heights: HeightsFile
    normals: str
    albedo: str
    picture: str
    mask: str
    three_lamps: dict[str, Any] | None
    glb: str


class TourStep(Schema):
    """view: the query of the viewer's permalink."""

    work: Id = Field(examples=["regular-shui"])
    view: Annotated[ShortText, Field(max_length=500)] = ""
    title: ShortBilingualInput = ShortBilingualInput()
    text: BilingualInput = BilingualInput()


class TourCreate(Schema):
    """A walk through works."""

    title: ShortBilingualInput
    steps: list[TourStep] = Field(max_length=100)


class TourUpdate(Schema):
    """What is left out stays."""

    title: ShortBilingualInput | None = None
    steps: list[TourStep] | None = Field(default=None, max_length=100)


class TourRead(Schema):
    """A guided walk."""

    id: str
    title: BilingualText
    steps: list[dict[str, Any]]
