"""Schemas of marks, attempts, classes, comparisons and jobs: what requests and responses hold."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ConfigDict, Field, model_validator

from rumu.web.addresses import service_url
from rumu.web.dependencies import Id, LongText, ShortText, Time
from rumu.web.schemas import BilingualText, Extended, PersonRead, Reference, Schema, WorkSummary

Point = list[float]


class PartRead(Schema):
    """One part of a mark, 0-100."""

    name: str = Field(examples=["structure"])
    zh: str = Field(examples=["結體"])
    en: str = Field(examples=["Structure"])
    score: float
    meaning: BilingualText


class RemarkRead(Schema):
    """One thing that a teacher would say.

    region, outline: fractions of the copy's cell, origin top left; master_outline: of the master's cell.
    stroke: number in the order of writing, from 1; None where it is of no single stroke, or not known.
    """

    kind: str = Field(examples=["lean"])
    name: BilingualText
    zh: str
    en: str
    severity: float
    size: float
    unit: str
    region: list[float] | None
    outline: list[list[Point]]
    master_outline: list[list[Point]] = Field(default_factory=list)
    stroke: int | None = None


class RefusalRead(BilingualText):
    """Why there is no mark."""

    code: str = Field(examples=["blank"])
    turned_by: Literal[90, 180, 270] | None = Field(
        default=None,
        examples=[90],
        description="Degrees clockwise that turn the picture upright; null where that is not what it needs.",
    )


class PoseRead(Schema):
    """How the copy lies on the master.

    angle: degrees, positive clockwise. scale: copy over master. shift: fractions of the cell, x right, y up.
    """

    angle: float
    scale: float
    shift: Point


class Alignment(Schema):
    """Takes points of the copy's cell to the master's.

    matrix: [a, b, c, d, e, f], with x' = a x + c y + e and y' = b x + d y + f.
    """

    matrix: list[float]


class ResidualPoints(Schema):
    """Points [x, y, r] of both lines: fractions of their own cell; r from 0, on the line, to 1, far off."""

    copy_: list[Point] = Field(alias="copy")
    master: list[Point]


class MarkRead(Schema):
    """A mark and what it rests on; score, level and interval are null if the copy was refused."""

    model_config = ConfigDict(extra="allow")

    score: float | None = Field(examples=[72.4])
    level: Literal["excellent", "good", "medium", "bad"] | None
    level_text: BilingualText | None
    cuts: dict[str, float] = Field(default={}, description="The lowest score of each level.")
    percentile: float | None = Field(
        default=None, description="The share of learners' copies that get a lower score, in per cent."
    )
    interval: list[float] | None = Field(examples=[[60.1, 83.0]])
    interval_note: BilingualText | None
    deduction_note: BilingualText | None = Field(
        default=None, description="What was taken off for how the whole stands in its picture."
    )
    parts: list[PartRead]
    praise: BilingualText | None = Field(default=None, description="One thing that is good; told first.")
    remarks: list[RemarkRead]
    similarity: float | None
    sim_paper: float | None
    pose: PoseRead | None
    refused: RefusalRead | None
    source: list[str] | None
    source_text: BilingualText | None
    align: Alignment | None
    residual: ResidualPoints | None = None
    seconds: float


class NumberChangeRead(Schema):
    """A number of two attempts, 0-100. change: 'same' where it is not larger than the error of measuring."""

    before: float
    after: float
    change: Literal["better", "same", "worse"]


class MarkChangeRead(NumberChangeRead):
    """The whole mark, and the change in words."""

    zh: str
    en: str


class PartChangeRead(NumberChangeRead):
    """One part of the mark, with its title."""

    name: str = Field(examples=["structure"])
    zh: str = Field(examples=["結體"])
    en: str = Field(examples=["Structure"])


class FaultChangeRead(Schema):
    """What became of one fault, in words.

    status: 'turned' where it is now to the other side. stroke: see RemarkRead. remark: index of the fault
    among this attempt's remarks; null where it is not told there.
    """

    status: Literal["gone", "smaller", "same", "larger", "turned", "new"]
    kind: str = Field(examples=["stroke_short"])
    stroke: int | None
    remark: int | None
    zh: str = Field(examples=["第三筆「橫」：仍太短，但好些了：18% → 9%。"])
    en: str = Field(examples=["Stroke 3, horizontal: still too short, but less so: 18% → 9%."])


class EarlierAttempt(Schema):
    """The attempt that another is compared with."""

    id: str
    created: datetime


class ProgressRead(Schema):
    """What changed against the attempt before, of the same writer and master."""

    previous: EarlierAttempt
    mark: MarkChangeRead
    parts: list[PartChangeRead]
    faults: list[FaultChangeRead]


class TeacherMarkRead(Schema):
    """A teacher's own mark, 0-100."""

    teacher: str
    mark: float
    note: str


