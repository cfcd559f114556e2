"""Rate limits, counted in memory: a service is one process."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

from limits import RateLimitItem, parse
from limits.storage import MemoryStorage
from limits.strategies import SlidingWindowCounterRateLimiter

from rumu.studio.errors import StudioError


class TooManyRequests(StudioError):  # noqa: N818
    """More requests than a limit allows. seconds: until the next one is allowed."""

    def __init__(self, seconds: int) -> None:
        super().__init__(
            "too_often",
            zh=f"請求太頻繁，請在 {seconds} 秒後再試。",
            en=f"Too many requests; try again in {seconds} s.",
        )
        self.seconds = seconds


@dataclass(frozen=True, slots=True)
class RateLimitSettings:
    """Requests in a time, in the notation of the library `limits`.

    login: of each address, for logins and invitations; login_name: for each name.
    marks: of each person; tries: of each address without a login.
    uploads: of each person.
    sheets: that are printed or shown for each address; photos: of sheets, of each person.
    meshes: that are made for each address; those that are there already are not counted.
    all: of each address, whatever it requests.
    """

    login: str = "60/minute"
    login_name: str = "10/minute"
    marks: str = "120/minute"
    tries: str = "60/minute"
    uploads: str = "60/hour"
    sheets: str = "120/minute"
    photos: str = "20/minute"
    meshes: str = "60/minute"
    all: str = "30000/minute"


class RateLimiter:
    """Counts the requests of each limit in a sliding window."""

    def __init__(self) -> None:
        self._limiter = SlidingWindowCounterRateLimiter(MemoryStorage())
        self._limits: dict[str, RateLimitItem] = {}

    def hit(self, limit: str, *identifiers: str) -> None:
        """Count a request. limit: such as '10/minute'. identifiers: what is counted, and whose it is.

        Raises TooManyRequests beyond the limit.
        """
        item = self._limits.get(limit) or self._limits.setdefault(limit, parse(limit))
        if not self._limiter.hit(item, *identifiers):
            stats = self._limiter.get_window_stats(item, *identifiers)
            raise TooManyRequests(max(1, math.ceil(stats.reset_time - time.time())))
