"""People with a login: who they are, what they are called, what they may be."""

from __future__ import annotations

import unicodedata
from dataclasses import dataclass
from typing import Any, Literal

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from rumu.database.tables import Person
from rumu.studio.errors import Clash, Missing, NotAllowed, Unusable
from rumu.studio.passwords import fits, hashed, outdated

Role = Literal["owner", "teacher", "pupil"]
LANGUAGES = ("zh", "en")
_LONGEST_NAME = 80


@dataclass(frozen=True, slots=True)
class Identity:
    """Who asks."""

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
    """What is known of a person while they ask."""
    return Identity(person.id, person.name, person.role, person.language)  # type: ignore[arg-type]


def create_person(session: Session, *, name: str, password: str, role: Role) -> Person:
    """A new login. Raises Clash when the name is taken, Unusable for a name or password that will not do."""
    shown, key = names(name)
    if _by_key(session, key) is not None:
        raise Clash("name_taken", zh=f"「{shown}」已經有人用了。", en=f"The name {shown!r} is taken.")
    person = Person(name=shown, name_key=key, role=role, password=hashed(password))
    session.add(person)
    session.flush()
    return person


def names(name: str) -> tuple[str, str]:
    """(as shown, as compared): width, case and spaces do not tell two people apart."""
    shown = " ".join(unicodedata.normalize("NFC", name).split())
    if not shown or len(shown) > _LONGEST_NAME or not shown.isprintable():
        raise Unusable(
            "name",
            zh=f"名字要有一到 {_LONGEST_NAME} 個字。",
            en=f"A name has 1 to {_LONGEST_NAME} printable characters, got {len(shown)}.",
        )
    return shown, unicodedata.normalize("NFKC", shown).casefold()[:_LONGEST_NAME]


def known_by(session: Session, *, name: str, password: str) -> Person | None:
    """The person whose name and password these are; takes as long when there is none."""
    try:
        person = _by_key(session, names(name)[1])
    except Unusable:
        person = None
    right = fits(password, person.password if person is not None and person.active else None)
    return person if right else None


def renew_hash(session: Session, person_id: str, *, password: str) -> None:
    """Hash a password again that is known to be right, when its hash is out of date."""
    person = session.get(Person, person_id)
    if person is not None and person.password is not None and outdated(person.password):
        person.password = hashed(password)


def current(session: Session, *, person_id: str, epoch: int) -> Identity | None:
    """Whose session it is, unless the person is gone, put out, or has signed out everywhere since."""
    person = session.get(Person, person_id)
    if person is None or not person.active or person.epoch != epoch:
        return None
    return identity(person)


def change_password(session: Session, person_id: str, *, old: str, new: str) -> Person:
    """A new password; every older session ends. Raises NotAllowed when the old one is wrong."""
    person = found(session, person_id)
    if not fits(old, person.password):
        raise NotAllowed("舊密碼不對。", "The old password is wrong.")
    person.password = hashed(new)
    person.epoch += 1
    return person


def change_person(session: Session, person_id: str, changes: dict[str, Any]) -> Person:
    """changes: of name, role, language, active. Raises Missing, Clash, or NotAllowed for the last owner."""
    person = found(session, person_id)
    was_owner = person.role == "owner" and person.active
    if changes.get("name") is not None:
        shown, key = names(changes["name"])
        other = _by_key(session, key)
        if other is not None and other.id != person.id:
            raise Clash("name_taken", zh=f"「{shown}」已經有人用了。", en=f"The name {shown!r} is taken.")
        person.name, person.name_key = shown, key
    for field in ("role", "language", "active"):
        if changes.get(field) is not None:
            setattr(person, field, changes[field])
    if not person.active:
        person.epoch += 1
    session.flush()
    if was_owner and not owner_exists(session):
        raise NotAllowed("至少要留一位館主。", "There must be an owner left.")
    return person


def set_password(session: Session, person_id: str, *, new: str) -> Person:
    """By an owner, for somebody who forgot theirs; every session of theirs ends."""
    person = found(session, person_id)
    person.password = hashed(new)
    person.epoch += 1
    return person


def owner_exists(session: Session) -> bool:
    """Whether somebody owns this place; until then it must not be shown to the world."""
    wanted = select(func.count()).select_from(Person).where(Person.role == "owner", Person.active)
    return bool(session.scalar(wanted))


def everybody(session: Session) -> list[Person]:
    """Everybody with a login, by name."""
    return list(session.scalars(select(Person).order_by(Person.name_key)))


def found(session: Session, person_id: str) -> Person:
    """The person with this id. Raises Missing."""
    person = session.get(Person, person_id)
    if person is None:
        raise Missing("沒有這個人。", "There is no such person.")
    return person


def _by_key(session: Session, key: str) -> Person | None:
    return session.scalar(select(Person).where(Person.name_key == key))
