"""Routes of IIIF, for viewers on any site: Presentation API 3 and Image API 3."""

from __future__ import annotations

import hashlib
from typing import Annotated, Any

from fastapi import APIRouter, Path, Query, Request, Response
from fastapi.responses import JSONResponse, RedirectResponse

from rumu.database.tables import Work
from rumu.errors import GalleryError
from rumu.gallery.assets import assets_of
from rumu.gallery.iiif import collection_manifest, manifest
from rumu.gallery.iiif_image import BadImageRequest, image_info
from rumu.gallery.iiif_text import search_text, search_text_1
from rumu.gallery.tile_maps import has_tiles, stored_tiles
from rumu.studio import worker_tasks
from rumu.studio.errors import Missing
from rumu.web.addresses import base_url, service_url
from rumu.web.dependencies import CleanText, PathId, ServiceDep
from rumu.web.files import FileContent
from rumu.web.responses import file_response, requested_etags
from rumu.web.routes.works import find_work
from rumu.web.service import Service

router = APIRouter(tags=["iiif"])
PathWord = Annotated[str, Path(max_length=80)]
SearchWords = Annotated[CleanText, Query(max_length=200)]


@router.get("/iiif/works/{work_id}/manifest.json", response_class=JSONResponse)
def get_manifest(request: Request, service: ServiceDep, work_id: PathId) -> Response:
    """The manifest of a work."""
    find_work(service, work_id)
    return _iiif_response(manifest(service.gallery, work_id, base=base_url(request)), "presentation")


@router.get("/iiif/works/{work_id}/search", response_class=JSONResponse)
def search_in_work(
    request: Request,
    service: ServiceDep,
    work_id: PathId,
    q: SearchWords = "",
) -> Response:
    """Where words stand in the text of a whole work: the Content Search API 2. q: words, parted by spaces."""
    find_work(service, work_id)
    return _iiif_response(
        search_text(service.gallery, work_id, q, base=base_url(request)), "search", version=2
    )


@router.get("/iiif/works/{work_id}/search/1", response_class=JSONResponse)
def search_in_work_1(
    request: Request,
    service: ServiceDep,
    work_id: PathId,
    q: SearchWords = "",
) -> Response:
    """The same by the Content Search API 1, for viewers that know no other."""
    find_work(service, work_id)
    return _iiif_response(
        search_text_1(service.gallery, work_id, q, base=base_url(request)), "search", version=1
    )


@router.get("/iiif/works/{work_id}/{part:path}", response_class=JSONResponse)
def get_part(
    request: Request, service: ServiceDep, work_id: PathId, part: Annotated[str, Path(max_length=200)]
) -> Response:
    """The canvas of a manifest, one of its pages of annotations, or one annotation, by its id."""
    find_work(service, work_id)
    facts = manifest(service.gallery, work_id, base=base_url(request))
    found = _find_part(facts, f"{base_url(request)}/iiif/works/{work_id}/{part}")
    if found is None:
        raise Missing(zh="這件作品沒有這個部分。", en="The work has no such part.")
    return _iiif_response({"@context": facts["@context"]} | found, "presentation")


@router.get("/iiif/collections/{collection_id}.json", response_class=JSONResponse)
def get_collection_manifest(request: Request, service: ServiceDep, collection_id: PathId) -> Response:
    """The manifests of a collection's works."""
    try:
        facts = collection_manifest(service.gallery, collection_id, base=base_url(request))
    except GalleryError as error:
        raise Missing(zh="沒有這個專題。", en="There is no such collection.") from error
    return _iiif_response(facts, "presentation")


@router.get("/iiif/image/{work_id}", include_in_schema=False)
def redirect_to_info(work_id: PathId) -> Response:
    """The Image API redirects the base URI of a picture to its description."""
    return RedirectResponse(service_url(f"/iiif/image/{work_id}/info.json"), 303)


@router.get("/iiif/image/{work_id}/info.json", response_class=JSONResponse)
def get_image_info(request: Request, service: ServiceDep, work_id: PathId) -> Response:
    """In what sizes and parts a picture is served."""
    find_work(service, work_id)
    facts = image_info(service.gallery, work_id, base=f"{base_url(request)}/iiif/image")
    return _iiif_response(facts, "image")


@router.get("/iiif/image/{work_id}/{region}/{size}/{rotation}/{name}", response_class=Response)
def get_image_part(
    *,
    request: Request,
    service: ServiceDep,
    work_id: PathId,
    region: PathWord,
    size: PathWord,
    rotation: PathWord,
    name: PathWord,
) -> Response:
    """A part of a picture, as the Image API names it. name: default.jpg and the like."""
    work = find_work(service, work_id)
    quality, _, ending = name.rpartition(".")
    path = "/".join((work.digest, region, size, rotation, name))
    etag = hashlib.sha256(path.encode("utf-8", "replace")).hexdigest()[:20]
    data: bytes | None = b""
    kind = ""
    if etag not in requested_etags(request.headers):
        data, kind = _stored_tile(service, work, f"{region}/{size}/{rotation}/{name}"), "image/jpeg"
    if data is None:
        try:
            data, kind = service.workers.call(
                worker_tasks.image_part,
                work_id=work_id,
                words=(region, size, rotation, quality, ending),
            )
        except BadImageRequest as error:
            facts = {"error": {"code": "image_request", "zh": "圖像請求不合規範。", "en": str(error)}}
            return JSONResponse(facts, 400)
    return file_response(request, FileContent(data, None, kind, etag))


def _stored_tile(service: Service, work: Work, name: str) -> bytes | None:
    """The tile of a work from one picture, if it has been made; most requests of IIIF viewers are for one."""
    if work.capture is not None or not has_tiles(work):
        return None
    store = service.gallery.store
    tiles = stored_tiles(store, assets_of(store, work), "albedo")
    return None if tiles is None else tiles.read(name)


def _find_part(facts: Any, part_id: str) -> dict[str, Any] | None:
    """The object with this id among the values of JSON."""
    if isinstance(facts, dict) and facts.get("id") == part_id:
        return facts
    values = facts.values() if isinstance(facts, dict) else facts if isinstance(facts, list) else ()
    return next((part for value in values if (part := _find_part(value, part_id)) is not None), None)


def _iiif_response(facts: dict[str, Any], api: str, *, version: int = 3) -> Response:
    """api: 'presentation', 'image' or 'search'."""
    profile = f"http://iiif.io/api/{api}/{version}/context.json"
    return JSONResponse(facts, media_type=f'application/ld+json;profile="{profile}"')
