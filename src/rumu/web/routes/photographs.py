"""Routes that look at the photograph of one character: what it shows, and its cell without perspective."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from typing import Annotated, Any, TypeVar

from anyio.to_thread import run_sync
from fastapi import APIRouter, File, Form, Request, Response, UploadFile
from pydantic import Field

from rumu.studio import worker_tasks
from rumu.studio.errors import Unusable
from rumu.studio.pictures import MAX_BYTES, check_picture
from rumu.web.addresses import client_address
from rumu.web.dependencies import OptionalUser, ServiceDep
from rumu.web.schemas import Schema
from rumu.web.service import Service
from rumu.web.studio_schemas import Point

router = APIRouter(tags=["marks"])
Answer = TypeVar("Answer")

Photograph = Annotated[UploadFile, File(description="A photograph, 10 MB and 24 MP at most.")]
CornerText = Annotated[
    str,
    Form(
        max_length=400,
        examples=["[[40, 60], [520, 75], [510, 560], [35, 540]]"],
        description="Corners of the cell in pixels, clockwise from the upper left: [[x, y], ...].",
    ),
]


class PhotographRead(Schema):
    """What a photograph shows.

    sheet: whether it is of a practice sheet, whose cells `/api/sheets` marks. cell: corners of the printed
    cell near those that were sent, or around them, clockwise from the upper left; null where no printed
    sides show it.
    """

    sheet: bool
    cell: list[Point] | None = Field(examples=[[[40.2, 60.1], [520, 75], [510, 560], [35, 540]]])


@router.post("/api/photographs", response_model=PhotographRead)
async def look_at_photograph(
    *,
    request: Request,
    service: ServiceDep,
    user: OptionalUser,
    picture: Photograph,
    corners: CornerText = "",
    around: Annotated[
        bool, Form(description="The corners are around the writing, the cell around them.")
    ] = False,
) -> dict[str, Any]:
    """Say whether a photograph is of a practice sheet, and where the printed cell near a square is."""
    _count(request, service, user.id if user else None)
    near = _read_corners(corners) if corners else None
    look = partial(_call, service, worker_tasks.look_at_photograph, picture, near, around=around)
    return await run_sync(look, limiter=service.marking_limiter)


@router.post("/api/photographs/cell", response_class=Response)
async def flatten_cell(
    *,
    request: Request,
    service: ServiceDep,
    user: OptionalUser,
    picture: Photograph,
    corners: CornerText,
) -> Response:
    """The cell between four corners of a photograph, as a square picture without perspective."""
    _count(request, service, user.id if user else None)
    around, flatten = _read_corners(corners), worker_tasks.flatten_cell
    data = await run_sync(_call, service, flatten, picture, around, limiter=service.marking_limiter)
    return Response(data, media_type="image/png", headers={"Cache-Control": "no-store"})


def _count(request: Request, service: Service, person_id: str | None) -> None:
    service.rate_limiter.hit(
        service.settings.rate_limits.sheets, "photographs", person_id or client_address(request)
    )


def _call(
    service: Service,
    work: Callable[..., Answer],
    picture: UploadFile,
    corners: list[list[float]] | None,
    **more: bool,
) -> Answer:
    """The answer of a worker to a picture, once it is read and known to be one."""
    data = picture.file.read(MAX_BYTES + 1)
    check_picture(data)
    return service.workers.call(work, data=data, corners=corners, **more)


def _read_corners(text: str) -> list[list[float]]:
    """Four points of two numbers. Raises Unusable."""
    try:
        points = json.loads(text)
        corners = [[float(x), float(y)] for x, y in points]
    except (ValueError, TypeError, RecursionError):
        corners = []
    if len(corners) != 4 or not all(abs(value) < 1e6 for corner in corners for value in corner):
        raise Unusable(
            "corners",
            zh="需要四個角的位置，例如 [[40, 60], [520, 75], [510, 560], [35, 540]]。",
            en="Expected the places of four corners, such as [[40, 60], [520, 75], [510, 560], [35, 540]].",
        )
    return corners
