"""Works and their files: a solid for printers has the size asked for; odd ids are reached and deleted."""

from __future__ import annotations

import io
from urllib.parse import quote

import pytest
from sqlalchemy import insert, text

from rumu.database.tables import Work
from rumu.web.rate_limits import RateLimitSettings


def test_an_stl_of_the_size_asked_for(world):
    import trimesh

    visitor = world.browser()
    url = "/api/works/regular-shui/files/stl"
    answer = visitor("GET", url, params={"width": 60, "base": 4, "exaggeration": 2})
    assert answer.status_code == 200 and b"estimated" in answer.content[:80]
    mesh = trimesh.load(io.BytesIO(answer.content), file_type="stl")
    assert mesh.is_watertight and mesh.volume > 0
    assert mesh.extents[0] == pytest.approx(60.0) and mesh.bounds[0, 2] == pytest.approx(-4.0)
    plain = trimesh.load(io.BytesIO(visitor("GET", url).content), file_type="stl")
    assert plain.extents[0] == pytest.approx(100.0) and plain.bounds[0, 2] == pytest.approx(-2.0)
    for wrong in ({"width": "nan"}, {"width": 0}, {"base": "inf"}, {"base": -1}, {"exaggeration": "nan"}):
        assert visitor("GET", url, params=wrong).status_code == 422
    assert visitor("GET", "/api/works/regular-shui/files/glb", params={"width": 60}).status_code == 422


def test_an_owner_changes_and_deletes_a_collection(new_world, code_of):
    world = new_world()
    owner, url = world.browser("館主"), "/api/collections/starter"
    title = {"zh": "蘭亭", "en": ""}
    answer = owner("PATCH", url, json={"title": title, "note": {"zh": "序", "en": "A preface."}})
    assert answer.status_code == 200
    facts = owner("GET", url).json()
    assert facts == answer.json()
    assert (facts["title"], facts["note"], facts["works"]) == (title, {"zh": "序", "en": "A preface."}, 30)
    assert owner("PATCH", url, json={"title": {"zh": " ", "en": ""}}).status_code == 422
    assert owner("PATCH", url, json={"id": "other"}).status_code in (200, 422)
    assert owner("GET", url).json() == facts
    assert code_of(owner("PATCH", "/api/collections/none", json={})) == "not_found"
    assert owner("DELETE", url).status_code == 204
    assert [work["collection"] for work in owner("GET", "/api/works").json()["items"]] == [
        "starter-brush"
    ] * 8 + ["starter-stele"]
    assert code_of(owner("DELETE", url)) == "not_found"


def test_one_client_makes_a_few_meshes_at_a_time(new_world, code_of):
    world = new_world(rate_limits=RateLimitSettings(meshes="3/hour"))
    visitor, url = world.browser(), "/api/works/regular-ren/files/glb"
    first = [visitor("GET", url, params={"exaggeration": step}) for step in (1, 2, 3)]
    assert [answer.status_code for answer in first] == [200, 200, 200]
    refused = visitor("GET", url, params={"exaggeration": 4})
    assert refused.status_code == 429 and code_of(refused) == "too_often"
    assert 1 <= int(refused.headers["Retry-After"]) <= 3600
    again = visitor("GET", url, params={"exaggeration": 2.05})  # it is there already, at the nearest step
    assert again.status_code == 200 and again.content == first[1].content
    assert again.headers["ETag"] == first[1].headers["ETag"]
    assert visitor("GET", "/api/works/regular-ren/files/thumb").status_code == 200  # no mesh


@pytest.fixture
def with_old_row(new_world):
    """A world with a work as imports once let it in: of any id, with any columns."""

    def make(work_id, **columns):
        world = new_world()
        with world.service.gallery.database.writing() as session:
            row = session.get_one(Work, "regular-shui")
            values = {column.name: getattr(row, column.name) for column in Work.__table__.columns}
            session.execute(insert(Work).values(values | {"id": work_id, "digest": "0" * 64}))
            for name, value in columns.items():
                session.execute(
                    text(f"UPDATE works SET {name} = :value WHERE id = :id"), {"value": value, "id": work_id}
                )
        return world

    return make


ODD_IDS = [
    "a/b",
    "永",
    "a b",
    "a?b#c",
    "50%",
    "a/b/../c",
    "x/files/thumb",
    "-a",
    "~a",
    "a/",
    "Ω:\\x",
    "'\"",
    "x" * 64,
]


@pytest.mark.parametrize("work_id", ODD_IDS)
def test_a_work_with_an_odd_id_is_shown_and_can_be_deleted(with_old_row, work_id):
    world = with_old_row(work_id)
    owner = world.browser("館主")
    listed = next(one for one in owner("GET", "/api/works?limit=200").json()["items"] if one["id"] == work_id)
    url = f"/api/works/{quote(work_id, safe='')}"
    if work_id != "x/files/thumb":  # which looks like a file of the work x
        assert owner("GET", url).json()["id"] == work_id
        assert owner("GET", listed["thumb"].removeprefix("http://testserver")).status_code == 200
        assert owner("GET", f"{url}/files/glb?download=true").status_code == 200
        assert owner("GET", f"{url}/viewer").json()["normals"]
        assert owner("PATCH", url, json={"title": {"zh": "改"}}).json()["title"]["zh"] == "改"
    assert world.browser("林")("DELETE", url).status_code == 403
    assert owner("DELETE", url).status_code == 204
    assert owner("GET", url).status_code == 404
    assert owner("GET", "/api/works/regular-shui").status_code == 200


@pytest.mark.parametrize(
    "columns",
    [
        {"width": "abc"},
        {"height": "abc"},
        {"spacing": float("inf")},
        {"spacing": "x"},
        {"height_source": "guess"},
    ],
    ids=str,
)
def test_a_work_with_broken_columns_does_not_end_the_list_and_can_be_deleted(with_old_row, columns):
    owner = with_old_row("broken", **columns).browser("館主")
    assert "broken" in {one["id"] for one in owner("GET", "/api/works?limit=200").json()["items"]}
    assert owner("GET", "/api/works/broken").status_code == 200
    assert owner("DELETE", "/api/works/broken").status_code == 204
