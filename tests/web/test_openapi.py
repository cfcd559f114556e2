"""The OpenAPI document is true: requests that it allows, and many that it does not, never end in a 5xx."""

from __future__ import annotations

import json
from collections import Counter

import pytest
import schemathesis
from hypothesis import HealthCheck, Phase, settings

from rumu.web.openapi import example, render_docs
from rumu.web.settings import RateLimitSettings

UNLIMITED = RateLimitSettings(
    **dict.fromkeys(
        ("login", "login_name", "marks", "tries", "uploads", "sheets", "photos", "all"), "1000000/second"
    )
)
NOT_TESTED = ("events",)  # the stream ends with its job, and here no job ends


@pytest.mark.parametrize("who", [None, "吳", "館主"])
def test_nothing_that_can_be_asked_ends_in_a_fault(new_world, who):
    """Generated requests to every route, by a visitor, a pupil and the owner; few, so that it stays short."""
    world = new_world(rate_limits=UNLIMITED)
    schema = schemathesis.openapi.from_dict(world.app.openapi())
    faults, answers = [], Counter()
    browser = world.browser(who)
    client = world.client(raise_server_exceptions=False)
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


def _leaves(value, path=()):
    """Paths of all values within an example of JSON, and of the example itself."""
    yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, part in items:
        yield from _leaves(part, (*path, key))


def _with(value, path, new):
    """The example with something else at one place."""
    if not path:
        return new
    copied = dict(value) if isinstance(value, dict) else list(value)
    copied[path[0]] = _with(copied[path[0]], path[1:], new)
    return copied


HOSTILE = [
    *(
        "NaN",
        "Infinity",
        "-Infinity",
        "1e999",
        "-1e999",
        "1" * 400,
        "1e308",
        "-0.0",
        "1" * 5000,
        "null",
        "true",
    ),
    *('"0001-01-01T00:00:00+14:00"', '"9999-12-31T23:59:59-14:00"', '"0001-01-01T00:00:00Z"', '"2026-01-01"'),
    *(
        '"2026-01-01T00:00:00"',
        '"\\ud800"',
        '"\\u0000"',
        '""',
        "[]",
        "{}",
        '"' + "x" * 20_000 + '"',
        "[" * 5000,
    ),
]


@pytest.mark.parametrize(("who", "step"), [("林", 4), ("館主", 1)])
def test_no_number_date_or_type_in_a_body_ends_in_a_fault(new_world, who, step):
    """Every place of every JSON body, with what Python's JSON lets in and databases do not.

    A teacher, who is let in to fewer routes, asks with every fourth of them.
    """
    world = new_world(rate_limits=UNLIMITED)
    browser = world.browser(who)
    document = world.app.openapi()
    asked, faults = 0, []
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            media = operation.get("requestBody", {}).get("content", {}).get("application/json")
            if media is None or path.startswith("/api/session"):  # which would end this one
                continue
            body = example(media["schema"], document)
            names = {"class_id": world.ids["林班"], "work_id": "regular-shui", "person_id": world.ids["吳"]}
            url = path.format_map(_Ids(names))
            for place in _leaves(body):
                for hostile in HOSTILE[::step]:
                    text = json.dumps(_with(body, place, "HERE")).replace('"HERE"', hostile)
                    headers = {"Content-Type": "application/json"}
                    answer = browser(method.upper(), url, content=text.encode(), headers=headers)
                    asked += 1
                    if answer.status_code >= 500:
                        faults.append((method, url, place, hostile[:40], answer.text))
                    if hostile in ("NaN", "Infinity", "-Infinity", "1e999", "-1e999"):
                        assert 400 <= answer.status_code < 500, (method, url, place, hostile, answer.text)
    assert faults == []
    assert asked > 500


class _Ids(dict):
    def __missing__(self, key):
        return "nothing"


@pytest.mark.parametrize(
    "due",
    [
        *(
            "0001-01-01T00:00:00+14:00",
            "0001-01-01T00:00:00Z",
            "9999-12-31T23:59:59-14:00",
            "9999-12-31T23:59:59Z",
        ),
        *("1969-12-31T00:00:00Z", "2201-01-01T00:00:00Z", "2026-12-01T16:00:00", "tomorrow", 1e300, [], True),
    ],
)
def test_a_task_is_due_within_the_calendar(world, due):
    teacher = world.browser("林")
    url = f"/api/classes/{world.ids['林班']}/tasks"
    answer = teacher("POST", url, json={"work": "regular-shui", "due": due})
    assert answer.status_code == 422 and answer.json()["error"]["zh"], answer.text
    good = teacher("POST", url, json={"work": "regular-shui", "due": "2026-12-01T23:00:00+14:00"})
    assert good.status_code == 201 and good.json()["due"] == "2026-12-01T09:00:00Z"


@pytest.mark.parametrize("value", ["nan", "inf", "-inf", "1e999", "9" * 400, "", "x", "\u0000", "1.5"])
def test_no_number_in_a_query_ends_in_a_fault(world, value):
    visitor = world.browser()
    for url, names in (
        ("/api/works", ("offset", "limit")),
        ("/api/works/regular-shui/files/stl", ("exaggeration", "width", "base")),
        ("/iiif/works/regular-shui/0,0,10,10/max/0/default.png", ("x",)),
    ):
        for name in names:
            assert visitor("GET", url, params={name: value}).status_code < 500


@pytest.mark.parametrize(
    "strokes",
    [
        *(
            "[[[NaN,0]]]",
            "[[[1e999,0]]]",
            '{"strokes":[[[1,2]]],"pen":NaN}',
            '{"strokes":[[[1,2]]],"pen":1e999}',
        ),
        *(
            "[[[" + "1" * 5000 + ",0]]]",
            "[" * 20000,
            "[[[true,1]]]",
            '[[["\\ud800",1]]]',
            "nothing",
            "[[[-Infinity,0]]]",
        ),
    ],
)
def test_strokes_that_are_none_are_refused(world, copy_of, strokes):
    answer = world.browser("吳").marked(copy_of(), kind="pen", strokes=strokes)
    assert answer.status_code == 422 and answer.json()["error"]["code"] == "strokes"
