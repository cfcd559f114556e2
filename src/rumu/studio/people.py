"""People with a login: names, roles, and passwords as Argon2id hashes.

Passwords are hashed two at a time, so that many logins at once do not take all the memory.
"""

from __future__ import annotations

import functools
import threading
import unicodedata
from dataclasses import dataclass
from typing import Any, Literal

from argon2 import PasswordHasher
from argon2.exceptions import InvalidHashError, VerificationError
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from rumu.database.tables import Person
from rumu.studio.errors import Clash, Missing, NotAllowed, Unusable

Role = Literal["owner", "teacher", "pupil"]
LANGUAGES = ("zh", "en")
_MAX_NAME = 80  # characters
MIN_PASSWORD, MAX_PASSWORD = 8, 200  # characters

HASHER = PasswordHasher()  # RFC 9106, low memory: 64 MiB each
_TWO_AT_A_TIME = threading.BoundedSemaphore(2)


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
    """Add a login. Raises Clash when the name is taken, Unusable for an invalid name or password."""
    shown, key = _check_name(session, name)
    person = Person(name=shown, name_key=key, role=role, password=hash_password(password))
    session.add(person)
    session.flush()
    return person


def _check_name(session: Session, name: str, *, person_id: str | None = None) -> tuple[str, str]:
    """Return a name as shown and as compared. Raises Unusable; Clash when another person has it."""
    shown, key = normalise_name(name)
    if session.scalar(select(Person.id).where(Person.name_key == key, Person.id != person_id)) is not None:
        raise Clash("name_taken", zh=f"「{shown}」已經有人用了。", en=f"The name {shown!r} is taken.")
    return shown, key


def normalise_name(name: str) -> tuple[str, str]:
    """Return a name as shown and as compared: width, case and spaces do not distinguish two people."""
    shown = " ".join(unicodedata.normalize("NFC", name).split())
    if not shown or len(shown) > _MAX_NAME or not shown.isprintable():
        raise Unusable(
            "name",
            zh=f"名字要有一到 {_MAX_NAME} 個字。",
            en=f"A name has 1 to {_MAX_NAME} printable characters, got {len(shown)}.",
        )
    return shown, unicodedata.normalize("NFKC", shown).casefold()[:_MAX_NAME]


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


def identify_session(session: Session, *, person_id: str, epoch: int) -> Identity | None:
    """Return the person of a session; None if they are deleted, disabled, or have ended all sessions."""
    person = session.get(Person, person_id)
    if person is None or not person.active or person.epoch != epoch:
        return None
    return identity(person)


def set_password(session: Session, person_id: str, *, new: str, old: str | None = None) -> Person:
    """Set a password and end every session of this person; only an owner does so without the old one.

    Raises NotAllowed when the old password is wrong, Missing, Unusable.
    """
    person = find_person(session, person_id)
    if old is not None and not verify_password(old, person.password):
        raise NotAllowed(zh="舊密碼不對。", en="The old password is wrong.")
    person.password = hash_password(new)
    person.epoch += 1
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
        person.epoch += 1
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


def hash_password(password: str) -> str:
    """Return the Argon2id hash of a new password. Raises Unusable when it is too short or too long."""
    if not MIN_PASSWORD <= len(password) <= MAX_PASSWORD:
        raise Unusable(
            "password",
            zh=f"密碼要有 {MIN_PASSWORD} 到 {MAX_PASSWORD} 個字元，現在有 {len(password)} 個。",
            en=f"A password has {MIN_PASSWORD} to {MAX_PASSWORD} characters, got {len(password)}.",
        )
    with _TWO_AT_A_TIME:
        return HASHER.hash(password)


def verify_password(password: str, hashed: str | None) -> bool:
    """Whether a password has this hash; as slow without one, so that response times reveal no names."""
    try:
        with _TWO_AT_A_TIME:
            HASHER.verify(hashed or _placeholder_hash(), password[: 2 * MAX_PASSWORD])
    except (VerificationError, InvalidHashError):
        return False
    return hashed is not None


@functools.cache
def _placeholder_hash() -> str:
    return HASHER.hash("a password that nobody has")
