"""The description of the service for programs (/api/openapi.json) and, as one plain page, for people
(/api/docs)."""

from __future__ import annotations

import json
from html import escape
from typing import Any

from fastapi import FastAPI, Response

_STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem;
  color: #222; }
h2 { margin-top: 2.5rem; border-bottom: 1px solid #ccc; } h3 { font: 600 15px monospace; margin-bottom: 0; }
code, pre { font: 13px/1.45 monospace; background: #f5f3ee; } pre { padding: .6rem; overflow: auto; }
table { border-collapse: collapse; } td { padding: .1rem .8rem .1rem 0; vertical-align: top; }
@media (prefers-color-scheme: dark) {
  body { background: #1b1a18; color: #ddd; }
  code, pre { background: #2a2825; } }
"""


def register(app: FastAPI) -> None:
    """Serve the page; FastAPI serves the JSON itself."""

    @app.get("/api/docs", include_in_schema=False)
    def docs() -> Response:
        return Response(page(app.openapi()), media_type="text/html; charset=utf-8")

    @app.get("/api/docs.css", include_in_schema=False)
    def style() -> Response:
        return Response(_STYLE, media_type="text/css")


def page(told: dict[str, Any]) -> str:
    """The description as HTML without scripts."""
    by_noun: dict[str, list[str]] = {}
    for path, methods in told["paths"].items():
        for method, operation in methods.items():
            tag = (operation.get("tags") or ["other"])[0]
            by_noun.setdefault(tag, []).append(_operation(path, method, operation, told))
    body = "".join(f"<h2>{escape(tag)}</h2>{''.join(parts)}" for tag, parts in by_noun.items())
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8"><title>rumu API</title>'
        '<link rel="stylesheet" href="/api/docs.css"></head><body>'
        f"<h1>{escape(told['info']['title'])} {escape(told['info']['version'])}</h1>"
        f"<p>{escape(told['info'].get('description', ''))}</p>"
        f'<p><a href="/api/openapi.json">openapi.json</a></p>{body}</body></html>'
    )


def _operation(path: str, method: str, operation: dict[str, Any], told: dict[str, Any]) -> str:
    rows = "".join(
        f"<tr><td><code>{escape(p['name'])}</code></td><td>{escape(p['in'])}</td>"
        f"<td>{escape(p.get('description', ''))}</td></tr>"
        for p in operation.get("parameters", ())
    )
    sent = operation.get("requestBody", {}).get("content", {})
    answers: dict[str, Any] = next(
        (a for code, a in operation["responses"].items() if code.startswith("2")), {}
    )
    answered = answers.get("content", {})
    return (
        f"<h3>{method.upper()} {escape(path)}</h3><p>{escape(operation.get('description', ''))}</p>"
        f"<table>{rows}</table>{_example('Sent', sent, told)}{_example('Answer', answered, told)}"
    )


def _example(title: str, content: dict[str, Any], told: dict[str, Any]) -> str:
    for kind, media in content.items():
        if "schema" in media:
            shown = json.dumps(example(media["schema"], told), ensure_ascii=False, indent=1)
            return f"<p>{title} ({escape(kind)})</p><pre>{escape(shown)}</pre>"
    return ""


def example(schema: dict[str, Any], told: dict[str, Any], depth: int = 0) -> Any:  # noqa: PLR0911
    """A value of a schema: its own example where it has one, else one made of its parts."""
    if "$ref" in schema:
        name = schema["$ref"].rsplit("/", 1)[-1]
        return None if depth > 8 else example(told["components"]["schemas"][name], told, depth + 1)
    for given in ("examples", "example", "default", "const"):
        if given in schema:
            return schema[given][0] if given == "examples" else schema[given]
    if "enum" in schema:
        return schema["enum"][0]
    if "anyOf" in schema:
        return example(schema["anyOf"][0], told, depth + 1)
    kind = schema.get("type")
    if kind == "object" or "properties" in schema:
        return {name: example(part, told, depth + 1) for name, part in schema.get("properties", {}).items()}
    if kind == "array":
        return [example(schema["items"], told, depth + 1)] if "items" in schema else []
    return {"string": "…", "integer": 1, "number": 1.0, "boolean": True}.get(str(kind))
