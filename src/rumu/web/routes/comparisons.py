"""Which of two copies is better."""

from __future__ import annotations

from typing import Any

from fastapi import APIRouter, Response

from rumu.studio import attempts, comparisons
from rumu.studio.practice import written
from rumu.web.cards import attempt_facts, work_card
from rumu.web.dependencies import CurrentUser, QueryId, ServiceDep, TeacherUser
from rumu.web.routes.practice import csv_answer
from rumu.web.studio_schemas import ComparisonCreate, ComparisonRead, PairRead

router = APIRouter(tags=["comparisons"])
COLUMNS = ("judge", "work", "left", "right", "winner", "seconds")


@router.get("/api/comparisons/next", response_model=PairRead | None, response_model_by_alias=True)
def next_pair(
    response: Response, service: ServiceDep, user: CurrentUser, work: QueryId = None
) -> dict[str, Any] | None:
    """The next pair for this judge; null when none is left."""
    response.headers["Cache-Control"] = "no-store"
    with service.gallery.database.reading() as session:
        pair = comparisons.next_pair(session, user, work_id=work)
        if pair is None:
            return None
        left, right = attempts.shown(session, [pair.left, pair.right])
    return {
        "work": work_card(left.work),
        "left": attempt_facts(left),
        "right": attempt_facts(right),
        "done": pair.done,
        "left_over": pair.left_over,
    }


@router.post("/api/comparisons", response_model=ComparisonRead, status_code=201)
def judge(service: ServiceDep, user: CurrentUser, told: ComparisonCreate) -> dict[str, Any]:
    """Keep a verdict; a judge judges a pair once."""
    with service.gallery.database.writing() as session:
        row = comparisons.judge(
            session, user, left=told.left, right=told.right, winner=told.winner, seconds=told.seconds
        )
    return {"id": row.id}


@router.get("/api/comparisons.csv", response_class=Response)
def table(service: ServiceDep, user: TeacherUser) -> Response:
    """All verdicts to an owner; to a teacher their own and their pupils'. Judges are told by their ids."""
    with service.gallery.database.reading() as session:
        rows = comparisons.verdicts(session, user)
    return csv_answer(written(COLUMNS, rows), "comparisons.csv")
