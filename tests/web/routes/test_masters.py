"""A work that is no character is shown, and nowhere offered or taken as a master."""

from __future__ import annotations

import pytest

from rumu.database.tables import Attempt
from rumu.gallery.catalog import change_work

RELIEF = "regular-shu"  # becomes a work that is no character


@pytest.fixture
def world(new_world):
    world = new_world()
    change_work(world.service.gallery, RELIEF, {"character": " "})
    return world


def test_it_is_among_the_works_but_not_among_the_masters(world):
    visitor = world.browser()
    every = visitor("GET", "/api/works?limit=200").json()
    masters = visitor("GET", "/api/works?limit=200&masters=true").json()
    assert masters["total"] == every["total"] - 2
    assert {w["id"] for w in every["items"]} - {w["id"] for w in masters["items"]} == {
        RELIEF,
        "stele-ru-mu-san-fen",
    }
    assert visitor("GET", "/api/works?masters=true&collection=starter&script=regular").json()["total"] == 5
    scripts = {f["value"]: f["count"] for f in visitor("GET", "/api/facets?masters=true").json()["script"]}
    assert scripts["regular"] == 7 and sum(scripts.values()) == masters["total"]


def test_it_is_refused_as_a_task_and_as_a_master(world, copy_of, code_of):
    teacher, pupil = world.browser("林"), world.browser("吳")
    tasks = f"/api/classes/{world.ids['林班']}/tasks"
    assert code_of(teacher("POST", tasks, json={"work": RELIEF})) == "no_character"
    assert teacher("POST", tasks, json={"work": "regular-tian"}).status_code == 201
    assert code_of(pupil.marked(copy_of(), work=RELIEF)) == "no_character"
    assert code_of(world.browser().marked(copy_of(), work=RELIEF, keep="false")) == "no_character"


def test_copies_of_it_are_not_compared(world):
    copies = [
        Attempt(work_id=RELIEF, kind="simulated", picture="p", score=50.0, version="0") for _ in range(3)
    ]
    with world.service.gallery.database.writing() as session:
        session.query(Attempt).delete()
        session.add_all(copies)
    assert world.browser("林")("GET", "/api/comparisons/next").json() is None