class AttemptRead(Schema):
    """One copy with its mark.

    id, picture: null if the copy was not kept. person: null if nobody wrote it, as with simulated copies.
    progress: null for the first attempt at a work, for a visitor's, and in lists.
    """

    id: str | None
    work: WorkSummary
    person: Reference | None
    kind: Literal["pen", "photo", "simulated"]
    grid: Literal["mi", "jiu", "tian", ""]
    created: datetime
    task: str | None = Field(validation_alias="task_id")
    picture: str | None
    strokes: str | None = None
    mark: MarkRead
    teacher_marks: list[TeacherMarkRead]
    simulated: bool = False
    progress: ProgressRead | None = None

    @model_validator(mode="before")
    @classmethod
    def _flatten(cls, shown: Any) -> Any:
        """From AttemptDetails, Extended where `progress` is known. `attempt_response` adds the residual."""
        attempt = shown.attempt
        mark = {name: value for name, value in attempt.mark.items() if name not in ("untold", "framed")}
        url = service_url(f"/api/attempts/{attempt.id}")
        return Extended(
            attempt,
            work=shown.work,
            person=shown.person,
            picture=attempt.id and f"{url}/picture",
            strokes=attempt.strokes and f"{url}/strokes",
            mark=mark,
            progress=getattr(shown, "progress", None),
            teacher_marks=[
                {"teacher": person.name, "mark": mark.mark, "note": mark.note}
                for person, mark in shown.teacher_marks
            ],
            simulated=attempt.kind == "simulated",
        )


class AttemptPage(Schema):
    """A part of all attempts, newest first, without residuals. total: how many there are."""

    total: int
    items: list[AttemptRead]


class TeacherMarkCreate(Schema):
    """mark: 0-100."""

    mark: float = Field(ge=0, le=100, allow_inf_nan=False, examples=[78])
    note: LongText = ""


class CurvePoint(Schema):
    """One attempt on a curve."""

    id: str
    created: datetime
    score: float | None
    interval: list[float] | None


class PracticeWork(Schema):
    """One work that a person copied. best, last, first: scores, null if no copy has one."""

    work: WorkSummary
    count: int
    best: float | None
    last: float | None
    first: float | None
    curve: list[CurvePoint] = Field(validation_alias="points")


class PracticeRead(Schema):
    """A person's practice by work, the one last practised first."""

    person: Reference
    works: list[PracticeWork]


# --- classes ---------------------------------------------------------------------------------------


class ClassCreate(Schema):
    """name: of the class."""

    name: Annotated[ShortText, Field(min_length=1, max_length=120)] = Field(examples=["三年二班"])


class ClassSummary(Schema):
    """A class in a list. pupils, tasks: how many there are."""

    id: str
    name: str
    created: datetime
    pupils: int
    tasks: int


class TaskRead(Schema):
    """What a class is to write."""

    id: str
    class_id: str
    work: WorkSummary
    title: str
    note: str
    due: datetime | None
    created: datetime


class OpenInvitation(Schema):
    """A link that has not been used; the link itself was shown once."""

    expires: datetime
    created: datetime


class ClassRead(Schema):
    """A class. pupils, invitations: empty for a pupil."""

    id: str
    name: str
    teacher: Reference | None
    pupils: list[PersonRead]
    tasks: list[TaskRead]
    invitations: list[OpenInvitation]


class TaskCreate(Schema):
    """due: with its time zone."""

    work: Id = Field(examples=["regular-shui"])
    title: ShortText = ""
    note: LongText = ""
    due: Time | None = Field(default=None, examples=["2026-12-01T16:00:00Z"])


class TaskRow(Schema):
    """One pupil. best, last: null if no copy was marked."""

    person: Reference
    attempts: int
    best: float | None
    last: float | None
    last_attempt: str | None = Field(validation_alias="last_id")
    teacher_mark: float | None


class CommonRemarkRead(Schema):
    """count: in how many pupils' latest copies."""

    kind: str
    zh: str
    en: str
    count: int


class TaskTable(Schema):
    """The table of a task; for a pupil only their own row."""

    task: TaskRead
    rows: list[TaskRow]
    common: list[CommonRemarkRead]


# --- comparisons and jobs --------------------------------------------------------------------------


class PairRead(Schema):
    """done: pairs that are judged; left_over: pairs that remain, this one included."""

    work: WorkSummary
    left: AttemptRead
    right: AttemptRead
    done: int
    left_over: int


class ComparisonCreate(Schema):
    """left, right: ids of the attempts where they stood. seconds: that the judgement took."""

    left: Id
    right: Id
    winner: Literal["left", "right", "same"]
    seconds: float | None = Field(default=None, ge=0, le=86400, allow_inf_nan=False)


class ComparisonRead(Schema):
    """The comparison as it was kept."""

    id: str


class JobRead(Schema):
    """Long work. total: 0 while it is unknown. error: why the job failed."""

    id: str
    kind: str = Field(examples=["import"])
    state: Literal["queued", "running", "done", "failed", "cancelled"]
    done: int
    total: int
    message: str
    result: dict[str, Any]
    error: Annotated[BilingualText | None, BeforeValidator(lambda error: error if any(error) else None)]


class JobStarted(Schema):
    """The job that does the work."""

    job: JobRead
