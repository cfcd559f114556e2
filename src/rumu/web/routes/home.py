"""Routes of the home page, and of pages that show works elsewhere: previews of links, and frames."""

from __future__ import annotations

import html
from typing import Any
from urllib.parse import quote

from fastapi import APIRouter, Request, Response
from fastapi.responses import HTMLResponse

from rumu.database.tables import Work
from rumu.gallery import catalog, cover
from rumu.gallery.single_page import SCRIPT, STYLE, page_facts, page_json, page_title
from rumu.gallery.vocabulary import HEIGHT_SOURCES
from rumu.web.addresses import base_url, service_url
from rumu.web.collection_schemas import CoverUpdate, HomeRead
from rumu.web.dependencies import OwnerUser, PathId, ServiceDep, WorkId
from rumu.web.routes.works import find_work, get_collection
from rumu.web.security import CONTENT_SECURITY_POLICY

router = APIRouter(tags=["home"])

PREVIEW = 1200  # pixels of the longer side of a preview's picture, as social networks ask for
_FRAMED = CONTENT_SECURITY_POLICY.replace("frame-ancestors 'self'", "frame-ancestors *")


@router.get("/api/home", response_model=HomeRead)
def get_home(service: ServiceDep) -> dict[str, Any]:
    """What the home page shows: one work that is lit there, and how many works the gallery has."""
    work, chosen = cover.cover_work(service.gallery)
    return {"cover": work, "chosen": chosen, "works": catalog.works(service.gallery, limit=0).total}


@router.put("/api/home", response_model=HomeRead)
def choose_cover(service: ServiceDep, user: OwnerUser, choice: CoverUpdate) -> dict[str, Any]:
    """Choose the work on the home page."""
    if choice.work is not None:
        find_work(service, choice.work)
    cover.choose_cover(service.gallery, choice.work)
    return get_home(service)


@router.get("/share/works/{work_id}", response_class=HTMLResponse)
def share_work(request: Request, service: ServiceDep, work_id: WorkId) -> Response:
    """A page that messengers and social networks make a preview of, with Open Graph metadata.

    It leads on to the page of the work, whose own address they cannot read: it stands after the hash.
    """
    work = find_work(service, work_id)
    hand = " ".join(dict.fromkeys(filter(None, work.hand)))
    source = HEIGHT_SOURCES.get(work.height_source)
    about = "。".join(filter(None, (hand, source and source.zh.rstrip("。"), source and source.en)))
    title = " ".join(dict.fromkeys(filter(None, work.title)))
    return _preview(base_url(request), f"works/{quote(work.id, safe='')}", title, about, work)


@router.get("/share/collections/{collection_id}", response_class=HTMLResponse)
def share_collection(request: Request, service: ServiceDep, collection_id: PathId) -> Response:
    """As `share_work`, for the page of a collection, with its cover."""
    shown = get_collection(service, collection_id)
    title, about = (" ".join(dict.fromkeys(filter(None, text))) for text in (shown.title, shown.note))
    return _preview(base_url(request), f"collections/{collection_id}", title, about[:300], shown.cover)


def _preview(base: str, path: str, title: str, about: str, picture: Work | None) -> Response:
    """The page that stands for the one at `path`, relative to the service's hash."""
    image = ""
    if picture is not None:
        name, size = quote(picture.id, safe=""), _preview_size(picture)
        address = html.escape(f"{base}/iiif/image/{name}/full/!{size}/0/default.jpg")
        image = f'<meta property="og:image" content="{address}">\n'
    page = _SHARED.format(
        title=html.escape(title),
        about=html.escape(about),
        here=html.escape(f"{base}/share/{path}"),
        there=html.escape(f"{base}/#/{path}"),
        icon=service_url("/seal.svg"),
        image=image,
    )
    return HTMLResponse(page, headers={"Cache-Control": "public, max-age=3600"})


@router.get("/embed/works/{work_id}", response_class=HTMLResponse)
def embed_work(service: ServiceDep, work_id: WorkId) -> Response:
    """The viewer of a work alone, which pages of other sites may show in a frame."""
    work = find_work(service, work_id)
    service.files.get(work, "facts")
    name = quote(work.id, safe="")
    facts = page_facts(
        service.gallery,
        work.id,
        url=lambda kind, tag: service_url(f"/api/works/{name}/files/{kind}?v={tag}"),
    )
    page = _EMBEDDED.format(
        title=html.escape(page_title(facts)),
        icon=service_url("/seal.svg"),
        style=service_url(f"/{STYLE}"),
        data=page_json(facts),
        script=service_url(f"/{SCRIPT}"),
    )
    headers = {"Content-Security-Policy": _FRAMED, "Cache-Control": "no-cache"}
    return HTMLResponse(page, headers=headers)


def _preview_size(work: Work) -> str:
    """Width and height that a preview's picture must fit into; nothing is enlarged."""
    return f"{min(PREVIEW, work.width)},{min(PREVIEW, work.height)}"


_SHARED = """<!doctype html>
<html lang="zh-Hant" prefix="og: https://ogp.me/ns#">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title} · rumu 入木</title>
<meta name="description" content="{about}">
<link rel="icon" href="{icon}" type="image/svg+xml">
<meta property="og:type" content="website">
<meta property="og:site_name" content="rumu 入木">
<meta property="og:title" content="{title}">
<meta property="og:description" content="{about}">
<meta property="og:url" content="{here}">
{image}<meta name="twitter:card" content="summary_large_image">
<meta http-equiv="refresh" content="0; url={there}">
</head>
<body><p><a href="{there}">{title}</a></p></body>
</html>
"""

_EMBEDDED = """<!doctype html>
<html lang="zh-Hant">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<link rel="icon" href="{icon}" type="image/svg+xml">
<link rel="stylesheet" href="{style}">
</head>
<body>
<div id="app"></div>
<script type="application/json" id="rumu-work">{data}</script>
<script src="{script}" defer></script>
</body>
</html>
"""
