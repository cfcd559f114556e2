"""The home page's facts and choice, previews of links, and frames on other sites."""

from __future__ import annotations

import json
import re


def test_the_owner_chooses_the_work_on_the_home_page(new_world, code_of) -> None:
    world = new_world()
    visitor, owner = world.browser(), world.browser("館主")
    facts = visitor("GET", "/api/home").json()
    assert facts["cover"]["height_source"] == "photometric" and facts["chosen"] is False
    assert facts["works"] == visitor("GET", "/api/works").json()["total"]
    assert visitor("PUT", "/api/home", json={"work": "regular-shui"}).status_code == 401
    assert world.browser("林")("PUT", "/api/home", json={"work": "regular-shui"}).status_code == 403
    assert code_of(owner("PUT", "/api/home", json={"work": "none"})) == "not_found"
    facts = owner("PUT", "/api/home", json={"work": "regular-shui"}).json()
    assert (facts["cover"]["id"], facts["chosen"]) == ("regular-shui", True)
    assert visitor("GET", "/api/home").json() == facts
    for name in ("picture", "normals"):
        answer = visitor("GET", facts["cover"][name])
        assert answer.status_code == 200 and answer.headers["content-type"] == "image/webp"
        assert "immutable" in answer.headers["cache-control"]
    assert owner("PUT", "/api/home", json={"work": None}).json()["chosen"] is False
    for collection in ("starter", "starter-brush", "starter-stele"):
        owner("DELETE", f"/api/collections/{collection}")
    assert visitor("GET", "/api/home").json() == {"cover": None, "chosen": False, "works": 0}


def test_a_shared_link_has_a_preview_and_leads_to_the_work(world) -> None:
    answer = world.browser()("GET", "/share/works/regular-shui")
    assert answer.status_code == 200 and "<script" not in answer.text
    meta = dict(re.findall(r'<meta (?:property|name)="([^"]+)" content="([^"]*)"', answer.text))
    assert "水" in meta["og:title"] and "青柳衡山" in meta["og:description"]
    assert meta["og:url"] == "http://testserver/share/works/regular-shui"
    assert 'content="0; url=http://testserver/#/works/regular-shui"' in answer.text
    picture = world.browser()("GET", meta["og:image"].removeprefix("http://testserver"))
    assert picture.status_code == 200 and picture.headers["content-type"] == "image/jpeg"
    assert world.browser()("GET", "/share/works/none").status_code == 404


def test_a_shared_collection_has_the_preview_of_its_cover(new_world) -> None:
    world = new_world()
    owner, url = world.browser("館主"), "/api/collections/starter"
    note = {"zh": "五體", "en": 'Five "scripts".'}
    assert owner("PATCH", url, json={"note": note, "cover": "regular-shui"}).status_code == 200
    answer = world.browser()("GET", "/share/collections/starter")
    meta = dict(re.findall(r'<meta (?:property|name)="([^"]+)" content="([^"]*)"', answer.text))
    assert meta["og:description"] == "五體 Five &quot;scripts&quot;."
    assert meta["og:image"].startswith("http://testserver/iiif/image/regular-shui/")
    assert 'content="0; url=http://testserver/#/collections/starter"' in answer.text
    for work in owner("GET", "/api/works", params={"collection": "starter"}).json()["items"]:
        owner("DELETE", f"/api/works/{work['id']}")
    assert "og:image" not in world.browser()("GET", "/share/collections/starter").text
    assert world.browser()("GET", "/share/collections/none").status_code == 404


def test_a_title_with_markup_stays_text(new_world) -> None:
    world = new_world()
    title = {"zh": '"><script>alert(1)</script>', "en": "</script><b>"}
    assert world.browser("館主")("PATCH", "/api/works/regular-shui", json={"title": title}).status_code == 200
    for path in ("/share/works/regular-shui", "/embed/works/regular-shui"):
        text = world.browser()("GET", path).text
        assert "<script>alert" not in text and "<b>" not in text


def test_other_sites_may_frame_the_viewer_of_a_work_and_nothing_else(world) -> None:
    visitor = world.browser()
    answer = visitor("GET", "/embed/works/regular-shui")
    assert answer.status_code == 200
    policy = answer.headers["content-security-policy"]
    assert "frame-ancestors *" in policy and "script-src 'self'" in policy and "'unsafe-inline'" not in policy
    assert "frame-ancestors 'self'" in visitor("GET", "/").headers["content-security-policy"]
    assert (
        "frame-ancestors 'self'"
        in visitor("GET", "/share/works/regular-shui").headers["content-security-policy"]
    )
    facts = json.loads(re.search(r'id="rumu-work">(.*?)</script>', answer.text, re.S)[1])
    assert facts["work"]["id"] == "regular-shui"
    for name in ("normals", "albedo", "picture"):
        assert visitor("GET", facts["viewer"][name]).status_code == 200
    assert visitor("GET", facts["viewer"]["heights"]["url"]).status_code == 200
    assert visitor("GET", "/embed/works/none").status_code == 404
