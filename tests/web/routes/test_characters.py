"""The strokes of characters through the service."""

from __future__ import annotations

import pytest


def test_strokes_come_in_the_order_of_writing_with_names_and_shapes(world):
    answer = world.browser()("GET", "/api/characters/永")
    assert answer.status_code == 200
    found = answer.json()
    assert [stroke["name"]["zh"] for stroke in found["strokes"]] == ["點", "橫折鉤", "橫撇", "撇", "捺"]
    assert found["structure"] == "single"
    for stroke in found["strokes"]:
        assert stroke["path"].startswith("M ")
        assert all(-0.1 < number < 1.1 for point in stroke["centre_line"] for number in point)


def test_they_are_kept_by_clients(world):
    browser = world.browser()
    etag = browser("GET", "/api/characters/水").headers["etag"]
    assert browser("GET", "/api/characters/水", headers={"If-None-Match": etag}).status_code == 304


@pytest.mark.parametrize("text", ["a", "永水", "%00", "𰯲"])
def test_of_anything_else_there_is_nothing(world, text):
    answer = world.browser()("GET", f"/api/characters/{text}")
    assert answer.status_code == 404
    assert set(answer.json()["error"]) >= {"zh", "en"}
