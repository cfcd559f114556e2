"""Signed sessions: a forged, truncated or expired ticket is refused."""

from __future__ import annotations

import pytest
from itsdangerous import URLSafeTimedSerializer

from rumu.studio.tickets import Ticket, Tickets, open_tickets


def test_a_ticket_is_read_as_it_was_written():
    tickets = Tickets("key")
    ticket = Ticket(person_id="p")
    assert tickets.read(tickets.serialise(ticket)) == ticket


@pytest.mark.parametrize("spoil", [lambda t: t[:-2], lambda t: "x" + t, lambda t: t.replace(".", "", 1)])
def test_a_damaged_ticket_is_refused(spoil):
    tickets = Tickets("key")
    assert tickets.read(spoil(tickets.serialise(Ticket(person_id="p")))) is None


@pytest.mark.parametrize("text", [None, "", "x", "é" * 400, "a.b.c", "W10.x.y"])
def test_text_that_is_no_ticket_is_refused(text):
    assert Tickets("key").read(text) is None


def test_a_ticket_of_another_key_is_refused():
    one, other = Tickets("key"), Tickets("another")
    ticket = Ticket(person_id="p")
    assert other.read(one.serialise(ticket)) is None
    assert one.csrf(ticket) != other.csrf(ticket)


def test_a_signed_value_of_another_shape_is_refused():
    tickets = Tickets("key")
    signer = URLSafeTimedSerializer("key", salt="rumu-session", signer_kwargs=tickets._signer.signer_kwargs)
    assert tickets.read(signer.dumps({"a": 1})) is None


def test_an_expired_ticket_is_refused(monkeypatch):
    tickets = Tickets("key")
    text = tickets.serialise(Ticket())
    from itsdangerous import timed

    now = timed.time.time()
    monkeypatch.setattr(timed.time, "time", lambda: now + 31 * 86400)
    assert tickets.read(text) is None


def test_the_csrf_token_belongs_to_one_session():
    tickets = Tickets("key")
    one, other = Ticket(), Ticket()
    assert tickets.has_csrf_token(one, tickets.csrf(one))
    for token in (tickets.csrf(other), "", None, "é"):
        assert not tickets.has_csrf_token(one, token)


def test_the_key_stays_with_the_database(gallery):
    ticket = Ticket(person_id="p")
    text = open_tickets(gallery.database).serialise(ticket)
    assert open_tickets(gallery.database).read(text) == ticket
