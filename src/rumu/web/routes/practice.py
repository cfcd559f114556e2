"""Routes of a person's practice: curves, a table and a sheet to print."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query, Response

from rumu.database.tables import ID_PATTERN
from rumu.gallery.derived import derived_file
from rumu.studio import practice
from rumu.studio.access import find_visible_person
from rumu.studio.practice_pdf import PracticeSheet, practice_pdf, printed_attempts
from rumu.web.dependencies import CurrentUser, QueryId, ServiceDep
from rumu.web.responses import csv_response, download_response
from rumu.web.schemas import Extended, LanguageName
from rumu.web.studio_schemas import PracticeRead

router = APIRouter(tags=["practice"])
WorkId = Annotated[str, Query(pattern=ID_PATTERN, examples=["regular-shui"])]


@router.get("/api/practice", response_model=PracticeRead)
def get_practice(service: ServiceDep, user: CurrentUser, person: QueryId = None) -> dict[str, Any]:
    """A person's curves, one for each work. person: by default the current user."""
    with service.gallery.database.reading() as session:
        learner = find_visible_person(session, person or user.id, user=user)
        curves = practice.curves(session, learner.id)
    return {"person": learner, "works": [_with_scores(curve) for curve in curves]}


def _with_scores(curve: practice.Curve) -> Extended:
    scores = curve.scores
    return Extended(
        curve,
        count=len(curve.attempts),
        best=max(scores, default=None),
        last=scores[-1] if scores else None,
        first=scores[0] if scores else None,
    )


@router.get("/api/practice.csv", response_class=Response)
def get_practice_csv(service: ServiceDep, user: CurrentUser, person: QueryId = None) -> Response:
    """All attempts of a person, one in each row."""
    with service.gallery.database.reading() as session:
        learner = find_visible_person(session, person or user.id, user=user)
        text = practice.attempts_csv(session, learner.id)
    return csv_response(text, "practice.csv")


@router.get("/api/practice.pdf", response_class=Response)
def get_practice_pdf(
    service: ServiceDep,
    user: CurrentUser,
    work: WorkId,
    person: QueryId = None,
    language: LanguageName = "zh",
) -> Response:
    """The practice of one work as a sheet to print."""
    with service.gallery.database.reading() as session:
        learner = find_visible_person(session, person or user.id, user=user)
        curve = practice.curve(session, learner.id, work_id=work)
    store = service.gallery.store
    pictures = {one.id: store.read(one.picture) for one in printed_attempts(curve)}
    master = derived_file(service.gallery, work, "picture").data
    pdf = practice_pdf(PracticeSheet(learner.name, curve, master, pictures, language))
    return download_response(
        pdf, media_type="application/pdf", filename=f"practice-{work}.pdf", disposition="inline"
    )
