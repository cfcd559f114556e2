"""What somebody practised: curves, and the same to take away."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query, Response

from rumu.database.tables import Person
from rumu.gallery.derived import derived
from rumu.studio import practice
from rumu.studio.access import seen_person
from rumu.studio.printing import Sheet, practice_pdf, shown_attempts
from rumu.web.cards import work_card
from rumu.web.dependencies import CurrentUser, QueryId, ServiceDep
from rumu.web.schemas import LanguageName
from rumu.web.service import Service
from rumu.web.studio_schemas import PracticeRead

router = APIRouter(tags=["practice"])
WorkId = Annotated[str, Query(pattern=r"^[A-Za-z0-9][A-Za-z0-9._~-]{0,63}$", examples=["regular-shui"])]


@router.get("/api/practice", response_model=PracticeRead)
def curves(service: ServiceDep, user: CurrentUser, person: QueryId = None) -> dict[str, Any]:
    """A person's curves, one a work; of the current user unless somebody else is named."""
    with service.gallery.database.reading() as session:
        whose = seen_person(session, person or user.id, who=user)
        found = practice.curves(session, whose.id)
    return {"person": {"id": whose.id, "name": whose.name}, "works": [_curve(one) for one in found]}


def _curve(one: practice.Curve) -> dict[str, Any]:
    scores = one.scores
    points = [
        {"id": p.id, "created": p.created, "score": p.score, "interval": p.interval and list(p.interval)}
        for p in one.points
    ]
    return {
        "work": work_card(one.work),
        "count": len(one.attempts),
        "best": max(scores, default=None),
        "last": scores[-1] if scores else None,
        "first": scores[0] if scores else None,
        "curve": points,
    }


@router.get("/api/practice.csv", response_class=Response)
def table(service: ServiceDep, user: CurrentUser, person: QueryId = None) -> Response:
    """All attempts of a person, one a row."""
    with service.gallery.database.reading() as session:
        whose = seen_person(session, person or user.id, who=user)
        text = practice.as_csv(session, whose.id)
    return csv_answer(text, "practice.csv")


@router.get("/api/practice.pdf", response_class=Response)
def sheet(
    service: ServiceDep,
    user: CurrentUser,
    work: WorkId,
    person: QueryId = None,
    language: LanguageName = "zh",
) -> Response:
    """One work's practice on a sheet of paper."""
    with service.gallery.database.reading() as session:
        whose = seen_person(session, person or user.id, who=user)
        curve = practice.curve(session, whose.id, work_id=work)
    data = practice_pdf(_sheet(service, whose, curve, language))
    headers = {"Content-Disposition": f'inline; filename="practice-{work}.pdf"', "Cache-Control": "no-store"}
    return Response(data, media_type="application/pdf", headers=headers)


def _sheet(service: Service, whose: Person, curve: practice.Curve, language: LanguageName) -> Sheet:
    store = service.gallery.store
    pictures = {one.id: store.read(one.picture) for one in shown_attempts(curve)}
    master = derived(service.gallery, curve.work.id, "picture").data
    return Sheet(whose.name, curve, master, pictures, language)


def csv_answer(text: str, name: str) -> Response:
    """With the mark that makes spreadsheets read UTF-8."""
    headers = {"Content-Disposition": f'attachment; filename="{name}"', "Cache-Control": "no-store"}
    return Response("\ufeff" + text, media_type="text/csv; charset=utf-8", headers=headers)
