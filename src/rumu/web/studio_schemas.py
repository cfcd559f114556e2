"""What goes over the wire about marks, attempts, classes, comparisons and jobs."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field

from rumu.web.dependencies import IdText, Line, Prose
from rumu.web.schemas import PersonFacts, Shape, Text, WorkCard

Point = list[float]


class PartFacts(Shape):
    """One part of a mark, 0-100."""

    name: str = Field(examples=["structure"])
    zh: str = Field(examples=["結體"])
    en: str = Field(examples=["Structure"])
    score: float
    meaning: Text


class RemarkFacts(Shape):
    """One thing a teacher would say. region, outline: fractions of the copy's cell, origin top left."""

    kind: str = Field(examples=["lean"])
    name: Text
    zh: str
    en: str
    severity: float
    size: float
    unit: str
    region: list[float] | None
    outline: list[list[Point]]


class RefusedFacts(Text):
    """Why there is no mark."""

    code: str = Field(examples=["blank"])


class PoseFacts(Shape):
    """angle: degrees, positive clockwise. scale: copy over master. shift: fractions of the cell, x right, y
    up."""

    angle: float
    scale: float
    shift: Point


class Align(Shape):
    """matrix: [a, b, c, d, e, f]; x' = a x + c y + e, y' = b x + d y + f takes the copy's cell to the
    master's."""

    matrix: list[float]


class Residual(Shape):
    """[x, y, r] each: fractions of the own cell; r 0 on the line to 1 far off."""

    copy_: list[Point] = Field(alias="copy")
    master: list[Point]
    model_config = ConfigDict(populate_by_name=True)


class MarkFacts(Shape):
    """A mark and what it rests on; score, level and interval are null when it was refused."""

    model_config = ConfigDict(extra="allow")

    score: float | None = Field(examples=[72.4])
    level: Literal["excellent", "good", "medium", "bad"] | None
    level_text: Text | None
    cuts: dict[str, float] = Field(default={}, description="The lowest score of each level.")
    interval: list[float] | None = Field(examples=[[60.1, 83.0]])
    interval_note: Text | None
    parts: list[PartFacts]
    remarks: list[RemarkFacts]
    similarity: float | None
    sim_paper: float | None
    pose: PoseFacts | None
    refused: RefusedFacts | None
    source: list[str] | None
    source_text: Text | None
    align: Align | None
    residual: Residual | None = None
    seconds: float


class Writer(Shape):
    """Who wrote it."""

    id: str
    name: str


class TeacherMarkFacts(Shape):
    """A teacher's own mark, 0-100."""

    teacher: str
    mark: float
    note: str


class AttemptFacts(Shape):
    """One copy with its mark. id, picture: null when it was not kept. person: null where nobody wrote it."""

    id: str | None
    work: WorkCard
    person: Writer | None
    kind: Literal["pen", "photo", "simulated"]
    grid: Literal["mi", "jiu", "tian", ""]
    created: datetime
    task: str | None
    picture: str | None
    strokes: str | None = None
    mark: MarkFacts
    teacher_marks: list[TeacherMarkFacts]
    simulated: bool = False


class AttemptPage(Shape):
    """A part of all attempts, newest first; residual is left out."""

    total: int
    items: list[AttemptFacts]


class TeacherMarkOrder(Shape):
    """mark: 0-100."""

    mark: float = Field(ge=0, le=100, allow_inf_nan=False, examples=[78])
    note: Prose = ""


class CurvePoint(Shape):
    """One attempt on a curve."""

    id: str
    created: datetime
    score: float | None
    interval: list[float] | None


class PracticeWork(Shape):
    """One work that a person copied."""

    work: WorkCard
    count: int
    best: float | None
    last: float | None
    first: float | None
    curve: list[CurvePoint]


class PracticeFacts(Shape):
    """By work, the one last practised first."""

    person: Writer
    works: list[PracticeWork]


# --- classes ---------------------------------------------------------------------------------------


class ClassOrder(Shape):
    """name: of the class."""

    name: Annotated[Line, Field(min_length=1, max_length=120)] = Field(examples=["三年二班"])


class ClassCard(Shape):
    """A class in a list."""

    id: str
    name: str
    created: datetime
    pupils: int
    tasks: int


class TaskFacts(Shape):
    """What a class is to write."""

    id: str
    class_id: str
    work: WorkCard
    title: str
    note: str
    due: datetime | None
    created: datetime


class OpenInvitation(Shape):
    """A link that has not been used; the link itself was shown once."""

    expires: datetime
    created: datetime


class ClassFacts(Shape):
    """A class. pupils, invitations: empty to a pupil."""

    id: str
    name: str
    teacher: Writer | None
    pupils: list[PersonFacts]
    tasks: list[TaskFacts]
    invitations: list[OpenInvitation]


class TaskOrder(Shape):
    """due: with its time zone."""

    work: IdText = Field(examples=["regular-shui"])
    title: Line = ""
    note: Prose = ""
    due: datetime | None = Field(default=None, examples=["2026-12-01T16:00:00Z"])


class TaskRow(Shape):
    """One pupil. best, last: null where no copy was marked."""

    person: Writer
    attempts: int
    best: float | None
    last: float | None
    last_attempt: str | None
    teacher_mark: float | None


class CommonRemarkFacts(Shape):
    """count: in how many pupils' latest copies."""

    kind: str
    zh: str
    en: str
    count: int


class TaskTable(Shape):
    """The table of a task; to a pupil their own row alone."""

    task: TaskFacts
    rows: list[TaskRow]
    common: list[CommonRemarkFacts]


# --- comparisons and jobs --------------------------------------------------------------------------


class PairFacts(Shape):
    """done: pairs judged; left_over: still to judge, this one included."""

    work: WorkCard
    left: AttemptFacts
    right: AttemptFacts
    done: int
    left_over: int


class Verdict(Shape):
    """left, right: ids of the attempts as they stood. seconds: that it took."""

    left: IdText
    right: IdText
    winner: Literal["left", "right", "same"]
    seconds: float | None = Field(default=None, ge=0, le=86400, allow_inf_nan=False)


class VerdictFacts(Shape):
    """That it was kept."""

    id: str


class JobFacts(Shape):
    """Long work. total: 0 while unknown. error: why it failed."""

    id: str
    kind: str = Field(examples=["import"])
    state: Literal["queued", "running", "done", "failed", "cancelled"]
    done: int
    total: int
    message: str
    result: dict[str, Any]
    error: Text | None


class JobStarted(Shape):
    """The job that does it."""

    job: JobFacts
