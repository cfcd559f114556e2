"""Routes of comparisons: which of two copies is better."""

from __future__ import annotations

from fastapi import APIRouter, Response

from rumu.csv_tables import csv_text
from rumu.database.tables import Comparison
from rumu.studio import attempts, comparisons
from rumu.web.dependencies import CurrentUser, QueryId, ServiceDep, TeacherUser
from rumu.web.responses import csv_response
from rumu.web.schemas import Extended
from rumu.web.studio_schemas import ComparisonCreate, ComparisonRead, PairRead

router = APIRouter(tags=["comparisons"])
COLUMNS = ("judge", "work", "left", "right", "winner", "seconds")


@router.get("/api/comparisons/next", response_model=PairRead | None, response_model_by_alias=True)
def get_next_pair(
    response: Response, service: ServiceDep, user: CurrentUser, work: QueryId = None
) -> Extended | None:
    """The next pair for this judge; null when none is left."""
    response.headers["Cache-Control"] = "no-store"
    with service.gallery.database.reading() as session:
        pair = comparisons.next_pair(session, user, work_id=work)
        if pair is None:
            return None
        left, right = attempts.attempt_details(session, [pair.left, pair.right])
    return Extended(pair, work=left.work, left=left, right=right)


@router.post("/api/comparisons", response_model=ComparisonRead, status_code=201)
def add_comparison(service: ServiceDep, user: CurrentUser, comparison: ComparisonCreate) -> Comparison:
    """Keep a judgement; a judge judges a pair once."""
    with service.gallery.database.writing() as session:
        return comparisons.judge(session, user, **comparison.model_dump())


@router.get("/api/comparisons.csv", response_class=Response)
def get_comparisons_csv(service: ServiceDep, user: TeacherUser) -> Response:
    """All judgements for an owner; for a teacher their own and their pupils'. Judges are given by id."""
    with service.gallery.database.reading() as session:
        rows = comparisons.verdicts(session, user)
    return csv_response(csv_text(COLUMNS, rows), "comparisons.csv")
