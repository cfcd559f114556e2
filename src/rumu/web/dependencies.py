"""FastAPI dependencies: the service, the current user, and types of parameters that can be trusted."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Annotated, Any

from anyio.to_thread import run_sync
from fastapi import Depends, HTTPException, Path, Query, Request, Response
from pydantic import AfterValidator, StringConstraints

from rumu.database.tables import ID_PATTERN, reject_control_characters
from rumu.studio.errors import NotAllowed, Unusable
from rumu.studio.people import Identity
from rumu.studio.tickets import DAYS_VALID, Ticket
from rumu.web.addresses import SessionCookie
from rumu.web.service import CurrentSession, Service

FIRST_YEAR, LAST_YEAR = 1970, 2200  # of times that people enter


async def get_service(request: Request) -> Service:
    """The running service."""
    service: Service = request.app.state.service
    return service


ServiceDep = Annotated[Service, Depends(get_service)]


async def find_session(request: Request, service: ServiceDep) -> CurrentSession | None:
    """The session of the person who is logged in, or None for a visitor."""
    tickets: list[Ticket] = request.state.tickets
    if all(ticket.person_id is None for ticket in tickets):
        return None  # most requests of the gallery: neither a thread nor a query
    return await run_sync(service.identify, tickets)


OptionalSession = Annotated[CurrentSession | None, Depends(find_session)]


async def get_user(session: OptionalSession) -> Identity | None:
    """The person who is logged in, or None for a visitor."""
    return None if session is None else session.user


OptionalUser = Annotated[Identity | None, Depends(get_user)]


async def require_session(session: OptionalSession) -> CurrentSession:
    """The session of the person who is logged in. Raises HTTPException for a visitor."""
    if session is None:
        raise HTTPException(401, "login")
    return session


RequiredSession = Annotated[CurrentSession, Depends(require_session)]


async def require_login(session: RequiredSession) -> Identity:
    """The person who is logged in. Raises HTTPException for a visitor."""
    return session.user


CurrentUser = Annotated[Identity, Depends(require_login)]


async def require_teacher(user: CurrentUser) -> Identity:
    """A teacher or an owner. Raises NotAllowed for others."""
    if not user.teaches:
        raise NotAllowed
    return user


TeacherUser = Annotated[Identity, Depends(require_teacher)]


async def require_owner(user: CurrentUser) -> Identity:
    """An owner. Raises NotAllowed for others."""
    if not user.owns:
        raise NotAllowed
    return user


OwnerUser = Annotated[Identity, Depends(require_owner)]


def set_session_cookie(request: Request, response: Response, service: Service, ticket: Ticket) -> None:
    """Set the cookie of a session; neither scripts nor forms of other sites can use it."""
    cookie = SessionCookie.of(request, service.tickets.fingerprint)
    response.set_cookie(
        cookie.name,
        service.tickets.serialise(ticket),
        max_age=DAYS_VALID * 86400,
        path=cookie.path,
        secure=cookie.secure,
        httponly=True,
        samesite="lax",
    )


def check_time(time: datetime) -> datetime:
    """A time with its zone, in years that every database and every time zone can hold, in UTC.

    Raises Unusable for another.
    """
    if time.tzinfo is None:
        raise Unusable("time", zh="時間要帶時區。", en="Expected the time with its time zone.")
    if not FIRST_YEAR < time.year < LAST_YEAR:
        raise Unusable(
            "time",
            zh=f"時間要在 {FIRST_YEAR} 年到 {LAST_YEAR} 年之間，卻是 {time.year} 年。",
            en=f"Expected a time between {FIRST_YEAR} and {LAST_YEAR}, got the year {time.year}.",
        )
    return time.astimezone(UTC)


_CLEAN = AfterValidator(reject_control_characters)
Time = Annotated[datetime, AfterValidator(check_time)]
CleanText = Annotated[str, _CLEAN]
ShortText = Annotated[str, StringConstraints(max_length=200, strip_whitespace=True), _CLEAN]
LongText = Annotated[str, StringConstraints(max_length=8000), _CLEAN]
Id = Annotated[str, StringConstraints(pattern=ID_PATTERN)]
PathId = Annotated[str, Path(pattern=ID_PATTERN, description="An id that the service gave.")]
WorkId = Annotated[
    str, Path(max_length=200, description="The id of a work. Imports once let in ids of any form."), _CLEAN
]
QueryId = Annotated[str | None, Query(pattern=ID_PATTERN, description="An id that the service gave.")]
SearchText = Annotated[CleanText | None, Query(max_length=200)]
Offset = Annotated[int, Query(ge=0, le=10_000_000)]
Limit = Annotated[int, Query(ge=1, le=200)]

ERROR_RESPONSES: dict[int | str, dict[str, Any]] = {
    "4XX": {
        "description": "Refused, with the reason in both languages.",
        "content": {
            "application/json": {
                "example": {
                    "error": {"code": "not_found", "zh": "沒有這個項目。", "en": "There is no such thing."}
                }
            }
        },
    }
}
