"""One person's practice: the curve of marks for each master, oldest first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import select
from sqlalchemy.orm import Session

from rumu.csv_tables import csv_text
from rumu.database.tables import Attempt, Work
from rumu.studio.errors import Missing

# one attempt a row, so that a spreadsheet or pandas reads it as it is
COLUMNS = (
    *("attempt", "created", "work", "character", "script", "kind", "task", "score", "low", "high", "level"),
    *("brushwork", "structure", "ink", "refused", "remarks", "version"),
)


@dataclass(frozen=True, slots=True)
class Point:
    """One attempt on a curve; score and interval are None where it was refused."""

    id: str
    created: datetime
    score: float | None
    interval: tuple[float, float] | None


@dataclass(frozen=True, slots=True)
class Curve:
    """A person's attempts at one work, oldest first."""

    work: Work
    attempts: tuple[Attempt, ...]

    @property
    def points(self) -> list[Point]:
        return [Point(a.id, a.created, a.score, _interval(a)) for a in self.attempts]

    @property
    def scores(self) -> list[float]:
        return [attempt.score for attempt in self.attempts if attempt.score is not None]


def curves(session: Session, person_id: str, *, work_id: str | None = None) -> list[Curve]:
    """Return a person's curves by work, the one practised last first."""
    by_work: dict[str, list[Attempt]] = {}
    for attempt in _attempts(session, person_id, work_id):
        by_work.setdefault(attempt.work_id, []).append(attempt)
    works = {w.id: w for w in session.scalars(select(Work).where(Work.id.in_(by_work)))}
    unsorted = (Curve(works[one], tuple(attempts)) for one, attempts in by_work.items())
    return sorted(unsorted, key=lambda curve: curve.attempts[-1].created, reverse=True)


def curve(session: Session, person_id: str, *, work_id: str) -> Curve:
    """Return a person's curve of one work. Raises Missing when they never copied it."""
    of_work = curves(session, person_id, work_id=work_id)
    if not of_work:
        raise Missing(zh="還沒有臨過這件作品。", en="There is no attempt at this work.")
    return of_work[0]


def attempts_csv(session: Session, person_id: str) -> str:
    """Return all attempts of a person, oldest first, as CSV text with COLUMNS."""
    attempts = list(_attempts(session, person_id, None))
    works = {w.id: w for w in session.scalars(select(Work).where(Work.id.in_({a.work_id for a in attempts})))}
    return csv_text(COLUMNS, (_row(attempt, works[attempt.work_id]) for attempt in attempts))


def _attempts(session: Session, person_id: str, work_id: str | None) -> Sequence[Attempt]:
    wanted = select(Attempt).where(Attempt.person_id == person_id)
    if work_id is not None:
        wanted = wanted.where(Attempt.work_id == work_id)
    return session.scalars(wanted.order_by(Attempt.created, Attempt.id)).all()


def _row(attempt: Attempt, work: Work) -> list[object]:
    mark = attempt.mark
    low, high = _interval(attempt) or ("", "")
    parts = {part["name"]: part["score"] for part in mark.get("parts", ())}
    refused = (mark.get("refused") or {}).get("code", "")
    return [
        attempt.id,
        attempt.created.isoformat(timespec="seconds"),
        work.id,
        work.character,
        work.script,
        attempt.kind,
        attempt.task_id or "",
        "" if attempt.score is None else round(attempt.score, 2),
        *(("", "") if low == "" else (round(float(low), 2), round(float(high), 2))),
        attempt.level or "",
        *(round(parts[name], 2) if name in parts else "" for name in ("brushwork", "structure", "ink")),
        refused,
        "; ".join(remark["kind"] for remark in mark.get("remarks", ())),
        attempt.version,
    ]


def _interval(attempt: Attempt) -> tuple[float, float] | None:
    bounds = attempt.mark.get("interval")
    return None if bounds is None else (float(bounds[0]), float(bounds[1]))
