"""How often somebody may ask, counted in memory: a service is one process."""

from __future__ import annotations

from limits import RateLimitItem, parse
from limits.storage import MemoryStorage
from limits.strategies import SlidingWindowCounterRateLimiter

from rumu.studio.errors import StudioError


class TooOften(StudioError):  # noqa: N818
    """Asked more often than is allowed. seconds: until it may be asked again."""

    def __init__(self, seconds: int) -> None:
        super().__init__(
            "too_often",
            zh=f"請求太頻繁，請在 {seconds} 秒後再試。",
            en=f"Asked too often; try again in {seconds} s.",
        )
        self.seconds = seconds


class RateLimits:
    """One window a rule and person or address."""

    def __init__(self) -> None:
        self._limiter = SlidingWindowCounterRateLimiter(MemoryStorage())
        self._rules: dict[str, RateLimitItem] = {}

    def count(self, rule: str, *whose: str) -> None:
        """Count one more. Raises TooOften beyond the rule, such as '10/minute'."""
        item = self._rules.get(rule) or self._rules.setdefault(rule, parse(rule))
        if not self._limiter.hit(item, *whose):
            import math
            import time

            stats = self._limiter.get_window_stats(item, *whose)
            raise TooOften(max(1, math.ceil(stats.reset_time - time.time())))
