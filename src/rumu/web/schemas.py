"""What goes over the wire about people, works and the gallery; examples stand in the documentation."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from rumu.studio.passwords import LONGEST
from rumu.web.dependencies import IdText, Line, Prose

RoleName = Literal["owner", "teacher", "pupil"]
LanguageName = Literal["zh", "en"]
Number = Annotated[float, Field(allow_inf_nan=False)]
Share = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]


class Shape(BaseModel):
    """Base: unknown fields are refused, so that a slip of the pen is told."""

    model_config = ConfigDict(extra="forbid")


class Text(Shape):
    """The same in traditional Chinese and in English."""

    zh: str = Field(examples=["水"])
    en: str = Field(examples=["Water"])


class Said(Shape):
    """A text in both languages, as somebody sends it."""

    zh: Prose = ""
    en: Prose = ""


class Title(Shape):
    """A short text in both languages, as somebody sends it."""

    zh: Line = ""
    en: Line = ""


# --- people ----------------------------------------------------------------------------------------


class PersonFacts(Shape):
    """Somebody with a login."""

    id: str
    name: str = Field(examples=["林老師"])
    role: RoleName
    language: LanguageName
    active: bool = True


class SessionFacts(Shape):
    """Who is logged in. csrf: to be sent back as X-CSRF-Token with everything that changes something."""

    person: PersonFacts | None
    csrf: str
    owner_exists: bool
    languages: list[str]
    version: str


class Credentials(Shape):
    """Name and password."""

    name: Line = Field(examples=["林老師"])
    password: str = Field(max_length=2 * LONGEST, examples=["a long password"])


class InvitationOrder(Shape):
    """For whom a link is. class_id: the class that a pupil joins with it."""

    role: RoleName = "pupil"
    class_id: IdText | None = None


class InvitationLink(Shape):
    """link: path of the page, to be put behind this service's address. Works once."""

    link: str = Field(examples=["/#/join/TOKEN"])
    token: str
    role: RoleName
    expires: datetime


class ClassName(Shape):
    """A class by id and name."""

    id: str
    name: str


class InvitationFacts(Shape):
    """What an invitation is for."""

    model_config = ConfigDict(populate_by_name=True, extra="forbid")

    role: RoleName
    school_class: ClassName | None = Field(alias="class")
    expires: datetime


class PersonChange(Shape):
    """What an owner changes of a person; password: a new one for somebody who forgot theirs."""

    name: Line | None = None
    role: RoleName | None = None
    language: LanguageName | None = None
    active: bool | None = None
    password: str | None = Field(default=None, max_length=2 * LONGEST)


class OwnChange(Shape):
    """What people change of themselves."""

    language: LanguageName


class PasswordChange(Shape):
    """old: as it was."""

    old: str = Field(max_length=2 * LONGEST)
    new: str = Field(max_length=2 * LONGEST)


# --- works -----------------------------------------------------------------------------------------


class WorkCard(Shape):
    """What a list shows of a work. thumb, thumb_normals: addresses of pictures."""

    id: str = Field(examples=["regular-shui"])
    title: Text
    character: str = Field(examples=["水"])
    script: str = Field(examples=["regular"])
    hand: Text
    dynasty: str
    period: Text
    collection: str = Field(examples=["starter"])
    kind: str = Field(examples=["image"])
    height_source: Literal["photometric", "inflation", "density"]
    width: int = Field(examples=[512])
    height: int = Field(examples=[512])
    thumb: str
    thumb_normals: str


class WorkPage(Shape):
    """A part of all that match."""

    total: int
    items: list[WorkCard]


class AnnotationFacts(Shape):
    """Something said of a point. x, y: fractions of the picture, origin top left."""

    id: str
    x: float
    y: float
    title: Text
    text: Text


class AnnotationNew(Shape):
    """As AnnotationFacts; one of the texts must say something."""

    x: Share = Field(examples=[0.42])
    y: Share = Field(examples=[0.3])
    title: Title = Title()
    text: Said = Said()


class AnnotationChange(Shape):
    """What is left out stays."""

    x: Share | None = None
    y: Share | None = None
    title: Title | None = None
    text: Said | None = None


class WorkFacts(WorkCard):
    """All that is known of a work. files: addresses. previous, next: ids in the same collection."""

    material: Text
    source: str
    licence: str
    attribution: str
    collection_title: Text
    files: dict[str, str]
    annotations: list[AnnotationFacts]
    spacing: float | None
    created: datetime
    previous: str | None
    next: str | None


class WorkChange(Shape):
    """What is left out stays. spacing: millimetres for each pixel; null where it is not known any more."""

    title: Title | None = None
    hand: Title | None = None
    period: Title | None = None
    material: Said | None = None
    character: Annotated[Line, Field(max_length=16)] | None = None
    script: Literal["", "seal", "clerical", "regular", "running", "cursive"] | None = None
    dynasty: Annotated[Line, Field(max_length=40)] | None = None
    source: Prose | None = None
    licence: Line | None = None
    attribution: Prose | None = None
    position: Annotated[int, Field(ge=0, le=10**6)] | None = None
    spacing: Annotated[float, Field(gt=0, le=1000, allow_inf_nan=False)] | None = None


class FacetFacts(Shape):
    """One choice and how many works it leaves."""

    value: str
    zh: str
    en: str
    count: int


class CollectionFacts(Shape):
    """Works that belong together."""

    id: str
    title: Text
    note: Text
    source: str
    licence: str
    works: int


class Heights(Shape):
    """url: raw float32, little endian, row by row from the top, in `unit`."""

    url: str
    width: int
    height: int
    min: float
    max: float


class ViewerFacts(Shape):
    """What the viewer needs of a surface. width, height: pixels of normals and albedo; spacing: of those."""

    model_config = ConfigDict(extra="allow")

    width: int
    height: int
    aspect: float
    unit: Literal["mm", "px"]
    spacing: float
    source: Literal["photometric", "inflation", "density"]
    source_text: Text
    heights: Heights
    normals: str
    albedo: str
    picture: str
    mask: str
    three_lamps: dict[str, Any] | None
    glb: str


class TourStep(Shape):
    """view: the query of the viewer's permalink."""

    work: IdText = Field(examples=["regular-shui"])
    view: Annotated[Line, Field(max_length=500)] = ""
    title: Title = Title()
    text: Said = Said()


class TourNew(Shape):
    """A walk through works."""

    title: Title
    steps: list[TourStep] = Field(max_length=100)


class TourChange(Shape):
    """What is left out stays."""

    title: Title | None = None
    steps: list[TourStep] | None = Field(default=None, max_length=100)


class TourFacts(Shape):
    """A guided walk."""

    id: str
    title: Text
    steps: list[dict[str, Any]]
