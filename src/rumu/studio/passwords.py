"""Passwords: Argon2id hashes, made two at a time so that a rush at the door does not take all the memory."""

from __future__ import annotations

import functools
import threading

from argon2 import PasswordHasher
from argon2.exceptions import InvalidHashError, VerificationError

from rumu.studio.errors import Unusable

SHORTEST, LONGEST = 8, 200

_HASHER = PasswordHasher()  # RFC 9106, low memory: 64 MiB each
_TWO = threading.BoundedSemaphore(2)


def hashed(password: str) -> str:
    """The Argon2id hash of a new password. Raises Unusable when it is too short or too long."""
    if not SHORTEST <= len(password) <= LONGEST:
        raise Unusable(
            "password",
            zh=f"密碼要有 {SHORTEST} 到 {LONGEST} 個字元，現在有 {len(password)} 個。",
            en=f"A password has {SHORTEST} to {LONGEST} characters, got {len(password)}.",
        )
    with _TWO:
        return _HASHER.hash(password)


def fits(password: str, held: str | None) -> bool:
    """Whether the password is the one that was hashed; as slow when there is none, so that names do not
    leak."""
    try:
        with _TWO:
            _HASHER.verify(held or _nobody(), password[: 2 * LONGEST])
    except (VerificationError, InvalidHashError):
        return False
    return held is not None


def outdated(held: str) -> bool:
    """Whether the hash was made with weaker settings than today's."""
    return _HASHER.check_needs_rehash(held)


@functools.cache
def _nobody() -> str:
    return _HASHER.hash("a password that nobody has")
