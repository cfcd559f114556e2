"""Passwords: how hard they are to guess, and their Argon2id hashes.

Passwords are hashed two at a time, so that many logins at once do not take all the memory, and with lower
priority where threads can have one, since each hash takes four threads for a while.
"""

from __future__ import annotations

import functools
import os
import sys
import threading
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor

from argon2 import PasswordHasher
from argon2.exceptions import InvalidHashError, VerificationError

from rumu.studio.errors import Unusable

MIN_PASSWORD, MAX_PASSWORD = 8, 200  # characters
LEAST_STRENGTH = {"owner": 3, "teacher": 3, "pupil": 2}
"""The least strength of a new password by role, 0 to 4 as zxcvbn estimates it.

2 withstands a guesser whom the limit of logins slows down (10^6 guesses), and is what a child remembers. 3
withstands one who is faster (10^8 guesses): owners and teachers see what others wrote.
"""
_ESTIMATED = 72  # characters of a password that are estimated; the time grows with their square

HASHER = PasswordHasher()  # RFC 9106, low memory: 64 MiB each
_NICENESS = 15  # as the workers that mark have

ADVICE = {
    "Use a few words, avoid common phrases.": "用幾個詞連起來，不要用常見的句子。",
    "No need for symbols, digits, or uppercase letters.": "不必用符號、數字或大寫字母。",
    "Add another word or two. Uncommon words are better.": "再加一兩個詞，越少見越好。",
    "Straight rows of keys are easy to guess.": "鍵盤上的一排鍵很容易猜。",
    "Short keyboard patterns are easy to guess.": "鍵盤上短短的走法很容易猜。",
    "Use a longer keyboard pattern with more turns.": "鍵盤走法要長一點、多轉幾個彎。",
    'Repeats like "aaa" are easy to guess.': "重複同一個字元（如「aaa」）很容易猜。",
    'Repeats like "abcabcabc" are only slightly harder to guess than "abc".': (
        "重複一段（如「abcabcabc」）只比「abc」難猜一點點。"
    ),
    "Avoid repeated words and characters.": "不要重複詞或字元。",
    'Sequences like "abc" or "6543" are easy to guess.': "連號（如「abc」或「6543」）很容易猜。",
    "Avoid sequences.": "不要用連號。",
    "Recent years are easy to guess.": "最近的年份很容易猜。",
    "Avoid recent years.": "不要用最近的年份。",
    "Avoid years that are associated with you.": "不要用和您有關的年份。",
    "Dates are often easy to guess.": "日期往往很容易猜。",
    "Avoid dates and years that are associated with you.": "不要用和您有關的日期和年份。",
    "This is a top-10 common password.": "這是最常見的十個密碼之一。",
    "This is a top-100 common password.": "這是最常見的一百個密碼之一。",
    "This is a very common password.": "這是很常見的密碼。",
    "This is similar to a commonly used password.": "這和常見的密碼很像。",
    "A word by itself is easy to guess.": "單獨一個詞很容易猜。",
    "Names and surnames by themselves are easy to guess.": "單獨一個姓或名很容易猜。",
    "Common names and surnames are easy to guess.": "常見的姓名很容易猜。",
    "Capitalization doesn't help very much.": "改成大寫開頭幫助不大。",
    "All-uppercase is almost as easy to guess as all-lowercase.": "全部大寫和全部小寫差不多容易猜。",
    "Reversed words aren't much harder to guess.": "把詞倒過來寫，並沒有難猜多少。",
    "Predictable substitutions like '@' instead of 'a' don't help very much.": (
        "用「@」代替「a」這類換法幫助不大。"
    ),
}
"""What zxcvbn says about a password that is easily guessed, in Chinese."""


def check_new_password(password: str, *, role: str, known: Iterable[str] = ()) -> None:
    """Raise Unusable for a new password that is too short, too long, or too easily guessed.

    known: what a guesser would try first, such as the person's name.
    """
    from zxcvbn import zxcvbn  # reads its lists of words when it is imported

    if not MIN_PASSWORD <= len(password) <= MAX_PASSWORD:
        raise Unusable(
            "password",
            zh=f"密碼要有 {MIN_PASSWORD} 到 {MAX_PASSWORD} 個字元，現在有 {len(password)} 個。",
            en=f"A password has {MIN_PASSWORD} to {MAX_PASSWORD} characters, got {len(password)}.",
        )
    tried = [word for text in known for word in (text, *text.split()) if word]
    estimate = zxcvbn(password[:_ESTIMATED], user_inputs=[*tried, "rumu", "入木", "書法", "calligraphy"])
    strength, least = estimate["score"], LEAST_STRENGTH[role]
    if strength >= least:
        return
    warning, suggestions = estimate["feedback"]["warning"], estimate["feedback"]["suggestions"]
    if not warning and not suggestions:  # zxcvbn has advice for 2 and less only
        suggestions = ["Add another word or two. Uncommon words are better."]
    advice = list(filter(None, (warning, *suggestions)))
    raise Unusable(
        "weak_password",
        zh=f"這個密碼太容易猜到：強度 {strength}（0 到 4），至少要 {least}。"
        + "".join(ADVICE.get(sentence, "") for sentence in advice),
        en=f"This password is too easy to guess: strength {strength} of 4, at least {least} is needed. "
        + " ".join(advice),
    )


def hash_password(password: str) -> str:
    """Return the Argon2id hash of a password."""
    return _hashing_threads().submit(HASHER.hash, password).result()


def verify_password(password: str, hashed: str | None) -> bool:
    """Whether a password has this hash; as slow without one, so that response times reveal no names."""
    try:
        _hashing_threads().submit(
            HASHER.verify, hashed or _placeholder_hash(), password[: 2 * MAX_PASSWORD]
        ).result()
    except (VerificationError, InvalidHashError):
        return False
    return hashed is not None


@functools.cache
def _placeholder_hash() -> str:
    return HASHER.hash("a password that nobody has")


@functools.cache
def _hashing_threads() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(2, thread_name_prefix="rumu-hash", initializer=_lower_priority)


def _lower_priority() -> None:
    """Let this thread, and those that it starts, go after others; elsewhere a process has one priority."""
    if sys.platform == "linux":
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICENESS)
