"""Links that let one person in, once."""

from __future__ import annotations

from datetime import timedelta

import pytest

from rumu.database.tables import Invitation, now
from rumu.studio import invitations
from rumu.studio.classes import create_class, pupils
from rumu.studio.errors import Clash, Missing, NotAllowed

PASSWORD = "a long password"


def joined(gallery, token, name, password=PASSWORD):
    with gallery.database.writing() as session:
        return invitations.accept(session, token, name=name, password=password)


@pytest.fixture
def link(gallery):
    def make(who, **order):
        with gallery.database.writing() as session:
            return invitations.invite(session, who, **order)[0]

    return make


@pytest.fixture
def a_class(gallery):
    def make(who, name="三年二班"):
        with gallery.database.writing() as session:
            return create_class(session, who, name=name).id

    return make


def test_the_link_of_the_first_owner_works_once(gallery):
    with gallery.database.writing() as session:
        old = invitations.invite_first_owner(session)
    with gallery.database.writing() as session:
        new = invitations.invite_first_owner(session)
    with pytest.raises(Missing):
        joined(gallery, old, "館主")  # a newer link replaced it
    assert joined(gallery, new, "館主").role == "owner"
    with pytest.raises(Missing):
        joined(gallery, new, "another")
    with gallery.database.writing() as session:
        assert invitations.invite_first_owner(session) is None


def test_the_database_holds_no_link(gallery, person, link):
    token = link(person("館主", "owner"), role="teacher")
    with gallery.database.reading() as session:
        assert all(token not in (row.token, row.role) for row in session.query(Invitation))


def test_a_link_expires(gallery, person, link):
    token = link(person("館主", "owner"), role="teacher")
    with gallery.database.writing() as session:
        session.query(Invitation).update({"expires": now() - timedelta(seconds=1)})
    with pytest.raises(Missing):
        joined(gallery, token, "林")


def test_a_refused_name_leaves_the_link_open(gallery, person, link):
    token = link(person("館主", "owner"), role="teacher")
    with pytest.raises(Clash):
        joined(gallery, token, "館主")
    assert joined(gallery, token, "林").role == "teacher"


def test_a_pupil_joins_the_class_and_a_second_one(gallery, person, link, a_class):
    lin = person("林", "teacher")
    first, second = a_class(lin, "one"), a_class(lin, "two")
    wu = joined(gallery, link(lin, role="pupil", class_id=first), "吳")
    assert joined(gallery, link(lin, role="pupil", class_id=second), "吳").id == wu.id
    with gallery.database.reading() as session:
        assert [p.id for c in (first, second) for p in pupils(session, c)] == [wu.id, wu.id]
    with pytest.raises(Clash):
        joined(gallery, link(lin, role="pupil", class_id=second), "吳", "not the password")


def test_who_may_invite_whom(gallery, person, link, a_class):
    lin, wu, zhou = person("林", "teacher"), person("吳", "pupil"), person("周", "teacher")
    own = a_class(lin)
    for who, order in (
        (wu, {"role": "pupil", "class_id": own}),
        (lin, {"role": "teacher"}),
        (lin, {"role": "owner", "class_id": own}),
        (lin, {"role": "pupil"}),
        (person("館主", "owner"), {"role": "teacher", "class_id": own}),
    ):
        with pytest.raises((NotAllowed, Missing)):
            link(who, **order)
    with pytest.raises(Missing):  # a class that is not theirs does not exist for them
        link(zhou, role="pupil", class_id=own)
