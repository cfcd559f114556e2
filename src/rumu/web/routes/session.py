"""Who is logged in; coming in, going out, and the links that let people in."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Path, Request, Response

from rumu import __version__
from rumu.database.tables import Person
from rumu.studio import invitations, people
from rumu.studio.passwords import outdated
from rumu.studio.people import LANGUAGES
from rumu.studio.tickets import Ticket
from rumu.web.cards import person_facts
from rumu.web.dependencies import CurrentUser, ServiceDep, TicketDep, set_session_cookie
from rumu.web.error_handlers import WrongLoginError
from rumu.web.schemas import (
    Credentials,
    InvitationCreate,
    InvitationLink,
    InvitationRead,
    PasswordUpdate,
    SessionRead,
    SessionUpdate,
)
from rumu.web.security import COOKIE, client_address
from rumu.web.service import Service

router = APIRouter(tags=["session"])
Token = Annotated[str, Path(pattern=r"^[A-Za-z0-9_-]{10,80}$", description="What stands in the link.")]


@router.get("/api/session", response_model=SessionRead)
def session(request: Request, response: Response, service: ServiceDep, ticket: TicketDep) -> dict[str, Any]:
    """Who is logged in, and the token that every change needs; a visitor gets a session too."""
    user = service.identify(ticket)
    if ticket is None or (ticket.person_id is not None and user is None):
        ticket = service.tickets.fresh()
        set_session_cookie(request, response, service, ticket)
    response.headers["Cache-Control"] = "no-store"
    return _session_facts(service, ticket)


@router.post("/api/login", response_model=SessionRead)
def login(request: Request, response: Response, service: ServiceDep, told: Credentials) -> dict[str, Any]:
    """Log in; the session and its token change."""
    service.rate_limiter.hit(service.settings.rate_limits.login, "login", client_address(request))
    service.rate_limiter.hit(service.settings.rate_limits.login_name, "name", told.name.casefold())
    with service.gallery.database.reading() as session:
        person = people.known_by(session, name=told.name, password=told.password)
    if person is None:
        raise WrongLoginError
    if person.password is not None and outdated(person.password):
        with service.gallery.database.writing() as session:
            people.renew_hash(session, person.id, password=told.password)
    return _let_in(request, response, service, person)


@router.post("/api/logout", response_model=SessionRead)
def logout(request: Request, response: Response, service: ServiceDep) -> dict[str, Any]:
    """Log out on this device."""
    response.delete_cookie(COOKIE, path="/")
    ticket = service.tickets.fresh()
    set_session_cookie(request, response, service, ticket)
    return _session_facts(service, ticket)


@router.patch("/api/session", response_model=SessionRead)
def change_session(
    service: ServiceDep, user: CurrentUser, ticket: TicketDep, told: SessionUpdate
) -> dict[str, Any]:
    """Change one's own language."""
    with service.gallery.database.writing() as session:
        people.change_person(session, user.id, {"language": told.language})
    assert ticket is not None
    return _session_facts(service, ticket)


@router.post("/api/password", response_model=SessionRead)
def password(
    request: Request, response: Response, service: ServiceDep, user: CurrentUser, told: PasswordUpdate
) -> dict[str, Any]:
    """Change one's own password; every other session of this person ends."""
    service.rate_limiter.hit(service.settings.rate_limits.login_name, "password", user.id)
    with service.gallery.database.writing() as session:
        person = people.change_password(session, user.id, old=told.old, new=told.new)
    return _let_in(request, response, service, person)


@router.post("/api/invitations", response_model=InvitationLink, status_code=201)
def invite(service: ServiceDep, user: CurrentUser, told: InvitationCreate) -> dict[str, Any]:
    """A link that makes one login; a teacher invites pupils into a class of theirs, an owner anybody."""
    with service.gallery.database.writing() as session:
        token, row = invitations.invite(session, user, role=told.role, class_id=told.class_id)
    return {"link": f"/#/join/{token}", "token": token, "role": row.role, "expires": row.expires}


@router.get("/api/invitations/{token}", response_model=InvitationRead, response_model_by_alias=True)
def invitation(request: Request, service: ServiceDep, token: Token) -> dict[str, Any]:
    """What a link is for."""
    service.rate_limiter.hit(service.settings.rate_limits.login, "invitation", client_address(request))
    with service.gallery.database.reading() as session:
        row, school_class = invitations.looked_at(session, token)
    joined = school_class and {"id": school_class.id, "name": school_class.name}
    return {"role": row.role, "class": joined, "expires": row.expires}


@router.post("/api/invitations/{token}", response_model=SessionRead, status_code=201)
def join(
    request: Request, response: Response, service: ServiceDep, token: Token, told: Credentials
) -> dict[str, Any]:
    """Make the login, and log in; a pupil with a login joins one more class with it."""
    service.rate_limiter.hit(service.settings.rate_limits.login, "login", client_address(request))
    service.rate_limiter.hit(service.settings.rate_limits.login_name, "name", told.name.casefold())
    with service.gallery.database.writing() as session:
        person = invitations.accept(session, token, name=told.name, password=told.password)
    return _let_in(request, response, service, person)


def _let_in(request: Request, response: Response, service: Service, person: Person) -> dict[str, Any]:
    ticket = service.tickets.fresh(person_id=person.id, epoch=person.epoch)
    set_session_cookie(request, response, service, ticket)
    return _session_facts(service, ticket)


def _session_facts(service: Service, ticket: Ticket) -> dict[str, Any]:
    with service.gallery.database.reading() as session:
        person = None if ticket.person_id is None else session.get(Person, ticket.person_id)
        owned = people.owner_exists(session)
    return {
        "person": person and person_facts(person),
        "csrf": service.tickets.csrf(ticket),
        "owner_exists": owned,
        "languages": list(LANGUAGES),
        "version": __version__,
    }
