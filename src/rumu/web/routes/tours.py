"""Routes of guided tours."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fastapi import APIRouter

from rumu.database.tables import Tour
from rumu.errors import GalleryError
from rumu.gallery import tours
from rumu.studio.errors import Missing
from rumu.web.dependencies import OwnerUser, PathId, ServiceDep
from rumu.web.routes.works import to_columns
from rumu.web.tour_schemas import TourCreate, TourRead, TourUpdate

router = APIRouter(tags=["tours"])


@router.get("/api/tours", response_model=list[TourRead])
def list_tours(service: ServiceDep) -> Sequence[Tour]:
    """All tours, in order."""
    return tours.tours(service.gallery)


@router.get("/api/tours/{tour_id}", response_model=TourRead)
def get_tour(service: ServiceDep, tour_id: PathId) -> Tour:
    """One tour."""
    try:
        return tours.tour(service.gallery, tour_id)
    except GalleryError as error:
        raise Missing(zh="沒有這條導覽。", en="There is no such tour.") from error


@router.post("/api/tours", response_model=TourRead, status_code=201)
def add_tour(service: ServiceDep, user: OwnerUser, tour: TourCreate) -> Tour:
    """Add a tour."""
    return tours.add_tour(service.gallery, _tour_columns(tour), author=user.id)


@router.patch("/api/tours/{tour_id}", response_model=TourRead)
def update_tour(service: ServiceDep, user: OwnerUser, tour_id: PathId, changes: TourUpdate) -> Tour:
    """Change the title or the steps of a tour."""
    get_tour(service, tour_id)
    return tours.change_tour(service.gallery, tour_id, _tour_columns(changes))


@router.delete("/api/tours/{tour_id}", status_code=204)
def delete_tour(service: ServiceDep, user: OwnerUser, tour_id: PathId) -> None:
    """Delete a tour."""
    get_tour(service, tour_id)
    tours.delete_tour(service.gallery, tour_id)


def _tour_columns(tour: TourCreate | TourUpdate) -> dict[str, Any]:
    values = tour.model_dump()
    steps = values.pop("steps")
    return to_columns(values) | ({} if steps is None else {"steps": [to_columns(step) for step in steps]})
