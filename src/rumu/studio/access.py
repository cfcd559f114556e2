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


def attempts_of(who: Identity, *, simulated: bool = True) -> ColumnElement[bool]:
    """Return a condition on Attempt: those that this person may see; the simulated ones are for all."""
    seen = _within(who, Attempt.person_id)
    return or_(seen, Attempt.kind == "simulated") if simulated else seen


def classes_of(who: Identity) -> ColumnElement[bool]:
    """Return a condition on SchoolClass: those in which this person teaches or learns; an owner sees all."""
    if who.owns:
        return true()
    if who.teaches:
        return SchoolClass.teacher_id == who.id
    return SchoolClass.id.in_(select(Membership.class_id).where(Membership.person_id == who.id))


def find_visible_person(session: Session, person_id: str, *, who: Identity) -> Person:
    """Return a person. Raises Missing also where they exist but may not be seen: an id reveals nothing."""
    person = session.scalar(select(Person).where(Person.id == person_id, _within(who, Person.id)))
    if person is None:
        raise Missing(zh="沒有這個人。", en="There is no such person.")
    return person


def find_visible_attempt(session: Session, attempt_id: str, *, who: Identity | None) -> Attempt:
    """Return an attempt. Raises Missing also where it exists but may not be seen."""
    allowed = Attempt.kind == "simulated" if who is None else attempts_of(who)
    attempt = session.scalar(select(Attempt).where(Attempt.id == attempt_id, allowed))
    if attempt is None:
        raise Missing(zh="沒有這張臨作。", en="There is no such copy.")
    return attempt


def _within(who: Identity, column: object) -> ColumnElement[bool]:
    """Return a condition on a column of ids of people: those that this person may see."""
    if who.owns:
        return true()
    themselves: ColumnElement[bool] = column == who.id  # type: ignore[assignment]
    if who.teaches:
        return or_(themselves, column.in_(pupils_of(who.id)))  # type: ignore[attr-defined]
    return themselves if who.role == "pupil" else false()
