"""One way to SQLite and PostgreSQL, and tables that are always those of the code."""

from __future__ import annotations

import multiprocessing
import threading
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path

import pytest
from sqlalchemy import select, text

from rumu.database.engine import Database, open_database
from rumu.database.tables import Base, Person, Setting
from rumu.errors import GalleryError


@pytest.fixture
def database(database_url: str):
    opened = open_database(database_url)
    yield opened
    opened.close()


def test_the_migrations_make_exactly_the_tables_of_the_code(database: Database):
    from alembic.autogenerate import compare_metadata
    from alembic.migration import MigrationContext

    with database.engine.connect() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        assert compare_metadata(context, Base.metadata) == []


def test_a_difference_would_be_found(database: Database):
    from alembic.autogenerate import compare_metadata
    from alembic.migration import MigrationContext

    with database.writing() as session:
        session.execute(text("ALTER TABLE settings ADD COLUMN stray INTEGER"))
    with database.engine.connect() as connection:
        found = compare_metadata(MigrationContext.configure(connection), Base.metadata)
    assert [change[0] for change in found] == ["remove_column"]


def test_every_migration_goes_back(database: Database):
    from importlib import resources

    from alembic import command
    from alembic.config import Config
    from sqlalchemy import inspect

    config = Config()
    config.set_main_option("script_location", str(resources.files("rumu.database").joinpath("migrations")))
    with database.engine.begin() as connection:
        config.attributes["connection"] = connection
        command.downgrade(config, "base")
    assert set(inspect(database.engine).get_table_names()) <= {"alembic_version"}


def test_what_was_written_is_there_when_it_is_opened_again(database_url):
    first = open_database(database_url)
    with first.writing() as session:
        session.add(Setting(name="key", value="值"))
    first.close()
    second = open_database(database_url)
    with second.reading() as session:
        assert session.get_one(Setting, "key").value == "值"
    second.close()


def test_a_block_that_fails_leaves_nothing(database: Database):
    with pytest.raises(RuntimeError), database.writing() as session:
        session.add(Setting(name="key", value="1"))
        session.flush()
        raise RuntimeError
    with database.reading() as session:
        assert session.get(Setting, "key") is None


def test_times_keep_their_zone(database: Database):
    told = datetime(2026, 3, 1, 8, 30, tzinfo=timezone(timedelta(hours=8)))
    with database.writing() as session:
        session.add(Person(id="a", name="a", name_key="a", role="owner", created=told))
    with database.reading() as session:
        back = session.get_one(Person, "a").created
    assert (back, back.tzinfo) == (told, UTC)
    assert (back.hour, back.minute) == (0, 30)


def test_a_time_without_a_zone_is_refused(database: Database):
    with pytest.raises(Exception, match="with its zone"), database.writing() as session:
        session.add(Person(name="a", name_key="a", role="owner", created=datetime(2026, 3, 1)))


def test_what_hangs_on_a_row_goes_with_it(database: Database):
    from rumu.database.tables import Annotation, Collection, Work

    facts = {"title_zh": "", "title_en": ""}
    with database.writing() as session:
        session.add(Collection(id="c", **facts))
        session.flush()
        session.add(Work(id="w", collection_id="c", picture="p", digest="d", width=1, height=1, **facts))
        session.flush()
        session.add(Annotation(work_id="w", x=0, y=0))
    with database.writing() as session:
        session.delete(session.get_one(Collection, "c"))
    with database.reading() as session:
        assert session.scalars(select(Annotation)).all() == session.scalars(select(Work)).all() == []


def _count_up(url: str, times: int) -> None:
    database = open_database(url)
    for _ in range(times):
        with database.writing() as session:
            found = session.get(Setting, "n", with_for_update=True)
            found.value = str(int(found.value) + 1)
    database.close()


def test_writers_wait_for_each_other(database: Database, database_url):
    with database.writing() as session:
        session.add(Setting(name="n", value="0"))
    threads = [threading.Thread(target=_count_up, args=(database_url, 20)) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    with database.reading() as session:
        assert session.get_one(Setting, "n").value == "80"


def test_threads_make_databases_at_once(tmp_path: Path):
    """A server and its work open databases in threads of one process, while Alembic has one at a time."""
    files = [tmp_path / f"{n}.db" for n in range(8)]
    with ThreadPoolExecutor(len(files)) as threads:
        opened = list(threads.map(open_database, files))
    for database in opened:
        with database.reading() as session:
            assert session.scalars(select(Person)).all() == []
        database.close()


def _open_at_once(url: str, barrier, told) -> None:
    barrier.wait()
    try:
        open_database(url).close()
        told.put("fine")
    except BaseException as error:
        told.put(repr(error))


def test_processes_that_start_at_once_make_the_tables_once(database_url):
    context = multiprocessing.get_context("spawn")
    barrier, told = context.Barrier(4), context.Queue()
    several = [context.Process(target=_open_at_once, args=(database_url, barrier, told)) for _ in range(4)]
    for process in several:
        process.start()
    answers = [told.get(timeout=120) for _ in several]
    for process in several:
        process.join()
    assert answers == ["fine"] * 4


@pytest.mark.parametrize("url", ["mysql://a/b", "nonsense://x", "sqlite+strange:///x"])
def test_other_databases_are_refused(url):
    with pytest.raises(GalleryError, match=r"expected a database sqlite:///FILE or postgresql://"):
        open_database(url)


def test_a_server_that_is_not_there_is_said_without_the_password():
    with pytest.raises(GalleryError) as refused:
        open_database("postgresql://me:secret@127.0.0.1:1/rumu")
    assert "cannot be opened" in str(refused.value) and "secret" not in str(refused.value)


def test_a_file_that_is_no_database_is_refused(tmp_path):
    (tmp_path / "rumu.sqlite").write_text("no database " * 100)
    with pytest.raises(GalleryError, match="cannot be opened"):
        open_database(tmp_path / "rumu.sqlite")


def test_a_folder_that_cannot_be_made_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(GalleryError, match="folder cannot be made"):
        open_database(tmp_path / "file" / "deeper" / "rumu.sqlite")


def test_a_database_of_a_newer_rumu_is_refused(database: Database, database_url):
    with database.writing() as session:
        session.execute(text("UPDATE alembic_version SET version_num = 'v9999'"))
    with pytest.raises(GalleryError, match="newer rumu"):
        open_database(database_url)


def test_a_database_from_before_the_first_release_is_refused(database: Database, database_url):
    with database.writing() as session:
        session.execute(text("UPDATE alembic_version SET version_num = '0001'"))
    with pytest.raises(GalleryError, match=r"before the first release; .*start with a new database"):
        open_database(database_url)


def test_a_plain_path_is_a_file_of_sqlite(tmp_path: Path):
    open_database(tmp_path / "new" / "rumu.sqlite").close()
    assert (tmp_path / "new" / "rumu.sqlite").read_bytes().startswith(b"SQLite format 3")
