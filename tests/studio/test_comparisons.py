"""Pairs are of one master, the least judged first, never twice for a judge, in random order."""

from __future__ import annotations

import itertools
from collections import Counter

import pytest

from rumu.database.tables import Attempt
from rumu.studio import comparisons
from rumu.studio.errors import Clash, Missing, Unusable


@pytest.fixture
def attempts(gallery):
    def make(works: dict[str, int], *, kind="simulated", person_id=None, score=50.0):
        with gallery.database.writing() as session:
            for work, count in works.items():
                for _ in range(count):
                    session.add(
                        Attempt(
                            work_id=work,
                            kind=kind,
                            person_id=person_id,
                            picture="p",
                            score=score,
                            version="0",
                        )
                    )

    return make


def pair(gallery, who, work=None):
    with gallery.database.reading() as session:
        return comparisons.next_pair(session, who, work_id=work)


def judge(gallery, who, left, right, *terms):
    winner, seconds = terms or ("left", 1.0)
    with gallery.database.writing() as session:
        return comparisons.judge(session, who, left=left, right=right, winner=winner, seconds=seconds)


def test_a_judge_sees_every_pair_of_each_master_once(gallery, person, attempts):
    attempts({"regular-tian": 4, "regular-shui": 3})
    lin = person("林")
    seen = []
    while (drawn := pair(gallery, lin)) is not None:
        assert drawn.left.work_id == drawn.right.work_id
        assert drawn.done == len(seen) and drawn.left_over == 9 - len(seen)
        seen.append(frozenset((drawn.left.id, drawn.right.id)))
        judge(gallery, lin, drawn.left.id, drawn.right.id)
    assert len(seen) == len(set(seen)) == 6 + 3


def test_the_least_judged_come_first_whoever_judged(gallery, person, attempts):
    attempts({"regular-tian": 6})
    for name in "甲乙丙":
        who = person(name)
        for _ in range(3):
            drawn = pair(gallery, who)
            judge(gallery, who, drawn.left.id, drawn.right.id)
    with gallery.database.reading() as session:
        rows = comparisons.verdicts(session, person("館主", "owner"))
    times = Counter(itertools.chain.from_iterable((row[2], row[3]) for row in rows))
    assert sorted(times.values()) == [3] * 6


def test_the_order_of_a_pair_is_random(gallery, person, attempts):
    attempts({"regular-tian": 2})
    lin = person("林")
    lefts = Counter(pair(gallery, lin).left.id for _ in range(60))
    assert len(lefts) == 2 and min(lefts.values()) > 10  # one in 10 million falls outside


def test_a_judge_gives_one_verdict_for_each_pair_in_either_order(gallery, person, attempts):
    attempts({"regular-tian": 2})
    lin, wu = person("林"), person("吳")
    drawn = pair(gallery, lin)
    judge(gallery, lin, drawn.left.id, drawn.right.id)
    with pytest.raises(Clash):
        judge(gallery, lin, drawn.right.id, drawn.left.id)
    judge(gallery, wu, drawn.right.id, drawn.left.id, "same", None)


def test_only_two_copies_of_one_master_can_be_judged(gallery, person, attempts):
    attempts({"regular-tian": 1, "regular-shui": 1})
    lin = person("林")
    with gallery.database.reading() as session:
        one, other = session.query(Attempt).all()
    for left, right in ((one.id, other.id), (one.id, one.id)):
        with pytest.raises(Unusable):
            judge(gallery, lin, left, right)
    with pytest.raises(Missing):
        judge(gallery, lin, one.id, "nothing")


def test_copies_of_others_are_not_shown_to_a_pupil_nor_refused_ones_to_anybody(gallery, person, attempts):
    lin, wu, owner = person("林"), person("吳"), person("館主", "owner")
    attempts({"regular-tian": 2}, kind="photo", person_id=wu.id)
    attempts({"regular-shui": 2}, score=None)
    assert pair(gallery, lin) is None
    assert pair(gallery, wu) is not None and pair(gallery, owner) is not None
    assert pair(gallery, owner, "regular-shui") is None


def test_verdicts_name_both_sides_and_are_for_those_who_may_see_them(gallery, person, attempts):
    attempts({"regular-tian": 3})
    lin, teacher, owner = person("林"), person("師", "teacher"), person("館主", "owner")
    drawn = pair(gallery, lin)
    judge(gallery, lin, drawn.left.id, drawn.right.id, "right", 2.5)
    with gallery.database.reading() as session:
        expected = (lin.id, "regular-tian", drawn.left.id, drawn.right.id, "right", 2.5)
        assert comparisons.verdicts(session, owner) == [expected]
        assert comparisons.verdicts(session, teacher) == []  # no pupil of theirs
