"""Invitation links, each for one login: of the first owner at the first start, of others later."""

from __future__ import annotations

import hashlib
import secrets
from datetime import timedelta

from sqlalchemy import delete, update
from sqlalchemy.orm import Session

from rumu.database.tables import Invitation, Membership, Person, SchoolClass, now
from rumu.studio.classes import find_row
from rumu.studio.errors import Clash, Missing, NotAllowed
from rumu.studio.people import Identity, Role, authenticate, create_person, owner_exists

DAYS_VALID = 14


def invite_first_owner(session: Session) -> str | None:
    """Return the token of a new link for the first owner, None when there is one; earlier links expire."""
    if owner_exists(session):
        return None
    session.execute(delete(Invitation).where(Invitation.role == "owner", Invitation.author_id.is_(None)))
    return _add_invitation(session, role="owner", class_id=None, author_id=None)[0]


def invite(
    session: Session, user: Identity, *, role: Role, class_id: str | None = None
) -> tuple[str, Invitation]:
    """Add an invitation and return (token, row). Owners invite anybody, teachers pupils into their classes.

    Raises NotAllowed, or Missing for a class that is not theirs.
    """
    if not (user.owns or (user.role == "teacher" and role == "pupil" and class_id is not None)):
        raise NotAllowed(
            zh="老師只能邀請學生進自己的班。", en="A teacher may invite pupils into their own classes only."
        )
    if class_id is not None:
        find_row(session, SchoolClass, class_id, user=user, require_teacher=True)
        if role != "pupil":
            raise NotAllowed(zh="班級只收學生。", en="Only pupils are invited into a class.")
    return _add_invitation(session, role=role, class_id=class_id, author_id=user.id)


def _add_invitation(
    session: Session, *, role: Role, class_id: str | None, author_id: str | None
) -> tuple[str, Invitation]:
    token = secrets.token_urlsafe(24)
    row = Invitation(
        token=hashlib.sha256(token.encode()).hexdigest(),  # the link itself is not stored
        role=role,
        class_id=class_id,
        author_id=author_id,
        expires=now() + timedelta(days=DAYS_VALID),
    )
    session.add(row)
    session.flush()
    return token, row


def find_invitation(session: Session, token: str) -> tuple[Invitation, SchoolClass | None]:
    """Return an open invitation and its class. Raises Missing when it is unknown, used or expired."""
    row = session.get(Invitation, hashlib.sha256(token.encode()).hexdigest())
    if row is None or row.used is not None or row.expires < now():
        raise Missing(
            zh="這個邀請連結無效，或者已經用過、過期了。",
            en="This invitation is unknown, used or out of date.",
        )
    if row.role == "owner" and row.author_id is None and owner_exists(session):
        raise Missing(zh="已經有館主了。", en="There is an owner already.")
    return row, session.get(SchoolClass, row.class_id) if row.class_id else None


def accept(session: Session, token: str, *, name: str, password: str) -> Person:
    """Add the login of an invitation, or add a pupil who has a login to one more class.

    Raises Missing, Clash when the name is taken, Unusable for an invalid name or password.
    """
    row, school_class = find_invitation(session, token)
    taken = update(Invitation).where(Invitation.token == row.token, Invitation.used.is_(None))
    if session.execute(taken.values(used=now())).rowcount != 1:  # type: ignore[attr-defined]
        raise Missing(zh="這個邀請連結已經用過了。", en="This invitation has been used.")
    person = None
    if school_class is not None:
        person = authenticate(session, name=name, password=password)
        if person is not None and person.role != "pupil":
            raise Clash("name_taken", zh="這個名字不是學生。", en="That name is not a pupil's.")
    if person is None:
        role: Role = row.role  # type: ignore[assignment]
        person = create_person(session, name=name, password=password, role=role)
    if school_class is not None and session.get(Membership, (school_class.id, person.id)) is None:
        session.add(Membership(class_id=school_class.id, person_id=person.id))
        session.flush()
    return person
