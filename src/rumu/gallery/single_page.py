"""One work as one HTML file: the viewer and everything it shows inside, to be mailed, kept and opened
anywhere."""

from __future__ import annotations

import base64
import gzip
import html
import json
from pathlib import Path
from typing import Any

from rumu.errors import GalleryError
from rumu.gallery.annotations import annotations_of
from rumu.gallery.catalog import collection, work
from rumu.gallery.derived import derived, viewer_facts
from rumu.gallery.gallery import Gallery

SCRIPT, STYLE = "standalone.js", "standalone.css"
LARGEST = 12_000_000  # bytes of a page that can still be mailed

_PACKED = {"heights", "glb"}  # numbers and meshes: gzip halves them, and the viewer undoes it
_BOTH = ("title", "hand", "period", "material")


def write_page(gallery: Gallery, work_id: str, target: str | Path, *, static: Path) -> int:
    """Write the page of a work; it appears whole or not at all. Returns its size in bytes. See
    `single_page`."""
    from rumu.outputs import whole_file

    page = single_page(gallery, work_id, static=static)
    with whole_file(target) as part:
        part.write_bytes(page)
    return len(page)


def single_page(gallery: Gallery, work_id: str, *, static: Path) -> bytes:
    """The page of a work, UTF-8.

    static: the folder that the front end was built into; standalone.js and standalone.css of it are put
    inside. The facts of work and viewer lie in <script type="application/json" id="rumu-work">; every address
    in them is a data: URL, so the page asks nothing of any network.
    Raises GalleryError when there is no such work or the front end was not built.
    """
    script, style = (_built(static, name) for name in (SCRIPT, STYLE))
    facts = page_facts(gallery, work_id)
    title = " ".join(dict.fromkeys((facts["work"]["title"]["zh"], facts["work"]["title"]["en"])))
    # In a script element only "</" can end it early, and in JSON it may be written otherwise.
    told = json.dumps(facts, ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")
    page = _PAGE.format(
        title=html.escape(title),
        style=style.replace("</style", "<\\/style"),
        told=told,
        script=_inside(script),
    ).encode()
    if len(page) > LARGEST:
        raise GalleryError(f"{work_id}: expected a page of at most {LARGEST} bytes, got {len(page)}")
    return page


def page_facts(gallery: Gallery, work_id: str) -> dict[str, Any]:
    """What the page knows: {work, viewer}, in the shape of the service's answers, its files as data: URLs."""

    def inside(kind: str, _: str) -> str:
        # A mesh to download is no part of what is shown, and would double the page.
        return "" if kind == "glb" else _data_url(gallery, work_id, kind)

    viewer = viewer_facts(gallery, work_id, url=inside)
    width, height = viewer.pop("pixels")
    heights = viewer.pop("height")
    return {
        "work": _work_facts(gallery, work_id),
        "viewer": viewer | {"width": width, "height": height, "heights": heights},
    }


def _work_facts(gallery: Gallery, work_id: str) -> dict[str, Any]:
    row = work(gallery, work_id)
    of = collection(gallery, row.collection_id)
    plain = ("id", "character", "script", "dynasty", "kind", "height_source", "width", "height")
    more = ("source", "licence", "attribution", "spacing")
    return (
        {name: getattr(row, name) for name in (*plain, *more)}
        | {name: _both(row, name) for name in _BOTH}
        | {
            "collection": of.id,
            "collection_title": _both(of, "title"),
            "annotations": [
                {
                    "id": one.id,
                    "x": one.x,
                    "y": one.y,
                    "title": _both(one, "title"),
                    "text": _both(one, "text"),
                }
                for one in annotations_of(gallery, work_id)
            ],
        }
    )


def _both(row: Any, name: str) -> dict[str, str]:
    return {language: getattr(row, f"{name}_{language}") for language in ("zh", "en")}


def _data_url(gallery: Gallery, work_id: str, kind: str) -> str:
    file = derived(gallery, work_id, kind)
    data = gzip.compress(file.data, 6, mtime=0) if kind in _PACKED else file.data
    return f"data:{file.media_type};base64,{base64.b64encode(data).decode()}"


def _built(static: Path, name: str) -> str:
    try:
        return (static / name).read_text(encoding="utf-8")
    except OSError as error:
        raise GalleryError(
            f"{static / name}: expected the built front end, there is none; in a checkout run: "
            "cd frontend && npm ci && npm run build"
        ) from error


def _inside(script: str) -> str:
    """A script that can stand in a page: no text of it ends or begins an element."""
    return script.replace("</script", "<\\/script").replace("<!--", "<\\!--")


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
<script type="application/json" id="rumu-work">{told}</script>
<script>{script}</script>
</body>
</html>
"""
