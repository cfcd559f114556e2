"""Comparisons of two copies of one master: the least judged pairs first, shown in random order."""

from __future__ import annotations

import itertools
import math
import random
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy import func, or_, select
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from rumu.database.tables import Attempt, Comparison, Person, Work
from rumu.studio.access import attempts_of, find_visible_attempt, pupils_of
from rumu.studio.errors import Clash, Unusable
from rumu.studio.people import Identity

_MAX_CANDIDATES = 60  # attempts of a work among which a pair is sought: the least judged


@dataclass(frozen=True, slots=True)
class AttemptPair:
    """Two attempts to compare.

    left, right: in random order. done: pairs that this judge has judged; left_over: pairs still to judge.
    """

    left: Attempt
    right: Attempt
    done: int
    left_over: int


def next_pair(session: Session, user: Identity, *, work_id: str | None = None) -> AttemptPair | None:
    """Return a pair that this judge has not judged yet, of one work if given; None when none is left."""
    attempts = _candidates(session, user, work_id)
    verdicts_given = select(Comparison.first_id, Comparison.second_id).where(Comparison.judge_id == user.id)
    judged = {frozenset((first, second)) for first, second in session.execute(verdicts_given)}
    by_work: dict[str, list[Attempt]] = {}
    for attempt in attempts:
        by_work.setdefault(attempt.work_id, []).append(attempt)
    open_pairs: dict[str, int] = {}
    for work, group in by_work.items():
        members = {attempt.id for attempt in group}
        open_pairs[work] = math.comb(len(group), 2) - sum(pair <= members for pair in judged)
    works = [work for work, count in open_pairs.items() if count]
    if not works:
        return None
    times = _count_judgements(session, [attempt.id for attempt in attempts])
    pairs = (_least_judged(by_work[work], times, judged) for work in works)
    _, chosen = min(pairs, key=lambda pair: pair[0])
    left, right = random.sample(chosen, 2)
    ids = {attempt.id for attempt in attempts}
    done = sum(pair <= ids for pair in judged)
    return AttemptPair(left, right, done, sum(open_pairs.values()))


def _candidates(session: Session, user: Identity, work_id: str | None) -> Sequence[Attempt]:
    masters = select(Work.id).where(func.trim(Work.character) != "")
    wanted = select(Attempt).where(
        attempts_of(user), Attempt.score.is_not(None), Attempt.work_id.in_(masters)
    )
    if work_id is not None:
        wanted = wanted.where(Attempt.work_id == work_id)
    return session.scalars(wanted).all()


def _count_judgements(session: Session, ids: Sequence[str]) -> Counter[str]:
    """Count how often each attempt has been judged, by anybody."""
    among = or_(Comparison.first_id.in_(ids), Comparison.second_id.in_(ids))
    pairs = session.execute(select(Comparison.first_id, Comparison.second_id).where(among))
    return Counter(attempt for first, second in pairs for attempt in (first, second))


def _least_judged(
    group: Sequence[Attempt], times: Counter[str], judged: set[frozenset[str]]
) -> tuple[tuple[int, float], list[Attempt]]:
    """Return ((judgements of its two, random number), the pair) for the least judged open pair of a work."""
    # drawn before they are sorted, so that attempts judged equally often come in random order
    order = sorted(random.sample(list(group), len(group)), key=lambda attempt: times[attempt.id])
    for some in (order[:_MAX_CANDIDATES], order):
        pairs = (
            ((times[a.id] + times[b.id], random.random()), [a, b])
            for a, b in itertools.combinations(some, 2)
            if frozenset((a.id, b.id)) not in judged
        )
        best = min(pairs, key=lambda pair: pair[0], default=None)
        if best is not None:
            return best
    raise AssertionError("expected an open pair in a group that has one")


def judge(
    session: Session, user: Identity, *, left: str, right: str, winner: str, seconds: float | None
) -> Comparison:
    """Store a judgement: winner 'left', 'right' or 'same'.

    Raises Missing for attempts that this judge may not see, Unusable for two that cannot be compared, Clash
    for a pair that they judged before.
    """
    a, b = (find_visible_attempt(session, one, user=user) for one in (left, right))
    if a.id == b.id or a.work_id != b.work_id:
        raise Unusable(zh="要比的是同一範字的兩張臨作。", en="Expected two different copies of one master.")
    first, second = sorted((a.id, b.id))
    row = Comparison(
        judge_id=user.id,
        work_id=a.work_id,
        first_id=first,
        second_id=second,
        left_id=a.id,
        winner=winner,
        seconds=seconds,
    )
    session.add(row)
    try:
        session.flush()
    except IntegrityError as error:
        raise Clash("judged", zh="這一對您已經比過了。", en="You have judged this pair already.") from error
    return row


def verdicts(session: Session, user: Identity) -> list[tuple[str, str, str, str, str, float | None]]:
    """Return (judge, work, left, right, winner, seconds) with ids.

    All judgements to an owner; to a teacher those by themselves and by their pupils.
    """
    wanted = select(Comparison).join(Person, Person.id == Comparison.judge_id).order_by(Comparison.created)
    if not user.owns:
        wanted = wanted.where(
            or_(Comparison.judge_id == user.id, Comparison.judge_id.in_(pupils_of(user.id)))
        )
    rows = []
    for one in session.scalars(wanted):
        right = one.second_id if one.left_id == one.first_id else one.first_id
        rows.append((one.judge_id, one.work_id, one.left_id, right, one.winner, one.seconds))
    return rows
