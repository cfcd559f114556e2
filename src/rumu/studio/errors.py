"""What the studio refuses: each refusal has a code for programs and a sentence in both languages for a
person."""

from __future__ import annotations

from typing import Any

from rumu.errors import RumuError


class StudioError(RumuError):
    """Base. code: one word or two; zh, en: one sentence each."""

    def __init__(self, code: str, *, zh: str, en: str) -> None:
        super().__init__(en)
        self.code, self.zh, self.en = code, zh, en

    def __reduce__(self) -> Any:
        return _again, (type(self), self.__dict__)  # as it comes back from another process


def _again(kind: type[StudioError], told: dict[str, Any]) -> StudioError:
    error = kind.__new__(kind, told["en"])
    error.__dict__.update(told)
    return error


class Missing(StudioError):  # noqa: N818  what it is, not that it went wrong
    """There is no such thing, or it is not this person's to know of."""

    def __init__(self, zh: str = "沒有這個項目。", en: str = "There is no such thing.") -> None:
        super().__init__("not_found", zh=zh, en=en)


class NotAllowed(StudioError):  # noqa: N818
    """Somebody else may do this, this person may not."""

    def __init__(self, zh: str = "您沒有這個權限。", en: str = "You may not do this.") -> None:
        super().__init__("not_allowed", zh=zh, en=en)


class Clash(StudioError):  # noqa: N818
    """It cannot be done now: something of the kind is there already."""

    def __init__(self, code: str = "conflict", *, zh: str, en: str) -> None:
        super().__init__(code, zh=zh, en=en)


class Unusable(StudioError):  # noqa: N818
    """What was given cannot be used."""

    def __init__(self, code: str = "unusable", *, zh: str, en: str) -> None:
        super().__init__(code, zh=zh, en=en)


class Busy(StudioError):  # noqa: N818
    """Too much is waiting; later it will do."""

    def __init__(self) -> None:
        super().__init__(
            "busy",
            zh="現在排隊的人太多，請過一會兒再試。",
            en="Too many are waiting now; try again in a moment.",
        )
