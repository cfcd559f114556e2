"""People with a login: names, roles, and sessions, which the server can end."""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from datetime import timedelta
from typing import Any, Literal

from sqlalchemy import delete, func, select
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from rumu.database.tables import LoginSession, Person, now
from rumu.studio.errors import Clash, Missing, NotAllowed, Unusable
from rumu.studio.passwords import HASHER, check_new_password, hash_password, verify_password
from rumu.studio.tickets import DAYS_VALID, Ticket

Role = Literal["owner", "teacher", "pupil"]
LANGUAGES = ("zh", "en")
_MAX_NAME = 80  # characters
_INVISIBLE = re.compile("[\u034f\u115f\u1160\u180b-\u180f\u3164\uffa0\ufe00-\ufe0f\U000e0100-\U000e01ef]")
"""Variation selectors and fillers, by which two names could differ and look the same."""


@dataclass(frozen=True, slots=True)
class Identity:
    """The person who makes a request."""

    id: str
    name: str
    role: Role
    language: str = "zh"

    @property
    def teaches(self) -> bool:
        return self.role in ("teacher", "owner")

    @property
    def owns(self) -> bool:
        return self.role == "owner"


def identity(person: Person) -> Identity:
    """Return the identity of a person who makes a request."""
    return Identity(person.id, person.name, person.role, person.language)  # type: ignore[arg-type]


def create_person(session: Session, *, name: str, password: str, role: Role) -> Person:
    """Add a login. Raises Clash when the name is taken, Unusable for an invalid name or weak password."""
    shown, key = _check_name(session, name)
    check_new_password(password, role=role, known=[shown])
    person = Person(name=shown, name_key=key, role=role, password=hash_password(password))
    session.add(person)
    try:
        session.flush()
    except IntegrityError as error:  # somebody took it at the same moment
        raise _taken(shown) from error
    return person


def _check_name(session: Session, name: str, *, person_id: str | None = None) -> tuple[str, str]:
    """Return a name as shown and as compared. Raises Unusable; Clash when another person has it."""
    shown, key = normalise_name(name)
    if session.scalar(select(Person.id).where(Person.name_key == key, Person.id != person_id)) is not None:
        raise _taken(shown)
    return shown, key


def _taken(shown: str) -> Clash:
    return Clash("name_taken", zh=f"「{shown}」已經有人用了。", en=f"The name {shown!r} is taken.")


def normalise_name(name: str) -> tuple[str, str]:
    """Return a name as shown and as compared: width, case and spaces do not distinguish two people."""
    shown = " ".join(unicodedata.normalize("NFC", name).split())
    if not name_key(shown) or len(shown) > _MAX_NAME or not shown.isprintable():
        raise Unusable(
            "name",
            zh=f"名字要有一到 {_MAX_NAME} 個字。",
            en=f"A name has 1 to {_MAX_NAME} printable characters, got {len(shown)}.",
        )
    return shown, name_key(shown)


def name_key(name: str) -> str:
    """Return what two names of one person share: width, case, spaces and invisible signs do not count."""
    folded = unicodedata.normalize("NFKC", unicodedata.normalize("NFKC", name).casefold())
    folded = _INVISIBLE.sub("", folded)
    return " ".join(folded.split())[:_MAX_NAME]


def authenticate(session: Session, *, name: str, password: str) -> Person | None:
    """Return the person of this name and password, None when there is none; in constant time."""
    try:
        person = session.scalar(select(Person).where(Person.name_key == normalise_name(name)[1]))
    except Unusable:
        person = None
    right = verify_password(password, person.password if person is not None and person.active else None)
    return person if right else None


def renew_hash(session: Session, person_id: str, *, password: str) -> None:
    """Hash a correct password again when its hash was made with weaker settings than today's."""
    person = session.get(Person, person_id)
    if person is not None and person.password is not None and HASHER.check_needs_rehash(person.password):
        person.password = hash_password(password)


def start_session(session: Session, person: Person) -> Ticket:
    """Return the ticket of a new session of this person; rows of expired sessions are deleted."""
    ticket = Ticket(person_id=person.id)
    expired = LoginSession.created < now() - timedelta(days=DAYS_VALID)
    session.execute(delete(LoginSession).where(expired))
    session.add(LoginSession(id=ticket.session_id, person_id=person.id))
    session.flush()
    return ticket


def end_session(session: Session, ticket: Ticket) -> None:
    """End the session of a ticket, wherever its cookie has been copied."""
    session.execute(delete(LoginSession).where(LoginSession.id == ticket.session_id))


def end_sessions(session: Session, person_id: str) -> None:
    """End every session of a person."""
    session.execute(delete(LoginSession).where(LoginSession.person_id == person_id))


def identify_session(session: Session, ticket: Ticket) -> Identity | None:
    """Return the person of a ticket; None if the session has ended or the person is disabled."""
    person = session.scalar(
        select(Person)
        .join(LoginSession, LoginSession.person_id == Person.id)
        .where(LoginSession.id == ticket.session_id, Person.id == ticket.person_id, Person.active)
    )
    return None if person is None else identity(person)


def set_password(session: Session, person_id: str, *, new: str, old: str | None = None) -> Person:
    """Set a password and end every session of this person; only an owner does so without the old one.

    Raises NotAllowed when the old password is wrong, Missing, Unusable.
    """
    person = find_person(session, person_id)
    if old is not None and not verify_password(old, person.password):
        raise NotAllowed(zh="舊密碼不對。", en="The old password is wrong.")
    check_new_password(new, role=person.role, known=[person.name, *([old] if old else [])])
    person.password = hash_password(new)
    end_sessions(session, person.id)
    return person


def change_person(session: Session, person_id: str, changes: dict[str, Any]) -> Person:
    """Change name, role, language or active. Raises Missing, Clash, or NotAllowed for the last owner."""
    person = find_person(session, person_id)
    was_owner = person.role == "owner" and person.active
    if changes.get("name") is not None:
        person.name, person.name_key = _check_name(session, changes["name"], person_id=person.id)
    for field in ("role", "language", "active"):
        if changes.get(field) is not None:
            setattr(person, field, changes[field])
    if not person.active:
        end_sessions(session, person.id)
    session.flush()
    if was_owner and not owner_exists(session):
        raise NotAllowed(zh="至少要留一位館主。", en="There must be an owner left.")
    return person


def owner_exists(session: Session) -> bool:
    """Whether there is an owner; until then the service must not be public."""
    wanted = select(func.count()).select_from(Person).where(Person.role == "owner", Person.active)
    return bool(session.scalar(wanted))


def find_person(session: Session, person_id: str) -> Person:
    """Return the person with this id. Raises Missing."""
    person = session.get(Person, person_id)
    if person is None:
        raise Missing(zh="沒有這個人。", en="There is no such person.")
    return person
