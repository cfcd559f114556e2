"""Sessions as signed tickets in a cookie, each with its CSRF token.

A visitor's session is its ticket alone. That of a person who is logged in has a row in the database, too
(`rumu.studio.people.start_session`), so that the server can end it.
"""

from __future__ import annotations

import hashlib
import hmac
import secrets
from dataclasses import dataclass, field

from itsdangerous import BadData, URLSafeTimedSerializer
from sqlalchemy import select
from sqlalchemy.exc import IntegrityError

from rumu.database.engine import Database
from rumu.database.tables import Setting

_KEY = "session_key"
_SALT = "rumu-session"
DAYS_VALID = 30


@dataclass(frozen=True, slots=True)
class Ticket:
    """The content of a session's cookie.

    person_id: None for a visitor. serial: random, one for each session.
    """

    person_id: str | None = None
    serial: str = field(default_factory=lambda: secrets.token_urlsafe(18))

    @property
    def session_id(self) -> str:
        """The id of the session's row, from which nobody can make the ticket."""
        return hashlib.sha256(self.serial.encode()).hexdigest()


class Tickets:
    """Signs and reads tickets with one key. fingerprint: tells services apart, and nothing of the key."""

    def __init__(self, key: str) -> None:
        self._key = key.encode()
        self.fingerprint = hashlib.sha256(b"name:" + self._key).hexdigest()[:8]
        self._signer = URLSafeTimedSerializer(
            key, salt=_SALT, signer_kwargs={"digest_method": hashlib.sha256}
        )

    def serialise(self, ticket: Ticket) -> str:
        """Return the signed text of a ticket, for the cookie."""
        return self._signer.dumps([ticket.serial, ticket.person_id])

    def read(self, text: str | None) -> Ticket | None:
        """Return the ticket, None for a forged, damaged or expired one."""
        if not text or len(text) > 1000:
            return None
        try:
            serial, person_id = self._signer.loads(text, max_age=DAYS_VALID * 86400)
            return Ticket(None if person_id is None else str(person_id), str(serial))
        except (BadData, ValueError, TypeError):
            return None

    def csrf(self, ticket: Ticket) -> str:
        """Return the token that a page must send in a header; another site cannot read it."""
        return hmac.new(self._key, f"csrf:{ticket.serial}".encode(), hashlib.sha256).hexdigest()[:40]

    def has_csrf_token(self, ticket: Ticket, token: str | None) -> bool:
        """Whether a token is that of this ticket."""
        return hmac.compare_digest(self.csrf(ticket).encode(), (token or "").encode("utf-8", "replace"))


def open_tickets(database: Database) -> Tickets:
    """Return the signer with the key of this database, which is made when there is none yet."""
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
