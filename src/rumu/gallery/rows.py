"""The rows of works, annotations, collections and tours as everything that comes in must have them.

An export may have been written by anyone, and SQLite stores whatever it is given. So each column of each row
is checked here, by one schema: its type, its range, its length, the form of ids and of keys of the store.
"""

from __future__ import annotations

import re
from datetime import datetime
from typing import Annotated, Any, Literal, Self, TypeVar

from pydantic import (
    AfterValidator,
    AwareDatetime,
    BaseModel,
    ConfigDict,
    Field,
    StringConstraints,
    ValidationError,
    model_validator,
)
from typing_extensions import TypedDict  # pydantic reads no other one before Python 3.12

from rumu.database.tables import ID_PATTERN, reject_control_characters
from rumu.errors import GalleryError
from rumu.values import Bilingual, Script

Model = TypeVar("Model", bound=BaseModel)

PICTURE_KEY = r"^pictures/[0-9a-f]{2}/[0-9a-f]{64}\.[a-z]{3,5}$"
_FOLDER_KEY = r"/[0-9a-f]{2}/[0-9a-f]{64}$"
_FILE_KEY = re.compile(r"(?:captures|surfaces)/[0-9a-f]{2}/[0-9a-f]{64}/[A-Za-z0-9][A-Za-z0-9._=-]{0,80}")


def _check_year(time: datetime) -> datetime:
    """A time that every database and every time zone can hold. Raises ValueError for another."""
    if not 1970 < time.year < 2200:
        raise ValueError("expected a year between 1970 and 2200")
    return time


_clean = AfterValidator(reject_control_characters)
RowId = Annotated[str, StringConstraints(pattern=ID_PATTERN)]
IdOrNone = Annotated[str, StringConstraints(pattern=f"^$|{ID_PATTERN}")]
Line = Annotated[str, StringConstraints(max_length=200), _clean]
Passage = Annotated[str, StringConstraints(max_length=20_000), _clean]
Fraction = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
Position = Annotated[int, Field(ge=0, lt=2**31)]
Pixels = Annotated[int, Field(ge=1, le=200_000)]
Time = Annotated[AwareDatetime, AfterValidator(_check_year)]
Digest = Annotated[str, StringConstraints(pattern=r"^[0-9a-f]{64}$")]


