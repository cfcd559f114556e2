"""Errors of the studio: each has a code for programs and a sentence in both languages for people."""

from __future__ import annotations

from typing import Any

from rumu.errors import RumuError


class StudioError(RumuError):
    """Base. code: one word or two; zh, en: one sentence each."""

    def __init__(self, code: str, *, zh: str, en: str) -> None:
        super().__init__(en)
        self.code, self.zh, self.en = code, zh, en

    def __reduce__(self) -> Any:
        return _restore, (type(self), self.__dict__)  # pickled between processes


def _restore(kind: type[StudioError], state: dict[str, Any]) -> StudioError:
    error = kind.__new__(kind, state["en"])
    error.__dict__.update(state)
    return error


class Missing(StudioError):  # noqa: N818
    """There is no such thing, or this person may not know of it."""

    def __init__(self, zh: str = "沒有這個項目。", en: str = "There is no such thing.") -> None:
        super().__init__("not_found", zh=zh, en=en)


class NotAllowed(StudioError):  # noqa: N818
    """This person may not do this."""

    def __init__(self, zh: str = "您沒有這個權限。", en: str = "You may not do this.") -> None:
        super().__init__("not_allowed", zh=zh, en=en)


class Clash(StudioError):  # noqa: N818
    """It conflicts with something that exists already."""

    def __init__(self, code: str = "conflict", *, zh: str, en: str) -> None:
        super().__init__(code, zh=zh, en=en)


class Unusable(StudioError):  # noqa: N818
    """What was given cannot be used."""

    def __init__(self, code: str = "unusable", *, zh: str, en: str) -> None:
        super().__init__(code, zh=zh, en=en)


class Busy(StudioError):  # noqa: N818
    """Too many requests are waiting; it can be tried again later."""

    def __init__(self) -> None:
        super().__init__(
            "busy",
            zh="現在排隊的人太多，請過一會兒再試。",
            en="Too many are waiting now; try again in a moment.",
        )
