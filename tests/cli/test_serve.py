"""serve: what it says before it serves, and what it refuses."""

from __future__ import annotations

import contextlib
import json

import pytest

from rumu.gallery.catalog import open_gallery
from rumu.studio.people import create_person
from rumu.web.server import ServerAddress, listen


@pytest.fixture
def not_run(monkeypatch):
    """Everything up to the moment where requests would be answered; the settings it would serve with."""
    seen = []

    class Stands:
        started, should_exit = False, True

        def __init__(self, config, *, end_work):
            seen.append(config)

        def run(self, sockets):
            assert sockets

    monkeypatch.setattr("rumu.web.connections.GracefulServer", Stands)
    return seen


def test_it_says_where_it_is_and_who_may_open(rumu, not_run, own_home):
    ended = rumu("serve", "--port", 0)
    assert ended.code == 0 and "http://127.0.0.1:" in ended.out and "/#/join/" in ended.out
    assert (own_home / "rumu.sqlite").is_file()


def test_a_script_gets_one_object(rumu, not_run):
    facts = rumu("serve", "--port", 0, "--json").facts
    assert facts["owner_link"].startswith(facts["url"])


def test_beyond_this_machine_only_with_an_owner(rumu, not_run, own_home, tmp_path):
    rumu("serve", "--port", 0, "--host", "0.0.0.0").failed_with("until the service has an owner")
    gallery = open_gallery()
    with gallery.database.writing() as session:
        create_person(session, name="館主", password="a long password", role="owner")
    ended = rumu("serve", "--port", 0, "--host", "0.0.0.0")
    assert ended.code == 0 and "/#/join/" not in ended.out


def test_place_and_calibration_are_handed_on(rumu, not_run, tmp_path):
    from rumu.assessment.calibration import panel, write_calibration

    own = tmp_path / "own.json"
    write_calibration(panel(), own)
    database, files = tmp_path / "a.sqlite", tmp_path / "f"
    rumu(
        "serve", "--port", 0, "--database", database, "--files", files, "--calibration", own, "--processes", 1
    )
    place = not_run[0].app.state.service.settings.storage
    assert (place.database, place.files, place.calibration) == (str(database), str(files), own)


def test_what_is_wrong_is_said_before_anything_is_made(rumu, not_run, tmp_path, own_home):
    rumu("serve", "--calibration", tmp_path / "none.json").failed_with("none.json")
    rumu("serve", "--port", 0, "--database", "mysql://x").failed_with("expected a database")
    with contextlib.closing(listen("127.0.0.1", 0)) as taken:
        rumu("serve", "--port", taken.getsockname()[1]).failed_with("try another --port")
    assert not own_home.exists()


def test_the_link_is_for_eyes_and_programs(capsys):
    from rumu.cli.serve import announce

    address = ServerAddress("http://127.0.0.1:1/", "http://127.0.0.1:1/#/join/x")
    announce(address, as_json=True)
    assert json.loads(capsys.readouterr().out) == {"url": address.url, "owner_link": address.owner_link}
