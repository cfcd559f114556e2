"""Files of works: a solid for printers has the size that was asked for."""

from __future__ import annotations

import io

import pytest

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
    assert owner("GET", "/api/works").json()["total"] == 0
    assert code_of(owner("DELETE", url)) == "not_found"


def test_one_client_makes_a_few_meshes_at_a_time(new_world, code_of):
    world = new_world(rate_limits=RateLimitSettings(meshes="3/minute"))
    visitor, url = world.browser(), "/api/works/regular-ren/files/glb"
    first = [visitor("GET", url, params={"exaggeration": step}) for step in (1, 2, 3)]
    assert [answer.status_code for answer in first] == [200, 200, 200]
    refused = visitor("GET", url, params={"exaggeration": 4})
    assert refused.status_code == 429 and code_of(refused) == "too_often"
    assert 1 <= int(refused.headers["Retry-After"]) <= 60
    again = visitor("GET", url, params={"exaggeration": 2.05})  # it is there already, at the nearest step
    assert again.status_code == 200 and again.content == first[1].content
    assert again.headers["ETag"] == first[1].headers["ETag"]
    assert visitor("GET", "/api/works/regular-ren/files/thumb").status_code == 200  # no mesh
