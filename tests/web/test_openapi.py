"""The OpenAPI document is true: requests that it allows, and many that it does not, never end in a 5xx."""

from __future__ import annotations

from collections import Counter

import pytest
import schemathesis
from hypothesis import HealthCheck, Phase, settings
from starlette.testclient import TestClient

from rumu.web.openapi import example, render_docs
from rumu.web.settings import RateLimitSettings

UNLIMITED = RateLimitSettings(
    **dict.fromkeys(("login", "login_name", "marks", "tries", "uploads", "all"), "1000000/second")
)
NOT_TESTED = ("events",)  # the stream ends with its job, and here no job ends


@pytest.mark.parametrize("who", [None, "吳", "館主"])
def test_nothing_that_can_be_asked_ends_in_a_fault(new_world, who):
    """Generated requests to every route, by a visitor, a pupil and the owner; few, so that it stays short."""
    world = new_world(rate_limits=UNLIMITED)
    schema = schemathesis.openapi.from_dict(world.app.openapi())
    faults, answers = [], Counter()
    browser = world.browser(who)
    client = TestClient(world.app, raise_server_exceptions=False)
    for result in schema.get_all_operations():
        operation = result.ok()
        if operation.path.endswith(NOT_TESTED):
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
            client.cookies.set(world.cookie, browser.client.cookies[world.cookie])
            request = case.as_transport_kwargs(base_url="http://testserver")
            request["headers"] = {**dict(request.get("headers") or {}), "X-CSRF-Token": browser.facts["csrf"]}
            request.pop("cookies", None)
            answer = client.request(**request)
            answers[answer.status_code] += 1
            if answer.status_code >= 500:
                faults.append((answer.status_code, case.method, case.formatted_path, request, answer.text))

        ask()
    assert faults == []
    assert answers.total() > 120 and answers[200] > 5 and answers[404] > 20, answers  # they were questions


def _given(operation):
    from hypothesis import given

    return given(case=operation.as_strategy())


def test_the_page_for_people_shows_every_route_with_what_is_sent_and_answered(world):
    document = world.app.openapi()
    page = render_docs(document)
    for path, methods in document["paths"].items():
        for method in methods:
            assert f"<h3>{method.upper()} {path}</h3>" in page
    assert "<script" not in page and "regular-shui" in page


def test_every_route_says_what_it_does(world):
    for path, methods in world.app.openapi()["paths"].items():
        for method, operation in methods.items():
            assert operation.get("description"), (method, path)
            assert "4XX" in operation["responses"], (method, path)


def test_examples_are_made_of_parts():
    document = {
        "components": {"schemas": {"A": {"properties": {"a": {"type": "string", "examples": ["x"]}}}}}
    }
    assert example({"type": "array", "items": {"$ref": "#/components/schemas/A"}}, document) == [{"a": "x"}]
    assert example({"anyOf": [{"type": "integer"}, {"type": "null"}]}, document) == 1
    assert example({"enum": ["p", "q"]}, document) == "p"
