"""Routes of the session, of invitations, and of people with a login."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

from anyio.to_thread import run_sync
from fastapi import APIRouter, HTTPException, Path, Query, Request, Response
from sqlalchemy import select

from rumu import __version__
from rumu.database.tables import Person
from rumu.studio import invitations, people
from rumu.studio.passwords import HASHER
from rumu.studio.people import LANGUAGES
from rumu.studio.tickets import Ticket
from rumu.web.addresses import client_address, service_url
from rumu.web.dependencies import (
    CurrentUser,
    OptionalSession,
    OwnerUser,
    PathId,
    RequiredSession,
    ServiceDep,
    set_session_cookie,
)
from rumu.web.schemas import (
    Credentials,
    InvitationCreate,
    InvitationLink,
    InvitationRead,
    PasswordUpdate,
    PersonRead,
    PersonUpdate,
    SessionRead,
    SessionUpdate,
)
from rumu.web.service import Service

router = APIRouter(tags=["session"])
people_router = APIRouter(tags=["people"])
Token = Annotated[str, Path(pattern=r"^[A-Za-z0-9_-]{10,80}$", description="The token of the link.")]


@router.get("/api/session", response_model=SessionRead)
def get_session(
    request: Request, response: Response, service: ServiceDep, session: OptionalSession
) -> dict[str, Any]:
    """Who is logged in, and the token that every change needs; a visitor gets a session too."""
    response.headers["Cache-Control"] = "no-store"
    if session is not None:
        return _session_facts(service, session.ticket)
    visitors = [ticket for ticket in request.state.tickets if ticket.person_id is None]
    if visitors:
        return _session_facts(service, visitors[0])
    return _start_session(request, response, service)


@router.post("/api/login", response_model=SessionRead)
async def log_in(
    request: Request, response: Response, service: ServiceDep, credentials: Credentials
) -> dict[str, Any]:
    """Log in; the session and its token change."""
    _limit_logins(request, service, credentials)
    # a class that logs in leaves the threads that answer readers to them
    return await run_sync(_log_in, request, response, service, credentials, limiter=service.login_limiter)


def _log_in(
    request: Request, response: Response, service: Service, credentials: Credentials
) -> dict[str, Any]:
    with service.gallery.database.reading() as session:
        person = people.authenticate(session, name=credentials.name, password=credentials.password)
    if person is None:
        raise HTTPException(401, "wrong_login")
    if person.password is not None and HASHER.check_needs_rehash(person.password):
        with service.gallery.database.writing() as session:
            people.renew_hash(session, person.id, password=credentials.password)
    return _start_session(request, response, service, person)


@router.post("/api/logout", response_model=SessionRead)
def log_out(
    *,
    request: Request,
    response: Response,
    service: ServiceDep,
    session: OptionalSession,
    everywhere: Annotated[
        bool, Query(description="Also end this person's sessions on other devices.")
    ] = False,
) -> dict[str, Any]:
    """Log out: the session ends on the server, so that no copy of its cookie opens it any more."""
    if session is not None:
        with service.gallery.database.writing() as database:
            if everywhere:
                people.end_sessions(database, session.user.id)
            else:
                people.end_session(database, session.ticket)
    return _start_session(request, response, service)


@router.patch("/api/session", response_model=SessionRead)
def update_session(service: ServiceDep, session: RequiredSession, changes: SessionUpdate) -> dict[str, Any]:
    """Change one's own language."""
    with service.gallery.database.writing() as database:
        people.change_person(database, session.user.id, {"language": changes.language})
    return _session_facts(service, session.ticket)


@router.post("/api/password", response_model=SessionRead)
def change_password(
    request: Request, response: Response, service: ServiceDep, user: CurrentUser, passwords: PasswordUpdate
) -> dict[str, Any]:
    """Change one's own password; every other session of this person ends."""
    service.rate_limiter.hit(service.settings.rate_limits.login_name, "password", user.id)
    with service.gallery.database.writing() as session:
        person = people.set_password(session, user.id, old=passwords.old, new=passwords.new)
    return _start_session(request, response, service, person)


@router.post("/api/invitations", response_model=InvitationLink, status_code=201)
def add_invitation(service: ServiceDep, user: CurrentUser, invitation: InvitationCreate) -> dict[str, Any]:
    """A link that makes one login; a teacher invites pupils into a class of theirs, an owner anybody."""
    with service.gallery.database.writing() as session:
        token, row = invitations.invite(session, user, role=invitation.role, class_id=invitation.class_id)
    return {"link": service_url(f"/#/join/{token}"), "token": token, "role": row.role, "expires": row.expires}


@router.get("/api/invitations/{token}", response_model=InvitationRead, response_model_by_alias=True)
def get_invitation(request: Request, service: ServiceDep, token: Token) -> dict[str, Any]:
    """What a link is for."""
    service.rate_limiter.hit(service.settings.rate_limits.login, "invitation", client_address(request))
    with service.gallery.database.reading() as session:
        row, school_class = invitations.find_invitation(session, token)
    return {"role": row.role, "class": school_class, "expires": row.expires}


@router.post("/api/invitations/{token}", response_model=SessionRead, status_code=201)
def accept_invitation(
    request: Request, response: Response, service: ServiceDep, token: Token, credentials: Credentials
) -> dict[str, Any]:
    """Make the login, and log in; a pupil with a login joins one more class with it."""
    _limit_logins(request, service, credentials)
    with service.gallery.database.writing() as session:
        person = invitations.accept(session, token, name=credentials.name, password=credentials.password)
    return _start_session(request, response, service, person)


@people_router.get("/api/people", response_model=list[PersonRead])
def list_people(service: ServiceDep, user: OwnerUser) -> Sequence[Person]:
    """Everybody with a login."""
    with service.gallery.database.reading() as session:
        return session.scalars(select(Person).order_by(Person.name_key)).all()


@people_router.patch("/api/people/{person_id}", response_model=PersonRead)
def update_person(service: ServiceDep, user: OwnerUser, person_id: PathId, changes: PersonUpdate) -> Person:
    """Change name, role, language or password, or shut somebody out (active: false)."""
    values = changes.model_dump(exclude_none=True)
    password = values.pop("password", None)
    with service.gallery.database.writing() as session:
        person = people.change_person(session, person_id, values)
        if password is not None:
            people.set_password(session, person_id, new=password)
    return person


def _limit_logins(request: Request, service: Service, credentials: Credentials) -> None:
    limits = service.settings.rate_limits
    service.rate_limiter.hit(limits.login, "login", client_address(request))
    service.rate_limiter.hit(limits.login_name, "name", people.name_key(credentials.name))


def _start_session(
    request: Request, response: Response, service: Service, person: Person | None = None
) -> dict[str, Any]:
    """A new session. person: None for a visitor's."""
    if person is None:
        ticket = Ticket()
    else:
        with service.gallery.database.writing() as session:
            ticket = people.start_session(session, person)
    set_session_cookie(request, response, service, ticket)
    return _session_facts(service, ticket)


def _session_facts(service: Service, ticket: Ticket) -> dict[str, Any]:
    with service.gallery.database.reading() as session:
        person = None if ticket.person_id is None else session.get(Person, ticket.person_id)
        owner_exists = people.owner_exists(session)
    return {
        "person": person,
        "csrf": service.tickets.csrf(ticket),
        "owner_exists": owner_exists,
        "languages": list(LANGUAGES),
        "version": __version__,
    }
