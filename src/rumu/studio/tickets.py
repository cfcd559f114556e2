"""Sessions as signed tickets: nothing of them is kept here but the key, and each carries its own CSRF
token."""

from __future__ import annotations

import hashlib
import hmac
import secrets
from dataclasses import dataclass

from itsdangerous import BadData, URLSafeTimedSerializer
from sqlalchemy import select
from sqlalchemy.exc import IntegrityError

from rumu.database.engine import Database
from rumu.database.tables import Setting

_KEY = "session_key"
_SALT = "rumu-session"
DAYS = 30


@dataclass(frozen=True, slots=True)
class Ticket:
    """serial: drawn at random for each session. person_id: None for a visitor. epoch: of the person, when
    the ticket was made."""

    serial: str
    person_id: str | None = None
    epoch: int = 0


class Tickets:
    """Makes and reads tickets with one key."""

    def __init__(self, key: str) -> None:
        self._key = key.encode()
        self._signer = URLSafeTimedSerializer(
            key, salt=_SALT, signer_kwargs={"digest_method": hashlib.sha256}
        )

    def fresh(self, *, person_id: str | None = None, epoch: int = 0) -> Ticket:
        return Ticket(secrets.token_urlsafe(12), person_id, epoch)

    def written(self, ticket: Ticket) -> str:
        """What stands in the cookie."""
        return self._signer.dumps([ticket.serial, ticket.person_id, ticket.epoch])

    def read(self, text: str | None) -> Ticket | None:
        """The ticket, or None for a forged, damaged or old one."""
        if not text or len(text) > 1000:
            return None
        try:
            serial, person_id, epoch = self._signer.loads(text, max_age=DAYS * 86400)
            return Ticket(str(serial), None if person_id is None else str(person_id), int(epoch))
        except (BadData, ValueError, TypeError):
            return None

    def csrf(self, ticket: Ticket) -> str:
        """What a page must say back in a header: another site can send the cookie, but cannot read this."""
        return hmac.new(self._key, f"csrf:{ticket.serial}".encode(), hashlib.sha256).hexdigest()[:40]

    def says(self, ticket: Ticket, token: str | None) -> bool:
        return hmac.compare_digest(self.csrf(ticket).encode(), (token or "").encode("utf-8", "replace"))


def open_tickets(database: Database) -> Tickets:
    """With the key of this database, made when there is none yet."""
    with database.reading() as session:
        key = session.scalar(select(Setting.value).where(Setting.name == _KEY))
    if key is None:
        try:
            with database.writing() as session:
                session.add(Setting(name=_KEY, value=secrets.token_hex(32)))
        except IntegrityError:
            pass  # another process was first
        with database.reading() as session:
            key = session.scalars(select(Setting.value).where(Setting.name == _KEY)).one()
    return Tickets(key)
