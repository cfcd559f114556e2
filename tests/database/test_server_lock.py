"""One server at a time: who holds the lock is said, and nothing stale stands in the way."""

from __future__ import annotations

import os
import socket

import pytest
from sqlalchemy import text

from rumu.database.engine import make_engine, open_database
from rumu.database.server_lock import DatabaseInUse, lock_server
from rumu.errors import GalleryError


def test_the_second_is_told_who_the_first_is(database_url):
    with lock_server(database_url) as lock:
        assert lock.is_held()
        with pytest.raises(DatabaseInUse) as refused, lock_server(database_url):
            pytest.fail("two servers")
    for said in (str(refused.value), refused.value.zh):
        assert f"pid {os.getpid()}, host {socket.gethostname()}, since 20" in said
    with lock_server(database_url):
        pass


def test_the_database_is_open_to_others_meanwhile(database_url):
    with lock_server(database_url):
        database = open_database(database_url)
        with database.writing() as session:
            session.execute(text("SELECT 1"))
        database.close()


def test_one_file_has_one_lock_by_whatever_path(tmp_path):
    (tmp_path / "other").symlink_to(tmp_path)
    with (
        lock_server(tmp_path / "a.sqlite"),
        pytest.raises(DatabaseInUse),
        lock_server(tmp_path / "other" / "a.sqlite"),
    ):
        pytest.fail("two servers")
    assert not list(tmp_path.glob("*.json"))


def test_a_stale_note_or_a_damaged_one_is_of_no_account(tmp_path):
    note = tmp_path / "a.sqlite.server.json"
    note.write_text("{")
    with lock_server(tmp_path / "a.sqlite"):
        note.write_text("{")
        with pytest.raises(DatabaseInUse, match=r"pid \?"), lock_server(tmp_path / "a.sqlite"):
            pytest.fail("two servers")


def test_another_database_has_another_lock(tmp_path):
    with lock_server(tmp_path / "a.sqlite"), lock_server(tmp_path / "b.sqlite"):
        pass


def test_databases_in_memory_need_none():
    with lock_server("sqlite://"), lock_server("sqlite://"):
        pass


def test_a_lost_connection_is_made_again(postgresql_url):
    with lock_server(postgresql_url) as lock:
        administrator = make_engine(postgresql_url.replace("postgresql", "postgresql+psycopg", 1))
        end_all = (
            "SELECT pg_terminate_backend(pid) FROM pg_stat_activity"
            " WHERE pid <> pg_backend_pid() AND datname = current_database()"
        )
        with administrator.connect() as connection:
            connection.execute(text(end_all))
        assert lock.is_held()
        with pytest.raises(DatabaseInUse), lock_server(postgresql_url):
            pytest.fail("two servers")
        with administrator.connect() as connection:
            connection.execute(text(end_all))
        with lock_server(postgresql_url):
            assert not lock.is_held()
        administrator.dispose()


def test_a_database_that_cannot_be_reached():
    with pytest.raises(GalleryError, match="cannot be opened"), lock_server("postgresql://127.0.0.1:1/x"):
        pytest.fail("locked nothing")
