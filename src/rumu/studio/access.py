"""Access rights: pupils see what they wrote, teachers also what their pupils wrote, owners everything."""

from __future__ import annotations

from typing import Any

from sqlalchemy import ColumnElement, Select, false, or_, select, true
from sqlalchemy.orm import Session

from rumu.database.tables import Attempt, Membership, Person, SchoolClass
from rumu.studio.errors import Missing
from rumu.studio.people import Identity


def pupils_of(teacher_id: str) -> Select[Any]:
    """Return a query of the ids of all pupils in the classes of a teacher."""
    return (
        select(Membership.person_id)
        .join(SchoolClass, SchoolClass.id == Membership.class_id)
        .where(SchoolClass.teacher_id == teacher_id)
    )


def attempts_of(user: Identity, *, simulated: bool = True) -> ColumnElement[bool]:
    """Return a condition on Attempt: those that this person may see; the simulated ones are for all."""
    visible = _within(user, Attempt.person_id)
    return or_(visible, Attempt.kind == "simulated") if simulated else visible


def classes_of(user: Identity) -> ColumnElement[bool]:
    """Return a condition on SchoolClass: those in which this person teaches or learns; an owner sees all."""
    if user.owns:
        return true()
    if user.teaches:
        return SchoolClass.teacher_id == user.id
    return SchoolClass.id.in_(select(Membership.class_id).where(Membership.person_id == user.id))


def find_visible_person(session: Session, person_id: str, *, user: Identity) -> Person:
    """Return a person. Raises Missing also where they exist but may not be seen: an id reveals nothing."""
    person = session.scalar(select(Person).where(Person.id == person_id, _within(user, Person.id)))
    if person is None:
        raise Missing(zh="沒有這個人。", en="There is no such person.")
    return person


def find_visible_attempt(session: Session, attempt_id: str, *, user: Identity | None) -> Attempt:
    """Return an attempt. Raises Missing also where it exists but may not be seen."""
    allowed = Attempt.kind == "simulated" if user is None else attempts_of(user)
    attempt = session.scalar(select(Attempt).where(Attempt.id == attempt_id, allowed))
    if attempt is None:
        raise Missing(zh="沒有這張臨作。", en="There is no such copy.")
    return attempt


def _within(user: Identity, column: object) -> ColumnElement[bool]:
    """Return a condition on a column of ids of people: those that this person may see."""
    if user.owns:
        return true()
    themselves: ColumnElement[bool] = column == user.id  # type: ignore[assignment]
    if user.teaches:
        return or_(themselves, column.in_(pupils_of(user.id)))  # type: ignore[attr-defined]
    return themselves if user.role == "pupil" else false()
