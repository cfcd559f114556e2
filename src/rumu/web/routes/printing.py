"""Routes that print practice sheets: what one holds, the sheet as a PDF, and its pages as pictures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Annotated, Any, Literal, TypeVar

from anyio.to_thread import run_sync
from fastapi import APIRouter, Depends, HTTPException, Query, Request, Response
from pydantic import Field

from rumu.database.tables import ID_PATTERN, SchoolClass
from rumu.pages.sheet_layout import LARGEST_CELL, LONGEST_PUPIL, SMALLEST_CELL, Grid, Help, Paper
from rumu.studio import classes, worker_tasks
from rumu.studio.errors import NotAllowed, Unusable
from rumu.studio.people import Identity
from rumu.studio.sheet_printing import MAX_CHARACTERS, MAX_WORKS, SheetRequest
from rumu.values import Script
from rumu.web.addresses import client_address
from rumu.web.dependencies import CleanText, Id, OptionalUser, ServiceDep, ShortText
from rumu.web.responses import download_response
from rumu.web.schemas import Schema
from rumu.web.service import Service

router = APIRouter(tags=["sheets"])
Answer = TypeVar("Answer")

PupilName = Annotated[ShortText, Field(max_length=LONGEST_PUPIL)]


class SheetPlanRead(Schema):
    """What a sheet holds: its number, pages for one pupil, cells to write in, and characters."""

    sheet: str = Field(examples=["1f6a09bc"])
    pages: int
    cells: int
    times: int = Field(description="Cells to write in for each character.")
    text: str = Field(examples=["永天人水"])


def sheet_request(
    *,
    text: Annotated[
        CleanText, Query(max_length=2 * MAX_CHARACTERS, examples=["永天人水"], description="To be written.")
    ] = "",
    works: Annotated[
        list[Id], Query(max_length=MAX_WORKS, description="Ids of works that are the masters; needs a login.")
    ] = [],  # noqa: B006  FastAPI copies it
    master: Annotated[
        Literal["strokes"] | Script,
        Query(
            description="Masters of the other characters: copybooks' strokes, or a script's starter works."
        ),
    ] = "strokes",
    paper: Annotated[Paper, Query()] = "A4",
    grid: Annotated[Grid, Query(description="米字格, 九宮格, 田字格, 回宮格, or corners.")] = "mi",
    model: Annotated[Help, Query(description="How the master helps.")] = "faint",
    cell: Annotated[float, Query(ge=SMALLEST_CELL, le=LARGEST_CELL, description="Millimetres.")] = 28,
    times: Annotated[
        int, Query(ge=0, le=500, description="Cells for each character; 0 fills whole rows.")
    ] = 0,
    strokes: Annotated[bool, Query(description="Whether the order of strokes stands above.")] = True,
    pupil: Annotated[
        list[PupilName], Query(max_length=60, description="For each of whom one is printed.")
    ] = [],  # noqa: B006
) -> SheetRequest:
    """A sheet as a request asks for it."""
    names = tuple(name for name in pupil if name)
    return SheetRequest(
        text, tuple(works), master, paper, grid, model, cell, times, strokes=strokes, pupils=names
    )


AskedSheet = Annotated[SheetRequest, Depends(sheet_request)]


@router.get("/api/practice-sheet", response_model=SheetPlanRead)
async def plan_sheet(
    request: Request, service: ServiceDep, user: OptionalUser, sheet: AskedSheet
) -> dict[str, Any]:
    """How many pages and cells a practice sheet has."""
    _check_asked(request, service, user, sheet)
    return await _in_worker(service, worker_tasks.plan_sheet, request=sheet)


@router.get("/api/practice-sheet.png", response_class=Response)
async def preview_sheet(
    request: Request,
    service: ServiceDep,
    user: OptionalUser,
    sheet: AskedSheet,
    number: Annotated[int, Query(ge=1, le=99, description="Which page.")] = 1,
) -> Response:
    """A page of a practice sheet as a picture to look at, for the first pupil."""
    _check_asked(request, service, user, sheet)
    data = await _in_worker(service, worker_tasks.preview_sheet, request=sheet, number=number)
    return Response(data, media_type="image/png", headers={"Cache-Control": "no-store"})


@router.get("/api/practice-sheet.pdf", response_class=Response)
async def print_sheet(
    request: Request,
    service: ServiceDep,
    user: OptionalUser,
    sheet: AskedSheet,
    class_id: Annotated[
        str | None,
        Query(alias="class", pattern=ID_PATTERN, description="Print one for each pupil of this class."),
    ] = None,
) -> Response:
    """A practice sheet to print.

    Its code says what belongs in each cell and for whom it was printed, so that a photograph of it comes back
    as marks (`/api/sheets`).
    """
    _check_asked(request, service, user, sheet)
    if class_id is not None:
        if user is None:
            raise HTTPException(401, "login")
        sheet = await run_sync(_for_class, service, user, sheet, class_id)
    data = await _in_worker(service, worker_tasks.print_sheet, request=sheet)
    return download_response(data, media_type="application/pdf", filename="practice-sheet.pdf")


def _check_asked(request: Request, service: Service, user: Identity | None, sheet: SheetRequest) -> None:
    """Count a request. Raises HTTPException for a visitor's works: their pictures would be kept."""
    if user is None and sheet.works:
        raise HTTPException(401, "login")
    who = client_address(request) if user is None else user.id
    service.rate_limiter.hit(service.settings.rate_limits.sheets, "sheets", who)


async def _in_worker(service: Service, work: Callable[..., Answer], **arguments: Any) -> Answer:
    """The answer of a worker; it is awaited in a thread of its own, not in those that answer readers."""
    call = partial(service.workers.call, work, **arguments)
    return await run_sync(call, limiter=service.marking_limiter)


def _for_class(service: Service, user: Identity, sheet: SheetRequest, class_id: str) -> SheetRequest:
    """The sheet for each pupil of a class. Raises Missing, NotAllowed, or Unusable for a class of nobody."""
    if not user.teaches:
        raise NotAllowed
    with service.gallery.database.reading() as session:
        row = classes.find_row(session, SchoolClass, class_id, user=user, require_teacher=True)
        names = tuple(pupil.name[:LONGEST_PUPIL] for pupil in classes.pupils(session, row.id))
    if not names:
        raise Unusable("no_pupils", zh="這個班還沒有學生。", en="There are no pupils in this class yet.")
    return replace(sheet, pupils=names)
