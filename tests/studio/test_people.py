"""Logins: names that are one, passwords that are hashed, an owner that stays."""

from __future__ import annotations

from datetime import timedelta

import pytest
from sqlalchemy import update

from rumu.database.tables import LoginSession, Person, now
from rumu.studio import people
from rumu.studio.errors import Clash, Missing, NotAllowed, Unusable
from rumu.studio.tickets import DAYS_VALID, Ticket

PASSWORD = "a long password"  # of everybody in these tests, see conftest


def test_a_password_is_stored_as_an_argon2_hash(gallery, person):
    lin = person("林")
    with gallery.database.reading() as session:
        held = session.get(Person, lin.id).password
    assert held.startswith("$argon2id$") and PASSWORD not in held


@pytest.mark.parametrize("name", ["Lin", "LIN", "Ｌｉｎ", "  lin ", "\u3000ＬＩＮ", "Lin\ufe0f", "L\u3164in"])
def test_width_case_and_spaces_do_not_distinguish_people(gallery, person, name):
    person("Lin")
    with gallery.database.reading() as session:
        assert people.authenticate(session, name=name, password=PASSWORD) is not None
    with pytest.raises(Clash, match="taken"):
        person(name)


@pytest.mark.parametrize("name", ["", "   ", "\u3164\ufe0f", "x" * 81, "a\nb\x00", "a\u202eb"])
def test_an_invalid_name_is_refused(person, name):
    with pytest.raises(Unusable):
        person(name)


def test_who_may_log_in(gallery, person):
    lin = person("林")
    with gallery.database.writing() as session:
        assert people.authenticate(session, name="林", password="another password") is None
        assert people.authenticate(session, name="nobody", password=PASSWORD) is None
        session.get(Person, lin.id).active = False
        session.flush()
        assert people.authenticate(session, name="林", password=PASSWORD) is None


def test_a_short_password_is_refused(gallery):
    with gallery.database.writing() as session, pytest.raises(Unusable, match="8 to 200"):
        people.create_person(session, name="a", password="1234567", role="pupil")


def test_a_new_password_ends_older_sessions(gallery, person):
    lin = person("林")
    with gallery.database.writing() as session:
        old = people.start_session(session, session.get_one(Person, lin.id))
        assert people.identify_session(session, old) == lin
        changed = people.set_password(session, lin.id, old=PASSWORD, new="quite another one")
        assert people.identify_session(session, old) is None
        assert people.identify_session(session, people.start_session(session, changed)) == lin
        with pytest.raises(NotAllowed):
            people.set_password(session, lin.id, old=PASSWORD, new="a third password")


def test_sessions_end_one_by_one_and_all_at_once(gallery, person):
    lin, wu = person("林"), person("吳")
    with gallery.database.writing() as session:
        row, other = session.get_one(Person, lin.id), session.get_one(Person, wu.id)
        one, two, three = (people.start_session(session, row) for _ in range(3))
        others = people.start_session(session, other)
        people.end_session(session, one)
        alive = [people.identify_session(session, ticket) for ticket in (one, two, three, others)]
        assert alive == [None, lin, lin, wu]
        people.end_sessions(session, lin.id)
        alive = [people.identify_session(session, ticket) for ticket in (two, three, others)]
        assert alive == [None, None, wu]


def test_a_session_is_of_the_person_in_its_ticket_who_is_not_disabled(gallery, person):
    lin, wu = person("林"), person("吳")
    with gallery.database.writing() as session:
        ticket = people.start_session(session, session.get_one(Person, lin.id))
        assert people.identify_session(session, Ticket(wu.id, ticket.serial)) is None
        assert people.identify_session(session, Ticket(lin.id)) is None  # signed, but never started
        people.change_person(session, lin.id, {"active": False})
        people.change_person(session, lin.id, {"active": True})
        assert people.identify_session(session, ticket) is None


def test_rows_of_expired_sessions_are_deleted(gallery, person):
    lin = person("林")
    with gallery.database.writing() as session:
        row = session.get_one(Person, lin.id)
        people.start_session(session, row)
        session.execute(update(LoginSession).values(created=now() - timedelta(days=DAYS_VALID, minutes=1)))
        people.start_session(session, row)
        assert session.query(LoginSession).count() == 1


def test_the_last_owner_cannot_go(gallery, person):
    lin, wu = person("林", "owner"), person("吳", "owner")
    with gallery.database.writing() as session:
        people.change_person(session, wu.id, {"role": "teacher"})
    for change in ({"role": "pupil"}, {"active": False}):
        with pytest.raises(NotAllowed), gallery.database.writing() as session:
            people.change_person(session, lin.id, change)
    with gallery.database.reading() as session:
        assert people.owner_exists(session)


def test_an_unknown_person_cannot_be_changed(gallery):
    with gallery.database.writing() as session, pytest.raises(Missing):
        people.change_person(session, "nobody", {"role": "pupil"})


def test_a_name_that_was_taken_at_the_same_moment_is_a_clash(gallery, person, monkeypatch):
    person("林")
    monkeypatch.setattr(people, "_check_name", lambda session, name: (name, people.name_key(name)))
    with pytest.raises(Clash, match="taken"):
        person("林")
