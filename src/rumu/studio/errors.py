"""Errors of the studio: each has a code for programs and a sentence in both languages for people."""

from __future__ import annotations

import re
from typing import Any

from rumu.errors import RumuError

_FOLDERS = re.compile(
    r"""(?<![\w.:/\\])(?:(?:/[^\s/:'"()\[\],;]+)+/|(?:[A-Za-z]:\\|\\\\)(?:[^\\\s:'"]+\\)+)(?=[^\s/\\])"""
)
"""The folders of an absolute path, up to its last name, on any system."""


def without_folders(text: str) -> str:
    """A text with the last names of the absolute paths in it: nobody outside needs the folders."""
    return _FOLDERS.sub("", text)


class StudioError(RumuError):
    """Base of the studio's errors.

    code: one word or two; zh, en: one sentence each; what is not given is that of the class.
    """

    code = "error"
    zh: str = "無法完成。"
    en = "It cannot be done."

    def __init__(self, code: str | None = None, *, zh: str | None = None, en: str | None = None) -> None:
        self.code = code or self.code
        super().__init__(en or self.en, zh=zh or self.zh)

    def __reduce__(self) -> Any:  # pickled between processes, whatever the arguments of a subclass
        return Exception.__new__, (type(self), self.en), self.__dict__


class Missing(StudioError):  # noqa: N818
    """There is no such thing, or the person who asks may not know of it."""

    code, zh, en = "not_found", "沒有這個項目。", "There is no such thing."


class NotAllowed(StudioError):  # noqa: N818
    """The person who asks may not do this."""

    code, zh, en = "not_allowed", "您沒有這個權限。", "You may not do this."


class Clash(StudioError):  # noqa: N818
    """It conflicts with something that exists already."""

    code = "conflict"


class Unusable(StudioError):  # noqa: N818
    """What was given cannot be used."""

    code = "unusable"


class Busy(StudioError):  # noqa: N818
    """Too many requests are waiting; it can be tried again later."""

    code = "busy"
    zh, en = "現在排隊的人太多，請過一會兒再試。", "Too many are waiting now; try again in a moment."
