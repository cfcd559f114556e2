"""A work as a single HTML file that holds the viewer and all its data, so that it opens anywhere."""

from __future__ import annotations

import base64
import gzip
import html
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rumu.errors import GalleryError
from rumu.gallery.annotations import annotations_of
from rumu.gallery.catalog import collection, work
from rumu.gallery.derived import derived_file, viewer_facts
from rumu.gallery.store import Gallery

SCRIPT, STYLE = "standalone.js", "standalone.css"
LARGEST = 12_000_000  # bytes of a page that can be sent by e-mail

_GZIPPED = {"heights", "glb"}  # numbers and meshes, which gzip halves; the viewer unpacks them
_BILINGUAL = ("title", "hand", "period", "material")


def write_page(gallery: Gallery, work_id: str, target: str | Path, *, static: Path) -> int:
    """Write the page of a work, completely or not at all; its size in bytes. See `single_page`."""
    from rumu.outputs import whole_file

    page = single_page(gallery, work_id, static=static)
    with whole_file(target) as part:
        part.write_bytes(page)
    return len(page)


def single_page(gallery: Gallery, work_id: str, *, static: Path) -> bytes:
    """The page of a work, UTF-8.

    static: the folder with the built front end, whose standalone.js and standalone.css are included. The data
    of work and viewer are in <script type="application/json" id="rumu-work">; all URLs in them are data:
    URLs, so the page needs no network.
    Raises GalleryError when there is no such work or the front end was not built.
    """
    script, style = (_read_built(static, name) for name in (SCRIPT, STYLE))
    facts = page_facts(gallery, work_id)
    page = _PAGE.format(
        title=html.escape(page_title(facts)),
        style=style.replace("</style", "<\\/style"),
        data=page_json(facts),
        script=script.replace("</script", "<\\/script").replace("<!--", "<\\!--"),
    ).encode()
    if len(page) > LARGEST:
        raise GalleryError(f"{work_id}: expected a page of at most {LARGEST} bytes, got {len(page)}")
    return page


def page_title(facts: dict[str, Any]) -> str:
    """The title of the page with these facts, in Chinese and English."""
    return " ".join(dict.fromkeys((facts["work"]["title"]["zh"], facts["work"]["title"]["en"])))


def page_json(facts: dict[str, Any]) -> str:
    """The page's data as the text of its script element."""
    # Only "</" can end a script element; in JSON the character may be escaped.
    return json.dumps(facts, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")


def page_facts(
    gallery: Gallery, work_id: str, *, url: Callable[[str, str], str] | None = None
) -> dict[str, Any]:
    """The page's data: {work, viewer} as in the service's answers.

    url: makes the address of a kind of derived file with its ETag; by default a data: URL that holds it.
    """

    def data_url(kind: str, _: str) -> str:
        if kind == "glb":  # it is for downloads only, and would double the page
            return ""
        file = derived_file(gallery, work_id, kind)
        data = gzip.compress(file.data, 6, mtime=0) if kind in _GZIPPED else file.data
        return f"data:{file.media_type};base64,{base64.b64encode(data).decode()}"

    viewer = viewer_facts(gallery, work_id, url=url or data_url)
    width, height = viewer.pop("pixels")
    heights = viewer.pop("height")
    return {
        "work": _work_facts(gallery, work_id),
        "viewer": viewer | {"width": width, "height": height, "heights": heights},
    }


def _work_facts(gallery: Gallery, work_id: str) -> dict[str, Any]:
    row = work(gallery, work_id)
    plain = ("id", "character", "script", "dynasty", "kind", "height_source", "width", "height")
    more = ("source", "licence", "attribution", "spacing")
    return (
        {name: getattr(row, name) for name in (*plain, *more)}
        | {name: getattr(row, name)._asdict() for name in _BILINGUAL}
        | {
            "collection": row.collection_id,
            "collection_title": collection(gallery, row.collection_id).title._asdict(),
            "annotations": [
                {"id": one.id, "x": one.x, "y": one.y}
                | {"title": one.title._asdict(), "text": one.text._asdict()}
                for one in annotations_of(gallery, work_id)
            ],
        }
    )


def _read_built(static: Path, name: str) -> str:
    try:
        return (static / name).read_text(encoding="utf-8")
    except OSError as error:
        raise GalleryError(
            f"{static / name}: expected the built front end, there is none; in a checkout run: "
            "cd frontend && npm ci && npm run build"
        ) from error


_PAGE = """<!doctype html>
<html lang="zh-Hant">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data: blob:; \
style-src 'unsafe-inline'; script-src 'unsafe-inline'; connect-src data: blob:; worker-src blob:; \
font-src data:">
<title>{title}</title>
<style>{style}</style>
</head>
<body>
<div id="app"></div>
<script type="application/json" id="rumu-work">{data}</script>
<script>{script}</script>
</body>
</html>
"""
