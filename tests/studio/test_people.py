"""Logins: names that are one, passwords that are hashed, an owner that stays."""

from __future__ import annotations

import pytest

from rumu.database.tables import Person
from rumu.studio import people
from rumu.studio.errors import Clash, Missing, NotAllowed, Unusable

PASSWORD = "a long password"  # of everybody in these tests, see conftest


def test_a_password_is_stored_as_an_argon2_hash(gallery, person):
    lin = person("林")
    with gallery.database.reading() as session:
        held = session.get(Person, lin.id).password
    assert held.startswith("$argon2id$") and PASSWORD not in held


@pytest.mark.parametrize("name", ["Lin", "LIN", "Ｌｉｎ", "  lin "])
def test_width_case_and_spaces_do_not_distinguish_people(gallery, person, name):
    person("Lin")
    with gallery.database.reading() as session:
        assert people.authenticate(session, name=name, password=PASSWORD) is not None
    with pytest.raises(Clash, match="taken"):
        person(name)


@pytest.mark.parametrize("name", ["", "   ", "x" * 81, "a\nb\x00", "a\u202eb"])
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
        assert people.identify_session(session, person_id=lin.id, epoch=0) == lin
        people.set_password(session, lin.id, old=PASSWORD, new="quite another one")
        assert people.identify_session(session, person_id=lin.id, epoch=0) is None
        assert people.identify_session(session, person_id=lin.id, epoch=1) == lin
        with pytest.raises(NotAllowed):
            people.set_password(session, lin.id, old=PASSWORD, new="a third password")


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
