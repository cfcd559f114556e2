"""A service in this process with people of every role, and browsers that behave as the pages do."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from starlette.testclient import TestClient

from conftest import copy_home
from rumu.database.tables import Membership, Person
from rumu.gallery.starter import starter_samples
from rumu.studio.classes import create_class
from rumu.studio.people import create_person, identity, start_session
from rumu.studio.storage import Storage
from rumu.web.addresses import COOKIE
from rumu.web.app import create_app
from rumu.web.settings import ServiceSettings

PASSWORD = "a long password"


class Browser:
    """Keeps cookies, and sends the CSRF token with every request."""

    def __init__(self, client: TestClient) -> None:
        self.client = client
        self.facts: dict[str, Any] = client.get("/api/session").json()

    def __call__(self, method: str, url: str, **more: Any) -> Any:
        headers = {"X-CSRF-Token": self.facts["csrf"]} | more.pop("headers", {})
        return self.client.request(method, url, headers=headers, follow_redirects=False, **more)

    def log_in(self, service: Any, person_id: str) -> Browser:
        """Log in by a session that the service makes; passwords have tests of their own."""
        with service.gallery.database.writing() as session:
            ticket = start_session(session, session.get_one(Person, person_id))
        self.client.cookies.clear()
        self.client.cookies.set(cookie_name(service), service.tickets.serialise(ticket))
        self.facts = self.client.get("/api/session").json()
        assert self.facts["person"]["id"] == person_id
        return self

    def marked(self, picture: bytes, *, work: str = "regular-tian", **more: Any) -> Any:
        return self("POST", "/api/marks", data={"work": work} | more, files={"picture": ("a.png", picture)})


def cookie_name(service: Any) -> str:
    """The name of the session's cookie without HTTPS."""
    return f"{COOKIE}_{service.tickets.fingerprint}"


@dataclasses.dataclass
class World:
    """server: a client whose lifespan is the service's; ids: of people, classes and attempts in it."""

    server: TestClient
    ids: dict[str, str]

    @property
    def app(self) -> Any:
        return self.server.app

    @property
    def service(self) -> Any:
        return self.app.state.service

    @property
    def cookie(self) -> str:
        return cookie_name(self.service)

    def client(self, **options: Any) -> TestClient:
        """A client that asks in the service's event loop; by itself it would start one for each request."""
        client = TestClient(self.app, **options)
        client.portal = self.server.portal
        return client

    def browser(self, name: str | None = None) -> Browser:
        browser = Browser(self.client(raise_server_exceptions=False))
        return browser if name is None else browser.log_in(self.service, self.ids[name])


def make_settings(folder: Path, **more: Any) -> ServiceSettings:
    storage = Storage(database=more.pop("database", str(folder / "rumu.sqlite")), files=str(folder / "files"))
    return ServiceSettings(storage, processes=0, prepare=False, **more)


def add_people(app: Any) -> dict[str, str]:
    """館主 (owner), 林 and 陳 (teachers), 吳 (pupil of 林), 周 (pupil of 陳)."""
    ids = {}
    with app.state.service.gallery.database.writing() as session:
        for name, role in (
            ("館主", "owner"),
            ("林", "teacher"),
            ("陳", "teacher"),
            ("吳", "pupil"),
            ("周", "pupil"),
        ):
            ids[name] = create_person(session, name=name, password=PASSWORD, role=role).id
            if role == "teacher":
                who = identity(session.get_one(Person, ids[name]))
                ids[f"{name}班"] = create_class(session, who, name=f"{name}班").id
        for teacher, pupil in (("林", "吳"), ("陳", "周")):
            session.add(Membership(class_id=ids[f"{teacher}班"], person_id=ids[pupil]))
    return ids


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory, starter_home: Path) -> Iterator[World]:
    """A service for all tests of a module: they may read it, and add what does not disturb the others."""
    app = create_app(make_settings(copy_home(starter_home, tmp_path_factory.mktemp("world"))))
    with TestClient(app) as server:
        yield World(server, add_people(app))


@pytest.fixture
def new_world(tmp_path: Path, starter_home: Path) -> Iterator[Callable[..., World]]:
    """Make a service for this test alone, with settings."""
    opened: list[TestClient] = []
    copy_home(starter_home, tmp_path)

    def make(*, people: bool = True, **settings: Any) -> World:
        app = create_app(make_settings(tmp_path, **settings))
        client = TestClient(app)
        client.__enter__()
        opened.append(client)
        return World(client, add_people(app) if people else {})

    yield make
    for client in opened:
        client.__exit__(None, None, None)


@pytest.fixture(scope="session")
def copy_of() -> Callable[..., bytes]:
    """A simulated copy's bytes, by work and degree."""

    def read(work: str = "regular-tian", degree: str = "good") -> bytes:
        return next(s for s in starter_samples(work=work) if s.degree == degree).path.read_bytes()

    return read


@pytest.fixture(scope="session")
def code_of() -> Callable[[Any], str]:
    """The code of an error, which has a sentence in both languages."""

    def read(answer: Any) -> str:
        error = json.loads(answer.text)["error"]
        assert error["zh"] and error["en"]
        return str(error["code"])

    return read