class _Row(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


class CollectionRow(_Row):
    """A row of tables.Collection."""

    id: RowId
    title_zh: Line
    title_en: Line
    note_zh: Passage = ""
    note_en: Passage = ""
    source: Passage = ""
    licence: Line = ""
    cover_id: IdOrNone = ""
    tour_id: IdOrNone = ""
    created: Time


class AnnotationRow(_Row):
    """A row of tables.Annotation, without its author."""

    id: RowId
    work_id: RowId
    x: Fraction
    y: Fraction
    title_zh: Line = ""
    title_en: Line = ""
    text_zh: Passage = ""
    text_en: Passage = ""
    position: Position = 0
    created: Time


class StepRow(_Row):
    """A step of a tour."""

    work: RowId
    view: Annotated[str, StringConstraints(max_length=1000), _clean] = ""
    title_zh: Line = ""
    title_en: Line = ""
    text_zh: Passage = ""
    text_en: Passage = ""


class TourRow(_Row):
    """A row of tables.Tour, without its author."""

    id: RowId
    title_zh: Line
    title_en: Line
    steps: Annotated[list[StepRow], Field(max_length=100)]
    position: Position = 0
    created: Time


Point = Annotated[list[Fraction], Field(min_length=2, max_length=2)]


class PlaceRow(TypedDict):
    """Where a character stands on its page.

    polygon: x and y of its outline, fractions of the page, origin top left. register, column, row, small,
    certainty: see pages.page.PageCharacter. direction: how its column runs.
    """

    __pydantic_config__ = ConfigDict(extra="forbid", strict=True)  # type: ignore[misc]

    polygon: Annotated[list[Point], Field(min_length=4, max_length=200)]
    register: Position
    column: Position
    row: Position
    small: Literal[0, 1] | None
    certainty: Fraction
    direction: Literal["vertical", "horizontal"]


Languages = Annotated[
    dict[Annotated[str, StringConstraints(max_length=40)], Annotated[list[Passage], Field(max_length=50)]],
    Field(max_length=50),
]


class StatedFact(_Row):
    """A label with its value, each a list of texts by language, as IIIF has them."""

    label: Languages
    value: Languages


class RecordRow(_Row):
    """What a museum says of a work in its IIIF manifest: texts by language, addresses of its pages.

    label, canvas_label: of the manifest and of the leaf. statement: that must be shown. provider: names by
    language. rights, manifest, canvas, homepage: addresses.
    """

    label: Languages
    canvas_label: Languages = {}
    metadata: Annotated[list[StatedFact], Field(max_length=200)] = []
    statement: StatedFact | None = None
    provider: Annotated[list[Languages], Field(max_length=20)] = []
    rights: Annotated[str, StringConstraints(max_length=2000), _clean] = ""
    manifest: Annotated[str, StringConstraints(max_length=2000), _clean] = ""
    canvas: Annotated[str, StringConstraints(max_length=2000), _clean] = ""
    homepage: Annotated[str, StringConstraints(max_length=2000), _clean] = ""


class WorkRow(_Row):
    """A row of tables.Work, without the text that searches look through.

    A dynasty and a licence that are too long are cut, as those of labels.csv are.
    """

    id: RowId
    collection_id: RowId
    parent_id: RowId | None = None
    occurrence: Position = 0
    place: PlaceRow | None = None
    position: Position = 0
    title_zh: Line
    title_en: Line
    character: Annotated[str, StringConstraints(max_length=16), _clean] = ""
    script: Literal[Script, ""] = ""
    hand_zh: Line = ""
    hand_en: Line = ""
    dynasty: Annotated[Passage, AfterValidator(lambda text: text[:40])] = ""
    period_zh: Line = ""
    period_en: Line = ""
    material_zh: Passage = ""
    material_en: Passage = ""
    source: Passage = ""
    licence: Annotated[Passage, AfterValidator(lambda text: text[:200])] = ""
    attribution: Passage = ""
    kind: Literal["image", "capture"] = "image"
    height_source: Literal["photometric", "inflation", "density"] = "inflation"
    picture: Annotated[str, StringConstraints(pattern=PICTURE_KEY)]
    surface: Annotated[str, StringConstraints(pattern=f"^surfaces{_FOLDER_KEY}")] | None = None
    capture: Annotated[str, StringConstraints(pattern=f"^captures{_FOLDER_KEY}")] | None = None
    digest: Digest
    origin: Annotated[str, StringConstraints(max_length=500), _clean] = ""
    width: Pixels
    height: Pixels
    spacing: Annotated[float, Field(gt=0, le=1000, allow_inf_nan=False)] | None = None
    text: Passage = ""
    record: RecordRow | None = None
    created: Time
    changed: Time

    @model_validator(mode="after")
    def _check_kind(self) -> Self:
        if (self.parent_id is None) != (self.place is None):
            raise ValueError("expected a parent and a place within it, or neither")
        of_capture = (self.surface is not None, self.capture is not None, self.height_source == "photometric")
        if of_capture != (self.kind == "capture",) * 3:
            raise ValueError(
                "expected a capture with surface, capture and photometric height, or an image without"
            )
        return self


class ExportedWork(WorkRow):
    """A line of an export: a work, what is said of it, and the keys of its files, which the export brings."""

    annotations: list[AnnotationRow]
    files: list[Annotated[str, StringConstraints(max_length=300)]]

    @model_validator(mode="after")
    def _check_belongings(self) -> Self:
        if any(one.work_id != self.id for one in self.annotations):
            raise ValueError("expected annotations of this work only")
        folders = {key for key in (self.surface, self.capture) if key is not None}
        others = [key for key in self.files if key != self.picture]
        if self.picture not in self.files or {key.rpartition("/")[0] for key in others} != folders:
            raise ValueError("expected the files of this work, all of them and no others")
        if not all(map(_FILE_KEY.fullmatch, others)):
            raise ValueError("expected files with names that rumu gives")
        return self

    def columns(self) -> dict[str, Any]:
        """The columns of tables.Work."""
        return self.model_dump(exclude={"annotations", "files"})


class ExportManifest(_Row):
    """The gallery.json of an export. works: the number of its lines."""

    kind: Literal["rumu gallery"]
    format: Literal[1, 2]
    works: Annotated[int, Field(ge=0)]
    collections: list[CollectionRow]
    tours: list[TourRow]


def read_row(model: type[Model], text: str | bytes, *, where: Bilingual) -> Model:
    """A row from JSON. where: its file and line. Raises GalleryError that names the first wrong column."""
    try:
        return model.model_validate_json(text)
    except ValidationError as error:
        raise _row_error(error, where) from error


def check_row(model: type[BaseModel], row: dict[str, Any], *, name: str) -> None:
    """Raise GalleryError, which begins with a name and tells the column, when a row is not as it must be."""
    try:
        model.model_validate(row)
    except ValidationError as error:
        raise _row_error(error, Bilingual(name, name)) from error


def _row_error(error: ValidationError, where: Bilingual) -> GalleryError:
    first = error.errors(include_url=False, include_input=False, include_context=False)[0]
    column, what = ".".join(map(str, first["loc"])), first["msg"].removeprefix("Value error, ")
    return GalleryError(
        f"{where.en}: {column}{': ' if column else ''}{what}",
        zh=f"{where.zh}{f'「{column}」' if column else ''}的內容不合規定（{what}）。",
    )
