"""The documentation of the API at /api/docs: one plain HTML page, made from /api/openapi.json.

FastAPI's own pages are not used. They load Swagger UI from another host; with its files on this one they
still start it by an inline script, which our Content-Security-Policy forbids. With a page and a script of
ours it runs, but that is 1.7 MB of JavaScript and CSS for a page that reads as well without any.
"""

from __future__ import annotations

import json
from importlib import resources
from typing import Any

from fastapi import FastAPI, Response
from fastapi.responses import HTMLResponse

_MAX_DEPTH = 8  # of schemas within schemas in an example


def register(app: FastAPI) -> None:
    """Add the page and its style sheet; FastAPI serves the JSON itself."""
    style = resources.files("rumu.web").joinpath("templates", "docs.css").read_text("utf-8")

    @app.get("/api/docs", include_in_schema=False)
    def get_docs() -> Response:
        return HTMLResponse(render_docs(app.openapi()))

    @app.get("/api/docs.css", include_in_schema=False)
    def get_style() -> Response:
        return Response(style, media_type="text/css")


def render_docs(document: dict[str, Any]) -> str:
    """An OpenAPI document as HTML without scripts."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    tags: dict[str, list[dict[str, Any]]] = {}
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            tag = (operation.get("tags") or ["other"])[0]
            request = operation.get("requestBody", {})
            examples = _examples("Sent", request, document)
            for status, response in operation["responses"].items():
                if status.startswith("2"):
                    examples += _examples("Answer", response, document)
            tags.setdefault(tag, []).append(
                {
                    "title": f"{method.upper()} {path}",
                    "description": operation.get("description", ""),
                    "parameters": operation.get("parameters", ()),
                    "examples": examples,
                }
            )
    environment = Environment(
        loader=PackageLoader("rumu.web"), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    return environment.get_template("docs.html").render(info=document["info"], tags=tags)


def _examples(title: str, message: dict[str, Any], document: dict[str, Any]) -> list[tuple[str, str]]:
    """(title, JSON) of the first kind of content that has a schema; empty if none has."""
    for kind, media in message.get("content", {}).items():
        if "schema" in media:
            value = example(media["schema"], document)
            return [(f"{title} ({kind})", json.dumps(value, ensure_ascii=False, indent=1))]
    return []


def example(schema: dict[str, Any], document: dict[str, Any], depth: int = 0) -> Any:  # noqa: PLR0911
    """A value of a schema: its own example if it has one, else one made of the examples of its parts."""
    if "$ref" in schema:
        if depth > _MAX_DEPTH:
            return None
        name = schema["$ref"].rsplit("/", 1)[-1]
        return example(document["components"]["schemas"][name], document, depth + 1)
    if "examples" in schema:
        return schema["examples"][0]
    for key in ("example", "default", "const"):
        if key in schema:
            return schema[key]
    if "enum" in schema:
        return schema["enum"][0]
    if "anyOf" in schema:
        return example(schema["anyOf"][0], document, depth + 1)
    kind = schema.get("type")
    if kind == "object" or "properties" in schema:
        properties = schema.get("properties", {})
        return {name: example(part, document, depth + 1) for name, part in properties.items()}
    if kind == "array":
        return [example(schema["items"], document, depth + 1)] if "items" in schema else []
    return {"string": "…", "integer": 1, "number": 1.0, "boolean": True}.get(str(kind))
