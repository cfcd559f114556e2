"""What routes ask for: the service, who asks, and texts and ids that can be trusted to be such."""

from __future__ import annotations

from typing import Annotated, Any

from anyio.to_thread import run_sync
from fastapi import Depends, Path, Query, Request, Response
from pydantic import AfterValidator, StringConstraints

from rumu.studio.errors import NotAllowed
from rumu.studio.people import Identity
from rumu.studio.tickets import DAYS, Ticket
from rumu.web.security import COOKIE, address
from rumu.web.error_handlers import LoginNeededError
from rumu.web.service import Service

_ID = r"^[A-Za-z0-9][A-Za-z0-9._~-]{0,63}$"


async def service_of(request: Request) -> Service:
    """The running service."""
    service: Service = request.app.state.service
    return service


Running = Annotated[Service, Depends(service_of)]


def ticket_of(request: Request) -> Ticket | None:
    """The session, as the guard read it."""
    ticket: Ticket | None = request.scope["state"].get("ticket")
    return ticket


async def anybody(request: Request, service: Running) -> Identity | None:
    """Who asks, or None for a visitor."""
    ticket = ticket_of(request)
    if ticket is None or ticket.person_id is None:
        return None  # most who browse: no thread and no question to the database
    return await run_sync(service.who, ticket)


Visitor = Annotated[Identity | None, Depends(anybody)]


async def somebody(who: Visitor) -> Identity:
    """Who asks; a visitor is sent to log in."""
    if who is None:
        raise LoginNeededError
    return who


Somebody = Annotated[Identity, Depends(somebody)]


async def a_teacher(who: Somebody) -> Identity:
    """A teacher or an owner."""
    if not who.teaches:
        raise NotAllowed
    return who


Teacher = Annotated[Identity, Depends(a_teacher)]


async def an_owner(who: Somebody) -> Identity:
    """An owner."""
    if not who.owns:
        raise NotAllowed
    return who


Owner = Annotated[Identity, Depends(an_owner)]


def caller(request: Request) -> str:
    """The address that asks, for rates."""
    return address(request.scope)


def give_ticket(request: Request, response: Response, service: Service, ticket: Ticket) -> None:
    """Set the cookie: out of reach of scripts, and of other sites' forms."""
    request.scope["state"]["ticket"] = ticket
    response.set_cookie(
        COOKIE,
        service.tickets.written(ticket),
        max_age=DAYS * 86400,
        path="/",
        secure=service.settings.secure or request.url.scheme == "https",
        httponly=True,
        samesite="lax",
    )


def speakable(text: str) -> str:
    """A text that a database can hold: no control characters but line breaks and tabs, no halves of
    letters."""
    if any((ord(c) < 32 and c not in "\n\r\t") or ord(c) == 127 or 0xD800 <= ord(c) <= 0xDFFF for c in text):
        raise ValueError("expected text without control characters")
    return text


Said = Annotated[str, AfterValidator(speakable)]
Line = Annotated[str, StringConstraints(max_length=200, strip_whitespace=True), AfterValidator(speakable)]
Prose = Annotated[str, StringConstraints(max_length=8000), AfterValidator(speakable)]
IdText = Annotated[str, StringConstraints(pattern=_ID)]
PathId = Annotated[str, Path(pattern=_ID, description="An id that the service gave.")]
QueryId = Annotated[str | None, Query(pattern=_ID, description="An id that the service gave.")]
Asked = Annotated[
    str | None, Query(max_length=200), AfterValidator(lambda v: v if v is None else speakable(v))
]
Offset = Annotated[int, Query(ge=0, le=10_000_000)]
Limit = Annotated[int, Query(ge=1, le=200)]

REFUSALS: dict[int | str, dict[str, Any]] = {
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
