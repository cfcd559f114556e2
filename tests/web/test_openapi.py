"""The description of the service holds: whatever it allows, and much that it does not, is answered without
a fault."""

from __future__ import annotations

from collections import Counter

import pytest
import schemathesis
from hypothesis import HealthCheck, Phase, settings
from starlette.testclient import TestClient

from rumu.web.openapi import example, page
from rumu.web.security import COOKIE
from rumu.web.settings import RateLimitSettings

ENDLESS = RateLimitSettings(
    **dict.fromkeys(("login", "login_name", "marks", "tries", "uploads", "all"), "1000000/second")
)
NOT_ASKED = ("events",)  # it ends with its job, and there is none to end


@pytest.mark.parametrize("who", [None, "吳", "館主"])
def test_nothing_that_can_be_asked_ends_in_a_fault(own_world, who):
    """Made-up questions to every route, by a visitor, a pupil and the owner; bounded, so that it stays
    short."""
    world = own_world(rate_limits=ENDLESS)
    schema = schemathesis.openapi.from_dict(world.app.openapi())
    faults, answers = [], Counter()
    browser = world.browser(who)
    client = TestClient(world.app, raise_server_exceptions=False)
    for found in schema.get_all_operations():
        operation = found.ok()
        if operation.path.endswith(NOT_ASKED):
            continue

        @settings(
            max_examples=4,
            deadline=None,
            database=None,
            derandomize=True,
            phases=[Phase.generate],
            suppress_health_check=list(HealthCheck),
        )
        @_given(operation)
        def ask(case):
            client.cookies.clear()
            client.cookies.set(COOKIE, browser.client.cookies[COOKIE])
            asked = case.as_transport_kwargs(base_url="http://testserver")
            asked["headers"] = {**dict(asked.get("headers") or {}), "X-CSRF-Token": browser.facts["csrf"]}
            asked.pop("cookies", None)
            answer = client.request(**asked)
            answers[answer.status_code] += 1
            if answer.status_code >= 500:
                faults.append((answer.status_code, case.method, case.formatted_path, asked, answer.text))

        ask()
    assert faults == []
    assert answers.total() > 120 and answers[200] > 5 and answers[404] > 20, answers  # they were questions


def _given(operation):
    from hypothesis import given

    return given(case=operation.as_strategy())


def test_the_page_for_people_shows_every_route_with_what_is_sent_and_answered(world):
    told = world.app.openapi()
    shown = page(told)
    for path, methods in told["paths"].items():
        for method in methods:
            assert f"<h3>{method.upper()} {path}</h3>" in shown
    assert "<script" not in shown and "regular-shui" in shown


def test_every_route_says_what_it_does(world):
    for path, methods in world.app.openapi()["paths"].items():
        for method, operation in methods.items():
            assert operation.get("description"), (method, path)
            assert "4XX" in operation["responses"], (method, path)


def test_examples_are_made_of_parts():
    told = {"components": {"schemas": {"A": {"properties": {"a": {"type": "string", "examples": ["x"]}}}}}}
    assert example({"type": "array", "items": {"$ref": "#/components/schemas/A"}}, told) == [{"a": "x"}]
    assert example({"anyOf": [{"type": "integer"}, {"type": "null"}]}, told) == 1
    assert example({"enum": ["p", "q"]}, told) == "p"
